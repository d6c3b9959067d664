"""How far to each family: the nearest point that satisfies a family's equations, from one configuration or from many.

The nearest point of a family whose joints are coupled is found by

    minimise ½‖x‖²  subject to  f(q) = 0,   x = (q − q0)/joint scale,

with Newton's method on the conditions x = Aᵀλ, f = 0 (A = ∂f/∂x, with second derivatives) from
many starts at once.

A family of pinned joints only is nearest where each of them turns to its nearest value: closed form. The others are
walked. A point counts where |f| ≤ 1e-9 and σ vanishes in the Jacobian itself.

Of many configurations (`Ruler`; `family_distances` of one) a family has many nearest points, and long conditions are
slow; so unless every family is pinned, the singular set itself is walked on as well (`SetDistance`), and a point that
this finds counts for the families whose conditions it satisfies. What is returned is singular, so a distance is never
too small; it may be too large by what no walk has come round to (measured against `nearest_singularity` in
`tests/families`). Beside it stands a bound from below, proven by one enclosure (`certify`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop import _core
from rankdrop.cover.ball import LARGEST
from rankdrop.cover.setting import Setting, enclose, settings_for
from rankdrop.errors import OptionError
from rankdrop.families.record import Family, Pin
from rankdrop.families.rescaling import family_in_metres
from rankdrop.families.searching import search
from rankdrop.formula.equation import REACHED, Mask
from rankdrop.kinematics import chain_of, configurations, one_configuration, task_view
from rankdrop.problem import Problem, whole_turns
from rankdrop.robot.model import Array, Robot
from rankdrop.solve import CUT
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, TIE, Tolerances
from rankdrop.units import in_metres, into_metres, out_of_metres, task_in_metres

STARTS, LATER = 24, 24  # around the configuration, and in the ball in which a nearer point must lie
_RADII = (0.3, 1.0, 2.5)  # of the balls the starts come from [rad]
_ITERATIONS = 25
_STILL = 1e-6  # steps shorter than this change the distance by their square [rad]
_LONGEST = 0.7  # step [rad]
_FLATTEST = 1e-2  # curvatures of the Lagrangian are taken for at least this
_ROUNDING = 1e-9  # a limit of 3.14159265359 is meant to allow π
_RETURNS = 3  # steps straight onto the family at the end
_NEIGHBOURS = np.arange(-2, 3)[:, None]  # whole turns from the nearest that a joint may stand at


_Draw = tuple[Array, list[NDArray[np.int64]]]

_BATCH = 512  # configurations whose points are tested together
_LOST = 1e-6  # σ at a foot: equations hold there to 1e-9, where a family has a fold the place to 3e-7 [1]
_TIE = 1e-9  # families at the same distance, to rounding [rad]
_CLEARLY = 0.99  # a share of the distance from a family
_LONG = 100  # terms of a family's equations beyond which walking on the singular set itself is quicker
_BELOW = 1 - 1e-9  # of a proven radius: what bisection and rounding leave open
_SWEEPS = 3  # rounds in which the feet of neighbours are tried
SET_CLOUD = 1500
"""Starts of the search for points that walks begin at."""
THOROUGH, QUICK = (24, 24), (6, 6)
"""Points of the cloud and of the ball that walks of one configuration begin at."""
_LM_ITERATIONS, _EVALUATIONS = 40, 100
_FAR = 1e3  # radius of the circle that slides are laid on [length scales]

Index = NDArray[np.int64]


@lru_cache(maxsize=64)
def _draws(seed: int, moves: tuple[bool, ...], values: tuple[int, ...]) -> tuple[_Draw, _Draw]:
    """Of the first starts and of the later ones: points (N, n) that fill balls evenly, over the joints that move.

    First of several radii, then of radius 1; and for each pinned joint which of its values (N,).
    """
    rng = np.random.default_rng(seed)

    def draw_in_balls(radii: Array) -> _Draw:
        x = _ball(rng, radii, np.array(moves))
        x[0] = 0
        return x, [rng.integers(count, size=len(radii)) for count in values]

    return draw_in_balls(np.resize(_RADII, STARTS)), draw_in_balls(np.ones(LATER))


def _ball(rng: np.random.Generator, radii: Array, moves: Mask) -> Array:
    """(N, n) points of balls of radii (N,), evenly, over the joints that move."""
    x = rng.standard_normal((len(radii), len(moves))) * moves
    share = radii * rng.random(len(radii)) ** (1 / max(1, int(moves.sum())))
    return np.asarray(x * (share / np.maximum(np.linalg.norm(x, axis=1), 1e-300))[:, None])


def _walk_from_starts(family: Family, problem: Problem, centre: Array, box: Array, seed: int) -> Array:
    """(P, n) where Newton's steps from starts around a configuration end; joints that do not matter stay at it.

    Where a walk led farther away than another had ended, its end is where it stood.
    """
    system, scale, periodic = family.system, problem.scale, problem.robot.periodic
    middle = np.clip(centre, box[0], box[1])  # free joints of a q outside the limits go to the limit
    first, later = _draws(seed, tuple(system.moves.tolist()), tuple(len(pin.values) for pin in family.pinned))
    pinned = [(j := pin.number - 1, _turns_by_way(pin, middle[j], periodic[j], box[:, j])) for pin in family.pinned]
    bounded = bool(np.isfinite(box[:, system.moves]).any())
    # on more equations than are independent Newton stays where no residual gets smaller: these are walked alone too
    every, few = len(family.equations), problem.n - family.dimension
    ends: list[Array] = []
    nearest = np.inf

    def walk(draw: _Draw, radius: float) -> None:
        """The configuration itself and points in balls around it, pinned joints at any of their values."""
        nonlocal nearest
        starts = middle + draw[0] * (radius * scale)
        for (j, options), choice in zip(pinned, draw[1], strict=True):
            if len(options):
                starts[:, j] = options[choice % len(options)]
        if bounded:
            starts = np.minimum(np.maximum(starts, box[0]), box[1])
        else:
            starts = starts
        for leading in (few, every) if 0 < few < every else (every,):
            settings = _core.FootSettings(
                leading=leading, iterations=_ITERATIONS, returns=_RETURNS, still=_STILL, longest=_LONGEST, cut=CUT,
                flattest=_FLATTEST, farthest=nearest, target=centre.tolist(), scale=scale.tolist(),
                periodic=periodic.astype(int).tolist(), columns=np.flatnonzero(system.moves).tolist(),
                limits=np.ascontiguousarray(box) if bounded else None,
            )  # fmt: skip
            end = _core.feet(system.compiled, starts, settings, threads=1)
            solved = np.abs(system.values(end)).max(axis=1) <= REACHED
            nearest = min(nearest, float(problem.length(end - centre)[solved].min(initial=np.inf)))
            ends.append(end)

    walk(first, 1.0)
    if 0.0 < nearest < np.inf:
        walk(later, 1.25 * nearest)
    return np.concatenate(ends)


def _turns_by_way(pin: Pin, at: float, periodic: bool, bounds: Array) -> Array:
    """Where a pinned joint may stand, as many places as it has values, the nearest first."""
    options = nearest_turns(np.array(pin.values), at, periodic, bounds)
    return np.asarray(options[np.abs(options - at).argsort()][: len(pin.values)])


def nearest_turns(values: Array, at: float, periodic: bool, bounds: Array) -> Array:
    """Values moved by whole turns to where they are nearest to `at` and inside the bounds."""
    options = _nearest_turns(values, np.array([at]), periodic, bounds)[0]
    return np.asarray(options[np.isfinite(options)])


def _nearest_turns(values: Array, at: Array, periodic: bool, bounds: Array) -> Array:
    """(N, options) values moved by whole turns to near each of (N,); nan outside the bounds."""
    if periodic:
        turns = np.rint((at[:, None] - values) / (2 * np.pi))[:, None] + _NEIGHBOURS
        options = (values + 2 * np.pi * turns).reshape(len(at), -1)
    else:
        options = np.broadcast_to(values, (len(at), len(values)))
    if bounds[0] == -np.inf and bounds[1] == np.inf:
        return np.asarray(options)
    return np.where((options < bounds[0] - _ROUNDING) | (options > bounds[1] + _ROUNDING), np.nan, options)


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
    problem = Problem(in_metres(robot), task_in_metres(task, robot), tolerances=tolerances, limits=limits)
    at, walls = into_metres(robot, centre)[None], walls_of(problem)
    families_in_metres = [family_in_metres(family, robot) for family in families]
    points = [_candidates(family, problem, at, walls, seed)[0] for family in families_in_metres]
    if any(len(candidates) for candidates in points):
        sigma = problem.sigma(np.concatenate(points))
    else:
        sigma = np.zeros((0, problem.generic_rank))
    records, before = [], 0
    for family, mine, candidates in zip(families, families_in_metres, points, strict=True):
        values = sigma[before : before + len(candidates), problem.generic_rank - family.corank]
        before += len(candidates)
        foot, distance, residual, most = _nearest_of(mine, problem, at[0], candidates, values, tolerances.singular)
        if foot is None:
            place, way = (), ()
        else:
            place = tuple(out_of_metres(robot, foot).tolist())
            way = tuple(out_of_metres(robot, foot - at[0]).tolist())
        records.append(FamilyDistance(family, distance, place, way, residual, most, _in_closed_form(family)))
    return tuple(sorted(records, key=lambda record: record.distance))


def _nearest_of(
    family: Family, problem: Problem, q: Array, points: Array, sigma: Array, zero: float
) -> tuple[Array | None, float, float, float]:
    """The nearest of some points (P, n) that is singular and of the family: its distance from q (n,), largest |f|, σ.

    Args:
        family, problem, zero: as for `feet_on`.
        sigma: (P,) singular values that should vanish at the points.
    """
    if not len(points):
        return None, np.inf, np.inf, np.inf
    residual = np.abs(family.system.values(points)).max(axis=1)
    way = np.where((residual <= REACHED) & (sigma <= zero), problem.length(points - q), np.inf)
    best = int(way.argmin())
    if way[best] == np.inf:
        return None, np.inf, np.inf, np.inf
    return points[best], float(way[best]), float(residual[best]), float(sigma[best])


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
    if len(points):
        sigma = problem.sigma(points)[:, problem.generic_rank - family.corank]
    else:
        sigma = np.zeros(0)
    if len(points):
        residual = np.abs(family.system.values(points)).max(axis=1)
    else:
        residual = np.zeros(0)
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
    parts = [np.empty((0, problem.n)), *(_walk_from_starts(family, problem, centre, box, seed) for centre in q)]
    return np.concatenate(parts), np.repeat(np.arange(len(q)), [len(part) for part in parts[1:]])


def _pinned_feet(pinned: Sequence[Pin], robot: Robot, q: Array, box: Array) -> Array:
    """(N, n) each pinned joint at its nearest value within the limits, nan where there is none; others in the limits.
    """
    feet, rows = np.minimum(np.maximum(q, box[0]), box[1]), np.arange(len(q))
    for pin in pinned:
        j = pin.number - 1
        options = _nearest_turns(np.array(pin.values), q[:, j], bool(robot.periodic[j]), box[:, j])
        far = np.abs(options - q[:, j, None])
        far[np.isnan(far)] = np.inf
        feet[:, j] = options[rows, far.argmin(axis=1)]
    return np.asarray(feet)


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
        self._ball = _ball(np.random.default_rng(seed), np.ones(starts[1]), self.moves) * self.scale
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
        parts = [self._feet_of_batch(q[i : i + _BATCH], within[i : i + _BATCH]) for i in range(0, len(q), _BATCH)]
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


@dataclass(frozen=True, eq=False)
class Distances:
    """Distances of N configurations from F families, and from the singular set where that was walked on.

    Attributes:
        distance: (N, F) ‖(foot − q)/joint scale‖ [rad; metres divided by the length scale]; inf where no point was
            reached: the family has no equations, or none within the limits.
        foot: (N, F, n) the point reached, not wrapped; nan where there is none.
        anywhere: (N,) distance from the singular set, found by walking on it; inf where it was not, or not reached.
        anywhere_foot: (N, n) the point reached; nan where there is none.
        at_least: (N,) no singular configuration, of a known family or not, is nearer: proven, 0 where nothing is.
    """

    distance: Array
    foot: Array
    anywhere: Array
    anywhere_foot: Array
    at_least: Array

    def nearest(self) -> tuple[Index, Array]:
        """(N,) index of the nearest family and the distance; −1 where another point is nearer, or none was reached.

        Of families at the same distance the first: callers put those that say more in front. A point of the singular
        set counts where it is clearly nearer than every family, by more than 1 %.
        """
        least = self.distance.min(axis=1, initial=np.inf)
        best = np.full(len(least), -1)
        if self.distance.shape[1]:
            best = (self.distance <= least[:, None] + _TIE).argmax(axis=1)
        other = self.anywhere < _CLEARLY * least - _TIE
        return np.where(other | ~np.isfinite(least), -1, best), np.minimum(least, self.anywhere)


def distances(
    families: Sequence[Family], robot: Robot, q: ArrayLike, task: Task, *, limits: bool = False, seed: int = 0
) -> Distances:
    """Distance from many configurations to every family.

    Args:
        families: of this arm and task (`Analysis.families`).
        robot: the arm.
        q: (N, n) [rad, m].
        task: from `resolve_task`.
        limits: only points within the joint limits.
        seed: of the clouds.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.

    Example:
        >>> from rankdrop.results.known import known_analysis
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("pa10")
        >>> task = resolve_task(None, arm)
        >>> far = distances(known_analysis(arm, task).families, arm, [[0.1, 0.9, 0.4, 0.25, 0.7, 1.1, 0.2]], task)
        >>> far.nearest()[1].round(12).tolist()  # θ4 = 0 is nearest
        [0.25]
        >>> bool(0.0 < far.at_least[0] <= 0.25)
        True
    """
    rows, _ = configurations(robot, q)
    return Ruler(families, robot, task, limits=limits, seed=seed).measure(rows)


class Ruler:
    """`distances`, again and again: what they begin at is made once.

    Args:
        families, robot, task, limits, seed: as in `distances`.
        starts: of the walks on the singular set (`SetDistance`); fewer do for configurations along a path.
    """

    def __init__(
        self, families: Sequence[Family], robot: Robot, task: Task, *, limits: bool = False, seed: int = 0,
        starts: tuple[int, int] = THOROUGH,
    ) -> None:  # fmt: skip
        self.robot, self._seed, self._starts = robot, seed, starts
        self._problem = Problem(in_metres(robot), task_in_metres(task, robot), limits=limits)
        self.families = tuple(family_in_metres(family, robot) for family in families)
        self._box = walls_of(self._problem)

    @cached_property
    def _set(self) -> SetDistance | None:
        """The singular set itself, where some family of corank 1 is not of pinned joints alone."""
        first = [family for family in self.families if family.corank == 1]
        walked = not first or any(not family.named or family.coupled or not family.pinned for family in first)
        if not walked or not self._problem.generic_rank:
            return None
        return SetDistance(self._problem.robot, self._problem.task, self._box, self._seed, self._starts)

    @cached_property
    def _settings(self) -> tuple[Setting, ...]:
        """What enclosures are made from; none for a task that cannot be certified."""
        try:
            return tuple(settings_for(self._problem.robot, self._problem.task))
        except OptionError:
            return ()

    def at_least(self, q: Array) -> Array:
        """(N,) radii within which no singular configuration lies, one enclosure each: proven, and rarely sharp.

        Args:
            q: (N, n) [rad, m]; for a task that cannot be certified nothing is proven, 0.
        """
        if not self._settings:
            return np.zeros(len(q))
        rows = np.ascontiguousarray(into_metres(self.robot, q))
        radii = [
            enclose(self._problem.robot, setting, rows, radius=LARGEST, threads=1)[1] for setting in self._settings
        ]
        return np.asarray(_BELOW * np.max(radii, axis=0))

    def measure(self, q: Array, *, along: bool = False, proven: bool = True) -> Distances:
        """Distances of configurations (N, n) from all families, and from the singular set where it is walked on.

        Args:
            q: (N, n) [rad, m].
            along: they follow each other on a path: what is near to one is tried for the next, both ways.
            proven: also the bound from below, about 1 ms each; else it is 0.
        """
        if proven:
            at_least = self.at_least(q)
        else:
            at_least = np.zeros(len(q))
        q = into_metres(self.robot, q)
        feet = np.full((len(q), len(self.families), q.shape[1]), np.nan)
        for k in range(len(self.families)):
            feet[:, k] = self._feet_on(q, k)
        apart = self._distance_to(feet, q[:, None])
        foot = np.full(q.shape, np.nan)
        if self._set is not None:
            foot = self._set.feet(q, apart.min(axis=1, initial=np.inf))
            if along:
                self._from_neighbours(self._set, q, foot)
            feet = self._feet_on_families(q, feet, foot)
        far, beyond = self._distance_to(feet, q[:, None]), self._distance_to(foot, q)
        return Distances(far, out_of_metres(self.robot, feet), beyond, out_of_metres(self.robot, foot), at_least)

    def feet(self, q: Array, which: int, points: Array | None = None) -> Array:
        """(N, n) points of one family near configurations (N, n); nan where none was reached.

        Args:
            q: (N, n), of the arm in metres.
            which: index of the family; −1: of any.
            points: (N, n) points of it that are near, or nan; the walk begins there, too.
        """
        feet = self._feet_on(q, which)
        if self._set is None:
            return feet
        if points is None:
            other = self._set.feet(q, self._distance_to(feet, q))
        else:
            nearer = self._distance_to(self._set.brought_near(points, q), q) < _CLEARLY * self._distance_to(feet, q)
            other = self._set.from_points(q, np.where(nearer[:, None], points, np.nan))
        if which >= 0:
            other = np.where(self._lies_on_family(which, other)[:, None], other, np.nan)
        return np.where((self._distance_to(other, q) < self._distance_to(feet, q))[:, None], other, feet)

    def _distance_to(self, feet: Array, q: Array) -> Array:
        """Distance [rad; slides scaled]; inf where there is no foot."""
        far = self._problem.length(feet - q)
        return np.where(np.isnan(far), np.inf, far)

    def _from_neighbours(self, walked: SetDistance, q: Array, foot: Array) -> None:
        """Walks from the feet of the configurations before and after, where these are nearer than one's own."""
        for _ in range(_SWEEPS):
            changed = False
            for mine, other in ((slice(1, None), slice(None, -1)), (slice(None, -1), slice(1, None))):
                points = walked.brought_near(foot[other], q[mine])
                nearer = self._distance_to(points, q[mine]) < _CLEARLY * self._distance_to(foot[mine], q[mine])
                rows = np.flatnonzero(nearer)
                ends = walked.from_points(q[mine][rows], points[rows])
                better = self._distance_to(ends, q[mine][rows]) < self._distance_to(foot[mine][rows], q[mine][rows])
                foot[mine][rows[better]] = ends[better]
                changed |= bool(better.any())
            if not changed:
                break

    def _feet_on_families(self, q: Array, feet: Array, foot: Array) -> Array:
        """Points of the singular set as feet on the families whose conditions hold there, where they are nearer."""
        far = self._distance_to(foot, q)
        for k in range(len(self.families)):
            rows = np.flatnonzero(far < self._distance_to(feet[:, k], q))
            rows = rows[self._lies_on_family(k, foot[rows])]
            feet[rows, k] = foot[rows]
        return feet

    def _lies_on_family(self, which: int, points: Array) -> Mask:
        """(N,) whether a family's conditions hold at points (N, n), which have its rank; False at nan."""
        family = self.families[which]
        rows = np.flatnonzero(np.isfinite(points).all(axis=1))
        if not family.named or not family.equations or not len(rows):
            return np.zeros(len(points), dtype=np.bool_)
        rows = rows[np.abs(family.system.values(points[rows])).max(axis=1) <= REACHED]
        rows = rows[self._problem.sigma(points[rows])[:, self._problem.generic_rank - family.corank] <= _LOST]
        return np.isin(np.arange(len(points)), rows)

    def _feet_on(self, q: Array, which: int) -> Array:
        """(N, n) points of a family by its own conditions; nan where none was reached, and of any (−1)."""
        if which >= 0:
            family = self.families[which]
        else:
            family = None
        if family is None or (self._set is not None and _is_long(family)):
            return np.full(q.shape, np.nan)
        parts = [feet_on(family, self._problem, q[i : i + _BATCH], self._box, zero=_LOST, seed=self._seed)[0]
                 for i in range(0, len(q), _BATCH)]  # fmt: skip
        return np.concatenate([q[:0], *parts])


def _is_long(family: Family) -> bool:
    coupled = bool(family.coupled or not family.pinned)
    return coupled and sum(len(equation.terms) for equation in family.equations) > _LONG
