"""How far a joint must stay from its singular value for the tool to keep a speed, proven over a region.

A straight motion of the tool without turning, v u with |u| = 1, asks for q̇ = J⁻¹ (v u; 0). The slowest direction has

    v(q) = min_i  q̇max_i / ‖row_i of the first three columns of J⁻¹‖

Over a box, U₁ᵀ J V₁ = Σ + E with |E| ≤ B (`rankdrop.cover.setting`). Where Σ − B is an M-matrix,

    J⁻¹ = V₁ (Σ + E)⁻¹ U₁ᵀ,     |(Σ + E)⁻¹| ≤ (Σ − B)⁻¹ entry by entry,
    (Σ + E)⁻¹ = Σ⁻¹ − Σ⁻¹ E Σ⁻¹ + (Σ + E)⁻¹ E Σ⁻¹ E Σ⁻¹,     |E − Σ_k G_k δ_k| ≤ B − Σ_k |G_k| h_k

with the derivatives G_k of U₁ᵀ J V₁ at the centre and the half-widths h: a linear part, which is exact, and a rest of
second order. So ‖row_i‖ is bounded, and v(q) from below, at every configuration of the box. With more joints than rows
the same q̇ is one of many that move the tool so, and the bound holds as well.

Branch and bound over the region: of the boxes in which v(q) is not proven, the one that reaches farthest from the
singular value is halved next. The farthest end that is left is the distance. Configurations that are slower, found on
the way, say how far from the best distance it can be. Families of several joints have distances of their own
(`rankdrop.cover.speed_measures`); the region goes up to the family in the joints that stand at values on it, or in the
joint in which the family is nearest.
"""

from __future__ import annotations

from math import radians

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.cover.setting import Setting, best_setting, enclose, regular
from rankdrop.cover.speed_measures import AtValues, ConditionResidual, at_values, nearest_root, residual
from rankdrop.errors import OptionError
from rankdrop.families.record import Family
from rankdrop.families.speed_distance import SpeedDistance
from rankdrop.kinematics import configurations, jacobian_derivative
from rankdrop.local.block import generic_rank, joint_scale
from rankdrop.local.posture import start_posture
from rankdrop.local.rates import rate_limits
from rankdrop.local.slowest import slowest_motions
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.task import Frame, Task
from rankdrop.tolerances import SPAN
from rankdrop.units import in_metres, into_metres, out_of_metres, task_in_metres

BUDGET = 100_000
"""Boxes for each distance, some 50 to 130 μs each."""

_OF_SEVERAL = 30_000  # boxes for a distance of several joints: three times as many gain a tenth
_ROWS_OF_TRANSLATION = 3
_BATCH = 512  # boxes halved at one time
_FINE, _SHARE = radians(0.1), 0.02  # a distance is as good as it need be: within 0.1° or 2 % of the best one
_OUTWARDS = 1.0 + 1e-9
_SLACK = 1e-9  # of an inverse: more than its rounding
_EQUAL = 1e-6  # between the bound at a point and the slowest motion there, where the two are one thing


class SpeedRegion:
    """A region around a posture, in which distances that keep a speed are proven.

    Args:
        robot: the arm; its `Joint.velocity` are the rate limits.
        task: from `resolve_task`.
        speed: that the tool is to keep [m/s].
        around: (n,) middle of the region; None for a usual posture.
        span: half its width in each joint; slides divided by the length scale [rad].
        budget: boxes for each distance.

    Raises:
        OptionError: no rate limits, a task without translation or with more rows than the rank, a speed or a span that
            is not positive.
        ConfigurationError: `around` has the wrong shape or is not finite.
    """

    def __init__(
        self, robot: Robot, task: Task, speed: float, *, around: ArrayLike | None = None, span: float = SPAN,
        budget: int = BUDGET,
    ) -> None:  # fmt: skip
        if not 0.0 < speed < np.inf:
            raise OptionError("a speed is a positive number", where="speed", got=speed, allowed="m/s above 0")
        if not 0.0 < span <= np.pi:
            raise OptionError("a span is a positive angle", where="span", got=span, allowed="rad, 0 … π")
        self.speed, self.span, self.budget = speed, span, budget
        self.robot, self.task = in_metres(robot), task_in_metres(task, robot)
        self.limits = rate_limits(self.robot)
        moves = [row for row in task.rows if row < _ROWS_OF_TRANSLATION]
        if not moves or generic_rank(self.robot, self.task) < task.m:
            raise OptionError("the tool of this task has no speed that it could keep in every direction", where="speed",
                              got=task.name,
                              allowed="a task with translations, in which no direction is lost always")  # fmt: skip
        limited = int(np.isfinite(self.limits).sum())
        if limited <= robot.n - task.m:  # the other joints alone can make any motion
            raise OptionError(
                "the arm has no rate limits that bound the tool's speed", where="speed",
                got=f"{robot.name}: limits for {limited} of {robot.n} joints",
                allowed=f"rate limits of at least {robot.n - task.m + 1} joints",
                mend="state `velocity` of the joints in its file, in rad/s (slides: m/s)",
            )  # fmt: skip
        if around is None:
            middle = start_posture(self.robot, self.task)
        else:
            rows, _ = configurations(robot, around)
            if len(rows) != 1:
                raise OptionError("a region has one middle", where="around", got=f"{len(rows)} configurations")
            middle = into_metres(robot, rows)[0]
        self.around = np.asarray(middle, dtype=np.float64)
        self.given = out_of_metres(robot, self.around)
        self.setting: Setting = best_setting(self.robot, self.task)
        self.matters = np.asarray(self.setting.matters)
        bound = float(self.least(self.around[None], np.zeros((1, robot.n)))[0])
        slowest = float(self.slowest(self.around[None])[0])
        if robot.n == task.m and bound > 0.0 and abs(bound - slowest) > _EQUAL * slowest:
            raise OptionError("speeds are proven for tasks with all rotations or none", where="speed", got=task.name,
                              allowed="pose, position")  # fmt: skip

    @property
    def free(self) -> tuple[int, ...]:
        """Numbers of the joints that may have any value."""
        return tuple(int(j) + 1 for j in np.flatnonzero(~self.matters))

    def turns(self, number: int) -> bool:
        """Whether a joint, by its number from 1, turns."""
        return self.robot.variables[number - 1].kind is not JointKind.PRISMATIC

    def distance(self, family: str, number: int, values: tuple[float, ...]) -> SpeedDistance:
        """From which distance of a turning joint from its value on a family the speed is kept.

        Args:
            family: its id.
            number: of the joint, from 1.
            values: of the joint on the family [rad]; the one nearest to the middle of the region counts.
        """
        j = number - 1
        gaps = [_gap(self.around[j] - value, periodic=bool(self.robot.periodic[j])) for value in values]
        nearest = int(np.argmin(np.abs(gaps)))
        gap = gaps[nearest]
        side = 1.0 if gap >= 0.0 else -1.0
        near = self._search(j, gap, side, abs(gap) + self.span)
        searches = [near]
        kept = near.distance
        if abs(gap) < self.span:  # the region goes on beyond the value
            beyond = self._search(j, gap, -side, self.span - abs(gap))
            searches.append(beyond)
            if kept is not None:
                kept = max(kept, beyond.kept_distance)
        slowest = max(searches, key=lambda search: search.slower or 0.0)
        return SpeedDistance(
            family, number, self.robot.variables[j].name, values[nearest], near.end, kept, slowest.slower,
            slowest.speed, sum(search.boxes for search in searches), any(search.spent for search in searches),
        )  # fmt: skip

    def distance_from(self, family: Family) -> SpeedDistance | None:
        """From which distance of a family the speed is kept, in the measure that the family has.

        Of one turning joint at values as `distance`; of several of them the largest of their distances; of one
        condition on several joints its residual. None for families with more conditions on several joints, with
        slides, or without known conditions.
        """
        if len(family.pinned) == 1 and not family.coupled and self.turns(family.pinned[0].number):
            pin = family.pinned[0]
            return self.distance(family.id, pin.number, pin.values)
        several = at_values(self.robot, family, self.around)
        if several is not None:
            return self._from_values(family.id, several)
        condition = residual(self.robot, family)
        if condition is not None:
            return self._from_residual(family, condition)
        return None

    def _from_values(self, family: str, measure: AtValues) -> SpeedDistance:
        """The distance from a family on which several joints stand at values."""
        low, high = self._bounds()
        for j, value in zip(measure.joints, measure.values, strict=True):
            low[j], high[j] = min(low[j], value), max(high[j], value)
        search = _MeasureSearch(self, measure, low, high)
        search.run()
        first = measure.joints[0]
        return SpeedDistance(
            family, first + 1, self.robot.variables[first].name, measure.values[0], search.end, search.distance,
            search.slower, search.speed, search.boxes, search.spent, "joints", measure.unit,
            tuple(j + 1 for j in measure.joints), measure.values,
        )  # fmt: skip

    def _from_residual(self, family: Family, measure: ConditionResidual) -> SpeedDistance:
        """The residual of the only condition of a family above which the speed is kept."""
        low, high = self._bounds()
        joints = [number - 1 for number in family.coupled]
        root = nearest_root(measure.condition, self.around, joints, self.robot.lower, self.robot.upper)
        if root is None:
            j, value = joints[0], float(self.around[joints[0]])
        else:
            j, value = root
            low[j], high[j] = min(low[j], value), max(high[j], value)
        search = _MeasureSearch(self, measure, low, high)
        search.run()
        return SpeedDistance(
            family.id, j + 1, self.robot.variables[j].name, value, search.end, search.distance, search.slower,
            search.speed, search.boxes, search.spent, "residual", measure.unit, tuple(family.coupled), (),
        )  # fmt: skip

    def _search(self, j: int, gap: float, side: float, end: float) -> _DistanceSearch:
        """The search on one side of the value of joint j, which is `gap` before the middle of the region."""
        low, high = self._bounds()
        low[j], high[j] = 0.0, end
        search = _DistanceSearch(self, j, float(self.around[j]) - gap, side, low, high)
        search.run()
        return search

    def least(self, centre: Array, half: Array) -> Array:
        """(M,) proven lower bounds of the slowest speed [m/s] in boxes (M, n) [rad, m]; 0 where there is none."""
        setting = self.setting
        rank = setting.rank
        _, _, bound, sigma, u, v, _ = enclose(self.robot, setting, centre, half / np.asarray(setting.scale) * _OUTWARDS)
        known = regular(sigma, bound)
        diagonal = np.arange(rank)
        matrix = -bound
        matrix[:, diagonal, diagonal] += sigma
        matrix[~known] = np.eye(rank)
        inverse = np.linalg.inv(matrix)
        inverse += _SLACK * inverse.sum(axis=2)[:, :, None]
        known &= np.asarray((matrix @ inverse >= np.eye(rank)).all(axis=(1, 2)))  # so it is no less than the inverse
        middle = 1.0 / np.where(known[:, None], sigma, 1.0)  # Σ⁻¹, where it is asked for
        wide = half / np.asarray(setting.scale) * _OUTWARDS
        along = u[:, [row < _ROWS_OF_TRANSLATION for row in setting.rows]].swapaxes(1, 2)  # (M, r, 3)
        rows = middle[:, :, None] * along  # Σ⁻¹ U₁ᵀ S ℓ
        slopes = self._slopes(centre, u, v)
        rates = v @ rows
        first = np.einsum("mnr,mkrs,msd->mknd", v * middle[:, None, :], slopes, rows, optimize=True)
        size = np.linalg.norm(rates, axis=2)
        unit = rates / np.maximum(size, 1e-300)[:, :, None]
        onto = np.einsum("mknd,mnd->mkn", first, unit)
        aside = np.linalg.norm(first - onto[..., None] * unit[:, None], axis=3)
        linear = np.hypot(size + np.einsum("mkn,mk->mn", np.abs(onto), wide), np.einsum("mkn,mk->mn", aside, wide))
        rest = np.maximum(bound - np.einsum("mkrs,mk->mrs", np.abs(slopes), wide), 0.0) + _SLACK * bound
        alpha = np.linalg.norm(rows, axis=2)[:, :, None]
        twice = np.abs(v) @ (inverse @ (bound @ (middle[:, :, None] * (bound @ alpha))))
        second = (np.abs(v * middle[:, None, :]) @ (rest @ alpha) + twice)[:, :, 0]
        cost = ((linear + second) / self.limits).max(axis=1) / setting.length * _OUTWARDS
        return np.where(known, 1.0 / cost, 0.0)

    def _slopes(self, centre: Array, u: Array, v: Array) -> Array:
        """(M, n, r, r) derivatives G_k of U₁ᵀ J V₁ by each scaled variable at centres (M, n)."""
        setting, scale = self.setting, np.asarray(self.setting.scale)
        frame = Frame(setting.link, setting.link, setting.point)
        change = jacobian_derivative(setting.with_tip_frame(self.robot), centre, frame)[:, list(setting.rows)]
        factors = np.where(np.array(setting.rows) < _ROWS_OF_TRANSLATION, 1.0 / setting.length, 1.0)
        change = change * factors[:, None, None] * scale
        return np.asarray(np.einsum("mij,mink,mns->mkjs", u, change, v, optimize=True))

    def slowest(self, q: Array) -> Array:
        """(N,) speed in the slowest direction at configurations (N, n) [m/s]."""
        return slowest_motions(self.robot, q, self.task)[0].speed

    def _bounds(self) -> tuple[Array, Array]:
        """(n,) ends of the region in each joint, inside the joint limits; joints that do not matter stand still."""
        reach = np.where(self.matters, self.span * joint_scale(self.robot, self.task), 0.0)
        low = np.maximum(self.around - reach, np.minimum(self.robot.lower, self.around))
        high = np.minimum(self.around + reach, np.maximum(self.robot.upper, self.around))
        return low, high


class _DistanceSearch:
    """Branch and bound for one distance; the joint is measured from its value on the family."""

    def __init__(self, region: SpeedRegion, j: int, value: float, side: float, low: Array, high: Array) -> None:
        self.region, self.j, self.value, self.side = region, j, value, side
        self.centre, self.half = ((low + high) / 2)[None], ((high - low) / 2)[None]
        self.weight = np.where(np.arange(len(low)) == j, 2.0, 1.0) / joint_scale(region.robot, region.task)
        self.end = float(high[j])
        self.distance: float | None = None
        self.slower: float | None = None
        self.speed: float | None = None
        self.boxes, self.spent, self.budget = 0, False, region.budget
        self.fine = _FINE

    def _reach(self, centre: Array, half: Array) -> Array:
        """(M,) the largest distance in each box."""
        return np.asarray(centre[:, self.j] + half[:, self.j])

    def run(self) -> None:
        """Halve the farthest boxes until the rest is near enough to a slower configuration, or to the value."""
        while True:
            far = self._reach(self.centre, self.half)
            below = self.slower or 0.0
            enough = below + max(self.fine, _SHARE * below)
            open_ = np.flatnonzero(far > enough)
            if not len(open_):
                self.distance = enough if self.slower is not None or len(far) else 0.0
                break
            if self.boxes >= self.budget:
                self.spent = True
                self.distance = float(far.max())
                break
            self._halve(open_, far)
        if self.distance is not None and self.distance >= self.end:
            self.distance = None

    @property
    def kept_distance(self) -> float:
        """From which distance the speed is kept in the region: nothing of it lies beyond its end."""
        if self.distance is None:
            return self.end
        return self.distance

    def _halve(self, open_: NDArray[np.intp], far: Array) -> None:
        chosen = open_[np.argsort(-far[open_], kind="stable")[:_BATCH]]
        rest = np.setdiff1d(np.arange(len(far)), chosen)
        centre, half = self.centre[chosen], self.half[chosen]
        self.boxes += len(chosen)
        left = self.region.least(self._joints(centre), half) < self.region.speed
        centre, half = centre[left], half[left]
        if len(centre):
            self._look(centre, half)
        each, widest = np.arange(len(centre)), (half * self.weight).argmax(axis=1)
        half = half.copy()
        half[each, widest] /= 2.0
        step = np.zeros_like(half)
        step[each, widest] = half[each, widest]
        # halves overlap by more than the rounding of their centres
        half = half * _OUTWARDS
        self.centre = np.concatenate([self.centre[rest], centre - step, centre + step])
        self.half = np.concatenate([self.half[rest], half, half])

    def _look(self, centre: Array, half: Array) -> None:
        """Slower configurations among the centres of boxes and of their far ends."""
        tried = np.concatenate([self._ends(centre, half), centre])
        speed = self.region.slowest(self._joints(tried))
        slow = np.flatnonzero(speed < self.region.speed)
        if not len(slow):
            return
        away = self._distances(tried[slow])
        farthest = slow[int(away.argmax())]
        distance = min(float(away.max()), self.end)
        if self.slower is None or distance > self.slower:
            self.slower, self.speed = distance, float(speed[farthest])

    def _ends(self, centre: Array, half: Array) -> Array:
        """(M, n) the far end of each box."""
        ends = centre.copy()
        ends[:, self.j] += half[:, self.j]
        return ends

    def _distances(self, rows: Array) -> Array:
        """(N,) distances of rows."""
        return np.asarray(rows[:, self.j])

    def _joints(self, rows: Array) -> Array:
        """Configurations of rows in which joint j is a distance."""
        q = rows.copy()
        q[:, self.j] = self.value + self.side * rows[:, self.j]
        return q


class _MeasureSearch(_DistanceSearch):
    """Branch and bound for a distance in a measure of several joints; rows are configurations."""

    def __init__(self, region: SpeedRegion, measure: AtValues | ConditionResidual, low: Array, high: Array) -> None:
        self.measure = measure
        super().__init__(region, 0, 0.0, 1.0, low, high)
        self.weight = 1.0 / joint_scale(region.robot, region.task)
        self.end = float(self._reach(self.centre, self.half)[0])
        self.fine = _FINE * measure.slope()
        self.budget = min(region.budget, _OF_SEVERAL)

    def _reach(self, centre: Array, half: Array) -> Array:
        return self.measure.most(centre, half)

    def _ends(self, centre: Array, half: Array) -> Array:
        return self.measure.far_corner(centre, half)

    def _distances(self, rows: Array) -> Array:
        return self.measure.at(rows)

    def _joints(self, rows: Array) -> Array:
        return rows


def _gap(difference: float, *, periodic: bool) -> float:
    """A difference of angles; of a joint that turns without end in (−π, π]."""
    if periodic:
        return float(np.pi - (np.pi - difference) % (2 * np.pi))
    return float(difference)
