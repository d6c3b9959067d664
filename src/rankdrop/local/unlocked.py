"""Mimic joints let go: what belongs to one screw alone is asked of a chain in which every joint is a variable."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rankdrop.robot.model import Array, Robot


def unlocked(robot: Robot, q: Array) -> tuple[Robot, Array, Array]:
    """The same chain with every mimic joint a variable of its own.

    Args:
        robot: the arm.
        q: (n,) configuration [rad, m].

    Returns:
        The chain with N variables; its configuration (N,); and the share (N, n) each variable of `robot` has in it.
    """
    if robot.n == len(robot.joints):
        return robot, q, np.eye(robot.n)
    index = {joint.name: i for i, joint in enumerate(robot.variables)}
    share, offset = np.zeros((len(robot.joints), robot.n)), np.zeros(len(robot.joints))
    for row, joint in enumerate(robot.joints):
        if joint.mimic is None:
            share[row, index[joint.name]] = 1.0
        else:
            share[row, index[joint.mimic.leader]], offset[row] = joint.mimic.multiplier, joint.mimic.offset
    free = replace(robot, joints=tuple(replace(joint, mimic=None) for joint in robot.joints))
    return free, share @ q + offset, share
