"""Straight moves between poses of the tip, judged; and where they cannot be followed, why."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.kinematics import pose
from rankdrop.path.check.tool_branch import Followed
from rankdrop.path.check.tool_path import _whole_turn_away, check_poses
from rankdrop.robot.open import open_robot

ARM = open_robot("ur5")
Q = np.array([[0.3, -1.2, 1.4, -1.0, 1.2, 0.4], [0.6, -1.0, 1.2, -1.2, 1.0, 0.4], [0.5, -0.9, 1.1, -1.1, 0.9, 0.1]])
POSES = pose(ARM, Q)
T = np.array([0.0, 1.0, 3.0])


@pytest.mark.slow
def test_the_tip_goes_straight_through_every_pose() -> None:
    found = check_poses(ARM, POSES, T, start=Q[0])
    assert found.verdict == "free"
    tool = found.tool
    assert (tool.poses, tool.complete, tool.reached, tool.reason) == (3, True, 3.0, "")
    q = np.concatenate([found.curve.control[:, 0], found.curve.control[-1:, -1]])
    whole = np.flatnonzero(tool.place == np.round(tool.place))
    np.testing.assert_allclose(q[whole], Q, atol=1e-9)
    np.testing.assert_allclose(found.curve.times[whole], T)
    at, now = tool.place - 1, pose(ARM, q)[:, :3, 3]
    line = np.stack([np.interp(at, [0, 1, 2], POSES[:, k, 3]) for k in range(3)], axis=1)
    assert np.linalg.norm(now - line, axis=1).max() < 1e-10
    middle = (q[1:] + q[:-1]) / 2
    off = np.linalg.norm(pose(ARM, middle)[:, :3, 3] - (line[1:] + line[:-1]) / 2, axis=1).max()
    assert off <= tool.off <= 1e-4
    assert tool.turned <= 1e-4


@pytest.mark.by_hand
def test_where_it_cannot_be_followed_is_told_with_its_reason() -> None:
    away = POSES.copy()
    away[2, :3, 3] = away[1, :3, 3] + [3.0, 0.0, 0.0]
    found = check_poses(ARM, away, start=Q[0])
    # it ends at the singularity, a last row to 1e-8 rad: beyond it that row makes a crossing
    assert found.verdict in ("crossing", "cannot be followed")
    assert not found.holds
    assert found.tool.reason == "singular"
    assert 2.0 < found.tool.reached < 3.0
    assert found.sentence.startswith("Cannot be followed beyond pose 2.")
    assert "pose 3 is out of reach" in found.sentence
    assert found.to_dict()["tool"]["complete"] is False
    puma = open_robot("puma560")
    q = np.array([0.3, -0.46, 0.62, 0.78, -0.94, 1.1])
    limit = check_poses(puma, pose(puma, q + np.outer([0, 1], [0, 0, puma.upper[2] - q[2] + 0.2, 0, 0, 0])), start=q)
    assert limit.tool.reason == "limit"
    assert "joint 3 (joint3) reaches its limit at pose 1." in limit.sentence
    last = limit.curve.control[-1, -1]
    assert last[2] == pytest.approx(puma.upper[2], abs=1e-3)


@pytest.mark.slow
def test_a_straight_move_through_a_singularity_does_not_get_past_it() -> None:
    arm = open_robot("planar3r")
    ends = pose(arm, [[0.5, 0.9, -0.8], [0.0, 0.0, 0.0]])
    ends[1, 0, 3] += 0.05  # a little out of reach
    found = check_poses(arm, ends)
    assert found.tool.reason == "singular"
    assert "out of reach" in found.sentence
    assert not found.holds


def test_a_branch_that_winds_a_joint_up_is_followed_from_a_whole_turn_away_too() -> None:
    """A UR5e turns its tool by 500° about the vertical; joint 6 has 720° of range and begins at 99°."""
    arm, angles = open_robot("ur5e"), np.radians(np.linspace(0.0, 500.0, 51))
    poses = np.repeat(np.eye(4)[None], len(angles), axis=0)
    poses[:, 0, 0], poses[:, 0, 1] = np.cos(angles), -np.sin(angles)
    poses[:, 1, 0], poses[:, 1, 1] = -np.sin(angles), -np.cos(angles)
    poses[:, 2, 2] = -1.0
    poses[:, :3, 3] = [-0.4, -0.2, 0.3]
    check = check_poses(arm, poses)
    taken = next(branch for branch in check.tool.branches if branch.chosen)
    assert (taken.complete, taken.reason, taken.joint) == (False, "limit", 6)
    turned = [
        branch for branch in check.tool.branches
        if np.allclose(branch.start - taken.start, [0, 0, 0, 0, 0, -2 * np.pi], atol=1e-9)
    ]  # fmt: skip
    assert [(branch.complete, branch.free, branch.posture) for branch in turned] == [(True, True, taken.posture)]
    again = check_poses(arm, poses, start=turned[0].start)
    assert again.verdict == "free"
    assert again.curve.control[-1, -1, 5] - again.curve.control[0, 0, 5] == pytest.approx(np.radians(500.0), abs=1e-6)
    assert any("is free to the end: start=" in line for line in check.summary)


@pytest.mark.parametrize(
    ("begins", "ends", "expected"), [(99.0, 360.0, -261.0), (-99.0, -360.0, 261.0), (-81.0, 360.0, None)]
)
def test_a_start_a_whole_turn_away_is_inside_the_limits(begins: float, ends: float, expected: float | None) -> None:
    """Joint 6 of a UR5e has 360° either way: from −81° there is no room for another turn back."""
    q = np.zeros((2, 6))
    q[:, 5] = np.radians([begins, ends])
    branch = Followed(q, np.array([1.0, 2.0]), complete=False, reached=2.0, last=q[1], reason="limit", joint=6)
    turned = _whole_turn_away(open_robot("ur5e"), q[0], branch)
    if expected is None:
        assert turned is None
    else:
        assert np.degrees(turned).round(9).tolist() == [0.0, 0.0, 0.0, 0.0, 0.0, expected]
