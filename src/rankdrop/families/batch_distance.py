"""How far many configurations are from every family: a point of each family, near enough to the nearest one.

From each configuration the nearest point of each family is sought as from one (`distance`). A family has many nearest
points, and long conditions are slow; so unless every family is pinned, the singular set itself is walked on as well
(`SetDistance`), and a point that this finds counts for the families whose conditions it satisfies. What is returned is
singular, so a distance is never too small; it may be too large by what no walk has come round to (measured against
`nearest_singularity` in `tests/families`). Beside it stands a bound from below, proven by one enclosure (`certify`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop import _core
from rankdrop.certify.ball import LARGEST, settings_of
from rankdrop.certify.setting import Setting, enclose
from rankdrop.errors import OptionError
from rankdrop.families.distance import feet_on, walls_of
from rankdrop.families.search_record import Outcome
from rankdrop.families.searching import search
from rankdrop.family.equation import REACHED
from rankdrop.family.record import Family, family_in_metres
from rankdrop.kinematics import chain_of, configurations, task_view
from rankdrop.local.block import generic_rank, joint_scale, singular_values
from rankdrop.problem import Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, TIE
from rankdrop.units import in_metres, into_metres, out_of_metres, task_in_metres

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
        moved = self._problem.robot is not robot
        self.families = tuple(family_in_metres(family, robot) for family in families) if moved else tuple(families)
        self._box = walls_of(self._problem)

    @cached_property
    def _set(self) -> SetDistance | None:
        """The singular set itself, where some family of corank 1 is not of pinned joints alone."""
        first = [one for one in self.families if one.corank == 1]
        walked = not first or any(not one.named or one.coupled or not one.pinned for one in first)
        if not walked or not self._problem.generic_rank:
            return None
        return SetDistance(self._problem.robot, self._problem.task, self._box, self._seed, self._starts)

    @cached_property
    def _settings(self) -> tuple[Setting, ...]:
        """What enclosures are made from; none for a task that cannot be certified."""
        try:
            return tuple(settings_of(self._problem.robot, self._problem.task))
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
        radii = [enclose(self._problem.robot, one, rows, radius=LARGEST, threads=1)[1] for one in self._settings]
        return np.asarray(_BELOW * np.max(radii, axis=0))

    def measure(self, q: Array, *, along: bool = False, proven: bool = True) -> Distances:
        """Distances of configurations (N, n) from all families, and from the singular set where it is walked on.

        Args:
            q: (N, n) [rad, m].
            along: they follow each other on a path: what is near to one is tried for the next, both ways.
            proven: also the bound from below, about 1 ms each; else it is 0.
        """
        at_least = self.at_least(q) if proven else np.zeros(len(q))
        q = into_metres(self.robot, q)
        feet = np.full((len(q), len(self.families), q.shape[1]), np.nan)
        for k in range(len(self.families)):
            feet[:, k] = self._feet_on(q, k)
        apart = self._far(feet, q[:, None])
        foot = np.full(q.shape, np.nan)
        if self._set is not None:
            foot = self._set.feet(q, apart.min(axis=1, initial=np.inf))
            if along:
                self._from_neighbours(self._set, q, foot)
            feet = self._credited(q, feet, foot)
        far, beyond = self._far(feet, q[:, None]), self._far(foot, q)
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
            other = self._set.feet(q, self._far(feet, q))
        else:
            nearer = self._far(self._set.brought_near(points, q), q) < _CLEARLY * self._far(feet, q)
            other = self._set.from_points(q, np.where(nearer[:, None], points, np.nan))
        if which >= 0:
            other = np.where(self._on(which, other)[:, None], other, np.nan)
        return np.where((self._far(other, q) < self._far(feet, q))[:, None], other, feet)

    def _far(self, feet: Array, q: Array) -> Array:
        """Distance [rad; slides scaled]; inf where there is no foot."""
        far = np.linalg.norm((feet - q) / self._problem.scale, axis=-1)
        return np.where(np.isnan(far), np.inf, far)

    def _from_neighbours(self, walked: SetDistance, q: Array, foot: Array) -> None:
        """Walks from the feet of the configurations before and after, where these are nearer than one's own."""
        for _ in range(_SWEEPS):
            changed = False
            for mine, other in ((slice(1, None), slice(None, -1)), (slice(None, -1), slice(1, None))):
                points = walked.brought_near(foot[other], q[mine])
                rows = np.flatnonzero(self._far(points, q[mine]) < _CLEARLY * self._far(foot[mine], q[mine]))
                ends = walked.from_points(q[mine][rows], points[rows])
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
        rows = rows[self._problem.sigma(points[rows])[:, self._problem.generic_rank - family.corank] <= _LOST]
        return np.isin(np.arange(len(points)), rows)

    def _feet_on(self, q: Array, which: int) -> Array:
        """(N, n) points of a family by its own conditions; nan where none was reached, and of any (−1)."""
        if which < 0 or (self._set is not None and self._is_long(self.families[which])):
            return np.full(q.shape, np.nan)
        family = self.families[which]
        parts = [feet_on(family, self._problem, q[i : i + _BATCH], self._box, zero=_LOST, seed=self._seed)[0]
                 for i in range(0, len(q), _BATCH)]  # fmt: skip
        return np.concatenate([q[:0], *parts])

    def _is_long(self, family: Family) -> bool:
        coupled = bool(family.coupled or not family.pinned)
        return coupled and sum(len(one.terms) for one in family.equations) > _LONG
