"""How a disagreement of two methods is worded."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rankdrop.exact.families import Reality
from rankdrop.exact.tree import Drop
from rankdrop.families.record import exact_of
from rankdrop.robot.open import open_robot
from rankdrop.verbs.conditions import conditions
from rankdrop.verbs.deriving import _not_singular


def test_a_family_that_is_not_singular_at_the_arms_own_lengths_is_no_exact_derivation() -> None:
    found = conditions(open_robot("scara"), points=0)
    chain = found.chain
    q = np.array([[0.3, 1e-7, 0.2, 0.1][: chain.n]])
    here = Reality(q, True, False, (), np.empty((0, chain.n)))
    sets = [(Drop(piece, 0), here) for family in found.families for piece in exact_of(family).pieces]
    assert _not_singular(chain, sets, found.families, found.generic_rank) == []
    far = [(drop, replace(reality, points=reality.points + 1e-3)) for drop, reality in sets]
    (told,) = _not_singular(chain, far, found.families, found.generic_rank)
    assert "does not vanish at" in str(told)
