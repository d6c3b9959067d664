"""The rank at one configuration: how much is lost against almost everywhere, and how much freedom is left over."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.kinematics import one_configuration
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_metres, into_metres, task_in_metres


class Cause(StrEnum):
    """What decides the verdict on a configuration."""

    LOST = "lost"  # the rank is below the generic one
    NEVER = "never"  # the arm is deficient for the task at every configuration
    NEAR_MISS = "near miss"  # σ_r is small, and its local minimum nearby is not zero
    DISTANCE = "distance"  # a singular configuration is near in joint space
    SMALL = "small"  # σ_r is small
    SLOW = "slow"  # some straight motion is slow within the rate limits of the joints
    NONE = "none"  # none of these


@dataclass(frozen=True, slots=True)
class Rank:
    """Rank of the task Jacobian at one configuration.

    Attributes:
        sigma: (min(m, n),) singular values, descending [1].
        sigma_error: bound on the error of each of them: 4 eps ‖J‖ of the one-sided Jacobi method.
        rank: number of singular values above the tolerance.
        generic_rank: rank of almost all configurations.
        corank: generic_rank − rank: task freedoms lost here.
        nullity: n − rank: joint motions that leave the task still to first order.
        always_singular: the generic rank is below min(m, n): the arm is deficient for this task everywhere.
        tolerance: singular values at or below it count as zero.
    """

    sigma: Array
    sigma_error: float
    rank: int
    generic_rank: int
    corank: int
    nullity: int
    always_singular: bool
    tolerance: float


def rank_at(robot: Robot, q: ArrayLike, task: Task, tolerances: Tolerances = DEFAULT) -> Rank:
    """Rank, corank and nullity at one configuration.

    Args:
        robot: the arm.
        q: (n,) configuration [rad, m].
        task: from `resolve_task`.
        tolerances: `singular` decides.

    Raises:
        ConfigurationError: q is not one configuration of this arm.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("pa10")
        >>> found = rank_at(arm, [0.0] * 7, resolve_task(None, arm))
        >>> found.rank, found.corank, found.nullity
        (3, 3, 4)
    """
    configuration = one_configuration(robot, q)
    configuration = into_metres(robot, configuration)
    sigma = singular_values(in_metres(robot), configuration, task_in_metres(task, robot))
    sigma.flags.writeable = False
    generic = generic_rank(robot, task)
    rank = min(generic, int((sigma > tolerances.singular).sum()))
    return Rank(
        sigma=sigma,
        sigma_error=float(4 * np.finfo(float).eps * np.linalg.norm(sigma)),
        rank=rank,
        generic_rank=generic,
        corank=generic - rank,
        nullity=robot.n - rank,
        always_singular=generic < min(task.m, robot.n),
        tolerance=tolerances.singular,
    )
