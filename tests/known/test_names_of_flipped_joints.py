"""A family's name does not depend on which way round a joint counts, but for the values of angles that it tells."""

from __future__ import annotations

import pytest

pytest.importorskip("flint")

from reference.region import flipped

from rankdrop.robot.open import open_robot
from rankdrop.verbs.conditions import conditions


@pytest.mark.by_hand_at("crx10ia-which0")
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "which"),
    [("crx10ia", [1, 2, 3]), pytest.param("ur5", [3, 5]), pytest.param("xarm6", [0, 4], marks=pytest.mark.by_hand)],
)
def test_names_stay_where_joints_are_flipped(name: str, which: list[int]) -> None:
    """A name was read off points of the first of a family's sets: axes 2 and 5 of a CRX-10iA aligned, at half of them.
    """
    robot = open_robot(name)
    names = [
        [(family.corank, family.name) for family in conditions(one, points=0, special=False, method="tree").families]
        for one in (robot, flipped(robot, which))
    ]
    assert names[0] == names[1]
