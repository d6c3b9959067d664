"""How what is not finished is worded."""

from __future__ import annotations

import pytest

from rankdrop.robot.dh import from_dh
from rankdrop.verbs.conditions import conditions


@pytest.mark.slow
@pytest.mark.parametrize(("n", "task", "alpha"), [(24, "pose", 0.7), (30, "planar", 0.0)])
def test_a_long_general_arm_ends_at_once_and_says_why(n: int, task: str, alpha: float) -> None:
    rows = [(0.1 + 0.01 * j, alpha, 0.05 * bool(alpha), 0) for j in range(n)]
    found = conditions(from_dh(rows, convention="standard"), task, points=0, lengths="numbers")
    assert not found.complete
    assert "would grow too long: the arm's screws were not written down" in str(found.left[0])
    assert found.generic_rank == (6 if task == "pose" else 3)
