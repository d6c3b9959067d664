"""The motions that a family takes away, as directions and in words."""

from __future__ import annotations

import numpy as np

from rankdrop.local.directions import lost_directions, lost_in_sparsest_frame, lost_over_family
from rankdrop.local.sentences import words
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.units import counted_length


def told(robot: Robot, at: Array, points: Array, task: Task, corank: int) -> tuple[Array, tuple[str, ...]]:
    """Lost directions at a configuration in the task's frame, and one sentence each.

    The words are for the whole family where some frame of the chain sees the same directions at all its points; else
    they are for the configuration, in the frame where they are sparsest, and say so.

    Args:
        robot: the arm.
        at: (n,) a configuration on the family, of exactly its corank.
        points: (N, n) others.
        task: the rows that matter.
        corank: of the family.
    """
    directions = lost_directions(robot, at, task, corank)
    length = counted_length(robot)
    steady = lost_over_family(robot, np.vstack([at, points[:5]]), task, corank)
    if steady is not None:
        return directions, tuple(words(direction, steady.name, length) for direction in steady.directions)
    plain = lost_in_sparsest_frame(robot, at, task, corank)
    return directions, tuple(f"{words(one, plain.name, length)} (at the witness)" for one in plain.directions)
