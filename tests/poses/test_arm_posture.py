"""Shoulder, elbow and wrist in words: known postures, and all solutions of a pose differ in them."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.kinematics import link_poses
from rankdrop.poses.arm_posture import arm_postures
from rankdrop.robot.open import open_robot
from rankdrop.text.postures import part_words


def test_front_and_up_are_those_of_the_drawn_arm() -> None:
    """IRB 120: frames of the links have the elbow and the wrist as origins; no Jacobian is used."""
    arm = open_robot("irb120")
    rng = np.random.default_rng(7)
    for q in rng.uniform(-2.5, 2.5, (40, 6)):
        frames = link_poses(arm, q)
        axis_2, elbow, wrist = (frames[index][:3, 3] for index in (1, 2, 4))
        ahead = np.array([np.cos(q[0]), np.sin(q[0])]) @ wrist[:2]
        along = wrist - axis_2
        off = (elbow - axis_2) - ((elbow - axis_2) @ along) / (along @ along) * along
        expected = ["shoulder front" if ahead > 0 else "shoulder back", "elbow up" if off[2] > 0 else "elbow down"]
        assert part_words(arm_postures(arm, q[None])[0])[:2] == expected


@pytest.mark.parametrize("name", ["so101", "px150", "xarm5"])
def test_rolling_the_tool_of_five_joints_changes_no_posture(name: str) -> None:
    """The tip may be off the axis of the roll: where it is decides nothing."""
    arm = open_robot(name)
    q = np.tile(np.radians([30.0, -20, 40, 10, 0]), (7, 1))
    q[:, 4] = np.linspace(-1.5, 1.5, 7)
    assert len(set(arm_postures(arm, q))) == 1
