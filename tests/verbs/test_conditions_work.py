"""The work of a derivation, in ticks, of one arm of each structure: it may not grow unnoticed.

Ticks are counted, not measured: they are the same on every machine. What a release takes is written down here when it
is made; a change that needs more than half as much again says so by a new number.
"""

from __future__ import annotations

import pytest

from rankdrop.algebra.work import work_spent
from rankdrop.robot.open import open_robot
from rankdrop.verbs.conditions import conditions

RELEASED = {"planar3r": 0.0082, "scara": 0.0048, "irb120": 0.252, "ur5": 0.293, "puma560": 0.422, "pa10": 0.534}
"""Counted work of all coranks [s], in the release before."""
SLOWER = {"gen3": 1.41, "panda": 1.49, "canadarm2": 1.73, "sawyer": 1.82}
"""The same, of arms that take longer."""
MOST = 1.5
"""How many times the work may have grown since."""


def work_of(name: str) -> float:
    """Counted work of deriving the conditions of an arm anew [s]."""
    before = work_spent()
    found = conditions(open_robot(name), fresh=True)
    assert found.complete
    return work_spent() - before


@pytest.mark.parametrize("name", RELEASED)
def test_a_derivation_takes_no_more_work_than_in_the_release_before(name: str) -> None:
    spent = work_of(name)
    assert 0.0 < spent <= MOST * RELEASED[name]


@pytest.mark.slow
@pytest.mark.parametrize("name", SLOWER)
def test_a_long_derivation_takes_no_more_work_than_in_the_release_before(name: str) -> None:
    assert work_of(name) <= MOST * SLOWER[name]
