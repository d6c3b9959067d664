"""Points of the singular set near many configurations, whatever family they are of.

Where an arm's families are not known, or not all of their conditions, the singular set itself is walked on:

    q ← q0 − D⁺(F(q) + D (q0 − q)),   F = U₂ᵀ J V₂ and its derivative D in scaled joint variables

is the nearest point of the set's tangent plane at q. Walks begin at q0 and at the nearest points of a cloud that a
search has found.
"""

from __future__ import annotations

from math import pi

import numpy as np

from rankdrop.families.search_record import Outcome
from rankdrop.families.searching import search
from rankdrop.family.system import shortest
from rankdrop.local.block import block, generic_rank, joint_scale, singular_values
from rankdrop.local.nearest import idle_joints
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT

CLOUD = 1500
"""Starts of the search for points that walks begin at."""
_SEEDS = 10  # of them, for each configuration
_ITERATIONS, _POLISH = 12, 4
_LONGEST = 0.5  # step [rad]
_FAR = 1e3  # radius of the circle that slides are laid on [length scales]
_ILL = 1e-8  # determinant of two rows of unit length below it: they are taken as one


class Anywhere:
    """Walks onto the set of corank 1.

    Args:
        robot: the arm, in metres.
        task: from `resolve_task`.
        box: (2, n) limits, infinite where there are none.
        seed: of the search.
    """

    def __init__(self, robot: Robot, task: Task, box: Array, seed: int) -> None:
        self.robot, self.task, self.box = robot, task, box
        self.rank = generic_rank(robot, task) - 1
        self.scale = joint_scale(robot, task)
        self.moves = ~idle_joints(robot, task)
        limited = bool(np.isfinite(box).all())
        found = search(robot, 1, task=task, starts=CLOUD, seed=seed, limits=limited)
        self.cloud = found.q[found.outcome == Outcome.CONVERGED]

    def feet(self, q: Array) -> Array:
        """(N, n) the nearest singular configuration reached from each start; nan where none was."""
        starts = [np.clip(q, self.box[0], self.box[1]), *self._near(q)]
        targets = np.concatenate([q] * len(starts))
        ends = self._walked(np.concatenate(starts), targets)
        there = singular_values(self.robot, ends, self.task)[:, self.rank] <= DEFAULT.singular
        far = np.where(there, np.linalg.norm((ends - targets) / self.scale, axis=1), np.inf).reshape(len(starts), -1)
        best, rows = far.argmin(axis=0), np.arange(len(q))
        feet = ends.reshape(len(starts), len(q), -1)[best, rows]
        return np.where(np.isfinite(far[best, rows])[:, None], feet, np.nan)

    def _near(self, q: Array) -> list[Array]:
        if not len(self.cloud):
            return []
        count = min(_SEEDS, len(self.cloud))
        order = np.argpartition(-(self._round(q) @ self._round(self.cloud).T), count - 1, axis=1)[:, :count]
        chosen = self.cloud[order]  # (N, seeds, n)
        gap = chosen - q[:, None]
        turns = np.where(self.robot.periodic, np.round(gap / (2 * pi)), 0.0)
        moved = chosen - 2 * pi * turns
        moved = np.where((moved >= self.box[0]) & (moved <= self.box[1]), moved, chosen)
        start = np.where(self.moves, moved, q[:, None])
        return [np.clip(start[:, k], self.box[0], self.box[1]) for k in range(count)]

    def _round(self, q: Array) -> Array:
        """Points whose inner products are large where configurations are near: joints that turn as (cos, sin)."""
        turning, sliding = self.moves & self.robot.periodic, self.moves & ~self.robot.periodic
        x = q[:, sliding] / self.scale[sliding]
        size = np.sqrt(np.maximum(_FAR**2 - x**2, 0.0))  # on a circle too, so wide that it is straight
        return np.concatenate([np.cos(q[:, turning]), np.sin(q[:, turning]), x, size], axis=1)

    def _walked(self, q: Array, targets: Array) -> Array:
        active = np.arange(len(q))
        for step_number in range(_ITERATIONS + _POLISH):
            f, a = self._linear(q[active])
            away = np.zeros_like(q[active])
            if step_number < _ITERATIONS:  # after that straight onto the set
                away = (targets[active] - q[active]) / self.scale
            step = away - _solved(a, f + np.einsum("nec,nc->ne", a, away))
            length = np.linalg.norm(step, axis=1)
            step *= np.minimum(1.0, _LONGEST / np.maximum(length, 1e-300))[:, None]
            q[active] = np.clip(q[active] + step * self.scale, self.box[0], self.box[1])
            if step_number == _ITERATIONS - 1:
                active = np.arange(len(q))
            elif step_number < _ITERATIONS:
                active = active[length > 1e-4]
            if not len(active):
                active = np.arange(len(q))
        return q

    def _linear(self, q: Array) -> tuple[Array, Array]:
        """F as (N, e) and D as (N, e, n), scaled."""
        parts = block(self.robot, q, self.task, self.rank)
        f = parts.f.reshape(len(q), -1)
        return f, parts.d.reshape(len(q), f.shape[1], self.robot.n) * self.scale


def _solved(a: Array, f: Array) -> Array:
    """(N, n) shortest solutions of a·x = f; one or two rows by hand, which is ten times as fast."""
    if a.shape[1] > 2:
        return shortest(a, f)
    size = np.maximum((a**2).sum(axis=2), 1e-28)
    if a.shape[1] == 1:
        return np.asarray(a[:, 0] * (f / size))
    cross = (a[:, 0] * a[:, 1]).sum(axis=1)
    determinant = size[:, 0] * size[:, 1] - cross**2
    good = determinant > _ILL * size[:, 0] * size[:, 1]
    scale = np.where(good, determinant, 1.0)
    first = (size[:, 1] * f[:, 0] - cross * f[:, 1]) / scale
    second = (size[:, 0] * f[:, 1] - cross * f[:, 0]) / scale
    x = first[:, None] * a[:, 0] + second[:, None] * a[:, 1]
    if not good.all():
        x[~good] = shortest(a[~good], f[~good])
    return np.asarray(x)
