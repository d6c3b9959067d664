"""A tool at the tip of an arm: the point that moves, and the axes it is told in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import RobotError
from rankdrop.robot.model import Robot
from rankdrop.robot.transform import from_xyz_rpy, times

TOOL = "tool point"
"""What the tip of an arm with a tool is called."""


def with_tool(robot: Robot, xyz: ArrayLike, rpy: Sequence[float] = (0.0, 0.0, 0.0)) -> Robot:
    """The arm with its end effector at a tool point: T(q) = exp(S_1 q_1) … exp(S_N q_N) · home · tool.

    Singularities of the full pose stay where they are; what is lost is told at the new point.

    Args:
        robot: the arm.
        xyz: (3,) the point, from the arm's tip in its axes [m].
        rpy: roll, pitch, yaw of the tool's axes in those of the tip [rad], as in URDF.

    Raises:
        RobotError: not three finite numbers each.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> with_tool(open_robot("planar2r"), (0.1, 0, 0)).home[:3, 3].tolist()
        [1.8, 0.0, 0.0]
    """
    point, turn = np.array(xyz, dtype=np.float64), np.array(rpy, dtype=np.float64)
    for values, what in ((point, "x, y, z"), (turn, "roll, pitch, yaw")):
        if values.shape != (3,) or not np.isfinite(values).all():
            raise RobotError("this is no tool point", got=values.tolist(), allowed=f"three finite numbers {what}")
    tool = from_xyz_rpy(point.tolist(), turn.tolist())
    return replace(robot, home=times(robot.home, tool), tip=TOOL)
