"""Random members of a family of an atlas, from its equations alone."""

from __future__ import annotations

import numpy as np

from rankdrop.families.record import Family
from rankdrop.formula.equation import System
from rankdrop.local.block import generic_rank, sample, singular_values
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task


def members(robot: Robot, task: Task, family: Family, count: int, seed: int = 0, starts: int = 400) -> Array:
    """(≤ count, n) solutions of the equations from random starts, of exactly the family's corank."""
    q, solved = System(family.equations).solve(sample(robot, task, starts, seed), iterations=60)
    sigma = singular_values(robot, q, task)
    rank = generic_rank(robot, task) - family.corank
    good = solved & (sigma[:, rank] <= 1e-12)
    if rank:
        good &= sigma[:, rank - 1] > 1e-4
    return np.asarray(q[good][:count])
