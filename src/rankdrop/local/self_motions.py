"""Self-motions: the tool stands still while the joints move, traced until the curve closes or ends.

Predictor: a step along the null space. Corrector: Gauss–Newton on the displacement from the start
(`rankdrop.local.orientation`), so that every point is right to rounding and errors do not add up. At a singular
configuration null motions that are no tangents of a curve are recognised at second order, and never followed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.configuration import Configuration, configuration_at
from rankdrop.errors import OptionError
from rankdrop.local.block import read_only
from rankdrop.local.inverses import task_sigma
from rankdrop.local.orientation import WEAK, Displacement
from rankdrop.local.rates import joint_direction
from rankdrop.local.ways_out import FLAT, definite, distinct, forms, null_basis, vanishing
from rankdrop.problem import whole_turns
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import words_of
from rankdrop.task import Task

CLOSED, LIMIT, REACHED = "closed loop", "joint limit", "length reached"
BRANCHES, NONE, STUCK = "singular: branches here", "no null space", "no convergence"

_STRAIGHT = 0.9  # cosine between two steps below which the step is halved
_SHORTEST = 1e-4  # share of the step at which the tracer gives up
_AT_LIMIT = 1e-6  # a step this short onto a limit counts as having reached it [rad]
_MET = 1e-6  # a minimum of σ on the curve below this is a singular configuration [1]


class Ending(StrEnum):
    """Why the trace of a self-motion ends, or why it does not begin."""

    NO_NULL_SPACE = "no null space"
    BENDS_AWAY = "direction bends away"
    DEFINITE = "definite"
    NO_TANGENT = "no tangent"
    NO_START = "no start"
    STARTS_BEYOND = "starts beyond a limit"
    AT_LIMIT = "reaches a limit"
    LONG_ENOUGH = "length reached"
    CLOSED = "closed"
    CROSSING = "crossing"
    NARROW_BEND = "bends without end"
    NOT_CONVERGED = "no convergence"
_ENDED = {
    Ending.NO_NULL_SPACE: NONE, Ending.BENDS_AWAY: BRANCHES, Ending.DEFINITE: BRANCHES, Ending.NO_TANGENT: BRANCHES,
    Ending.NO_START: BRANCHES, Ending.STARTS_BEYOND: LIMIT, Ending.AT_LIMIT: LIMIT, Ending.LONG_ENOUGH: REACHED,
    Ending.CLOSED: CLOSED, Ending.CROSSING: BRANCHES, Ending.NARROW_BEND: BRANCHES, Ending.NOT_CONVERGED: STUCK,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class End:
    """How the trace of a self-motion ends.

    Attributes:
        reason: why it ends, or does not begin.
        number, joint: which joint is at its limit, from 1, and its name; 0 and "" where none is.
        travelled: length of the curve where it was long enough or closed [rad].
        bend: largest second derivative of the displacement along the given null motion, where it leaves the task
            [1/rad²].
    """

    reason: Ending
    number: int = 0
    joint: str = ""
    travelled: float = 0.0
    bend: float = 0.0


@dataclass(frozen=True, slots=True)
class SelfMotion:
    """A traced self-motion.

    Attributes:
        q: (N, n) configurations [rad, m], the start first; angles run on, they are not wrapped.
        task_error: (N,) norm of the displacement from the start, translations divided by the length scale; ≤ 1e-10.
        sigma_min: (N,) σ_r of the task Jacobian, r the generic rank [1].
        length: of the curve, in scaled joint coordinates [rad].
        end: why the curve ends there.
        nullity: dimension of the null space at the start; above 1 the curve is one of many.
        corank: at the start; above 0 not every null motion need belong to a self-motion.
    """

    q: Array
    task_error: Array
    sigma_min: Array
    length: float
    end: End
    nullity: int
    corank: int

    @property
    def ended(self) -> str:
        """Kind of the end.

        One of "closed loop", "joint limit", "length reached", "singular: branches here", "no null space" and "no
        convergence".
        """
        return _ENDED[self.end.reason]

    @property
    def words(self) -> str:
        """The reason of the end as a sentence."""
        words: str = words_of(self).end_sentence(self.end)
        return words


def self_motion(
    robot: Robot | Configuration,
    q: ArrayLike | None = None,
    task: Task | str | None = None,
    *,
    length: float = 20.0,
    step: float = 0.05,
    direction: ArrayLike | None = None,
    limits: bool = True,
) -> SelfMotion:
    """Trace the self-motion through q until it closes, meets a joint limit or a singularity, or is long enough.

    With one null motion there is one curve, and `direction` chooses its sense. With more, the first step follows the
    part of `direction` in the null space (by default of the first joint that has one) and every later step the
    projection of the one before. From a singular start the direction must satisfy the second-order conditions; by
    default such a direction is looked for, and if none can be traced the record holds the start alone and says so.

    Singularities on the way are found as minima of σ along the curve, refined; where two branches cross, the record
    ends at the crossing, because the curve does not say which one to take.

    Args:
        robot: the arm, or a `Configuration`, which stands for the first three.
        q: (n,) configuration [rad, m].
        task: name, `Task`, or None for the task the arm is made for.
        length: of the curve at most, in scaled joint coordinates (slides divided by the length scale) [rad].
        step: of the predictor, in the same measure [rad].
        direction: (n,) wanted joint motion at the start [rad, m].
        limits: stop at joint limits.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
        OptionError: length or step out of range, or a direction that has no part in the null space.
        TaskError: there is no such task, or its reference point does not move with the tip.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> traced = self_motion(open_robot("pa10"), [0.1, 0.6, 0.3, 1.2, 0.4, 0.9, 0.2], limits=False)
        >>> traced.ended, bool(traced.task_error.max() < 1e-10)
        ('closed loop', True)
    """
    if not (np.isfinite(length) and length > 0.0 and 1e-4 <= step <= 0.2 and length / step <= 1e5):
        raise OptionError(
            "length or step out of range", got=f"length {length}, step {step}",
            allowed="step 0.0001 … 0.2 [rad], length at most 100 000 steps",
        )  # fmt: skip
    here = configuration_at(robot, q, task)
    robot, start, verdict = here.robot, here.q, here.measured
    where = Displacement(robot, start, here.task)
    if limits:
        low, high = (robot.lower, robot.upper)
    else:
        low, high = (np.full(robot.n, -np.inf), np.full(robot.n, np.inf))
    if direction is None:
        wanted = None
    else:
        wanted = joint_direction(robot, direction) / where.joints
    points, end = [start], End(Ending.NO_NULL_SPACE)
    if verdict.nullity:
        units, end = _units(here, wanted)
        for unit in units:
            trace = _TracedRun(where, low, high, length, step)
            points, end = trace.run(unit)
            if len(points) > 1 or _ENDED[end.reason] == LIMIT:
                break
    motion = read_only(np.array(points))
    errors = read_only(np.linalg.norm(where.error(motion), axis=-1))
    sigma = read_only(task_sigma(robot, motion, here.task)[:, verdict.generic_rank - 1])
    travelled = float(np.linalg.norm(np.diff(motion, axis=0) / where.joints, axis=1).sum())
    return SelfMotion(motion, errors, sigma, travelled, end, verdict.nullity, verdict.corank)


def _units(place: Configuration, wanted: Array | None) -> tuple[list[Array], End]:
    """Unit null motions (scaled) to try at the start, best first; and why, if there are none."""
    null = null_basis(place)
    quadratic = forms(place, null)
    given = wanted is not None
    if wanted is None:
        inside = null @ null.T
        strongest = np.flatnonzero(np.diag(inside) > 0.25 / len(inside))
        wanted = np.eye(len(inside))[strongest[0]]
    coefficients = null.T @ wanted
    if np.linalg.norm(coefficients) < 1e-6 * np.linalg.norm(wanted):
        raise OptionError("the direction has no part in the null space", mend="see redundancy(…).null_basis")
    first = coefficients / np.linalg.norm(coefficients)
    bent = float(np.abs(np.einsum("pij,i,j->p", quadratic, first, first)).max(initial=0.0))
    if bent <= FLAT:
        return [null @ first], End(Ending.NO_START)
    if given:
        return [], End(Ending.BENDS_AWAY, bend=bent)
    if definite(quadratic, seed=0):
        return [], End(Ending.DEFINITE)
    tangents, _ = vanishing(quadratic, seed=0)
    along = tangents @ first
    kept = distinct(tangents, np.argsort(-np.abs(along)))
    return [null @ tangents[i] * np.sign(along[i] or 1.0) for i in kept], End(Ending.NO_TANGENT)


@dataclass
class _TracedRun:
    """One run of predictor and corrector from the start of `where`."""

    where: Displacement
    low: Array
    high: Array
    length: float
    step: float
    points: list[Array] = field(default_factory=list)
    weakest: list[float] = field(default_factory=list)

    def run(self, unit: Array) -> tuple[list[Array], End]:
        """Points, and why they end."""
        where, now, first = self.where, self.where.start, unit
        self.points = [now]
        outside = self._joints_beyond_limits(now)
        if outside.size:
            return self.points, self._at_limit(Ending.STARTS_BEYOND, outside[0])
        kept, h, travelled = -1, self.step, 0.0
        while True:
            goal = min(h, self.length - travelled)
            if goal <= 1e-9 * self.length:
                return self.points, End(Ending.LONG_ENOUGH, travelled=travelled)
            there, turned, sigma = self._next_point(now, unit, goal)
            if there is None:
                h = goal / 2
                if h < _SHORTEST * self.step:
                    return self._stuck(kept)
                continue
            beyond = self._joints_beyond_limits(there)
            if beyond.size:
                if goal <= _AT_LIMIT:
                    return self.points, self._at_limit(Ending.AT_LIMIT, beyond[0])
                h = goal / 2
                continue
            if kept < 0:
                kept = int((sigma > WEAK).sum())
            self.points.append(there)
            self.weakest.append(float(sigma[kept - 1]) if kept else np.inf)
            travelled += float(np.linalg.norm((there - now) / where.joints))
            if self._end_at_crossing():
                return self.points, End(Ending.CROSSING)
            now, unit = there, turned
            if self._closes(now, unit, first, travelled):
                return self.points, End(Ending.CLOSED, travelled=travelled)
            near = (np.minimum(now - self.low, self.high - now) / where.joints).min() < 2 * h
            h = h if near else min(self.step, 1.5 * h)

    def _joints_beyond_limits(self, q: Array) -> NDArray[np.intp]:
        """Indices of the joints beyond their limits."""
        return np.flatnonzero((q < self.low) | (q > self.high))

    def _next_point(self, now: Array, unit: Array, h: float) -> tuple[Array | None, Array, Array]:
        """The next point, the unit tangent there and σ; None where the step is too long."""
        where = self.where
        guess = now + h * where.joints * unit
        there, arrived = where.back(guess)
        if not arrived or np.linalg.norm((there - guess) / where.joints) > 0.3 * h:
            return None, unit, np.zeros(0)
        _, sigma, v = where.split(there)
        kept = int((sigma > WEAK).sum())
        tangent = v[:, kept:] @ (v[:, kept:].T @ unit)
        size = float(np.linalg.norm(tangent))
        if size < _STRAIGHT:
            return None, unit, np.zeros(0)
        return there, tangent / size, sigma

    def _end_at_crossing(self) -> bool:
        """Whether σ has passed through zero in the last two steps; if so the trace ends exactly there."""
        if self.weakest[-1] <= WEAK or len(self.weakest) < 3:
            return self.weakest[-1] <= WEAK
        before, middle, after = self.weakest[-3:]
        if not (middle <= before and middle <= after and middle <= 2.0 * max(before - middle, after - middle)):
            return False
        point, sigma = self._lowest(self.points[-3], self.points[-1])
        if sigma > _MET:
            return False
        self.points[-2:] = [point]
        return True

    def _lowest(self, start: Array, end: Array) -> tuple[Array, float]:
        """Where σ is least on the curve between two of its points, and its value: ever finer rows of points."""
        rank, low, high = int((self.where.split(start)[1] > WEAK).sum()), 0.0, 1.0
        while True:
            shares = np.linspace(low, high, 9)
            points, arrived = self.where.back(start + shares[:, None] * (end - start))
            sigma = np.where(arrived, self.where.split(points)[1][:, rank - 1], np.inf)
            best = int(sigma.argmin())
            if high - low <= 1e-8:
                return points[best], float(sigma[best])
            low, high = shares[max(best - 1, 0)], shares[min(best + 1, 8)]

    def _closes(self, now: Array, unit: Array, first: Array, travelled: float) -> bool:
        """Whether the start lies just ahead, whole turns apart; if so it becomes the last point."""
        way = self.where.start - now
        way = way - whole_turns(self.where.robot, way)
        scaled = way / self.where.joints
        distance = float(np.linalg.norm(scaled))
        if travelled < 4 * self.step or distance > 1.2 * self.step:
            return False
        if scaled @ unit < 0.99 * distance or first @ unit < _STRAIGHT:
            return False
        if distance > 1e-9:
            self.points.append(now + way)
        return True

    def _stuck(self, kept: int) -> tuple[list[Array], End]:
        if self.weakest and self.weakest[-1] < 10 * self.step:
            return self.points, End(Ending.NARROW_BEND)
        if kept < 0:
            return self.points, End(Ending.NO_START)
        return self.points, End(Ending.NOT_CONVERGED)

    def _at_limit(self, reason: Ending, index: int) -> End:
        return End(reason, int(index) + 1, self.where.robot.variables[index].name)
