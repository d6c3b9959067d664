"""How far to each family: the nearest point that satisfies a family's equations, from one configuration or from many.

The nearest point of a family whose joints are coupled is found by

    minimise ½‖x‖²  subject to  f(q) = 0,   x = (q − q0)/joint scale,

with Newton's method on the conditions x = Aᵀλ, f = 0 (A = ∂f/∂x, with second derivatives) from
many starts at once.

A family of pinned joints only is nearest where each of them turns to its nearest value: closed form. The others are
walked (`Coupled`). A point counts where |f| ≤ 1e-9 and σ vanishes in the Jacobian itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop import _core
from rankdrop.family.equation import REACHED
from rankdrop.family.record import Family, Pin, family_in_metres
from rankdrop.kinematics import one_configuration
from rankdrop.problem import Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.solve import CUT
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_metres, into_metres, metre_exponent, out_of_metres, task_in_metres

STARTS, LATER = 24, 24  # around the configuration, and in the ball in which a nearer point must lie
_RADII = (0.3, 1.0, 2.5)  # of the balls the starts come from [rad]
_ITERATIONS = 25
_STILL = 1e-6  # steps shorter than this change the distance by their square [rad]
_LONGEST = 0.7  # step [rad]
_FLATTEST = 1e-2  # curvatures of the Lagrangian are taken for at least this
_ROUNDING = 1e-9  # a limit of 3.14159265359 is meant to allow π
_RETURNS = 3  # steps straight onto the family at the end


_Draw = tuple[Array, list[NDArray[np.int64]]]


@lru_cache(maxsize=64)
def _draws(seed: int, moves: tuple[bool, ...], values: tuple[int, ...]) -> tuple[_Draw, _Draw]:
    """Of the first starts and of the later ones: points (N, n) that fill balls evenly, over the joints that move.

    First of several radii, then of radius 1; and for each pinned joint which of its values (N,).
    """
    rng = np.random.default_rng(seed)

    def drawn(radii: Array) -> _Draw:
        x = rng.standard_normal((len(radii), len(moves))) * np.array(moves)
        x *= (radii * rng.random(len(radii)) ** (1 / sum(moves)) / _lengths(x))[:, None]
        x[0] = 0
        return x, [rng.integers(count, size=len(radii)) for count in values]

    return drawn(np.resize(_RADII, STARTS)), drawn(np.ones(LATER))


class Coupled:
    """The nearest points of one family with coupled joints; the joints it does not depend on stay where they are."""

    def __init__(self, family: Family, problem: Problem, centre: Array, box: Array, seed: int) -> None:
        robot = problem.robot
        self.family, self.robot, self.box = family, robot, box
        self.centre = np.clip(centre, box[0], box[1])  # free joints of a q outside the limits go to the limit
        # on more equations than are independent Newton stays where no residual gets smaller: these are walked alone too
        self.ways = [len(family.equations)]
        if 0 < robot.n - family.dimension < len(family.equations):
            self.ways.insert(0, robot.n - family.dimension)  # what comes later is left where it leads farther
        self.moves = family.system.moves
        self.bounded = bool(np.isfinite(box[:, self.moves]).any())
        self.scale = problem.scale
        self.target = centre
        self.draws = _draws(seed, tuple(self.moves.tolist()), tuple(len(joint.values) for joint in family.pinned))
        self.pinned = [(joint.number - 1, self._options(joint)) for joint in family.pinned]

    def points(self) -> Array:
        """Ends of all starts, and where walks stood that led farther away than another had ended."""
        first, late = self.draws
        ends, nearest = self._ends(self._starts(first, 1.0), np.inf)
        if nearest == 0 or not np.isfinite(nearest):
            return ends
        return np.concatenate([ends, self._ends(self._starts(late, 1.25 * nearest), nearest)[0]])

    def _ends(self, starts: Array, nearest: float) -> tuple[Array, float]:
        """Ends of all starts; how far the nearest is of what solves the equations, or was before."""
        ends = []
        for leading in self.ways:
            ends.append(self._walk(starts, leading, nearest))
            solved = np.abs(self.family.system.values(ends[-1])).max(axis=1) <= REACHED
            nearest = min(nearest, float(_lengths((ends[-1] - self.target) / self.scale)[solved].min(initial=np.inf)))
        return np.concatenate(ends), nearest

    def _starts(self, draw: _Draw, radius: float) -> Array:
        """The configuration itself, and points in balls around it; pinned joints at any of their values."""
        points, choices = draw
        q = self.centre + points * (radius * self.scale)
        for (j, options), choice in zip(self.pinned, choices, strict=True):
            if len(options):
                q[:, j] = options[choice % len(options)]
        return np.asarray(np.minimum(np.maximum(q, self.box[0]), self.box[1]) if self.bounded else q)

    def _options(self, joint: Pin) -> Array:
        j = joint.number - 1
        options = nearest_turns(np.array(joint.values), self.centre[j], bool(self.robot.periodic[j]), self.box[:, j])
        return np.asarray(options[np.abs(options - self.centre[j]).argsort()][: len(joint.values)])

    def _walk(self, q: Array, leading: int, farthest: float) -> Array:
        """Newton steps of all starts on the first equations until they stand still, then straight onto the family.

        Those that lead farther away than that may end anywhere.
        """
        settings = _core.FootSettings(
            leading=leading, iterations=_ITERATIONS, returns=_RETURNS, still=_STILL, longest=_LONGEST, cut=CUT,
            flattest=_FLATTEST, farthest=farthest, target=self.target.tolist(), scale=self.scale.tolist(),
            periodic=self.robot.periodic.astype(int).tolist(), columns=np.flatnonzero(self.moves).tolist(),
            limits=np.ascontiguousarray(self.box) if self.bounded else None,
        )  # fmt: skip
        return _core.feet(self.family.system.compiled, q, settings, threads=1)


def nearest_turns(values: Array, at: float, periodic: bool, bounds: Array) -> Array:
    """Values moved by whole turns to where they are nearest to `at` and inside the bounds."""
    every = values.tolist()
    if periodic:
        turn = 2 * np.pi
        every = [value + turn * (round((at - value) / turn) + more) for more in range(-2, 3) for value in every]
    low, high = float(bounds[0]) - _ROUNDING, float(bounds[1]) + _ROUNDING
    return np.array([value for value in every if low <= value <= high])


def _lengths(vectors: Array) -> Array:
    return np.asarray(np.sqrt(np.add.reduce(vectors * vectors, axis=1)))


@dataclass(frozen=True, slots=True)
class FamilyDistance:
    """The nearest point of one family.

    Attributes:
        family: the family.
        distance: ‖(q* − q0)/joint scale‖₂ [rad; metres divided by the length scale]; inf where no point of the family
            was reached (none within the limits, or no equations: `family.named` is False).
        q: (n,) q*, not wrapped: q* − q0 is the motion [rad, m]; empty where the distance is inf.
        delta: (n,) q* − q0 [rad, m].
        residual: largest |f| of the family's equations at q*.
        sigma: largest of the singular values that should vanish at q*, from the Jacobian [1].
        exact: closed form: the nearest without doubt. Otherwise the best of many starts.
    """

    family: Family
    distance: float
    q: tuple[float, ...]
    delta: tuple[float, ...]
    residual: float
    sigma: float
    exact: bool


def family_distances(
    families: Sequence[Family],
    robot: Robot,
    q: ArrayLike,
    task: Task,
    *,
    limits: bool = False,
    seed: int = 0,
    tolerances: Tolerances = DEFAULT,
) -> tuple[FamilyDistance, ...]:
    """Distance from q to every family, nearest first.

    Args:
        families: of any coranks, for this arm and task.
        robot: the arm.
        q: (n,) [rad, m].
        task: from `resolve_task`.
        limits: only points within the joint limits.
        seed: of the starts of families whose joints are coupled.
        tolerances: `singular` decides whether a point is singular.

    Returns:
        One record per family. Families without equations come last with distance inf: they were not asked.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
    """
    centre = one_configuration(robot, q)
    if metre_exponent(robot):
        there = [family_in_metres(family, robot) for family in families]
        made = family_distances(
            there, in_metres(robot), into_metres(robot, centre), task_in_metres(task, robot), limits=limits, seed=seed,
            tolerances=tolerances,
        )
        given = dict(zip(map(id, there), families, strict=True))
        return tuple(_out_of_metres(one, given[id(one.family)], robot) for one in made)
    problem = Problem(robot, task, tolerances=tolerances, limits=limits)
    records = [_record(family, problem, centre, seed) for family in families]
    return tuple(sorted(records, key=lambda record: record.distance))


def _record(family: Family, problem: Problem, centre: Array, seed: int) -> FamilyDistance:
    (foot,), (distance,), (residual,), (sigma,) = feet_on(
        family, problem, centre[None], walls_of(problem), zero=problem.tolerances.singular, seed=seed
    )
    exact = _in_closed_form(family)
    if not np.isfinite(distance):
        return FamilyDistance(family, np.inf, (), (), np.inf, np.inf, exact)
    q, delta = tuple(foot.tolist()), tuple((foot - centre).tolist())
    return FamilyDistance(family, float(distance), q, delta, float(residual), float(sigma), exact)


def _out_of_metres(distance: FamilyDistance, family: Family, robot: Robot) -> FamilyDistance:
    if not distance.q:
        return replace(distance, family=family)
    q, delta = out_of_metres(robot, distance.q), out_of_metres(robot, distance.delta)
    return replace(distance, family=family, q=tuple(q.tolist()), delta=tuple(delta.tolist()))


def walls_of(problem: Problem) -> Array:
    """(2, n) joint limits, infinite where none are asked for [rad, m]."""
    robot = problem.robot
    if problem.limits:
        return np.stack([robot.lower, robot.upper])
    return np.array([[-np.inf], [np.inf]]) * np.ones(robot.n)


def feet_on(
    family: Family, problem: Problem, q: Array, box: Array, *, zero: float, seed: int
) -> tuple[Array, Array, Array, Array]:
    """The nearest point of a family from each of many configurations; of one configuration, a batch of one.

    Args:
        family: of the arm in metres.
        problem: the arm in metres.
        q: (N, n).
        box: (2, n) limits, infinite where there are none.
        zero: σ of a singular point.
        seed: of the starts of families whose joints are coupled.

    Returns:
        (N, n) the point, nan where none was reached; (N,) its distance, inf there; (N,) largest |f| and (N,) σ at it.
    """
    points, owner = _candidates(family, problem, q, box, seed)
    sigma = problem.sigma(points)[:, problem.generic_rank - family.corank] if len(points) else np.zeros(0)
    residual = np.abs(family.system.values(points)).max(axis=1) if len(points) else np.zeros(0)
    good = (residual <= REACHED) & (sigma <= zero)
    points, owner, sigma, residual = points[good], owner[good], sigma[good], residual[good]
    way = problem.length(points - q[owner])
    order = np.lexsort((way, owner))
    rows, first = np.unique(owner[order], return_index=True)
    best = order[first]
    feet, far = np.full(q.shape, np.nan), np.full((3, len(q)), np.inf)
    feet[rows], far[:, rows] = points[best], (way[best], residual[best], sigma[best])
    return feet, far[0], far[1], far[2]


def _in_closed_form(family: Family) -> bool:
    return family.named and bool(family.pinned) and not family.coupled


def _candidates(
    family: Family, problem: Problem, q: Array, box: Array, seed: int
) -> tuple[Array, NDArray[np.int64]]:
    """(P, n) points of a family, or nearly so, and (P,) which of the configurations (N, n) each of them is for."""
    if _in_closed_form(family):
        feet = _pinned_feet(family.pinned, problem.robot, q, box)
        rows = np.flatnonzero(np.isfinite(feet).all(axis=1))
        return feet[rows], rows
    if not family.named or not family.equations:
        return np.empty((0, problem.n)), np.empty(0, dtype=np.int64)
    parts = [np.empty((0, problem.n)), *(Coupled(family, problem, centre, box, seed).points() for centre in q)]
    return np.concatenate(parts), np.repeat(np.arange(len(q)), [len(part) for part in parts[1:]])


def _pinned_feet(pinned: Sequence[Pin], robot: Robot, q: Array, box: Array) -> Array:
    """(N, n) each pinned joint at its nearest value within the limits, nan where there is none; others in the limits.
    """
    feet, rows = np.clip(q, box[0], box[1]), np.arange(len(q))
    bounded = [bool(np.isfinite(ends).any()) for ends in box.T]
    for one in pinned:
        j, values = one.number - 1, np.array(one.values)
        at, options = q[:, j, None], np.broadcast_to(values, (len(q), len(values)))
        if robot.periodic[j]:
            turns = np.round((at - values) / (2 * np.pi))[:, None] + np.arange(-2, 3)[:, None]
            options = (values + 2 * np.pi * turns).reshape(len(q), -1)
        far = np.abs(options - at)
        if bounded[j]:
            outside = (options < box[0, j] - _ROUNDING) | (options > box[1, j] + _ROUNDING)
            far = np.where(outside, np.inf, far)
        best = far.argmin(axis=1)
        feet[:, j] = options[rows, best]
        if bounded[j]:
            feet[np.isinf(far[rows, best]), j] = np.nan
    return feet
