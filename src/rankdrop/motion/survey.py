"""The stretches of a path: where it reaches a singularity, and between, which family is nearest and how near."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from rankdrop import _core
from rankdrop.errors import RankdropError
from rankdrop.families.batch_distance import QUICK, Ruler
from rankdrop.families.on_the_spot import name_on_the_spot
from rankdrop.family.incidence import families_at
from rankdrop.family.record import Family, family_in_metres
from rankdrop.kinematics import chain_of, task_view
from rankdrop.local.block import decompose, generic_rank, joint_scale, singular_values
from rankdrop.local.directions import words
from rankdrop.local.nearest import nearest_singularity
from rankdrop.local.rates import rate_limits
from rankdrop.motion.crossings import Crossing
from rankdrop.motion.curve import Curve, Index, largest
from rankdrop.motion.options import PathOptions
from rankdrop.motion.record import (
    FREE,
    LEADS,
    UNDECIDED,
    VERDICTS,
    Closest,
    Place,
    Profile,
    Remark,
    Stretch,
    Violation,
)
from rankdrop.results.explanation.parts import lost_seen_from
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import Tolerances
from rankdrop.units import counted_length, metre_exponent

_PLACES = 400  # of the profile, evenly along the length; as many rows besides
_ZOOMS, _NEAR = 8, 9  # rounds and points of the search for the closest approach of a stretch
_BEYOND, _KEPT = 1e-9, 1.0 + 1e-9  # beyond a range [rad, m], and of a rate limit: below it rounding
_SPOTS = 12  # families that are named, and nearest points that are searched, without an atlas: some 0.1 s each
_LOST = 40  # crossings whose lost motions are worked out


def _badness(stretch: Stretch) -> tuple[object, ...]:
    """Worst first; free stretches that lead to a crossing say least and come last."""
    leads = stretch.verdict == FREE and stretch.closest.distance < LEADS
    return VERDICTS.index(stretch.verdict), leads, stretch.closest.distance, stretch.start.row, stretch.start.share


def outer(families: Sequence[Family], robot: Robot, task: Task, tolerances: Tolerances) -> tuple[Family, ...]:
    """Families to be measured: corank 1, and those of higher corank, in front, that no one of corank 1 holds."""
    plain = tuple(one for one in families if one.corank == 1)
    higher = [one for one in families if one.corank > 1 and one.equations]
    apart = tuple(one for one in higher if not families_at(plain, robot, one.witness, task, tolerances))
    return (*apart, *plain)


@dataclass
class Survey:
    """Measures a path against its arm's families.

    Attributes:
        robot, task, path: in metres.
        given: families as they are known, of `asked`.
        source: where they are from.
        asked: the arm as it was given.
        options, tolerances: how it is checked.
        remarks: what could not be worked out.
        profile: numbers along the path, once `stretches` has been called.
    """

    robot: Robot
    task: Task
    path: Curve
    given: Sequence[Family]
    source: str
    asked: Robot
    options: PathOptions
    tolerances: Tolerances
    remarks: tuple[tuple[Remark, Any], ...] = ()
    families: tuple[Family, ...] = ()
    _spots: list[tuple[Family, Array]] = field(default_factory=list)

    def __post_init__(self) -> None:
        if metre_exponent(self.asked):
            self.families = tuple(family_in_metres(one, self.asked) for one in self.given)
        else:
            self.families = tuple(self.given)
        self._rank = generic_rank(self.robot, self.task)
        self._scale = joint_scale(self.robot, self.task)
        self._limits = rate_limits(self.robot)
        self._rates = self.path.rates
        self._near = outer(self.families, self.robot, self.task, self.tolerances)
        self._ruler = Ruler(self._near, self.robot, self.task, limits=self.options.limits, starts=QUICK)
        self._feet = np.empty((0, self.robot.n))
        self.profile = self._profile()

    def _profile(self) -> Profile:
        positions = self._positions()
        stretch, share = self.path.split(positions)
        q = self.path.at(stretch, share)
        family, distance, self._feet = self._nearest(q, along=True)
        sigma = singular_values(self.robot, q, self.task)
        rates = np.full(len(q), np.nan)
        if self._rates is not None and np.isfinite(self._limits).any():
            rates = self._share_of_limit(self._rates).max(axis=1)[stretch]
        return Profile(
            positions + 1.0, self.path.time(stretch, share), distance, family,
            sigma[:, self._rank - 1] if self._rank else np.zeros(len(q)), rates, tuple(one.id for one in self._near),
        )  # fmt: skip

    def _share_of_limit(self, rates: Array) -> Array:
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(rates > 0.0, rates / self._limits, 0.0)

    def _positions(self) -> Array:
        """Places evenly along the length, and rows; counted in stretches from 0."""
        count = len(self.path.control)
        steps = np.linalg.norm((self.path.control[:, -1] - self.path.control[:, 0]) / self._scale, axis=1)
        until = np.concatenate([[0.0], np.cumsum(steps)])
        places = np.unique(np.linspace(0, count, min(_PLACES, count + 1)).round())
        if until[-1] > 0.0:
            grows = np.concatenate([[True], np.diff(until) > 0.0])
            even = np.interp(np.linspace(0.0, until[-1], _PLACES), until[grows], np.flatnonzero(grows))
            places = np.union1d(places, even)
        return places

    def _nearest(self, q: Array, *, along: bool = False) -> tuple[Index, Array, Array]:
        """Index of the nearest family, −1 where another point is nearer, the distance and the point; nan without."""
        found = self._ruler.measure(q, along=along, proven=False)
        family, least = found.nearest()
        feet = found.anywhere_foot.copy()
        rows = np.flatnonzero(family >= 0)
        feet[rows] = found.foot[rows, family[rows]]
        return family, np.where(np.isfinite(least), least, np.nan), feet

    def stretches(self, crossings: Sequence[Crossing]) -> tuple[Stretch, ...]:
        """All parts of the path, worst first: by verdict, then by distance."""
        parts = [self._singular(one, with_lost=k < _LOST) for k, one in enumerate(crossings)]
        if len(crossings) > _LOST:
            self.remarks = (*self.remarks, ("lost", (_LOST, len(crossings))))
        last = len(self.path.control) - 1
        ends = [(0, 0.0), *(end for one in crossings for end in (one.start, one.end)), (last, 1.0)]
        gaps = [(ends[i], ends[i + 1]) for i in range(0, len(ends), 2)]
        free = [part for gap in gaps if self._position(gap[1]) > self._position(gap[0]) for part in self._split_up(gap)]
        if not crossings and not free:  # the arm stands still in one place
            free = [((0, 0.0), (last, 1.0), int(self.profile.family[0]), 0)]
        parts += self._free(free)
        return tuple(sorted(parts, key=_badness))

    def violations(self) -> tuple[Violation, ...]:
        """Joint limits that the path breaks, or may break: the worst rate, and every joint outside its range."""
        robot, control = self.robot, self.path.control
        over = [self._too_fast(self.path.times)] if self.path.times is not None else []
        reached, bound = largest(control, lambda q: np.maximum(q - robot.upper, robot.lower - q), _BEYOND)
        samples = np.concatenate([control[:, 0], control[-1:, -1]])
        outside = (samples < robot.lower - _BEYOND) | (samples > robot.upper + _BEYOND)
        for j in np.flatnonzero((bound > _BEYOND).any(axis=0)).tolist():
            proven = bool((reached[:, j] > _BEYOND).any())
            excess, rows = (reached if proven else bound)[:, j], np.flatnonzero(outside[:, j])
            first = int(rows[0] if len(rows) else excess.argmax())
            place = (first, 0.0) if first < len(control) else (first - 1, 1.0)
            worst = float(excess.max())
            over.append(Violation("range", j + 1, self._place_of(place), worst, len(rows), proven, "", np.inf))
        return tuple(one for one in over if one is not None)

    def _too_fast(self, times: Array) -> Violation | None:
        """The largest rate as a multiple of its limit, where it exceeds it."""
        if not np.isfinite(self._limits).any() or self._rates is None:
            return None
        bound = self._share_of_limit(self._rates)
        reached = bound
        if self.path.degree > 1:
            steps = self.path.degree * np.diff(self.path.control, axis=1) / np.diff(times)[:, None, None]
            reached, bound = largest(steps, lambda rate: self._share_of_limit(np.abs(rate)), _KEPT)
        proven = bool((reached > _KEPT).any())
        shares = reached if proven else bound
        stretch, joint = np.unravel_index(int(shares.argmax()), shares.shape)
        if shares[stretch, joint] <= _KEPT:
            return None
        place = (int(stretch), 0.5)
        family, distance, _ = self._nearest(self.path.at(np.array([stretch]), np.array([0.5])))
        known = family[0] >= 0
        return Violation(
            "rate", int(joint) + 1, self._place_of(place), float(shares[stretch, joint]), 0, proven,
            self._near[family[0]].name if known else "", float(distance[0]) if known else np.inf,
        )  # fmt: skip

    @staticmethod
    def _position(place: tuple[int, float]) -> float:
        return place[0] + place[1]

    def _split_up(
        self, gap: tuple[tuple[int, float], tuple[int, float]]
    ) -> Iterator[tuple[tuple[int, float], tuple[int, float], int, int]]:
        """A free part cut where the nearest family changes: start, end, family, index of the nearest place inside."""
        at, low, high = self.profile.position - 1.0, self._position(gap[0]), self._position(gap[1])
        inside = np.flatnonzero((at >= low) & (at <= high))
        if not len(inside):
            inside = np.array([int(np.abs(at - (low + high) / 2).argmin())])
        family = self.profile.family[inside]
        cuts = [0, *(np.flatnonzero(np.diff(family)) + 1).tolist(), len(inside)]
        start = gap[0]
        for first, after in pairwise(cuts):
            mine = inside[first:after]
            if after < len(inside):
                stretch, share = self.path.split(np.array([(at[inside[after - 1]] + at[inside[after]]) / 2]))
                end = (int(stretch[0]), float(share[0]))
            else:
                end = gap[1]
            far = self.profile.distance[mine]
            values = np.where(np.isnan(far), np.inf, far) if np.isfinite(far).any() else self.profile.sigma[mine]
            yield start, end, int(family[first]), int(mine[int(np.argmin(values))])
            start = end

    def _free(self, parts: list[tuple[tuple[int, float], tuple[int, float], int, int]]) -> list[Stretch]:
        best = self._zoomed(parts)
        found = []
        without = sorted((self.profile.sigma[part[3]], k) for k, part in enumerate(parts) if part[2] < 0)
        searched = {k for _, k in without[:_SPOTS]}
        if len(without) > _SPOTS:
            self.remarks = (*self.remarks, ("distances", (_SPOTS, len(without))))
        for k, (start, end, family, row) in enumerate(parts):
            place = self._place(best[k])
            q = self.path.at(np.array([place[0]]), np.array([place[1]]))[0]
            name, number, foot, distance = "", "", np.zeros(0), np.inf
            if family >= 0:
                foot = self._ruler.feet(q[None], family, self._feet[row][None])[0]
                distance = float(np.linalg.norm((foot - q) / self._scale))
                number, name = self._near[family].id, self._near[family].name
            elif k in searched:
                number, name, foot, distance = self._searched(q)
            closest = Closest(self._place_of(place), q, distance, foot, self._sigma(q), self._weak(place, q))
            part = Crossing(FREE, start, end, (start, end), place, q, np.zeros(0), 0, False, "covered")
            found.append(self._stretch(part, number, name, closest))
        return found

    def _zoomed(self, parts: list[tuple[tuple[int, float], tuple[int, float], int, int]]) -> Array:
        """Positions of the closest approaches: grids around the nearest place, finer and finer."""
        at = self.profile.position - 1.0
        best = np.array([np.clip(at[k], self._position(a), self._position(b)) for a, b, _, k in parts])
        low = np.array([max(at[max(k - 1, 0)], self._position(a)) for a, _, _, k in parts])
        high = np.array([min(at[min(k + 1, len(at) - 1)], self._position(b)) for _, b, _, k in parts])
        near = self._feet[[k for _, _, _, k in parts]]  # (parts, n)
        for family in {part[2] for part in parts}:
            mine = np.flatnonzero([part[2] == family for part in parts])
            for _ in range(_ZOOMS):
                grid = np.linspace(low[mine], high[mine], _NEAR, axis=1)
                q = self.path.at(*self.path.split(grid.reshape(-1)))
                feet = self._ruler.feet(q, family, near[mine].repeat(_NEAR, axis=0))
                values = np.linalg.norm((feet - q) / self._scale, axis=1)
                if np.isnan(values).all():
                    values = singular_values(self.robot, q, self.task)[:, self._rank - 1]
                k = np.where(np.isnan(values), np.inf, values).reshape(grid.shape).argmin(axis=1)
                rows = np.arange(len(mine))
                best[mine] = grid[rows, k]
                low[mine], high[mine] = grid[rows, np.maximum(k - 1, 0)], grid[rows, np.minimum(k + 1, _NEAR - 1)]
        return best

    def _searched(self, q: Array) -> tuple[str, str, Array, float]:
        """Name, foot and distance of the nearest singular configuration that a search finds."""
        try:
            nearest = nearest_singularity(
                self.robot, q, self.task, limits=self.options.limits, tolerances=self.tolerances
            )
        except RankdropError as error:
            self.remarks = (*self.remarks, ("no distance", error.what))
            return "", "", np.zeros(0), np.inf
        if nearest is None:
            return "", "", np.zeros(0), np.inf
        foot = np.array(nearest.q)
        number, name = self._name_singularity(foot, nearest.corank)
        return number, name, foot, nearest.distance

    def _singular(self, part: Crossing, *, with_lost: bool) -> Stretch:
        name, number, null = "", "", np.nan
        lost: tuple[str, ...] = ()
        if part.corank:
            number, name = self._name_singularity(part.q, part.corank)
            null = self._null_share(part)
            if with_lost:
                framed = lost_seen_from(self.robot, part.q, self.task, part.corank, self.options.frame)
                lost = tuple(words(row, framed.name, counted_length(self.asked)) for row in framed.directions)
        distance, foot = 0.0, part.q
        if part.kind == UNDECIDED:
            family, far, feet = self._nearest(part.q[None])
            distance, foot = np.inf, np.zeros(0)
            if family[0] >= 0:
                distance, foot = float(far[0]), feet[0]
                number, name = self._near[family[0]].id, self._near[family[0]].name
        closest = Closest(
            self._place_of(part.at), part.q, distance, foot, self._sigma(part.q), self._weak(part.at, part.q)
        )
        return self._stretch(part, number, name, closest, lost, null)

    def _stretch(
        self, part: Crossing, family: str, name: str, closest: Closest, lost: tuple[str, ...] = (),
        null_share: float = np.nan,
    ) -> Stretch:  # fmt: skip
        rates, factor, slowest = np.zeros(0), np.nan, 0
        start, end = part.start, part.end
        if self._rates is not None:
            after = end[0] + (end[1] > 0.0 or end[0] == start[0])
            rates = self._rates[start[0] : max(after, start[0] + 1)].max(axis=0)
            if np.isfinite(self._limits).any():
                shares = self._share_of_limit(rates)
                factor = 1.0 / max(1.0, float(shares.max()))
                slowest = int(shares.argmax()) + 1 if factor < 1.0 else 0
        low, high = part.bracket
        return Stretch(
            self._place_of(start), self._place_of(end), (self._place_of(low), self._place_of(high)), part.kind, family,
            name, closest, part.corank, part.lies, part.evidence, part.condition, lost, null_share, rates, factor,
            slowest,
        )  # fmt: skip

    def _name_singularity(self, q: Array, corank: int) -> tuple[str, str]:
        """Id and name of the family that a singular configuration lies on; on the spot where none is known."""
        tolerances = self.tolerances
        found = families_at(self.families, self.robot, q, self.task, tolerances, self.source)
        if found and found[0].family.corank >= corank:
            family = found[0].family
            return family.id, family.name
        spots = [local for local, _ in self._spots]
        again = families_at(spots, self.robot, q, self.task, tolerances)
        if again and again[0].family.corank >= corank:
            return "", again[0].family.name
        if len(self._spots) >= _SPOTS:
            return "", found[0].family.name if found else ""
        try:
            local = name_on_the_spot(self.robot, q, self.task, corank)
        except RankdropError:  # rounding: q is singular to the tolerance and not to that of its neighbours
            return "", found[0].family.name if found else ""
        self._spots.append((local, q))
        return "", local.name

    def _place_of(self, place: tuple[int, float]) -> Place:
        """A place for people: the end of a stretch is the beginning of the next."""
        stretch, share = place
        time = self.path.time(np.array([stretch]), np.array([share]))
        stretch, share = (stretch + 1, 0.0) if share == 1.0 else (stretch, share)
        return Place(stretch + 1, share, None if time is None else float(time[0]))

    def _place(self, position: float) -> tuple[int, float]:
        stretch, share = self.path.split(np.array([position]))
        return int(stretch[0]), float(share[0])

    def _sigma(self, q: Array) -> float:
        return float(singular_values(self.robot, q, self.task)[self._rank - 1]) if self._rank else 0.0

    def _travel(self, place: tuple[int, float]) -> Array:
        """(n,) direction of the joints' motion."""
        return np.asarray(self.path.slope(np.array([place[0]]), np.array([place[1]]))[0])

    def _weak(self, place: tuple[int, float], q: Array) -> float:
        jacobian = _core.jacobian(chain_of(self.robot), task_view(self.robot, self.task), q[None])[0]
        travel = jacobian @ self._travel(place)
        size = float(np.linalg.norm(travel))
        if not self._rank or size == 0.0:
            return np.nan
        return float(abs(decompose(self.robot, q, self.task).u[:, self._rank - 1] @ travel) / size)

    def _null_share(self, part: Crossing) -> float:
        motion = self._travel(part.at)
        size = float(np.linalg.norm(motion))
        if size == 0.0:
            return np.nan
        still = decompose(self.robot, part.q, self.task).v[:, self._rank - part.corank : self._rank]
        return float(np.linalg.norm(still.T @ motion) / size)
