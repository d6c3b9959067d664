"""Nearest points of the singular set itself, whatever family they are of: walks on the set from many starts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rankdrop import _core
from rankdrop.distance.distance import ball_points
from rankdrop.families.searching import search
from rankdrop.kinematics import chain_of, task_view
from rankdrop.problem import Problem, whole_turns
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, TIE

BATCH = 512  # configurations whose points are tested together
SET_CLOUD = 1500
"""Starts of the search for points that walks begin at."""
THOROUGH, QUICK = (24, 24), (6, 6)
"""Points of the cloud and of the ball that walks of one configuration begin at."""
_LM_ITERATIONS, _EVALUATIONS = 40, 100
_FAR = 1e3  # radius of the circle that slides are laid on [length scales]


class SetDistance:
    """Nearest points of the set of corank 1, whatever family they are of.

    Each configuration asks the core, as `nearest_singularity` does, with fewer starts: the nearest points of a cloud on
    the set that a search has found, the configuration itself, and points of the ball in which a nearer one must lie.
    Every start is driven onto the set, and walks along it to a local minimum of the distance.

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
        self.problem, self.box = Problem(robot, task), box
        self.moves, self.scale = ~self.problem.idle, self.problem.scale
        self._chain, self._view = chain_of(robot), task_view(robot, task)
        self._limits = box if bool(np.isfinite(box).any()) else None
        everywhere = bool(np.isfinite(box).all())
        self.cloud = search(robot, 1, task=task, starts=SET_CLOUD, seed=seed, limits=everywhere).converged
        self._starts = starts[0]
        self._ball = ball_points(np.random.default_rng(seed), np.ones(starts[1]), self.moves) * self.scale
        self._onto = _core.SearchSettings(
            method=0, rank=self.problem.rank, iterations=_LM_ITERATIONS, singular=DEFAULT.singular, seed=0, tie=TIE,
            target=DEFAULT.singular, stationary=DEFAULT.stationary, scale=self.scale, limits=self._limits,
        )  # fmt: skip

    def feet(self, q: Array, within: Array) -> Array:
        """(N, n) the nearest singular configuration reached from each; nan where none was.

        Args:
            q: (N, n).
            within: (N,) how far a singular configuration is that is known already; inf where none is.
        """
        parts = [self._feet_of_batch(q[i : i + BATCH], within[i : i + BATCH]) for i in range(0, len(q), BATCH)]
        return np.concatenate([q[:0], *parts])

    def _feet_of_batch(self, q: Array, within: Array) -> Array:
        """`feet` of a batch: all its starts are driven onto the set in one call."""
        known = (within > 0.0) & (within < np.inf)  # the ball is known at once
        near = self._cloud_neighbours(q)
        around = q[:, None] + np.where(known, within, 0.0)[:, None, None] * self._ball
        starts = [np.concatenate([q[i, None], around[i]]) if known[i] else q[i, None] for i in range(len(q))]
        onto = self._onto_set(starts)
        feet, far = self._walk_along_set(q, [np.concatenate(pair) for pair in zip(near, onto, strict=True)])
        rows = np.flatnonzero(~known & (far > 0.0) & (far < np.inf))
        if len(rows) and len(self._ball):
            starts = [q[i] + far[i] * self._ball for i in rows]
            others, nearer = self._walk_along_set(q[rows], self._onto_set(starts))
            better = nearer < far[rows]
            feet[rows[better]] = others[better]
        return feet

    def from_points(self, q: Array, points: Array) -> Array:
        """(N, n) where the walk ends that begins at a singular configuration (N, n) given for each; nan where none is.
        """
        feet = np.full(q.shape, np.nan)
        rows = np.flatnonzero(np.isfinite(points).all(axis=1))
        feet[rows] = self._walk_along_set(q[rows], [points[i, None] for i in rows])[0]
        return feet

    def _onto_set(self, starts: Sequence[Array]) -> list[Array]:
        """For each of some lists of starts (S, n) the points (P, n) of the set that they are driven to."""
        every, ends = np.concatenate(starts), np.cumsum([len(rows) for rows in starts])
        if self._limits is not None:
            every = np.clip(every, *self.box)
        q, _, outcome, *_, interrupted = _core.search(self._chain, self._view, every, self._onto, threads=1)
        if interrupted:
            raise KeyboardInterrupt
        there = np.split(outcome == 0, ends[:-1])
        return [rows[good] for rows, good in zip(np.split(q, ends[:-1]), there, strict=True)]

    def _walk_along_set(self, centres: Array, points: Sequence[Array]) -> tuple[Array, Array]:
        """Nearest ends of walks along the set from its points (P, n) for each centre (N, n): nan where there is none.

        Returns:
            (N, n) the ends, (N,) how far they are; inf where there is none.
        """
        feet, least = np.full(centres.shape, np.nan), np.full(len(centres), np.inf)
        counts = np.array([len(rows) for rows in points], dtype=np.int64)
        if not counts.any():
            return feet, least
        near = self.brought_near(np.concatenate(points), np.repeat(centres, counts, axis=0))
        starts = np.split(near, np.cumsum(counts)[:-1])
        walks = [self._walks(centre, rows) for centre, rows in zip(centres, starts, strict=True)]
        q, reached = np.concatenate([walk[0] for walk in walks]), np.concatenate([walk[1] for walk in walks])
        there = np.isfinite(reached) & self.problem.singular(q)
        far = np.where(there, self.problem.length(q - np.repeat(centres, counts, axis=0)), np.inf)
        first = np.cumsum(counts) - counts
        for i in np.flatnonzero(counts):
            best = first[i] + int(far[first[i] : first[i] + counts[i]].argmin())
            if there[best]:
                feet[i], least[i] = q[best], far[best]
        return feet, least

    def _walks(self, centre: Array, starts: Array) -> tuple[Array, Array]:
        """(P, n) ends of walks from points of the set to local minima of the distance, (P,) finite where they end."""
        if not len(starts):
            return starts, np.empty(0)
        along = _core.NearestSettings(
            rank=self.problem.rank, evaluations=_EVALUATIONS, singular=DEFAULT.singular, target=DEFAULT.target,
            centre=centre, scale=self.scale, limits=self._limits,
        )  # fmt: skip
        q, distance, _, _ = _core.nearest(self._chain, self._view, starts, along, threads=1)
        return q, distance

    def brought_near(self, points: Array, centre: Array) -> Array:
        """Points (M, n) with whole turns taken off the way from `centre` (n,) or (M, n), as far as limits let them."""
        near = points - whole_turns(self.problem.robot, points - centre)
        return np.ascontiguousarray(np.where((near < self.box[0]) | (near > self.box[1]), points, near))

    def _cloud_neighbours(self, q: Array) -> Array:
        """(N, seeds, n) points of the cloud nearest to each, idle joints left as they are."""
        count = min(self._starts, len(self.cloud))
        if not count:
            return np.empty((len(q), 0, self.problem.n))
        order = np.argpartition(-(self._round(q) @ self._round(self.cloud).T), count - 1, axis=1)[:, :count]
        start = np.where(self.moves, self.cloud[order], q[:, None])
        return np.clip(start, self.box[0], self.box[1])

    def _round(self, q: Array) -> Array:
        """Points whose inner products are large where configurations are near: joints that turn as (cos, sin)."""
        periodic = self.problem.robot.periodic
        turning, sliding = self.moves & periodic, self.moves & ~periodic
        x = q[:, sliding] / self.scale[sliding]
        size = np.sqrt(np.maximum(_FAR**2 - x**2, 0.0))  # on a circle too, so wide that it is straight
        return np.concatenate([np.cos(q[:, turning]), np.sin(q[:, turning]), x, size], axis=1)
