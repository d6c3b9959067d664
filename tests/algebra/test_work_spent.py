"""How much work a derivation takes, by the clock that ticks with work: the same on every machine, however busy it is.

A change that makes a structure half as much work again is seen here; one that saves much lowers the bound.
"""

from __future__ import annotations

import pytest

from rankdrop import conditions, open_robot
from rankdrop.algebra.work import work_spent

MEASURED = {
    "planar3r": 0.0077,
    "scara": 0.0046,
    "stanford": 0.0487,  # with a slide
    "rcrrrr": 0.0860,
    "anthropomorphic": 0.1405,
    "irb120": 0.2466,  # spherical wrist
    "ur5": 0.2926,  # three parallel axes
    "crx10ia": 0.2041,  # offset wrist
    "gen3_lite": 0.3175,
    "pa10": 0.5277,  # seven joints
    "panda": 1.4408,
    "sawyer": 1.6242,
    "canadarm2": 1.3365,
}
"""Seconds of work, of the version before this one."""


@pytest.mark.slow
@pytest.mark.by_hand_at("panda", "sawyer", "canadarm2")
@pytest.mark.parametrize("name", list(MEASURED))
def test_a_derivation_takes_no_more_than_half_as_much_work_again(name: str) -> None:
    before = work_spent()
    found = conditions(open_robot(name), points=0, special=False, seconds=60.0)
    work = work_spent() - before
    assert found.complete
    assert 0.3 * MEASURED[name] < work < 1.5 * MEASURED[name]
