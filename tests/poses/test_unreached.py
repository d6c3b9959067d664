"""Why a pose is not reached."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.kinematics import pose
from rankdrop.poses.branches import inverse
from rankdrop.poses.inverse import rotation
from rankdrop.poses.unreached import EDGE, JOINTS, ORIENTATION, POSITION
from rankdrop.robot.open import open_robot


@pytest.mark.slow
def test_too_few_joints_are_named_with_the_angle_and_the_distance() -> None:
    robot = open_robot("px150")
    found = inverse(robot, [0.2, 0.1, 0.2, 0.0, 0.0, 0.0], starts=300)
    why = found.unreached
    assert why is not None
    assert why.kind == JOINTS
    assert why.turn == pytest.approx(np.arctan2(0.1, 0.2), abs=1e-5)
    assert why.shift == pytest.approx(0.1, abs=1e-5)
    assert "yaw" in found.sentence
    assert "5 joints" in found.sentence
    reached = inverse(robot, [0.2, 0.1, 0.2, 0.0, 0.0, float(np.arctan2(0.1, 0.2))])
    assert reached.branches
    assert reached.unreached is None


@pytest.mark.slow
def test_an_orientation_out_of_reach_is_told_from_a_position() -> None:
    robot = open_robot("ur5e")
    edge = pose(robot, [0.2, -0.5, 0.05, -0.3, 0.7, 0.1])
    edge[:3, :3] = edge[:3, :3] @ rotation(np.array([[0.0, np.pi / 2, 0.0]]))[0]
    found = inverse(robot, edge, starts=300)
    if found.unreached is not None:
        assert found.unreached.kind == ORIENTATION
        assert found.unreached.position <= 1e-6
        assert found.unreached.turn is not None
        np.testing.assert_allclose(found.unreached.turned[:3, 3], edge[:3, 3], atol=1e-4)
    assert found.unreached is not None or found.branches


@pytest.mark.parametrize(("beyond", "kind"), [
    (3e-10, EDGE), (4e-7, EDGE), (3e-6, POSITION), (0.08, POSITION),
])  # fmt: skip
def test_a_pose_that_misses_the_edge_of_reach_by_rounding_says_so(beyond: float, kind: str) -> None:
    """An IRB 120 stretched forward at the height of its shoulder: upper arm, forearm and flange in one line."""
    robot, goal = open_robot("irb120"), np.eye(4)
    goal[:3, :3] = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]
    goal[:3, 3] = 0.27 + np.hypot(0.07, 0.302) + 0.072 + beyond, 0.0, 0.29
    found = inverse(robot, goal, starts=300)
    why = found.unreached
    assert why is not None
    assert why.kind == kind
    assert beyond - 1e-12 <= why.shift <= beyond + 3e-8
    np.testing.assert_allclose(pose(robot, why.near)[:3, 3], why.tip[:3, 3], atol=1e-9)
    assert ("which is rounding" in found.sentence) == (kind == EDGE)
