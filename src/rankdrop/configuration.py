"""A configuration of an arm for a task, with its Jacobian taken apart: worked out once, for all that is asked there.

A `Configuration` holds the decomposition J = U Σ Vᵀ split at its rank, the screws and frames of the links, and the room
inside the joint limits; each is computed when it is first read. `configuration_at` makes one of what people say:
(robot, q, task).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from rankdrop import _core
from rankdrop.errors import OptionError, TaskError
from rankdrop.kinematics import (
    chain_of,
    link_poses,
    one_configuration,
    task_jacobian,
    task_jacobian_derivative,
    task_view,
)
from rankdrop.local.block import Decomposition, decompose, read_only
from rankdrop.problem import Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_metres, into_metres, metre_exponent, task_in_metres

LEAST = 1e-3
"""A motion shorter than this is no motion: the joint stands at its limits [rad, or length scales]."""
_FINITE = (0.3, -0.3, 0.7, -0.7)  # finite motions that judge a predicted gain: far from small, and unrelated [rad]
_NOISE = 10.0  # near a singularity a singular value counts as regained once it is so much larger than it was
_ROOM = 0.1  # with less room than this inside the limits the judge looks past them [rad]


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


@dataclass(frozen=True, eq=False)
class Configuration:
    """A configuration of an arm, for one task.

    Attributes:
        problem: arm, task, tolerances.
        q: (n,) configuration [rad, m], not to be written to.
        assumed: corank to take q for, near a singularity; None: the one it has.

    Raises:
        OptionError: when the rank is first read: there is no such corank, or more is lost at q.
    """

    problem: Problem
    q: Array
    assumed: int | None = None

    def __reduce__(self) -> tuple[type[Configuration], tuple[Problem, Array, int | None]]:
        return Configuration, (self.problem, self.q, self.assumed)  # what the core keeps is made anew elsewhere

    @property
    def robot(self) -> Robot:
        """The arm."""
        return self.problem.robot

    @property
    def task(self) -> Task:
        """Rows, frame and length scale."""
        return self.problem.task

    @property
    def tolerances(self) -> Tolerances:
        """Thresholds."""
        return self.problem.tolerances

    @cached_property
    def metric(self) -> Configuration:
        """The same with the arm in metres, where σ is that of rates in rad/s and m/s; mostly itself."""
        if not metre_exponent(self.robot):
            return self
        problem = replace(self.problem, robot=in_metres(self.robot), task=task_in_metres(self.task, self.robot))
        return Configuration(problem, into_metres(self.robot, self.q), self.assumed)

    @cached_property
    def jacobian(self) -> Array:
        """(m, n) task Jacobian, translation rows divided by the length scale."""
        return task_jacobian(self.robot, self.q, self.task)

    @cached_property
    def derivative(self) -> Array:
        """(m, n, n) ∂J/∂q of the task Jacobian; the last axis is the joint by which it is derived."""
        return task_jacobian_derivative(self.robot, self.q, self.task)

    def derivative_along(self, directions: Array) -> Array:
        """(d, m, n) derivatives of the task Jacobian along directions (d, n) in scaled coordinates."""
        along = self.derivative @ (directions * self.scale).T  # (m, n, d)
        return np.ascontiguousarray(along.transpose(2, 0, 1))

    @cached_property
    def links(self) -> Array:
        """(N + 2, 4, 4) poses of base, links and tip."""
        return link_poses(self.robot, self.q)

    @cached_property
    def parts(self) -> Decomposition:
        """J = U Σ Vᵀ."""
        return decompose(self.robot, self.q, self.task)

    @property
    def sigma(self) -> Array:
        """(min(m, n),) singular values, descending [1]."""
        return self.parts.sigma

    @property
    def u(self) -> Array:
        """(m, m) left singular vectors as columns; the first `rank` belong to what is kept."""
        return self.parts.u

    @property
    def v(self) -> Array:
        """(n, n) right singular vectors as columns."""
        return self.parts.v

    @cached_property
    def measured(self) -> Rank:
        """Rank, corank and nullity of the arm in metres."""
        sigma = read_only(self.metric.sigma.copy())
        generic, least = self.problem.generic_rank, self.tolerances.singular
        rank = min(generic, int((sigma > least).sum()))
        return Rank(
            sigma, float(4 * np.finfo(float).eps * np.linalg.norm(sigma)), rank, generic, generic - rank,
            self.robot.n - rank, generic < min(self.task.m, self.robot.n), least,
        )  # fmt: skip

    @property
    def generic(self) -> int:
        """Rank almost everywhere."""
        return self.problem.generic_rank

    @cached_property
    def rank(self) -> int:
        """The rank at q, or the one that is assumed there."""
        lost = self.measured.corank
        if self.assumed is None:
            return self.generic - lost
        if not lost <= self.assumed <= self.generic:
            allowed = f"{lost} (the lost rank) … {self.generic}"
            raise OptionError("q has no such corank", got=self.assumed, allowed=allowed)
        return self.generic - self.assumed

    @property
    def corank(self) -> int:
        """Task freedoms lost at q."""
        return self.generic - self.rank

    @property
    def u2(self) -> Array:
        """(m, m − rank) lost directions of the task."""
        return self.u[:, self.rank :]

    @property
    def v2(self) -> Array:
        """(n, n − rank) null space of the Jacobian."""
        return self.v[:, self.rank :]

    @property
    def scale(self) -> Array:
        """(n,) what one unit of joint motion is measured by [rad, m]."""
        return self.problem.scale

    @cached_property
    def floor(self) -> float:
        """A singular value at or below it is not a rank regained."""
        return max(self.tolerances.singular, _NOISE * float(self.sigma[self.rank]) if self.corank else 0.0)

    @cached_property
    def chain(self) -> _core.Chain:
        """The arm as the core takes it."""
        return chain_of(self.robot)

    @cached_property
    def view(self) -> _core.View:
        """The task as the core takes it."""
        return task_view(self.robot, self.task)

    def kept_jacobian(self) -> Array:
        """(m, n) the Jacobian without the singular values that count as zero."""
        r = self.rank
        return np.asarray((self.u[:, :r] * self.sigma[:r]) @ self.v[:, :r].T)

    def inverse(self) -> Array:
        """(n, m) its pseudo-inverse J⁺."""
        r = self.rank
        return np.asarray((self.v[:, :r] / self.sigma[:r]) @ self.u[:, :r].T)

    def singular_values(self, configurations: Array) -> Array:
        """(..., min(m, n)) singular values at other configurations (..., n), which are finite."""
        rows = np.ascontiguousarray(configurations).reshape(-1, len(self.q))
        sigma = _core.singular_values(self.chain, self.view, rows, None)
        return sigma.reshape(*configurations.shape[:-1], sigma.shape[1])

    def last(self, configurations: Array) -> Array:
        """(...) σ_r at other configurations (..., n), r the generic rank."""
        return self.singular_values(configurations)[..., self.generic - 1]

    @cached_property
    def room(self) -> tuple[Array, Array]:
        """How far each joint can go down and up, (n,) each ≥ 0, in scaled coordinates; from outside only back."""
        down = np.maximum(self.q - self.robot.lower, 0.0) / self.scale
        return down, np.maximum(self.robot.upper - self.q, 0.0) / self.scale

    def judge_steps(self, directions: Array) -> Array:
        """(4, d) signed lengths of finite motions along directions (d, n), scaled coordinates, inside the limits.

        Where the limits leave no room to either side they are not looked at: the judge asks about the arm's geometry.
        """
        down, up = self.room
        size = np.maximum(np.abs(directions), 1e-300)
        forward = np.where(directions > 0, up, np.where(directions < 0, down, np.inf)) / size
        backward = np.where(directions > 0, down, np.where(directions < 0, up, np.inf)) / size
        steps = np.array(_FINITE)[:, None]
        inside = np.clip(steps, -backward.min(axis=-1), forward.min(axis=-1))
        used = np.where(np.abs(inside) >= _ROOM, inside, 0.0)
        return np.where((used != 0.0).any(axis=0), used, steps)

    def check_moves(self) -> None:
        """Refuse an arm that makes no motion of the task anywhere.

        Raises:
            TaskError: the generic rank is 0.
        """
        if not self.generic:
            name = self.robot.name
            raise TaskError("the arm does not move any row of this task", where=f"robot {name!r}", got=self.task.name)


def configuration_at(
    robot: Robot | Configuration,
    q: ArrayLike | None = None,
    task: Task | str | None = None,
    tolerances: Tolerances = DEFAULT,
    corank: int | None = None,
) -> Configuration:
    """The configuration that people say as (robot, q, task); one that is there already is returned as it is.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
        TaskError: there is no such task.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> measured = configuration_at(open_robot("pa10"), [0.0] * 7).measured
        >>> measured.rank, measured.corank, measured.nullity
        (3, 3, 4)
    """
    if isinstance(robot, Configuration):
        return robot
    configuration = read_only(one_configuration(robot, [] if q is None else q))
    return Configuration(Problem(robot, resolve_task(task, robot), tolerances=tolerances), configuration, corank)
