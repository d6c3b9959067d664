"""The tool path of a joint path: how far it is from singularities, and how densely new joint paths follow it."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.local.block import joint_scale, singular_values
from rankdrop.path.curve import curve
from rankdrop.path.mend.joint_tool_path import tool_path
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task


@pytest.mark.parametrize("name", ["pa10", "gen3", "ur5", "planar3r"])
def test_the_slope_of_sigma_is_that_of_differences(name: str) -> None:
    robot = open_robot(name)
    task = resolve_task("planar-position" if name == "planar3r" else None, robot)
    rank, h = task.m, 1e-5
    q = np.random.default_rng(2).uniform(-1.5, 1.5, (20, robot.n))
    scale = joint_scale(robot, task)
    sigma, slope = tool_path(robot, task, curve(q, None)).rising(q)
    for j in range(robot.n):
        way = h * scale[j] * np.eye(robot.n)[j]
        up, down = (singular_values(robot, q + sign * way, task)[:, rank - 1] for sign in (1.0, -1.0))
        np.testing.assert_allclose(slope[:, j], (up - down) / (2 * h), atol=1e-6)
    np.testing.assert_allclose(sigma, singular_values(robot, q, task)[:, rank - 1], atol=1e-12)
