"""The configuration at the first pose of a tool path: that of the start, else the posture that people use."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.errors import ConfigurationError
from rankdrop.kinematics import pose
from rankdrop.local.posture import fault, spine
from rankdrop.path.check import first_pose
from rankdrop.path.check.first_pose import within_limits
from rankdrop.path.check.tool_path import check_poses
from rankdrop.poses.inverse import joint_difference
from rankdrop.robot.open import open_robot
from rankdrop.robot.transform import from_xyz_rpy
from rankdrop.task import resolve_task
from rankdrop.text.tool_paths import branch_chosen


@pytest.mark.spread(1)
@pytest.mark.slow
@pytest.mark.parametrize(("name", "q", "counts"), [
    ("puma560", [0.2, -0.6, 0.3, 0.4, 0.0, 0.3], (2, 1)),
    ("ur5e", [0.3, -1.2, 1.4, -1.0, 0.0, 0.4], (4, 2)),
    ("puma560", [0.2, -0.6, 0.3, 0.4, 0.5, 0.3], (2, 0)),
])  # fmt: skip
def test_points_of_a_self_motion_are_not_counted_as_solutions(
    monkeypatch: pytest.MonkeyPatch, name: str, q: list[float], counts: tuple[int, int]
) -> None:
    """Newton's method ends on more points of a self-motion from more starts; the counts stay what they are."""
    arm = open_robot(name)
    goal = pose(arm, np.array(q))
    found = []
    for starts in (256, 512):
        monkeypatch.setattr(first_pose, "STARTS", starts)
        many = within_limits(arm, goal, resolve_task(None, arm))
        found.append(len(many))
        assert first_pose.count_solutions(arm, goal, resolve_task(None, arm), many) == counts
    assert (found[1] > found[0]) == (counts[1] > 0)
    tool = check_poses(arm, goal[None]).tool
    assert (tool.solutions, tool.self_motions) == counts
    assert (f"of {counts[1]} self-motion" in tool.chosen) == (counts[1] > 0)


@pytest.mark.slow
def test_a_start_near_the_first_pose_is_enough() -> None:
    arm = open_robot("ur5e")
    task = resolve_task(None, arm)
    goal = from_xyz_rpy([0.4, 0.2, 0.3], [np.pi, 0.0, 0.0])
    known = within_limits(arm, goal, task)
    rng = np.random.default_rng(4)
    for row, size in ((0, 0.1), (3, 0.4), (5, 0.7), (7, 0.8)):
        for _ in range(2):
            way = rng.normal(size=6)
            start = known[row] + size * way / np.linalg.norm(way)
            found = check_poses(arm, goal[None], start=start, branches=False)
            nearest = np.linalg.norm(joint_difference(arm, start, known), axis=1).min()
            taken = np.linalg.norm(joint_difference(arm, start, np.asarray(found.tool.start)[None]), axis=1)[0]
            assert taken == pytest.approx(nearest, abs=1e-6)
            assert found.tool.moved == pytest.approx(taken, abs=1e-6)


def test_the_posture_that_people_use_has_its_elbow_up() -> None:
    arm = open_robot("ur5e")
    for place in ([-0.4, 0.2, 0.3], [0.4, 0.2, 0.3], [0.5, -0.3, 0.4]):
        known = within_limits(arm, from_xyz_rpy(place, [np.pi, 0.0, 0.0]), resolve_task(None, arm))
        assert len(known) == 8
        height = spine(arm, known)[:, :, 2].mean(axis=1)
        assert height[0] > np.median(height)
        assert fault(arm, known)[0] == 0.0


ARM = open_robot("ur5")
Q = np.array([[0.3, -1.2, 1.4, -1.0, 1.2, 0.4], [0.6, -1.0, 1.2, -1.2, 1.0, 0.4], [0.5, -0.9, 1.1, -1.1, 0.9, 0.1]])
POSES = pose(ARM, Q)


@pytest.mark.slow
def test_without_a_start_the_posture_that_people_use_is_taken() -> None:
    task = resolve_task(None, ARM)
    known = within_limits(ARM, POSES[0], task)
    assert len(known) == 8
    assert np.abs(pose(ARM, known) - POSES[0]).max() < 1e-9
    assert fault(ARM, known[:1])[0] == fault(ARM, known).min()
    assert np.linalg.norm(known - Q[0], axis=1).min() < 1e-9
    found = check_poses(ARM, POSES[:1])
    np.testing.assert_allclose(found.tool.start, known[0], atol=1e-9)
    assert branch_chosen(found.tool) == "the posture that people use (one of 8 found)"


def test_a_first_pose_out_of_reach_and_bad_starts_are_errors() -> None:
    away = POSES + 0.0
    away[:, :3, 3] *= 1000
    with pytest.raises(ConfigurationError, match=r"poses: pose 1 is out of reach: no configuration within the joint"):
        check_poses(ARM, away)
    with pytest.raises(ConfigurationError, match=r"start: pose 1 is not reached"):
        check_poses(ARM, away, start=Q[0])
    with pytest.raises(ConfigurationError, match=r"start: the start is one configuration; got shape \(2,\)"):
        check_poses(ARM, POSES, start=[0, 0])
    with pytest.raises(ConfigurationError, match=r"poses, pose 2: the last row of the matrix is not 0 0 0 1; got"):
        check_poses(ARM, POSES * np.array([1, 2, 1])[:, None, None])
    with pytest.raises(ConfigurationError, match=r"t, pose 3: time does not go on"):
        check_poses(ARM, POSES, [0, 1, 1])


def inwards(beyond: float) -> np.ndarray:
    """(3, 4, 4) poses of an IRB 120 from the edge of reach forward, and beyond it, straight inwards."""
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[:, :3, :3] = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]
    poses[:, 2, 3] = 0.29
    poses[:, 0, 3] = 0.27 + np.hypot(0.07, 0.302) + 0.072 + np.array([beyond, -0.05, -0.1])
    return poses


@pytest.mark.parametrize("beyond", [4.5e-10, 4e-7])
@pytest.mark.parametrize("start", [None, np.radians([0.0, 90.0, -76.95, 0.0, -13.05, 0.0])])
def test_a_path_begins_at_the_edge_of_reach_that_its_first_pose_misses_by_rounding(
    beyond: float, start: np.ndarray | None
) -> None:
    arm, poses = open_robot("irb120"), inwards(beyond)
    check = check_poses(arm, poses, start=start)
    assert check.tool.complete
    assert check.verdict == "touching"
    np.testing.assert_allclose(pose(arm, check.curve.samples[0]), poses[0], atol=2 * beyond)
    np.testing.assert_allclose(pose(arm, check.curve.samples[-1]), poses[-1], atol=1e-9)
    assert check.tool.off >= beyond - 1e-12
    assert any("beyond the edge of reach" in note for note in check.notes)


def test_a_first_pose_beyond_the_edge_by_more_is_out_of_reach() -> None:
    with pytest.raises(ConfigurationError, match="out of reach"):
        check_poses(open_robot("irb120"), inwards(1e-5))
