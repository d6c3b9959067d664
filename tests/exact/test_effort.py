"""The work of a derivation, counted in steps: the same on every machine, and not more than it was."""

from __future__ import annotations

import pytest

from rankdrop.algebra.work import Work, work_spent
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.tree import rank_tree
from rankdrop.robot.open import open_robot

WORK = {"scara": 0.003, "puma560": 0.39, "ur5": 0.27, "pa10": 0.40, "canadarm2": 1.24, "panda": 0.92}
"""Work of the rank tree, all coranks [s of an idle machine]."""
RISE = 1.5


@pytest.mark.by_hand
@pytest.mark.slow_at("canadarm2", "panda")
@pytest.mark.parametrize("name", WORK)
def test_the_work_of_a_derivation_does_not_rise(name: str) -> None:
    before = work_spent()
    rank_tree(exact_chain(open_robot(name)), Work(60.0, 0))
    assert work_spent() - before < RISE * WORK[name]
