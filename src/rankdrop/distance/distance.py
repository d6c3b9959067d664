"""How far one configuration is from each family: the nearest point that satisfies a family's equations.

The nearest point of a family whose joints are coupled is found by

    minimise ½‖x‖²  subject to  f(q) = 0,   x = (q − q0)/joint scale,

with Newton's method on the conditions x = Aᵀλ, f = 0 (A = ∂f/∂x, with second derivatives) from
many starts at once.

A family of pinned joints only is nearest where each of them turns to its nearest value: closed form. The others are
walked. A point counts where |f| ≤ 1e-9 and σ vanishes in the Jacobian itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop import _core
from rankdrop.families.record import Family, Pin
from rankdrop.families.rescaling import family_in_metres
from rankdrop.formula.equation import REACHED, Mask
from rankdrop.kinematics import one_configuration
from rankdrop.problem import Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.solve import CUT
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances
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


@lru_cache(maxsize=64)
def _draws(seed: int, moves: tuple[bool, ...], values: tuple[int, ...]) -> tuple[_Draw, _Draw]:
    """Of the first starts and of the later ones: points (N, n) that fill balls evenly, over the joints that move.

    First of several radii, then of radius 1; and for each pinned joint which of its values (N,).
    """
    rng = np.random.default_rng(seed)

    def draw_in_balls(radii: Array) -> _Draw:
        x = ball_points(rng, radii, np.array(moves))
        x[0] = 0
        return x, [rng.integers(count, size=len(radii)) for count in values]

    return draw_in_balls(np.resize(_RADII, STARTS)), draw_in_balls(np.ones(LATER))


def ball_points(rng: np.random.Generator, radii: Array, moves: Mask) -> Array:
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
