"""A configuration with its Jacobian taken apart, and the room it has inside the joint limits."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from rankdrop import _core
from rankdrop.errors import OptionError, TaskError
from rankdrop.kinematics import chain_of, one_configuration, task_view
from rankdrop.local.block import decompose, joint_scale
from rankdrop.local.verdict import rank_at
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import Tolerances

LEAST = 1e-3
"""A motion shorter than this is no motion: the joint stands at its limits [rad, or length scales]."""
_FINITE = (0.3, -0.3, 0.7, -0.7)  # finite motions that judge a predicted gain: far from small, and unrelated [rad]
_NOISE = 10.0  # near a singularity a singular value counts as regained once it is so much larger than it was
_ROOM = 0.1  # with less room than this inside the limits the judge looks past them [rad]


@dataclass(frozen=True, slots=True)
class Place:
    """A configuration, its singular value decomposition split at its rank, and what counts as zero there.

    Attributes:
        robot, q, task: what and where; q is (n,).
        rank, generic: rank at q, and almost everywhere.
        sigma: (min(m, n),) singular values at q.
        u, v: (m, m), (n, n) singular vectors as columns; the first `rank` belong to what is kept.
        scale: (n,) what one unit of joint motion is measured by [rad, m].
        floor: a singular value at or below it is not a rank regained.
        chain, view: arm and task as the core takes them.
    """

    robot: Robot
    q: Array
    task: Task
    rank: int
    generic: int
    sigma: Array
    u: Array
    v: Array
    scale: Array
    floor: float
    chain: _core.Chain
    view: _core.View

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

    def kept(self) -> Array:
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


def check_moves(robot: Robot, task: Task, generic_rank: int) -> None:
    """Refuse an arm that makes no motion of the task anywhere.

    Raises:
        TaskError: the generic rank is 0.
    """
    if not generic_rank:
        raise TaskError("the arm does not move any row of this task", where=f"robot {robot.name!r}", got=task.name)


def place_at(robot: Robot, q: ArrayLike, task: Task, tolerances: Tolerances, corank: int | None = None) -> Place:
    """The configuration with its singular value decomposition split at its rank.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
        OptionError: there is no such corank, or more is lost at q.
        TaskError: the arm does not move in this task at all.
    """
    configuration = one_configuration(robot, q)
    task = replace(task, length_scale=task.scale(robot))  # the reach is worked out once
    verdict = rank_at(robot, configuration, task, tolerances)
    generic = verdict.generic_rank
    check_moves(robot, task, generic)
    lost = verdict.corank if corank is None else corank
    if not verdict.corank <= lost <= generic:
        raise OptionError("q has no such corank", got=corank, allowed=f"{verdict.corank} (what is lost) … {generic}")
    rank = generic - lost
    parts = decompose(robot, configuration, task)
    noise = float(parts.sigma[rank]) if lost else 0.0
    return Place(
        robot, configuration, task, rank, generic, parts.sigma, parts.u, parts.v, joint_scale(robot, task),
        floor=max(tolerances.singular, _NOISE * noise), chain=chain_of(robot), view=task_view(robot, task),
    )  # fmt: skip


def room(place: Place) -> tuple[Array, Array]:
    """How far each joint can go down and up, (n,) each ≥ 0, in scaled coordinates; from outside only the way back."""
    down = np.maximum(place.q - place.robot.lower, 0.0) / place.scale
    up = np.maximum(place.robot.upper - place.q, 0.0) / place.scale
    return down, up


def judge_steps(place: Place, directions: Array) -> Array:
    """(4, d) signed lengths of finite motions along directions (d, n), scaled coordinates, kept inside the limits.

    Where the limits leave no room to either side they are not looked at: the judge asks about the arm's geometry.
    """
    down, up = room(place)
    size = np.maximum(np.abs(directions), 1e-300)
    forward = np.where(directions > 0, up, np.where(directions < 0, down, np.inf)) / size
    backward = np.where(directions > 0, down, np.where(directions < 0, up, np.inf)) / size
    low, high = -backward.min(axis=-1), forward.min(axis=-1)
    steps = np.array(_FINITE)[:, None]
    inside = np.clip(steps, low, high)
    used = np.where(np.abs(inside) >= _ROOM, inside, 0.0)
    return np.where((used != 0.0).any(axis=0), used, steps)
