"""A path to try: from a good posture of any arm through the nearest singular configuration and beyond."""

from __future__ import annotations

import numpy as np

from rankdrop.local import nearest_singularity, start_posture
from rankdrop.path.read.trajectory import Trajectory
from rankdrop.robot import Robot
from rankdrop.task import Task

_BEYOND = 0.5  # how far past the singular configuration, as a share of the way to it
_DIGITS = 4  # of the joint values, as people type them [rad, m]
_TIMES = np.array([0.0, 2.0, 4.0])


def example_path(robot: Robot, task: Task) -> Trajectory:
    """Three rows in 4 s that cross a singularity in the middle of the second half, or come near one.

        q₀, q₀ + (q* − q₀)/2, q₀ + 3 (q* − q₀)/2

    q₀ is `start_posture`, q* the nearest singular configuration inside the joint limits. Where none is found, joint 1
    moves by 0.2.

    Args:
        robot: any arm.
        task: from `resolve_task`.

    Returns:
        q is (3, n) [rad, m], inside the joint limits, rounded to four decimals.
    """
    start = start_posture(robot, task)
    near = nearest_singularity(robot, start, task, limits=True)
    if near is not None:
        way = near.q - start
    else:
        way = 0.2 * np.eye(robot.n)[0]
    rows = [start, start + 0.5 * way, start + (1.0 + _BEYOND) * way]
    q = np.clip(np.round(rows, _DIGITS), robot.lower, robot.upper)
    return Trajectory(f"{robot.name} example", _TIMES, q, True, ())
