"""What is asked of an arm: where it loses k freedoms of a task, by which thresholds, and whether limits bind.

    rank J(q) ≤ r,   r = generic rank − k

A `Problem` knows what every step of an analysis needs and nobody should pass beside it: the rank r and the generic one,
the scale of joint motions, the box that configurations are drawn from, the joints that do not matter, which joints go
round; and the Jacobian as the problem sees it, `sigma(q)` and `block(q)`. Public functions take (robot, q, task) as
people say it and make one of these; what they call takes the `Problem`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.kinematics import chain_of, handles_of, view_of
from rankdrop.local.block import (
    Block,
    block,
    generic_rank,
    joint_scale,
    limit_box,
    sample,
    sampling_box,
    singular_values,
)
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances

Mask = NDArray[np.bool_]

SAME_SIGMA = 1e-12  # singular values that differ by less are the same [1]
_EDGE = 1e-9  # a joint this far beyond a limit stands at it [rad, m]


def wrap(angle: Array) -> Array:
    """Angles in (−π, π]."""
    return np.asarray(np.pi - np.mod(np.pi - angle, 2 * np.pi))


def wrap_joints(robot: Robot, q: Array) -> Array:
    """(..., n) the same configurations, turning joints in (−π, π]."""
    return np.asarray(np.where(robot.periodic, wrap(q), q))


def into_one_turn(robot: Robot, q: Array) -> Array:
    """(N, n) the same configurations, turning joints by whole turns into [−π, π]; what is there stays to the last bit.
    """
    turned = np.clip(q - 2 * np.pi * np.ceil((q - np.pi) / (2 * np.pi)), -np.pi, np.pi)
    return np.asarray(np.where(robot.periodic, turned, q))


def into_limits(robot: Robot, q: Array) -> Array:
    """(..., n) the same configurations, turning joints by as few whole turns as bring them between their limits.

    Those that no turn brings there stay, as do slides.
    """
    short = np.ceil(np.maximum(robot.lower - _EDGE - q, 0.0) / (2 * np.pi))
    long = np.ceil(np.maximum(q - robot.upper - _EDGE, 0.0) / (2 * np.pi))
    turned = q + 2 * np.pi * (short - long)
    there = robot.periodic & (turned >= robot.lower - _EDGE) & (turned <= robot.upper + _EDGE)
    return np.asarray(np.where(there, turned, q))


def whole_turns(robot: Robot, way: Array) -> Array:
    """(..., n) the whole turns in a joint motion: what is left without them is the shortest way to the same place."""
    return np.asarray(2 * np.pi * np.where(robot.periodic, np.round(way / (2 * np.pi)), 0.0))


@dataclass(frozen=True, eq=False)
class Problem:
    """Where does this arm lose k freedoms of this task?

    Attributes:
        robot, task: the arm.
        corank: k, freedoms lost; 0 asks for the generic rank.
        tolerances: thresholds.
        limits: only configurations within the joint limits count.
    """

    robot: Robot
    task: Task
    corank: int = 1
    tolerances: Tolerances = DEFAULT
    limits: bool = False

    def at(self, corank: int) -> Problem:
        """The same arm, asked for another corank."""
        return replace(self, corank=corank)

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.robot.n

    @cached_property
    def generic_rank(self) -> int:
        """Rank of the task Jacobian at almost all configurations."""
        return generic_rank(self.robot, self.task)

    @property
    def rank(self) -> int:
        """r = generic rank − k, the rank that is kept; σ[r] vanishes on the set that is asked for."""
        return self.generic_rank - self.corank

    @cached_property
    def scale(self) -> Array:
        """(n,) what one unit of joint motion is measured by: 1 for a turning joint, the length scale for a slide."""
        return joint_scale(self.robot, self.task)

    @cached_property
    def box(self) -> tuple[Array, Array]:
        """Lower and upper corner (n,) of the configurations worth sampling [rad, m]."""
        return sampling_box(self.robot, self.task, limits=self.limits)

    @cached_property
    def walls(self) -> tuple[Array, Array] | None:
        """Lower and upper corner (n,) of where a motion may go [rad, m]; None where no limits are asked for."""
        if self.limits:
            return limit_box(self.robot, self.task)
        return None

    @cached_property
    def idle(self) -> Mask:
        """(n,) joints on which the singular values do not depend at all: the first and the last one for a pose, say."""
        known = handles_of(self.robot).idle
        key = (self.task.frame, self.task.rows, self.task.scale(self.robot), self.limits)
        if key not in known:
            rng = np.random.default_rng(0)
            q = np.repeat(self.random(16, rng)[None], self.n + 1, axis=0)  # (n + 1, 16, n), the last one unchanged
            j = np.arange(self.n)
            q[j, :, j] = self.random(16, rng).T
            sigma = self.sigma(q)
            known[key] = np.abs(sigma[:-1] - sigma[-1]).max(axis=(1, 2)) < SAME_SIGMA
            known[key].flags.writeable = False
        return known[key]

    def sigma(self, q: Array) -> Array:
        """(..., min(m, n)) singular values of the task Jacobian at q (..., n), finite, descending [1]."""
        if q.ndim == 1:
            return singular_values(self.robot, q, self.task)
        rows = np.ascontiguousarray(q).reshape(-1, self.n)
        sigma = _core.singular_values(chain_of(self.robot), view_of(self.robot, self.task), rows)
        return sigma.reshape(*q.shape[:-1], sigma.shape[1])

    def block(self, q: Array) -> Block:
        """F and D at q (..., n), beyond the rank that is kept."""
        return block(self.robot, q, self.task, self.rank)

    def singular(self, q: Array) -> Mask:
        """(N,) whether k freedoms or more are lost at q (N, n): σ[r] ≤ `singular`."""
        if not len(q):
            return np.zeros(0, dtype=np.bool_)
        return np.asarray(self.sigma(q)[:, self.rank] <= self.tolerances.singular)

    def random(self, count: int, rng: np.random.Generator) -> Array:
        """(count, n) uniform configurations of the box."""
        return rng.uniform(*self.box, size=(count, self.n))

    def sample(self, count: int, seed: int) -> Array:
        """(count, n) the same from a seed: the starts of a search."""
        return sample(self.robot, self.task, count, seed, limits=self.limits)

    def within_limits(self, q: Array) -> Mask:
        """(N,) whether configurations respect the limits, angles up to whole turns; all True without limits."""
        ok = np.ones(len(q), dtype=np.bool_)
        if not self.limits:
            return ok
        for j, joint in enumerate(self.robot.variables):
            x = q[:, j]
            if self.robot.periodic[j] and np.isfinite(joint.lower):
                x = joint.lower - _EDGE + np.mod(x - joint.lower + _EDGE, 2 * np.pi)
            ok &= (x >= joint.lower - _EDGE) & (x <= joint.upper + _EDGE)
        return ok

    def length(self, way: Array) -> Array:
        """(...) norms of joint motions (..., n) in scaled joint coordinates [rad; metres divided by the length scale].
        """
        scaled = way / self.scale
        return np.asarray(np.sqrt(np.add.reduce(scaled * scaled, axis=-1)))
