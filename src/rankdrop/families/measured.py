"""How far many configurations are from every family: a point of each family, near enough to the nearest one.

A family of pinned joints only is nearest where each turns to its nearest value: closed form. The others are walked to:

    q ← q0 − A⁺(f(q) + A (q0 − q)),   A = ∂f/∂q in scaled joint variables

is the nearest point of the family's tangent plane at q, again and again, from q0 itself and from the points nearest to
it of a cloud on the family. Such a walk circles where the family is curved as narrowly as it is far, and a family has
many nearest points; so unless every family is pinned, the singular set itself is walked on as well, from more starts
(`Anywhere`), and a point that this finds counts for the families whose conditions it satisfies. What is returned is
singular, so a distance is never too small; it may be too large by what no walk has come round to (measured against
`nearest_singularity` in `tests/families`). Beside it stands a bound from below, proven by one enclosure (`certify`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop import _core
from rankdrop.certify.ball import LARGEST, settings_of
from rankdrop.certify.setting import Setting, enclose
from rankdrop.errors import OptionError
from rankdrop.families.distance import nearest_turns
from rankdrop.families.search_record import Outcome
from rankdrop.families.searching import search
from rankdrop.family.equation import REACHED, System
from rankdrop.family.record import Family, Pin, family_in_metres
from rankdrop.kinematics import chain_of, configurations, task_view
from rankdrop.local.block import generic_rank, joint_scale, sampling_box, singular_values
from rankdrop.problem import Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.solve import iterate, newton, towards
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, TIE
from rankdrop.units import in_metres, into_metres, out_of_metres, task_in_metres

CLOUD = 600
"""Points of a family of coupled joints that walks begin at."""
_SEEDS = 4  # of them, for each configuration
_ITERATIONS = 10
_LONGEST = 0.7  # step [rad]
_STILL = 1e-6  # steps shorter than this change the distance by their square [rad]
_LANDING = 3  # Newton steps onto the family at the end
_DOUBLE = 40  # … where it has double zeros: each halves the rest
_BATCH = 512  # configurations walked together
_LOST = 1e-6  # σ at a foot: equations hold there to 1e-9, where a family has a fold the place to 3e-7 [1]
_TIE = 1e-9  # families at the same distance, to rounding [rad]
_CLEARLY = 0.99  # a share of the distance from a family
_LONG = 100  # terms of a family's equations beyond which walking on the singular set itself is quicker
_BELOW = 1 - 1e-9  # of a proven radius: what bisection and rounding leave open
_FLAT = 1e-3  # |∂f/∂q| where an equation has a double zero: solving leaves 2e-4 for the UR5, whose others have 0.05
_SWEEPS = 3  # rounds in which the feet of neighbours are tried


SET_CLOUD = 1500
"""Starts of the search for points that walks begin at."""
THOROUGH, QUICK = (24, 24), (6, 6)
"""Points of the cloud and of the ball that walks of one configuration begin at."""
_LM_ITERATIONS, _EVALUATIONS = 40, 100
_FAR = 1e3  # radius of the circle that slides are laid on [length scales]


class Anywhere:
    """Walks onto the set of corank 1, whatever family its points are of.

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
        self.robot, self.task, self.box = robot, task, box
        self.rank = generic_rank(robot, task) - 1
        self.scale = joint_scale(robot, task)
        self.moves = ~Problem(robot, task).idle
        self._limits = box if bool(np.isfinite(box).any()) else None
        found = search(robot, 1, task=task, starts=SET_CLOUD, seed=seed, limits=bool(np.isfinite(box).all()))
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


Index = NDArray[np.int64]


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
    return Measure(families, robot, task, limits=limits, seed=seed).of(rows)


class Measure:
    """`distances`, again and again: what they begin at is made once.

    Args:
        families, robot, task, limits, seed: as in `distances`.
    """

    def __init__(
        self, families: Sequence[Family], robot: Robot, task: Task, *, limits: bool = False, seed: int = 0
    ) -> None:
        self.robot = robot
        self._there, self._task = in_metres(robot), task_in_metres(task, robot)
        known = families if self._there is robot else [family_in_metres(family, robot) for family in families]
        self._known, self._limits, self._seed = known, limits, seed

    @cached_property
    def _ruler(self) -> Ruler:
        return Ruler(self._known, self._there, self._task, limits=self._limits, seed=self._seed)

    @cached_property
    def _settings(self) -> tuple[Setting, ...]:
        return _settings(self._there, self._task)

    def of(self, q: Array, *, along: bool = False) -> Distances:
        """Distances of configurations (N, n) [rad, m]; `along`: they follow each other on a path."""
        moved = into_metres(self.robot, q)
        found = replace(self._ruler.measure(moved, along=along), at_least=self.at_least(q))
        if self._there is self.robot:
            return found
        return replace(
            found, foot=out_of_metres(self.robot, found.foot),
            anywhere_foot=out_of_metres(self.robot, found.anywhere_foot),
        )  # fmt: skip

    def at_least(self, q: Array) -> Array:
        """(N,) the proven bound alone."""
        return _proven(self._there, self._settings, into_metres(self.robot, q))


def at_least(robot: Robot, q: Array, task: Task) -> Array:
    """(N,) radii within which no singular configuration lies, one enclosure each: proven, and rarely sharp.

    Args:
        robot: the arm, in metres.
        q: (N, n).
        task: from `resolve_task`; for one that cannot be certified nothing is proven, 0.
    """
    return _proven(robot, _settings(robot, task), q)


def _settings(robot: Robot, task: Task) -> tuple[Setting, ...]:
    """What enclosures are made from; none for a task that cannot be certified."""
    try:
        return tuple(settings_of(robot, task))
    except OptionError:
        return ()


def _proven(robot: Robot, settings: tuple[Setting, ...], q: Array) -> Array:
    """(N,) the largest radius that an enclosure from one of the settings proves."""
    if not settings:
        return np.zeros(len(q))
    rows = np.ascontiguousarray(q)
    radii = [enclose(robot, one, rows, radius=LARGEST, threads=1)[1] for one in settings]
    return np.asarray(_BELOW * np.max(radii, axis=0))


class Ruler:
    """Measures distances to given families, again and again; the clouds are made once.

    Args:
        families: of this arm and task.
        robot: the arm, in metres (`units.in_metres`).
        task, limits, seed: as in `distances`.
        starts: of the walks on the singular set (`Anywhere`); fewer do for configurations along a path.
    """

    def __init__(
        self, families: Sequence[Family], robot: Robot, task: Task, *, limits: bool = False, seed: int = 0,
        starts: tuple[int, int] = THOROUGH,
    ) -> None:  # fmt: skip
        self.families, self.robot = tuple(families), robot
        self.scale = joint_scale(robot, task)
        none = np.array([[-np.inf], [np.inf]]) * np.ones(robot.n)
        self.box = np.stack([robot.lower, robot.upper]) if limits else none
        first = [one for one in self.families if one.corank == 1]
        walked = not first or any(not one.named or one.coupled or not one.pinned for one in first)
        walked = walked and generic_rank(robot, task) > 0
        self.task, self._rank = task, generic_rank(robot, task)
        self._anywhere = Anywhere(robot, task, self.box, seed, starts) if walked else None
        self._walks = {
            k: _Walk(family, robot, task, self.scale, self.box, seed)
            for k, family in enumerate(self.families)
            if family.named and family.equations and (family.coupled or not family.pinned)
            and not (walked and sum(len(one.terms) for one in family.equations) > _LONG)
        }  # fmt: skip

    def measure(self, q: Array, *, along: bool = False) -> Distances:
        """Distances of configurations (N, n) from all families, and from the singular set where it is walked on.

        Args:
            q: (N, n).
            along: they follow each other on a path: what is near to one is tried for the next, both ways.
        """
        feet = np.full((len(q), len(self.families), self.robot.n), np.nan)
        for k in range(len(self.families)):
            feet[:, k] = self._walked_feet(q, k)
        apart = self._far(feet, q[:, None])
        foot = np.full(q.shape, np.nan)
        if self._anywhere is not None:
            foot = self._anywhere.feet(q, apart.min(axis=1, initial=np.inf))
            if along:
                self._from_neighbours(self._anywhere, q, foot)
            feet = self._credited(q, feet, foot)
        return Distances(self._far(feet, q[:, None]), feet, self._far(foot, q), foot, np.zeros(len(q)))

    def feet(self, q: Array, which: int, points: Array | None = None) -> Array:
        """(N, n) points of one family near configurations (N, n); nan where none was reached.

        Args:
            q: (N, n).
            which: index of the family; −1: of any.
            points: (N, n) points of it that are near, or nan; the walk begins there, too.
        """
        feet = self._walked_feet(q, which)
        if self._anywhere is None:
            return feet
        if points is None:
            other = self._anywhere.feet(q, self._far(feet, q))
        else:
            nearer = self._far(self._anywhere.brought_near(points, q), q) < _CLEARLY * self._far(feet, q)
            other = self._anywhere.from_points(q, np.where(nearer[:, None], points, np.nan))
        if which >= 0:
            other = np.where(self._on(which, other)[:, None], other, np.nan)
        return np.where((self._far(other, q) < self._far(feet, q))[:, None], other, feet)

    def _far(self, feet: Array, q: Array) -> Array:
        """Distance [rad; slides scaled]; inf where there is no foot."""
        far = np.linalg.norm((feet - q) / self.scale, axis=-1)
        return np.where(np.isnan(far), np.inf, far)

    def _from_neighbours(self, anywhere: Anywhere, q: Array, foot: Array) -> None:
        """Walks from the feet of the configurations before and after, where these are nearer than one's own."""
        for _ in range(_SWEEPS):
            changed = False
            for mine, other in ((slice(1, None), slice(None, -1)), (slice(None, -1), slice(1, None))):
                points = anywhere.brought_near(foot[other], q[mine])
                rows = np.flatnonzero(self._far(points, q[mine]) < _CLEARLY * self._far(foot[mine], q[mine]))
                ends = anywhere.from_points(q[mine][rows], points[rows])
                better = self._far(ends, q[mine][rows]) < self._far(foot[mine][rows], q[mine][rows])
                foot[mine][rows[better]] = ends[better]
                changed |= bool(better.any())
            if not changed:
                break

    def _credited(self, q: Array, feet: Array, foot: Array) -> Array:
        """Points of the singular set as feet on the families whose conditions hold there, where they are nearer."""
        far = self._far(foot, q)
        for k in range(len(self.families)):
            rows = np.flatnonzero(far < self._far(feet[:, k], q))
            rows = rows[self._on(k, foot[rows])]
            feet[rows, k] = foot[rows]
        return feet

    def _on(self, which: int, points: Array) -> NDArray[np.bool_]:
        """(N,) whether a family's conditions hold at points (N, n), which have its rank; False at nan."""
        family = self.families[which]
        there = np.asarray(np.isfinite(points).all(axis=1))
        if not family.named or not family.equations or not there.any():
            return np.zeros(len(points), dtype=np.bool_)
        rows = np.flatnonzero(there)
        rows = rows[np.abs(family.system.values(points[rows])).max(axis=1) <= REACHED]
        rows = rows[singular_values(self.robot, points[rows], self.task)[:, self._rank - family.corank] <= _LOST]
        return np.isin(np.arange(len(points)), rows)

    def _walked_feet(self, q: Array, which: int) -> Array:
        """(N, n) points of a family by its own conditions; nan where none was reached, and of any (−1)."""
        if which < 0:
            return np.full(q.shape, np.nan)
        family = self.families[which]
        if which in self._walks:
            return np.concatenate(
                [q[:0], *(self._walks[which].feet(q[i : i + _BATCH]) for i in range(0, len(q), _BATCH))]
            )
        if family.named and family.pinned and not family.coupled:
            return _pinned_feet(family.pinned, self.robot, q, self.box)
        return np.full(q.shape, np.nan)


def _pinned_feet(pinned: Sequence[Pin], robot: Robot, q: Array, box: Array) -> Array:
    """(N, n) each pinned joint at its nearest value within the limits, the others moved no more than the limits ask."""
    feet = np.clip(q, box[0], box[1])
    for one in pinned:
        j, values = one.number - 1, np.array(one.values)
        at = q[:, j, None]
        if bool(robot.periodic[j]):
            turns = np.round((at[..., None] - values[:, None]) / (2 * pi)) + np.arange(-2, 3)
            options = (values[:, None] + 2 * pi * turns).reshape(len(q), 5 * len(values))
        else:
            options = np.broadcast_to(values, (len(q), len(values)))
        room = 1e-9  # a limit of 3.14159265359 is meant to allow π
        inside = (options >= box[0, j] - room) & (options <= box[1, j] + room)
        far = np.where(inside, np.abs(options - at), np.inf)
        best = far.argmin(axis=1)
        rows = np.arange(len(q))
        feet[:, j] = np.where(np.isfinite(far[rows, best]), options[rows, best], np.nan)
    return feet


class _Walk:
    """Walks onto one family of coupled joints."""

    def __init__(self, family: Family, robot: Robot, task: Task, scale: Array, box: Array, seed: int) -> None:
        self.robot, self.scale, self.box = robot, scale, box
        self.system = family.system
        self.task, self.rank = task, generic_rank(robot, task) - family.corank
        moves = np.zeros(robot.n, dtype=np.bool_)
        for equation in family.equations:
            moves[[number - 1 for number in equation.joints]] = True
        self.columns = np.flatnonzero(moves)
        self.cloud = self._cloud(family, task, np.random.default_rng(seed))
        self.led = self._leading()

    def _cloud(self, family: Family, task: Task, rng: np.random.Generator) -> Array:
        low, high = sampling_box(self.robot, task, limits=bool(np.isfinite(self.box).any()))
        starts = rng.uniform(low, high, (CLOUD, self.robot.n))
        for joint in family.pinned:
            options = nearest_turns(np.array(joint.values), 0.0, False, self.box[:, joint.number - 1])
            if len(options):
                starts[:, joint.number - 1] = rng.choice(options, len(starts))
        end, _ = self.system.solve(starts, iterations=20, still=1e-10)
        end = end[np.abs(self.system.values(end)).max(axis=1) <= REACHED]
        return np.asarray(end[((end >= self.box[0]) & (end <= self.box[1])).all(axis=1)])

    def _leading(self) -> System:
        """The equations that walks follow: one whose derivative vanishes on the family leads them astray."""
        if not len(self.cloud):
            return self.system
        slope = np.median(np.linalg.norm(self.system.jacobian(self.cloud), axis=2), axis=0)
        led = tuple(one for one, size in zip(self.system.equations, slope, strict=True) if size > _FLAT)
        return System(led) if led else self.system

    def feet(self, q: Array) -> Array:
        """(N, n) the nearest point reached from each start; nan where none was."""
        starts = [np.clip(q, self.box[0], self.box[1]), *self._near(q)]
        targets = np.concatenate([q] * len(starts))
        ends = self._walked(np.concatenate(starts), targets)
        there = np.abs(self.system.values(ends)).max(axis=1) <= REACHED
        there &= singular_values(self.robot, ends, self.task)[:, self.rank] <= _LOST  # not all but a zero
        far = np.where(there, np.linalg.norm((ends - targets) / self.scale, axis=1), np.inf).reshape(len(starts), -1)
        best = far.argmin(axis=0)
        rows = np.arange(len(q))
        feet = ends.reshape(len(starts), len(q), -1)[best, rows]
        return np.where(np.isfinite(far[best, rows])[:, None], feet, np.nan)

    def _near(self, q: Array) -> list[Array]:
        """(N, n) each: q with its coupled joints at those of the points of the cloud nearest to it."""
        if not len(self.cloud):
            return []
        at = self.columns
        gap = (self.cloud[None, :, at] - q[:, None, at]) / self.scale[at]
        turns = np.where(self.robot.periodic[at], np.round(gap / (2 * pi)), 0.0)
        inside = self._inside(self.cloud[None, :, at] - 2 * pi * turns, at)
        gap = np.where(inside, gap - 2 * pi * turns, gap)
        order = np.argpartition((gap**2).sum(axis=2), min(_SEEDS, len(self.cloud)) - 1, axis=1)[:, :_SEEDS]
        seeds = []
        for k in range(order.shape[1]):
            start = np.clip(q, self.box[0], self.box[1])
            start[:, at] = q[:, at] + self.scale[at] * gap[np.arange(len(q)), order[:, k]]
            seeds.append(start)
        return seeds

    def _inside(self, values: Array, at: Index) -> NDArray[np.bool_]:
        return np.asarray((values >= self.box[0, at]) & (values <= self.box[1, at]))

    def _walked(self, q: Array, targets: Array) -> Array:
        """Tangent planes, then straight onto the family, where it has double zeros in more steps."""

        def to_tangent_plane(q: Array, active: Index) -> Array:
            f, a = self.led.linear(q)
            return towards((targets[active] - q) / self.scale, f, a * self.scale)

        near = iterate(to_tangent_plane, q, iterations=_ITERATIONS, longest=_LONGEST, still=_STILL, scale=self.scale,
                       box=self.box)  # fmt: skip
        ends = newton(self.led.residuals, near, scale=self.scale, iterations=_LANDING, step=np.inf, box=self.box)
        off = np.abs(self.system.values(ends)).max(axis=1) > REACHED
        if off.any():  # other zeros of the equations that led: on by all of them
            ends[off] = newton(
                self.system.residuals, ends[off], scale=self.scale, iterations=_DOUBLE, step=np.inf, box=self.box
            )
        return ends
