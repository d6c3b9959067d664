"""How far many configurations are from every family, and from the singular set.

Of many configurations a family has many nearest points, and long conditions are slow; so unless every family is pinned,
the singular set itself is walked on as well (`SetDistance`), and a point that this finds counts for the families whose
conditions it satisfies. What is returned is singular, so a distance is never too small; it may be too large by what no
walk has come round to (measured against `nearest_singularity` in `tests/distance`). Beside it stands a bound from
below, proven by one enclosure (`Ruler.at_least`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.cover.ball import LARGEST
from rankdrop.cover.setting import Setting, enclose, settings_for
from rankdrop.distance.distance import feet_on, walls_of
from rankdrop.distance.singular_set import BATCH, THOROUGH, SetDistance
from rankdrop.errors import OptionError
from rankdrop.families.record import Family
from rankdrop.families.rescaling import family_in_metres
from rankdrop.formula.equation import REACHED, Mask
from rankdrop.kinematics import configurations
from rankdrop.problem import Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.units import in_metres, into_metres, out_of_metres, task_in_metres

_LOST = 1e-6  # σ at a foot: equations hold there to 1e-9, where a family has a fold the place to 3e-7 [1]
_TIE = 1e-9  # families at the same distance, to rounding [rad]
_CLEARLY = 0.99  # a share of the distance from a family
_LONG = 100  # terms of a family's equations beyond which walking on the singular set itself is quicker
_BELOW = 1 - 1e-9  # of a proven radius: what bisection and rounding leave open
_SWEEPS = 3  # rounds in which the feet of neighbours are tried
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
        parts = [feet_on(family, self._problem, q[i : i + BATCH], self._box, zero=_LOST, seed=self._seed)[0]
                 for i in range(0, len(q), BATCH)]  # fmt: skip
        return np.concatenate([q[:0], *parts])


def _is_long(family: Family) -> bool:
    coupled = bool(family.coupled or not family.pinned)
    return coupled and sum(len(equation.terms) for equation in family.equations) > _LONG
