"""Singularities that poses miss by as little as they are rounded: the joints go straight across, and the tip stays."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.kinematics import pose, task_jacobian
from rankdrop.path.check.follow import follow
from rankdrop.path.check.missed_singularity import StraightCrossing
from rankdrop.path.check.tool_line import poses_at
from rankdrop.path.check.tool_path import check_poses
from rankdrop.poses.inverse import Aim
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task


@pytest.mark.parametrize("poses", [2, 3])
@pytest.mark.parametrize("missed", [1e-10, 1e-8, 1e-6])
def test_a_line_that_misses_a_wrist_by_rounding_goes_straight_on(poses: int, missed: float) -> None:
    """Meca500 along Y through θ = (0, 0, 0, −90°, 0, 90°), the tool tilted by as little as printed digits.

    The configuration is that of Mecademic's programming manual (firmware 9.2), figure 8. The exact solutions turn joint
    4 by 180° within a nanometre; the joints that go straight on keep the tip within its tolerance.
    """
    arm = open_robot("meca500")
    line = np.tile(np.eye(4), (poses, 1, 1))
    line[:, 0, 2], line[:, 2, 0] = missed, -missed
    line[:, :3, 3] = np.stack([np.full(poses, 0.2025), np.linspace(0.05, -0.05, poses), np.full(poses, 0.308)], axis=1)
    start = np.radians([22.62, 4.30, -4.48, -89.56, 22.62, 89.53])
    found = follow(arm, line, start, through=True, tolerance=(1e-4, 1e-4))
    assert found.complete
    assert [passed.rest for passed in found.passed] == [False]
    assert set(range(1, poses + 1)) <= set(found.place.tolist())
    assert np.degrees(np.abs(np.diff(found.q[:, 3]))).max() < 0.2
    targets = poses_at(line, found.place - 1.0)
    reached = pose(arm, found.q)
    assert np.abs(reached - targets).max() <= 2.0 * max(missed, 1e-9)


def test_a_line_that_ends_next_to_a_wrist_singularity_reaches_its_end() -> None:
    arm = open_robot("meca500")
    line = np.tile(np.eye(4), (2, 1, 1))
    line[:, :3, 3] = [[0.2025, 0.05, 0.308], [0.2025, 0.0, 0.308]]  # the last pose is 1e-10 rad from singular
    start = np.radians([22.62, 4.30, -4.48, -89.56, 22.62, 89.53])
    found = follow(arm, line, start, through=True, tolerance=(1e-4, 1e-4))
    assert found.complete
    assert not found.passed
    assert abs(np.degrees(found.q[-1, 3]) + 90.0) < 0.01


@pytest.mark.parametrize("missed", [-1e-6, 1e-10, 1e-8, 1e-6])
@pytest.mark.parametrize("tilted", [1, 2])
def test_a_line_that_begins_next_to_a_wrist_singularity_leaves_it_straight(missed: float, tilted: int) -> None:
    """Meca500 from θ = (0, 0, 0, −90°, 0, 90°) along −Y: the exact solutions turn joint 4 by up to 90° at the start."""
    arm = open_robot("meca500")
    line = np.tile(np.eye(4), (2, 1, 1))
    line[:, 0, tilted], line[:, tilted, 0] = missed, -missed
    line[:, :3, 3] = [[0.2025, 0.0, 0.308], [0.2025, -0.05, 0.308]]
    start = np.radians([0.0, 0.0, 0.0, -90.0, 0.0, 90.0])
    check = check_poses(arm, line, start=start, branches=False)
    assert check.tool is not None
    assert check.tool.complete
    assert np.degrees(np.abs(np.diff(check.tool.q[:, 3]))).max() < 0.2
    ahead = poses_at(line, check.tool.place - 1.0)
    assert np.abs(pose(arm, check.tool.q) - ahead).max() <= 2.0 * max(abs(missed), 1e-9)
    assert check.tool.moved < 1e-3


def test_an_elbow_that_the_first_pose_misses_is_not_left_straight() -> None:
    """A stretched arm leaves by the square root of the way: no row ahead is in line with the singularity."""
    arm = open_robot("puma560")
    stretched = np.radians([10.0, 40.0, 0.0, 20.0, 30.0, 10.0])
    stretched[2] = -np.arctan2(0.4318, 0.0203)  # the wrist in line with axes 2 and 3
    task = resolve_task(None, arm)
    assert abs(np.linalg.det(task_jacobian(arm, stretched, task))) < 1e-12
    aim = Aim(arm, task)
    goal = pose(arm, stretched)
    poses = np.stack([goal, goal])
    poses[1, :3, 3] *= 0.98
    assert StraightCrossing(aim, poses, (1e-4, 1e-4), limits=True).leave(stretched) is None
