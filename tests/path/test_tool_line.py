"""Straight lines of the tool."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.kinematics import pose
from rankdrop.path.check.tool_line import poses_at
from rankdrop.poses.inverse import Aim
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task


@pytest.mark.shipped
@pytest.mark.parametrize("name", ["ur5", "panda", "stanford", "planar3r", "scara"])
def test_the_deviation_of_a_straight_joint_motion_is_below_its_bound(name: str, rng: np.random.Generator) -> None:
    """Rows on a line of poses are the rows' own here, so that the whole deviation is that between the rows."""
    robot = open_robot(name)
    task = resolve_task(None, robot)
    aim = Aim(robot, task)
    for size in (0.3, 0.03, 0.003):
        start = rng.uniform(np.maximum(robot.lower, -1.0), np.minimum(robot.upper, 1.0))
        q = np.stack([start, start + rng.normal(size=robot.n) * size])
        ends = pose(robot, q)
        away, turned = aim.deviation(q, ends)
        share = np.linspace(0, 1, 101)
        now, wanted = pose(robot, q[0] + share[:, None] * (q[1] - q[0])), poses_at(ends, share)
        off = np.linalg.norm(now[:, :3, 3] - wanted[:, :3, 3], axis=1).max()
        cosine = (np.trace(now[:, :3, :3] @ wanted[:, :3, :3].swapaxes(1, 2), axis1=1, axis2=2) - 1) / 2
        assert off <= away[0] * (1 + 1e-9)
        assert np.arccos(np.clip(cosine, -1, 1)).max() <= turned[0] + 1e-7
        assert away[0] <= 40 * off + 1e-9  # and no bound for nothing


@pytest.mark.shipped
def test_a_free_axis_of_the_tool_is_compared_by_its_direction(rng: np.random.Generator) -> None:
    """Rows differ by a turn about Z of the tip, which the task leaves free; the bound is of the direction of Z."""
    robot = open_robot("ur5")
    aim = Aim(robot, resolve_task("tool-axis-free", robot))
    start = rng.uniform(-1.0, 1.0, 6)
    q = np.stack([start, start + rng.normal(size=6) * 0.01])
    ends = pose(robot, q + np.outer([0.7, -0.4], [0, 0, 0, 0, 0, 1]))
    away, turned = aim.deviation(q, ends)
    share = np.linspace(0, 1, 101)
    now, wanted = pose(robot, q[0] + share[:, None] * (q[1] - q[0])), poses_at(ends, share)
    cosine = (now[:, :3, 2] * wanted[:, :3, 2]).sum(axis=1)
    assert np.arccos(np.clip(cosine, -1.0, 1.0)).max() <= turned[0] < 0.2
    assert np.linalg.norm(now[:, :3, 3] - wanted[:, :3, 3], axis=1).max() <= away[0] < 1e-3
