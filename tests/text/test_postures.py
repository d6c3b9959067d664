"""The words of a posture: front or back, elbow up or down."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from rankdrop.kinematics import pose
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


def test_signs_stay_for_what_has_no_word() -> None:
    parts = arm_postures(open_robot("ur5e"), np.radians([[0.0, -90, -90, -90, 90, 0]]))[0]
    assert posture_words(("elbow −", "wrist +", "shoulder −"), parts) == "shoulder right, elbow up, wrist +"
    assert posture_words((), arm_postures(open_robot("panda"), np.zeros((1, 7)))[0]) == "–"
