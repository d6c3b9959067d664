"""Solutions of one pose as Newton's method finds them from random starts: isolated ones and self-motions.

Starts are drawn in batches until several batches in a row find nothing new. Solutions are isolated, or they form
continua: curves and surfaces of configurations along which the tool stands still. A redundant arm has these at every
pose, any arm may at a singular one. At a configuration with null motions N of J the dimension is the number of
independent displacements that remain

    q′ − q,   q′ = the solution next to q + δ N w,

and a curve is followed by such steps until it closes, ends, or its budget is spent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rankdrop.local.block import joint_scale, sampling_box, singular_values
from rankdrop.local.posture import by_habit
from rankdrop.poses.inverse import Aim, distinct, joint_difference, within_limits, wrap_joints
from rankdrop.problem import into_limits
from rankdrop.questions import InverseOptions
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task

_BATCH, _QUIET, _LIMIT = 256, 3, 8  # starts at a time; batches without news at the end; most starts, in `starts`
SINGULAR = 1e-5  # σ_r below which a solution counts as singular: pairs of solutions cannot be separated there
_SAME = 1e-6  # regular solutions nearer to each other are one [rad; slides scaled]; singular ones, `_STEP`
_NEWS = 0.5  # a singular solution nearer to a known one is no news: it is on the same curve, or ends there [rad]
_PROBE = 0.02  # δ of a displacement that may leave the tool still [rad]
_STEP, _STEPS = 0.08, 500  # along a curve [rad]; steps each way
_ENOUGH = 8  # singular solutions looked at where one of them is on a surface
_INWARDS = 20  # projections of the points of a surface into the joint limits
_CURVES = 64  # curves that are followed at most


@dataclass(frozen=True, eq=False)
class Continuum:
    """A self-motion: connected configurations along which the tool stands still.

    Attributes:
        q: (n,) a configuration on it, inside the joint limits and away from singularities where one was found, and of
            these in the posture that people use.
        dimension: 1 for a curve, 2 for a surface.
        closed: a curve that comes back to its start.
        complete: a curve that was followed to its closing or to both of its ends.
        singular: every configuration of it is singular.
        lowest, highest: (n,) of the joints along the curve that was followed [rad, m], counted on through whole turns.
        inside: share of the curve inside the joint limits; of a surface, share of its points that were found.
        beyond, residual: as of a `Branch`.
    """

    q: Array
    dimension: int
    closed: bool
    complete: bool
    singular: bool
    lowest: Array
    highest: Array
    inside: float
    beyond: tuple[tuple[int, float], ...]
    residual: float


@dataclass(frozen=True, eq=False)
class SelfMotionCurve:
    """A self-motion as it was followed.

    Attributes:
        points: (K, n) configurations in order, some 0.08 rad apart, angles counted on through whole turns [rad, m].
        closed: the last point is next to the first one.
        complete: it was followed to its closing or to both of its ends.
    """

    points: Array
    closed: bool
    complete: bool


class _Piece(NamedTuple):
    """A solution on a self-motion.

    Attributes:
        q: (n,) [rad, m].
        dimension: of the self-motion.
        singular: σ_r is zero at q.
    """

    q: Array
    dimension: int
    singular: bool


@dataclass(eq=False)
class SolutionSearch:
    """Solutions of one pose as they are found."""

    aim: Aim
    task: Task
    goal: Array
    tried: int = 0
    arrived: int = 0

    def __post_init__(self) -> None:
        self.robot = self.aim.robot
        self.scale = joint_scale(self.robot, self.task)
        self.curves: list[SelfMotionCurve] = []
        self.regular = np.empty((0, self.robot.n))
        self.singular = np.empty((0, self.robot.n))

    @property
    def redundant(self) -> bool:
        """Regular solutions form continua."""
        return self.robot.n > self.aim.rank

    def run(self, how: InverseOptions) -> None:
        """Batches of random starts, inside the joint limits and outside in turn, until there is no news."""
        boxes = [sampling_box(self.robot, self.task, limits=limits) for limits in (False, True)]
        rng = np.random.default_rng(how.seed)
        quiet = 0
        while self.tried < how.starts or (quiet < _QUIET and self.tried < _LIMIT * how.starts and not self.redundant):
            low, high = boxes[(self.tried // _BATCH) % 2]
            if self.tried == 0:
                size = min(_BATCH, how.starts)
            else:
                size = _BATCH
            if self.redundant and self.tried >= how.starts // 4:  # every start finds a new point of the same curves
                break
            news = self._take(rng.uniform(low, high, (size, self.robot.n)))
            self.tried += size
            quiet = 0 if news else quiet + 1

    def _take(self, starts: Array) -> bool:
        """Whether some of the starts led to new solutions."""
        solutions = self.aim.solve_from(self.goal, starts)
        self.arrived += len(solutions)
        if not len(solutions):
            return False
        targets = np.broadcast_to(self.goal, (len(solutions), 4, 4))
        polished, arrived = self.aim.solve(targets, solutions)
        solutions = wrap_joints(self.robot, np.where(arrived[:, None], polished, solutions))
        solutions = solutions[self.aim.confirms(targets, solutions)]
        weak = self.sigma(solutions) <= SINGULAR
        near = _STEP if self.redundant else _SAME
        regular = distinct(self.robot, self.task, solutions[~weak], near, self.regular)
        apart_from_all = distinct(self.robot, self.task, solutions[weak], _NEWS, self.singular)
        singular = distinct(self.robot, self.task, solutions[weak], _STEP, self.singular)
        self.regular = np.concatenate([self.regular, regular])
        self.singular = np.concatenate([self.singular, singular])
        return len(regular) + len(apart_from_all) > 0

    def sigma(self, q: Array) -> Array:
        """(N,) σ_r, r the generic rank."""
        if not len(q):
            return np.empty(0)
        return np.asarray(singular_values(self.robot, q, self.task)[:, self.aim.rank - 1])

    def isolated_and_curves(self) -> tuple[Array, tuple[Continuum, ...], bool]:
        """Isolated solutions (k, n), self-motions, and whether some were not followed."""
        isolated, pieces = self._by_freedom()
        surface = max(pieces, key=lambda piece: piece.dimension, default=None)
        if surface is not None and surface.dimension > 1:  # surfaces are not separated, nor what is connected with them
            q, dimension, singular = surface
            same = [piece.q for piece in pieces if piece.dimension == dimension and piece.singular == singular]
            points = self._inwards(np.array(same))
            return isolated, (self._continuum(q, dimension, points, False, False, singular),), True
        continua, more = self._follow_curves(pieces)
        continua = self._in_order(continua)
        alone = [not self._on_a_curve(q) for q in isolated]
        return isolated[alone], tuple(continua), more

    def _in_order(self, continua: list[Continuum]) -> list[Continuum]:
        """Inside the limits first, then closed curves, then in the order of the postures that people use."""
        if not continua:
            return []
        order = by_habit(self.robot, self.task, np.array([continuum.q for continuum in continua]))
        usual = [continua[row] for row in order]
        return sorted(usual, key=lambda continuum: (bool(continuum.beyond), not continuum.closed))

    def _inwards(self, points: Array) -> Array:
        """Points (N, n) of a surface, and where none of them is inside the joint limits, those towards the limits.

        Alternating projections: to the limits joint by joint, and by Newton's method back to the pose.
        """
        now = into_limits(self.robot, points)
        candidates = now
        for _ in range(_INWARDS):
            if within_limits(self.robot, candidates).any() or not len(now):
                break
            projected, arrived = self.aim.solve(self.goal[None], np.clip(now, self.robot.lower, self.robot.upper))
            now = into_limits(self.robot, projected[arrived])
            candidates = np.concatenate([candidates, now])
        return candidates

    def _by_freedom(self) -> tuple[Array, list[_Piece]]:
        """Isolated solutions (k, n), and those on a self-motion; of a surface not all that were found."""
        isolated: list[Array] = [np.empty((0, self.robot.n))]
        pieces: list[_Piece] = []
        if self.redundant:
            pieces = [_Piece(q, self.robot.n - self.aim.rank, False) for q in self.regular]
        else:
            isolated.append(self.regular)
        for row, q in enumerate(self.singular):
            if row >= _ENOUGH and any(piece.dimension > 1 for piece in pieces):
                break
            dimension = self._freedom(q)
            if dimension:
                pieces.append(_Piece(q, dimension, True))
            else:
                isolated.append(q[None])
        return np.concatenate(isolated), pieces

    def _follow_curves(self, pieces: Sequence[_Piece]) -> tuple[list[Continuum], bool]:
        """The curves through solutions, and whether some were not followed: there are more than `_CURVES`."""
        continua: list[Continuum] = []
        for q, _, singular in pieces:
            if self._on_a_curve(q):
                continue
            if len(self.curves) == _CURVES:
                return continua, True
            points, closed, complete = self._curve(q)
            self.curves.append(SelfMotionCurve(points, closed, complete))
            continua.append(self._continuum(q, 1, points, closed, complete, singular))
        return continua, False

    def _on_a_curve(self, q: Array) -> bool:
        return any(self._lies_on(q, curve.points) for curve in self.curves)

    def _lies_on(self, q: Array, points: Array) -> bool:
        gap = np.linalg.norm(joint_difference(self.robot, q, points) / self.scale, axis=1)
        return bool(gap.min() <= 1.5 * _STEP)

    def _null(self, q: Array) -> Array:
        """(k, n) orthonormal null motions of scaled joints."""
        _, sigma, vt = np.linalg.svd(self.aim.jacobian(q[None])[0])
        return np.asarray(vt[int((sigma > SINGULAR).sum()) :])

    def _next_solution(self, q: Array, guess: Array, step: float, off_at_most: float) -> Array | None:
        """The solution next to a guess a step away from q; None where the tool does not stand still along it."""
        solutions, arrived = self.aim.solve(self.goal[None], guess[None])
        off = float(np.linalg.norm((solutions[0] - guess) / self.scale))
        gone = float(np.linalg.norm((solutions[0] - q) / self.scale))
        good = arrived[0] and off <= off_at_most * step and gone >= step / 4
        if good:
            return np.asarray(solutions[0])
        return None

    def _freedom(self, q: Array) -> int:
        """Dimension of the self-motion through q."""
        null = self._null(q)
        if not len(null):
            return 0
        rng = np.random.default_rng(0)
        if len(null) > 1:
            mixed = rng.normal(size=(4 * len(null), len(null)))
        else:
            mixed = np.ones((1, 1))
        ways = np.concatenate([np.eye(len(null)), mixed]) @ null
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        moved = []
        for way in (*ways, *(-ways)):
            end = self._next_solution(q, q + _PROBE * way * self.scale, _PROBE, 1.0)
            if end is not None:
                moved.append((end - q) / self.scale / _PROBE)
        if not moved:
            return 0
        size = np.linalg.svd(np.array(moved), compute_uv=False)
        return int((size > 0.1 * size[0]).sum())

    def _curve(self, q: Array) -> tuple[Array, bool, bool]:
        """(K, n) points along a curve, whether it is closed, and whether it was followed to its ends."""
        first = self._null(q)[0]
        parts: list[list[Array]] = []
        complete = True
        for way in (first, -first):
            now, heading, points = q, way, list[Array]()
            for count in range(_STEPS):
                null = self._null(now)
                along = null.T @ (null @ heading)
                size = float(np.linalg.norm(along))
                if size < 0.5:
                    end = None
                else:
                    end = self._next_solution(now, now + _STEP * along / size * self.scale, _STEP, 1 / 3)
                if end is None:
                    break
                heading = (end - now) / self.scale
                heading = heading / np.linalg.norm(heading)
                now = end
                points.append(now)
                back = float(np.linalg.norm(joint_difference(self.robot, q, now[None])[0] / self.scale))
                if count > 2 and back <= 0.6 * _STEP and heading @ way > 0.0:
                    return np.array([q, *points]), True, True
            else:
                complete = False
            parts.append(points)
        return np.array([*parts[1][::-1], q, *parts[0]]), False, complete

    def _continuum(
        self, q: Array, dimension: int, points: Array, closed: bool, complete: bool, singular: bool
    ) -> Continuum:
        """The facts of a self-motion, shown at its best configuration."""
        placed = into_limits(self.robot, wrap_joints(self.robot, points))
        outside = _beyond_limits(self.robot, placed).max(axis=1, initial=0.0)
        inside = outside <= 0.0
        best = self._best_known(placed, outside)
        return Continuum(
            placed[best], dimension, closed, complete, singular, points.min(axis=0), points.max(axis=0),
            float(inside.mean()), joints_beyond(self.robot, placed[best]), self.residual(points),
        )  # fmt: skip

    def _best_known(self, placed: Array, outside: Array) -> int:
        """The point (of N, n) by which a self-motion is shown: of those inside the limits and not singular the posture
        that people use; else the least outside, and of these the farthest from singularities.
        """
        sigma = self.sigma(placed)
        usable = np.flatnonzero((outside <= 0.0) & (sigma > SINGULAR))
        if len(usable):
            return int(usable[by_habit(self.robot, self.task, placed[usable])[0]])
        return int(np.lexsort((-sigma, outside))[0])

    def residual(self, q: Array) -> float:
        """Largest difference in what the task asks for [m, 1]."""
        away, chord = self.aim.missing(np.broadcast_to(self.goal, (len(q), 4, 4)), q)
        if self.aim.heading is not None:
            chord = np.abs(self.aim.error(self.goal, q)[:, -1])
        return float(max(away.max(initial=0.0), chord.max(initial=0.0)))


def _beyond_limits(robot: Robot, q: Array) -> Array:
    """(N, n) how far each joint is beyond its limits, with a sign; 0 inside [rad, m]."""
    high = np.maximum(q - robot.upper - 1e-9, 0.0)
    low = np.maximum(robot.lower - q - 1e-9, 0.0)
    return np.asarray(np.maximum(high, low))


def joints_beyond(robot: Robot, q: Array) -> tuple[tuple[int, float], ...]:
    """Joints (from 1) of a configuration (n,) outside their limits, each with how far [rad, m]."""
    amounts = _beyond_limits(robot, q[None])[0]
    return tuple((int(i) + 1, float(amounts[i])) for i in np.flatnonzero(amounts > 0.0))
