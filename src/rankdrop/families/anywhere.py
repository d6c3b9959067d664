"""Points of the singular set near many configurations, whatever family they are of.

Each configuration asks the core, as `nearest_singularity` does, with fewer starts: the nearest points of a cloud on the
set that a search has found, the configuration itself, and points of the ball in which a nearer one must lie. Every
start is driven onto the set, and walks along it to a local minimum of the distance.
"""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.families.search_record import Outcome
from rankdrop.families.searching import search
from rankdrop.kinematics import chain_of, task_view
from rankdrop.local.block import generic_rank, joint_scale, singular_values
from rankdrop.problem import Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, TIE

CLOUD = 1500
"""Starts of the search for points that walks begin at."""
THOROUGH, QUICK = (24, 24), (6, 6)
"""Points of the cloud and of the ball that walks of one configuration begin at."""
_LM_ITERATIONS, _EVALUATIONS = 40, 100
_FAR = 1e3  # radius of the circle that slides are laid on [length scales]


class Anywhere:
    """Walks onto the set of corank 1.

    Args:
        robot: the arm, in metres.
        task: from `resolve_task`.
        box: (2, n) limits, infinite where there are none.
        seed: of the search, and of the points of the ball.
        starts: points of the cloud and of the ball that are tried, `THOROUGH` or `QUICK`.
    """

    def __init__(
        self, robot: Robot, task: Task, box: Array, seed: int, starts: tuple[int, int] = THOROUGH
    ) -> None:
        self.robot, self.task, self.box = robot, task, box
        self.rank = generic_rank(robot, task) - 1
        self.scale = joint_scale(robot, task)
        self.moves = ~Problem(robot, task).idle
        self._limits = box if bool(np.isfinite(box).any()) else None
        found = search(robot, 1, task=task, starts=CLOUD, seed=seed, limits=bool(np.isfinite(box).all()))
        self.cloud = found.q[found.outcome == Outcome.CONVERGED]
        self._starts = starts
        self._ball = _unit_ball(np.random.default_rng(seed), starts[1], self.moves) * self.scale
        self._onto = _core.SearchSettings(
            method=0, rank=self.rank, iterations=_LM_ITERATIONS, singular=DEFAULT.singular, target=DEFAULT.singular,
            stationary=DEFAULT.stationary, seed=0, scale=self.scale, limits=self._limits, tie=TIE,
        )  # fmt: skip

    def feet(self, q: Array, within: Array) -> Array:
        """(N, n) the nearest singular configuration reached from each; nan where none was.

        Args:
            q: (N, n).
            within: (N,) how far a singular configuration is that is known already; inf where none is.
        """
        near = self._near(q)
        feet = np.full(q.shape, np.nan)
        for i, centre in enumerate(q):
            starts = centre[None]
            if (known := 0.0 < within[i] < np.inf):  # the ball is known at once
                starts = np.concatenate([starts, centre + within[i] * self._ball])
            foot, far = self._walked(centre, np.concatenate([near[i], self._onto_set(starts)]))
            if not known and 0.0 < far < np.inf and len(self._ball):
                other, nearer = self._walked(centre, self._onto_set(centre + far * self._ball))
                foot = other if nearer < far else foot
            feet[i] = foot
        return feet

    def from_points(self, q: Array, points: Array) -> Array:
        """(N, n) where the walk ends that begins at a singular configuration (N, n) given for each; nan where none is.
        """
        feet = np.full(q.shape, np.nan)
        for i in np.flatnonzero(np.isfinite(points).all(axis=1)):
            feet[i] = self._walked(q[i], points[i : i + 1])[0]
        return feet

    def _onto_set(self, starts: Array) -> Array:
        if self._limits is not None:
            starts = np.clip(starts, *self.box)
        chain, view = chain_of(self.robot), task_view(self.robot, self.task)
        q, _, outcome, *_ = _core.search(chain, view, np.ascontiguousarray(starts), self._onto, threads=1)
        return np.asarray(q[outcome == 0])

    def _walked(self, centre: Array, points: Array) -> tuple[Array, float]:
        """The nearest end of walks along the set from points of it, and how far it is; nan and inf without one."""
        points = self.brought_near(points, centre)
        if not len(points):
            return np.full(len(centre), np.nan), np.inf
        along = _core.NearestSettings(
            rank=self.rank, evaluations=_EVALUATIONS, singular=DEFAULT.singular, target=DEFAULT.target, centre=centre,
            scale=self.scale, limits=self._limits,
        )  # fmt: skip
        chain, view = chain_of(self.robot), task_view(self.robot, self.task)
        q, distance, _, _ = _core.nearest(chain, view, points, along, threads=1)
        there = np.isfinite(distance) & (singular_values(self.robot, q, self.task)[:, self.rank] <= DEFAULT.singular)
        far = np.where(there, np.linalg.norm((q - centre) / self.scale, axis=1), np.inf)
        best = int(far.argmin())
        return (q[best], float(far[best])) if there[best] else (np.full(len(centre), np.nan), np.inf)

    def brought_near(self, points: Array, centre: Array) -> Array:
        """Points (M, n) with whole turns taken off the way from `centre` (n,) or (M, n), as far as limits let them."""
        near = points - 2 * pi * np.where(self.robot.periodic, np.round((points - centre) / (2 * pi)), 0.0)
        return np.ascontiguousarray(np.where((near < self.box[0]) | (near > self.box[1]), points, near))

    def _near(self, q: Array) -> Array:
        """(N, seeds, n) points of the cloud nearest to each, idle joints left as they are."""
        count = min(self._starts[0], len(self.cloud))
        if not count:
            return np.empty((len(q), 0, self.robot.n))
        order = np.argpartition(-(self._round(q) @ self._round(self.cloud).T), count - 1, axis=1)[:, :count]
        start = np.where(self.moves, self.cloud[order], q[:, None])
        return np.clip(start, self.box[0], self.box[1])

    def _round(self, q: Array) -> Array:
        """Points whose inner products are large where configurations are near: joints that turn as (cos, sin)."""
        turning, sliding = self.moves & self.robot.periodic, self.moves & ~self.robot.periodic
        x = q[:, sliding] / self.scale[sliding]
        size = np.sqrt(np.maximum(_FAR**2 - x**2, 0.0))  # on a circle too, so wide that it is straight
        return np.concatenate([np.cos(q[:, turning]), np.sin(q[:, turning]), x, size], axis=1)


def _unit_ball(rng: np.random.Generator, count: int, moves: NDArray[np.bool_]) -> Array:
    """(count, n) points of the unit ball over the joints that move, evenly."""
    x = rng.standard_normal((count, len(moves))) * moves
    length = np.maximum(np.linalg.norm(x, axis=1, keepdims=True), 1e-300)
    return np.asarray(x / length * rng.random((count, 1)) ** (1 / max(1, int(moves.sum()))))
