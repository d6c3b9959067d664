"""Shoulder, elbow and wrist in words: known postures, and all solutions of a pose differ in them."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from rankdrop.kinematics import link_poses, pose
from rankdrop.poses.arm_posture import arm_postures
from rankdrop.poses.branches import inverse
from rankdrop.robot.open import open_robot
from rankdrop.text.postures import part_words, posture_words


def words(name: str, degrees: list[float]) -> str:
    return ", ".join(part_words(arm_postures(open_robot(name), np.radians([degrees]))[0]))


@pytest.mark.parametrize(("name", "degrees", "expected"), [
    # the usual start of each maker: over the table in front, the tool pointing down
    ("irb120", [0, 0, 0, 0, 90, 0], "shoulder front, elbow up, wrist not flipped"),
    ("kr6r900", [0, -90, 90, 0, 90, 0], "shoulder front, elbow up, wrist not flipped"),
    ("lrmate200id", [0, 0, 0, 0, -90, 0], "shoulder front, elbow up, wrist not flipped"),
    ("gp7", [0, 0, 0, 0, -90, 0], "shoulder front, elbow up, wrist not flipped"),
    ("irb120", [0, 0, 0, 180, -90, 0], "shoulder front, elbow up, wrist flipped"),
    ("irb120", [170, 0, 0, 0, 90, 0], "shoulder front, elbow up, wrist not flipped"),
    ("irb120", [0, -60, -60, 0, 90, 0], "shoulder back, elbow down, wrist not flipped"),
    ("irb120", [0, 0, 0, 0, 0, 0], "shoulder front, elbow up"),
    ("ur5e", [0, -90, -90, -90, 90, 0], "shoulder right, elbow up"),
    ("ur5e", [0, 0, 90, -90, 90, 0], "shoulder left, elbow up"),
    ("ur5e", [0, -180, 90, -90, 90, 0], "shoulder right, elbow down"),
    ("ur5e", [0, -60, 0, -90, 90, 0], "shoulder left"),
    ("px150", [0, 0, 0, 0, 0], "shoulder front, elbow up"),
    ("scara", [0, 60, 0, 0], "elbow right"),
    ("scara", [40, -60, 0, 0], "elbow left"),
    ("panda", [0, 0, 0, -90, 0, 90, 0], ""),
    ("rs007n", [0, 20, -60, 0, -60, 0], "shoulder front, elbow up, wrist not flipped"),
])  # fmt: skip
def test_known_postures(name: str, degrees: list[float], expected: str) -> None:
    assert words(name, degrees) == expected


@pytest.mark.slow
@pytest.mark.parametrize("name", ["irb120", "kr6r900", "lrmate200id", "puma560"])
def test_the_eight_solutions_of_a_pose_are_the_eight_combinations(name: str) -> None:
    arm = open_robot(name)
    found = inverse(arm, pose(arm, np.radians([20.0, -40, 50, 30, 50, 10])))
    told = {tuple(part_words(branch.parts)) for branch in found.branches}
    assert len(told) == len(found.branches)
    shoulders = {words[0] for words in told}
    assert shoulders in ({"shoulder front", "shoulder back"}, {"shoulder left", "shoulder right"})
    assert told <= set(product(sorted(shoulders), ("elbow up", "elbow down"), ("wrist flipped", "wrist not flipped")))
    for branch in found.branches:
        np.testing.assert_allclose(pose(arm, branch.q), found.pose, atol=1e-9)


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


def test_signs_stay_for_what_has_no_word() -> None:
    parts = arm_postures(open_robot("ur5e"), np.radians([[0.0, -90, -90, -90, 90, 0]]))[0]
    assert posture_words(("elbow −", "wrist +", "shoulder −"), parts) == "shoulder right, elbow up, wrist +"
    assert posture_words((), arm_postures(open_robot("panda"), np.zeros((1, 7)))[0]) == "–"
