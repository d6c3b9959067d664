"""How tests of conditions are worded."""

from __future__ import annotations

import numpy as np

from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.signs import families_between
from rankdrop.robot.open import open_robot


def test_equal_signs_prove_nothing_and_it_is_said():
    chain = exact_chain(open_robot("planar2r"))
    found = families_between(chain, [0, 0.5], [0, 0.5 + 2 * np.pi])
    assert found.parting == ()
    assert "does not prove that a path without singularity exists" in found.sentences()[0]
    assert [one.kind for one in found.crossings] == ["crosses", "crosses"]
