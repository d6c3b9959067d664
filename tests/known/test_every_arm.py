"""Every arm of the catalogue, analysed with few starts: its families are those shipped, and the exact ones agree.

All of them: `pytest -m slow tests/known/test_every_arm.py` (two minutes of one processor); three by default. With as
many starts as what is shipped, and derived anew: one of each structure (`test_known.py`,
`results/test_stored_conditions.py`).
"""

from __future__ import annotations

import pytest

from known.arms import STRUCTURES
from rankdrop.families.derivation import AGREES
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import conditions_names, shipped
from rankdrop.robot.open import open_robot, robot_names
from rankdrop.verbs.analyze import analyze

QUICK = ("planar3r", "gp25", "ur30")
ALONE = {"rizon10"}
"""Families too many for few starts, and no exact conditions: made anew in whole."""
ARMS = [
    pytest.param(name, marks=() if name in QUICK else pytest.mark.by_hand)
    for name in robot_names() if name not in ALONE
]


def rows(found: Analysis) -> list[tuple[object, ...]]:
    """The rows of an analysis, in order."""
    return [(one.id, one.name, one.corank, one.dimension, one.free, one.coupled) for one in found.families]


def test_no_arm_is_left_out() -> None:
    assert set(STRUCTURES) >= ALONE
    assert set(conditions_names()) == set(robot_names()) - ALONE


@pytest.mark.slow_at("ur30")
@pytest.mark.shipped
@pytest.mark.parametrize("name", ARMS)
def test_analysis_and_exact_conditions_agree_and_are_those_shipped(name: str) -> None:
    found = analyze(open_robot(name), starts=500, exact="on", threads=1)
    assert rows(found) == rows(shipped(name))
    assert found.exact is not None
    assert (found.exact.status, found.exact.disagreements) == (AGREES, ())
    assert found.verified
