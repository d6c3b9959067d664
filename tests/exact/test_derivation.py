"""A derivation by all of its methods."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rankdrop.algebra.work import Work
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.derivation import corank_one
from rankdrop.exact.tree import rank_tree
from rankdrop.robot.open import open_robot


@pytest.mark.slow
def test_a_disagreement_is_a_line_with_one_configuration() -> None:
    """PUMA, by decoupling and by a rank tree that has lost a set: the set is not printed, a point on it is."""
    chain = exact_chain(open_robot("puma560"))
    tree = rank_tree(chain, Work(60.0, 0))
    first = [drop for drop in tree.drops if drop.rank == 5]
    less = replace(tree, drops=[drop for drop in tree.drops if drop is not first[0]])
    assert corank_one(chain, "decoupling", tree, (), Work(60.0, 0)).disagreements == ()
    (found,) = corank_one(chain, "decoupling", less, (), Work(60.0, 0)).disagreements
    line = str(found)
    assert line.startswith("decoupling has 1 set that the rank tree has not: at q = (")
    assert line.endswith("the rank is 5 of 6")
    assert len(line) < 200
