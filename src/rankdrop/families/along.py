"""Singular values along lines of joint space: one joint swept, the others held."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.local.block import generic_rank, sampling_box, singular_values
from rankdrop.local.verdict import one_configuration
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task


@dataclass(frozen=True, eq=False)
class Sweep:
    """One joint swept through a configuration.

    Attributes:
        number: the joint, from 1.
        unit: "rad" or "m".
        at: its value in the configuration.
        values: (N,) its values, increasing; `at` is one of them.
        sigma: (N, r) singular values σ_1 … σ_r there, descending, r the generic rank.
    """

    number: int
    unit: str
    at: float
    values: Array
    sigma: Array


def sweeps(robot: Robot, q: ArrayLike, task: Task, count: int = 121) -> tuple[Sweep, ...]:
    """Singular values with each joint swept in turn: a whole turn about q, or the travel of a slide.

    Args:
        robot, task: the arm.
        q: (n,) [rad, m].
        count: values of each joint, one more where the configuration's own is not among them.

    Returns:
        One `Sweep` per joint.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
    """
    centre = one_configuration(robot, q)
    low, high = sampling_box(robot, task, limits=False)
    rank = generic_rank(robot, task)
    found = []
    for j, joint in enumerate(robot.variables):
        begin, end = (-np.pi, np.pi) if robot.periodic[j] else (min(low[j], centre[j]), max(high[j], centre[j]))
        values = np.union1d(np.linspace(begin, end, count), [centre[j]])
        line = np.repeat(centre[None], len(values), axis=0)
        line[:, j] = values
        sigma = singular_values(robot, line, task)[:, :rank]
        found.append(Sweep(j + 1, joint.unit, float(centre[j]), values, sigma))
    return tuple(found)
