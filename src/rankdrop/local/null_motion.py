"""Self-motion: the curve of configurations that leave the task where it is, traced step by step.

Predictor: a step along the null space. Corrector: Gauss–Newton on the displacement from the start
(`rankdrop.local.orientation`), so that every point is right to rounding and errors do not add up. At a singular
configuration null motions that are no tangents of a curve are told at second order, and never followed.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import OptionError
from rankdrop.kinematics import one_configuration
from rankdrop.local.inverse import task_sigma
from rankdrop.local.orientation import WEAK, Displacement
from rankdrop.local.place import Place, place_at
from rankdrop.local.second_order import FLAT, definite, distinct, forms, null_basis, vanishing
from rankdrop.local.verdict import rank_at
from rankdrop.problem import whole_turns
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT, Tolerances

CLOSED, LIMIT, REACHED = "closed loop", "joint limit", "length reached"
BRANCHES, NONE, STUCK = "singular: branches here", "no null space", "no convergence"
_STRAIGHT = 0.9  # cosine between two steps below which the step is halved
_SHORTEST = 1e-4  # share of the step at which the tracer gives up
_AT_LIMIT = 1e-6  # a step this short onto a limit counts as having reached it [rad]
_MET = 1e-6  # a minimum of σ on the curve below this is a singular configuration [1]
_GOLDEN = 0.6180339887498949


@dataclass(frozen=True, slots=True)
class SelfMotion:
    """A traced self-motion.

    Attributes:
        q: (N, n) configurations [rad, m], the start first; angles run on, they are not wrapped.
        task_error: (N,) norm of the displacement from the start, translations divided by the length scale; ≤ 1e-10.
        sigma_min: (N,) σ_r of the task Jacobian, r the generic rank [1].
        length: of the curve, in scaled joint coordinates [rad].
        ended: "closed loop", "joint limit", "length reached", "singular: branches here", "no null space" or
            "no convergence".
        words: the reason as a sentence.
        nullity: dimension of the null space at the start; above 1 the curve is one of many.
        corank: at the start; above 0 not every null motion need belong to a self-motion.
    """

    q: Array
    task_error: Array
    sigma_min: Array
    length: float
    ended: str
    words: str
    nullity: int
    corank: int


def self_motion(
    robot: Robot,
    q: ArrayLike,
    task: Task | str | None = None,
    *,
    length: float = 20.0,
    step: float = 0.05,
    direction: ArrayLike | None = None,
    limits: bool = True,
    tolerances: Tolerances = DEFAULT,
) -> SelfMotion:
    """Trace the self-motion through q until it closes, meets a joint limit or a singularity, or is long enough.

    With one null motion there is one curve, and `direction` chooses its sense. With more, the first step follows the
    part of `direction` in the null space (by default of the first joint that has one) and every later step the
    projection of the one before. From a singular start the direction must satisfy the second-order conditions; by
    default such a direction is looked for, and if none can be traced the record holds the start alone and says so.

    Singularities on the way are found as minima of σ along the curve, refined; where two branches cross, the record
    ends at the crossing, because the curve does not say which one to take.

    Args:
        robot: the arm.
        q: (n,) configuration [rad, m].
        task: name, `Task`, or None for the task the arm is made for.
        length: of the curve at most, in scaled joint coordinates (slides divided by the length scale) [rad].
        step: of the predictor, in the same measure [rad].
        direction: (n,) wanted joint motion at the start [rad, m].
        limits: stop at joint limits.
        tolerances: `singular` decides the rank.

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
    resolved = resolve_task(task, robot)
    start = one_configuration(robot, q)
    if not (np.isfinite(length) and length > 0.0 and 1e-4 <= step <= 0.2 and length / step <= 1e5):
        raise OptionError(
            "length or step out of range", got=f"length {length}, step {step}",
            allowed="step 0.0001 … 0.2 [rad], length at most 100 000 steps",
        )  # fmt: skip
    verdict = rank_at(robot, start, resolved, tolerances)
    where = Displacement(robot, start, resolved)
    low, high = (robot.lower, robot.upper) if limits else (np.full(robot.n, -np.inf), np.full(robot.n, np.inf))
    wanted = None if direction is None else _wanted(robot, direction) / where.joints
    points, ended, words = [start], NONE, "nothing can move without the task: the null space is empty"
    if verdict.nullity:
        units, refusal = _units(place_at(robot, start, resolved, tolerances), wanted)
        points, ended, words = [start], BRANCHES, refusal
        for unit in units:
            trace = _Trace(where, low, high, length, step)
            points, ended, words = trace.run(unit)
            if len(points) > 1 or ended == LIMIT:
                break
    found = np.array(points)
    errors = np.array([np.linalg.norm(where.error(point)) for point in found])
    sigma = task_sigma(robot, found, resolved)[:, verdict.generic_rank - 1]
    for array in (found, errors, sigma):
        array.flags.writeable = False
    travelled = float(np.linalg.norm(np.diff(found, axis=0) / where.joints, axis=1).sum())
    return SelfMotion(found, errors, sigma, travelled, ended, words, verdict.nullity, verdict.corank)


def _wanted(robot: Robot, direction: ArrayLike) -> Array:
    wanted = np.asarray(direction, dtype=np.float64)
    if wanted.shape != (robot.n,) or not np.isfinite(wanted).all() or not wanted.any():
        raise OptionError("a direction is one finite number per joint, not all zero", got=wanted.tolist())
    return wanted


def _units(place: Place, wanted: Array | None) -> tuple[list[Array], str]:
    """Unit null motions (scaled) to try at the start, best first; and what to say if none can be followed."""
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
        return [null @ first], "no curve follows this null motion, though nothing forbids it at second order"
    if given:
        return [], (
            f"the start is singular, and along this null motion the task leaves at second order ({bent:.3g} per rad²): "
            "it is not part of a self-motion"
        )
    if definite(quadratic, seed=0):
        return [], "the start is singular, and every null motion leaves the task at second order: no self-motion exists"
    tangents, _ = vanishing(quadratic, seed=0)
    along = tangents @ first
    words = "the start is singular, and no null motion was found that belongs to a self-motion; that is no proof"
    kept = distinct(tangents, np.argsort(-np.abs(along)))
    return [null @ tangents[i] * np.sign(along[i] or 1.0) for i in kept], words


@dataclass
class _Trace:
    """One run of predictor and corrector from the start of `where`."""

    where: Displacement
    low: Array
    high: Array
    length: float
    step: float
    points: list[Array] = field(default_factory=list)
    weakest: list[float] = field(default_factory=list)

    def run(self, unit: Array) -> tuple[list[Array], str, str]:
        """Points, reason and sentence."""
        where, now, first = self.where, self.where.start, unit
        self.points = [now]
        outside = np.flatnonzero((now < self.low) | (now > self.high))
        if outside.size:
            return self.points, LIMIT, f"{self._name(outside[0])} starts beyond its limit"
        kept, h, travelled = -1, self.step, 0.0
        while True:
            goal = min(h, self.length - travelled)
            if goal <= 1e-9 * self.length:
                return self.points, REACHED, f"length {travelled:.3g} rad reached"
            there, turned, sigma = self._ahead(now, unit, goal)
            if there is not None:
                beyond = np.flatnonzero((there < self.low) | (there > self.high))
                if beyond.size and goal <= _AT_LIMIT:
                    return self.points, LIMIT, f"{self._name(beyond[0])} reaches its limit"
            if there is None or beyond.size:
                h = goal / 2
                if there is None and h < _SHORTEST * self.step:
                    return self._stuck(kept)
                continue
            if kept < 0:
                kept = int((sigma > WEAK).sum())
            self.points.append(there)
            self.weakest.append(float(sigma[kept - 1]) if kept else np.inf)
            travelled += float(np.linalg.norm((there - now) / where.joints))
            if self._crossed():
                return self.points, BRANCHES, "the curve runs into a singular configuration, where branches meet"
            now, unit = there, turned
            if self._closes(now, unit, first, travelled):
                return self.points, CLOSED, f"closed after {travelled:.3g} rad"
            near = (np.minimum(now - self.low, self.high - now) / where.joints).min() < 2 * h
            h = h if near else min(self.step, 1.5 * h)

    def _ahead(self, now: Array, unit: Array, h: float) -> tuple[Array | None, Array, Array]:
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

    def _crossed(self) -> bool:
        """Whether σ has passed through zero in the last two steps; if so the trace ends exactly there."""
        if len(self.weakest) < 2:
            return self.weakest[-1] <= WEAK
        if self.weakest[-1] <= WEAK:
            return True
        if len(self.weakest) < 3:
            return False
        before, middle, after = self.weakest[-3:]
        if not (middle <= before and middle <= after and middle <= 2.0 * max(before - middle, after - middle)):
            return False
        point, sigma = self._lowest(self.points[-3], self.points[-1])
        if point is None or sigma > _MET:
            return False
        self.points[-2:] = [point]
        return True

    def _lowest(self, start: Array, end: Array) -> tuple[Array | None, float]:
        """Minimum of σ on the curve between two of its points, by golden section."""
        rank = int((self.where.split(start)[1] > WEAK).sum())

        def look(share: float) -> tuple[Array | None, float]:
            point, arrived = self.where.back(start + share * (end - start))
            return (point, float(self.where.split(point)[1][rank - 1])) if arrived else (None, np.inf)

        low, high = 0.0, 1.0
        left, right = 1.0 - _GOLDEN, _GOLDEN
        at_left, at_right = look(left), look(right)
        while high - low > 1e-8:
            if at_left[1] <= at_right[1]:
                high, right, at_right = right, left, at_left
                left = high - _GOLDEN * (high - low)
                at_left = look(left)
            else:
                low, left, at_left = left, right, at_right
                right = low + _GOLDEN * (high - low)
                at_right = look(right)
        return min(at_left, at_right, key=lambda found: found[1])

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

    def _stuck(self, kept: int) -> tuple[list[Array], str, str]:
        if self.weakest and self.weakest[-1] < 10 * self.step:
            return self.points, BRANCHES, "the curve bends without end near a singular configuration"
        if kept < 0:
            return self.points, BRANCHES, "no curve starts along this null motion: it is not part of a self-motion"
        return self.points, STUCK, "the corrector does not converge"

    def _name(self, index: int) -> str:
        return f"joint {index + 1} ({self.where.robot.variables[index].name})"
