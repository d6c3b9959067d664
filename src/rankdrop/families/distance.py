"""How far to each family: the nearest point that satisfies a family's equations, and whether the search agrees.

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
from rankdrop.local.nearest import Nearest
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
        """Values of a pinned joint, those that are nearest."""
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
    rounding = 1e-9  # a limit of 3.14159265359 is meant to allow π
    low, high = float(bounds[0]) - rounding, float(bounds[1]) + rounding
    return np.array([value for value in every if low <= value <= high])


def _lengths(vectors: Array) -> Array:
    """(N,) norms of vectors (N, n)."""
    return np.asarray(np.sqrt(np.add.reduce(vectors * vectors, axis=1)))


AGREE = 1e-6  # distances that differ by less are the same: σ that vanishes to second order leaves half the digits [rad]


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


@dataclass(frozen=True, slots=True)
class Agreement:
    """Two answers to "how far": the nearest point over the families and the nearest of a search.

    Attributes:
        agree: both distances are the same to 1e-6, or neither found anything.
        gap: distance of the search minus that of the nearest family [rad]; nan where one of them has none.
        family: the nearest family, where its distance is the smaller or the same; None where the search is nearer.
        words: one sentence.
    """

    agree: bool
    gap: float
    family: Family | None
    words: str


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
    box = np.stack([robot.lower, robot.upper]) if limits else np.array([[-np.inf], [np.inf]]) * np.ones(robot.n)
    points = [_points(family, problem, centre, box, seed) for family in families]
    every = np.concatenate([np.empty((0, robot.n)), *points])
    sigma, distance = problem.sigma(every), problem.length(every - centre)
    records, end = [], 0
    for family, mine in zip(families, points, strict=True):
        end += len(mine)
        part = slice(end - len(mine), end)
        rank = problem.generic_rank - family.corank
        singular = sigma[part, rank] if len(mine) else np.zeros(0)
        records.append(_record(family, mine, centre, singular, distance[part], tolerances))
    return tuple(sorted(records, key=lambda record: record.distance))


def _in_closed_form(family: Family) -> bool:
    return family.named and bool(family.pinned) and not family.coupled


def _points(family: Family, problem: Problem, centre: Array, box: Array, seed: int) -> Array:
    """(N, n) points of a family, or nearly so, of which the nearest is taken; none where it has no equations."""
    if _in_closed_form(family):
        return _pinned_point(family.pinned, problem.robot, centre, box)
    if family.named and family.equations:
        return Coupled(family, problem, centre, box, seed).points()
    return np.empty((0, problem.n))


def _out_of_metres(distance: FamilyDistance, family: Family, robot: Robot) -> FamilyDistance:
    if not distance.q:
        return replace(distance, family=family)
    q, delta = out_of_metres(robot, distance.q), out_of_metres(robot, distance.delta)
    return replace(distance, family=family, q=tuple(q.tolist()), delta=tuple(delta.tolist()))


def agreement(distances: Sequence[FamilyDistance], nearest: Nearest | None) -> Agreement:
    """Whether the families and a search give the same distance; where they do not, which of the two falls short.

    Args:
        distances: from `family_distances`, over all families known.
        nearest: from `nearest_singularity` at the same q, task and limits; None where the search found nothing.
    """
    reached = [record for record in distances if np.isfinite(record.distance)]
    unnamed = sum(not record.family.named for record in distances)
    first = min(reached, key=lambda record: record.distance, default=None)
    if first is None and nearest is None:
        return Agreement(True, np.nan, None, "neither the families nor the search reach a singularity")
    if first is None:
        text = f"the search found a singularity, no named family has one{_more(unnamed)}"
        return Agreement(False, np.nan, None, text)
    if nearest is None:
        return Agreement(False, np.nan, first.family, f"the search found none, family {first.family.id} has one")
    gap = nearest.distance - first.distance
    if abs(gap) <= AGREE:
        return Agreement(True, gap, first.family, f"search and families agree: {first.family.id} ({first.family.name})")
    if gap > 0:
        text = f"the search missed a nearer point of family {first.family.id} ({first.family.name})"
        return Agreement(False, gap, first.family, text)
    text = f"the search found a singularity nearer than every named family{_more(unnamed)}"
    return Agreement(False, gap, None, text)


def _more(unnamed: int) -> str:
    if unnamed <= 1:
        return " (a family without conditions was not asked)" if unnamed else ""
    return f" ({unnamed} families have no conditions and were not asked)"


def _record(
    family: Family, points: Array, centre: Array, sigma: Array, distance: Array, tolerances: Tolerances
) -> FamilyDistance:
    """The nearest of the points (N, n) that solve the equations and are singular; sigma and distance of each (N,)."""
    exact = _in_closed_form(family)
    nothing = FamilyDistance(family, np.inf, (), (), np.inf, np.inf, exact)
    if not len(points):
        return nothing
    residual = np.abs(family.system.values(points)).max(axis=1)
    good = (residual <= REACHED) & (sigma <= tolerances.singular)
    if not good.any():
        return nothing
    best = int(np.where(good, distance, np.inf).argmin())
    at = points[best]
    return FamilyDistance(
        family, float(distance[best]), tuple(at.tolist()), tuple((at - centre).tolist()), float(residual[best]),
        float(sigma[best]), exact,
    )  # fmt: skip


def _pinned_point(pinned: Sequence[Pin], robot: Robot, centre: Array, box: Array) -> Array:
    """(1, n) every pinned joint at its nearest value, the others where they are; (0, n) where the limits forbid it."""
    point = np.clip(centre, box[0], box[1])
    for joint in pinned:
        j = joint.number - 1
        options = nearest_turns(np.array(joint.values), centre[j], bool(robot.periodic[j]), box[:, j])
        if not len(options):
            return np.empty((0, robot.n))
        point[j] = options[np.abs(options - centre[j]).argmin()]
    return point[None]
