"""A branch of a tool path near a singularity, followed by the length of its joint motion, not by the way of the tool.

The solutions (x, w) of e(x, w) = 0 on a straight move, q = S x, are a curve where (J, −ξ) has full rank. Its tangent
has dw/dl ∝ det J, so that at a singularity on the curve

    dw/dl changes its sign   the curve folds back,
    det J changes its sign   and dw/dl does not: two curves cross (uᵀξ = 0), and the branch is smooth there,
    neither does             and both are zero: the branch goes on, from rest.

Steps are along the last secant, corrected on the plane across it (Keller's pseudo-arclength continuation), so that a
crossing is stepped over. Two curves that only pass each other closely differ from a crossing by σ_r: between them
it is not zero. Where a self-motion crosses, the corrector may end on it: σ_r is zero there, and the step is taken again
with another length.

Source: E. L. Allgower, K. Georg, Introduction to Numerical Continuation Methods (2003), ch. 2, 8.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rankdrop.path.check.passing import StraightMove
from rankdrop.robot.model import Array

_FIRST, _LONGEST, _SHORTEST = 1e-5, 0.02, 1e-8  # of a step [rad; slides scaled]
_GROWTH = 2.0  # of a step, where the last one was taken
_LENGTH = 0.06  # of the part that is followed at a time [rad; slides scaled]
_TRIES = 400
_TURNED = 0.998  # cosine between two steps at least
_OFF = 0.1  # share of the last step that the solution at the end of the move may be off its guess
_SELF_MOTION = 1e-9  # σ_r of a point that may be on a self-motion
_SECOND = 1e-4  # σ_(r−1) below which the corank is 2 or more, and nothing is decided
_REGULAR = 1e-9  # smallest singular value of (J, −ξ) of a start without a heading
_SINGULAR = 1e-6  # σ_r at its least of a singularity that is touched or crossed
_NEAR_END = 1e-4  # that the solution at the end of the move may be off its guess at least [rad; slides scaled]
_TINY = 1e-300  # no way at all
_AT_END = 1e-9  # of w: a curve that folds back so near to the end of the move has reached it
_HALVED = 40  # halvings of a step that crosses a singularity
_SECTIONS = 40  # of a search for a largest w, or a least σ_r
_GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0


@dataclass(frozen=True, eq=False)
class CurveCrossing:
    """A singularity through which a solution curve goes on.

    Attributes:
        w: where.
        q: (n,) configuration there [rad, m].
        rest: the arm has to rest there.
    """

    w: float
    q: Array
    rest: bool


@dataclass(frozen=True, eq=False)
class CurvePart:
    """A part of a solution curve, along which w grows.

    Attributes:
        w: (K,) ways from its start.
        q: (K, n) configurations there [rad, m].
        crossings: singularities on it, in order.
        folds: the curve folds back at the last of its points.
        heading: (n + 1,) unit vector of (x, w) at its end.
    """

    w: Array
    q: Array
    crossings: tuple[CurveCrossing, ...]
    folds: bool
    heading: Array


@dataclass(frozen=True, eq=False)
class _CurvePoint:
    """A point y = (x, w) of the curve.

    Attributes:
        y: (n + 1,)
        way: (n + 1,) unit vector that led to it.
        slope: dw/dl.
        sigma: σ_r, with the sign of det J.
    """

    y: Array
    way: Array
    slope: float
    sigma: float


def follow_curve(move: StraightMove, q: Array, heading: Array | None) -> CurvePart | None:
    """Follow the solution curve through a configuration ahead: to where it folds back, to the end of the move, or far
    enough to leave a singularity behind.

    Args:
        move: seen from q.
        q: (n,) configuration on it [rad, m].
        heading: (n + 1,) unit vector of (x, w) that leads there; None: w grows, and q is not singular.

    Returns:
        The part with at least one point; None where it cannot be decided how the curve goes on.
    """
    walk = _CurveWalk(move)
    start = walk.first_point(np.append(q / move.aim.joints, 0.0), heading)
    if start is None:
        return None
    walk.points.append(start)
    return walk.run()


class _CurveWalk:
    def __init__(self, move: StraightMove) -> None:
        self.move, self.aim, self.room = move, move.aim, move.room
        self.points: list[_CurvePoint] = []
        self.crossings: list[CurveCrossing] = []
        self.step, self.length, self.goal = _FIRST, 0.0, _LENGTH

    def run(self) -> CurvePart | None:
        """The part from the first point on; None where it cannot be decided how the curve goes on."""
        for _ in range(_TRIES):
            if self.step < _SHORTEST:
                return None
            new = self.step_along(self.points[-1], self.step)
            if new is None or self.is_doubtful(new):
                self.step /= 2
                continue
            if new.slope <= 0.0:
                return self.part_to_fold(new)
            if new.y[-1] >= self.room:
                return self.part_to_end(new)
            if not self.take_point(new):
                self.step /= 2
            if self.length >= self.goal:
                return self.part(folds=False)
        return None

    def is_doubtful(self, new: _CurvePoint) -> bool:
        """A point on a self-motion, or one behind the last one though w grows."""
        if new.slope > 0.0 and new.y[-1] <= self.points[-1].y[-1]:
            return True
        return abs(new.sigma) <= _SELF_MOTION and bool(new.y[-1] < self.room)

    def take_point(self, new: _CurvePoint) -> bool:
        """Go on to a point, and note a singularity on the way; False where the step jumps to another curve."""
        before = self.points[-1]
        if np.sign(new.sigma) != np.sign(before.sigma):
            crossing = self.find_crossing(before, self.step)
            if crossing is None:
                return False
            self.crossings.append(crossing)
            self.goal = self.length + self.step + _LENGTH
        self.length += self.step
        self.step = min(_GROWTH * self.step, _LONGEST)
        self.points.append(new)
        touched = self.find_touch()
        if touched is not None:
            self.points[-2] = touched
            self.crossings.append(CurveCrossing(float(touched.y[-1]), touched.y[:-1] * self.aim.joints, True))
        return True

    def first_point(self, y: Array, heading: Array | None) -> _CurvePoint | None:
        """The first point, with a way along the curve; None where that has no direction."""
        if heading is not None:
            return self._point(y, heading)
        _, sigma, vt = np.linalg.svd(self.move.slopes(y))
        if sigma[-1] <= _REGULAR or vt[-1, -1] == 0.0:
            return None
        return self._point(y, vt[-1] * np.sign(vt[-1, -1]))

    def step_along(self, start: _CurvePoint, step: float) -> _CurvePoint | None:
        """The point a step on; None where the step is too long."""
        guess = start.y + step * start.way
        y = self.move.on_plane(guess, start.way)
        if y is None:
            return None
        gone = y - start.y
        way = gone / np.linalg.norm(gone)
        if way @ start.way < _TURNED:  # so the corrector adds 6 % of a step at most
            return None
        return self._point(y, way)

    def _point(self, y: Array, way: Array) -> _CurvePoint | None:
        matrix = self.move.slopes(y)
        jacobian = matrix[:, :-1]
        sigma = np.linalg.svd(jacobian, compute_uv=False)
        if sigma[-2] < _SECOND:
            return None
        tangent = np.linalg.svd(matrix)[2][-1]
        slope = float(tangent[-1]) * float(np.sign(tangent @ way))
        return _CurvePoint(y, way, slope, float(sigma[-1] * np.linalg.slogdet(jacobian)[0]))

    def find_crossing(self, start: _CurvePoint, step: float) -> CurveCrossing | None:
        """The zero of det J within a step; None where it jumps across zero, from one curve to another."""
        low, high = 0.0, step
        best = start
        for _ in range(_HALVED):
            middle = (low + high) / 2
            point = self.step_along(start, middle)
            if point is None:
                break
            best = min(best, point, key=lambda point: abs(point.sigma))
            if np.sign(point.sigma) == np.sign(start.sigma):
                low = middle
            else:
                high = middle
        if abs(best.sigma) > _SINGULAR:
            return None
        return CurveCrossing(float(best.y[-1]), best.y[:-1] * self.aim.joints, False)

    def find_touch(self) -> _CurvePoint | None:
        """The point next to the last one but one at which σ_r is zero without a change of sign."""
        if len(self.points) < 3:
            return None
        before, middle, after = self.points[-3:]
        low = abs(middle.sigma) < min(abs(before.sigma), abs(after.sigma))
        if not low or len({np.sign(point.sigma) for point in (before, middle, after)}) > 1:
            return None
        least = self._best(before, float(np.linalg.norm(after.y - before.y)), lambda point: -abs(point.sigma))
        if abs(least.sigma) > _SINGULAR:
            return None
        return least

    def _best(self, start: _CurvePoint, length: float, value: Callable[[_CurvePoint], float]) -> _CurvePoint:
        """The point of the largest value within a length from a point, by golden sections."""
        low, high, best = 0.0, length, start
        for _ in range(_SECTIONS):
            left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
            nearer, farther = self.step_along(start, left), self.step_along(start, right)
            if nearer is None or farther is None:
                high = right
                continue
            best = max(best, nearer, farther, key=value)
            if value(nearer) >= value(farther):
                high = right
            else:
                low = left
        return best

    def part_to_fold(self, new: _CurvePoint) -> CurvePart | None:
        """The part up to the largest w before a point; where that is the end of the move, the curve has reached it."""
        last = self.points[-1]
        top = self._best(last, float(np.linalg.norm(new.y - last.y)), lambda point: float(point.y[-1]))
        if top.y[-1] >= self.room - _AT_END:
            return self.part_to_end(top)
        if top is not last:
            self.points.append(top)
        return self.part(folds=True)

    def part_to_end(self, new: _CurvePoint) -> CurvePart | None:
        """The part up to the end of the move, next to a point."""
        before = self.points[-1]
        gone = new.y - before.y
        share = min(1.0, (self.room - before.y[-1]) / max(gone[-1], _TINY))
        guess = (before.y + share * gone)[:-1]
        q = self.move.solution_near(self.room, guess * self.aim.joints)
        most = max(_OFF * float(np.linalg.norm(gone)), _NEAR_END)
        if q is None or np.linalg.norm(q / self.aim.joints - guess) > most:
            return None
        last = self._point(np.append(q / self.aim.joints, self.room), before.way)
        if last is None:
            return None
        if np.sign(last.sigma) != np.sign(before.sigma) and abs(last.sigma) > _SINGULAR:
            crossing = self.find_crossing(before, float(np.linalg.norm(last.y - before.y)))
            if crossing is None:
                return None
            self.crossings.append(crossing)
        self.points.append(last)
        return self.part(folds=False)

    def part(self, *, folds: bool) -> CurvePart:
        """The points after the first."""
        w = np.array([point.y[-1] for point in self.points[1:]])
        q = np.array([point.y[:-1] * self.aim.joints for point in self.points[1:]])
        return CurvePart(w, q, tuple(self.crossings), folds, self.points[-1].way)
