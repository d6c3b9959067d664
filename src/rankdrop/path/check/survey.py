"""The parts of a path, measured: the nearest family between singularities, its distance, and the motions lost there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np

from rankdrop import _core
from rankdrop.distance.many_distances import Ruler
from rankdrop.distance.singular_set import QUICK
from rankdrop.errors import RankdropError
from rankdrop.families.incidence import families_at
from rankdrop.families.record import Family
from rankdrop.families.rescaling import family_in_metres
from rankdrop.kinematics import chain_of, task_view
from rankdrop.local.block import decompose, generic_rank, joint_scale
from rankdrop.local.directions import lost_seen_from
from rankdrop.local.nearest import nearest_singularity
from rankdrop.local.rates import rate_limits
from rankdrop.path.check.crossings import SPOTS, smallest_sigma
from rankdrop.path.check.record import FREE, LEADS, UNDECIDED, VERDICTS, Closest, Profile, Remark, Stretch, Violation
from rankdrop.path.curve import Curve, Index, Place, largest
from rankdrop.questions import PathOptions
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import Tolerances
from rankdrop.units import counted_length, in_metres, metre_exponent

_PLACES = 400  # of the profile, evenly along the length; as many rows besides
_ZOOMS, _NEAR = 8, 9  # rounds and points of the search for the closest approach of a stretch
_BEYOND, _KEPT = 1e-9, 1.0 + 1e-9  # beyond a range [rad, m], and of a rate limit: below it rounding
_LOST = 40  # crossings whose lost motions are worked out


def outer(families: Sequence[Family], robot: Robot, task: Task, tolerances: Tolerances) -> tuple[Family, ...]:
    """Families to be measured: corank 1, and those of higher corank, in front, that no one of corank 1 holds."""
    plain = tuple(family for family in families if family.corank == 1)
    higher = [family for family in families if family.corank > 1 and family.equations]
    apart = tuple(family for family in higher if not families_at(plain, robot, family.witness, task, tolerances))
    return (*apart, *plain)


def measures(
    asked: Robot, task: Task, families: Sequence[Family], options: PathOptions, tolerances: Tolerances
) -> tuple[tuple[Family, ...], tuple[Family, ...], Ruler]:
    """The families in metres, those that are measured, and what measures them.

    Args:
        asked: the arm as it was given.
        task: in metres.
        families: of `asked`.
        options, tolerances: of the check.
    """
    robot, scaled = in_metres(asked), bool(metre_exponent(asked))
    every = tuple(family_in_metres(family, asked) if scaled else family for family in families)
    near = outer(every, robot, task, tolerances)
    return every, near, Ruler(near, robot, task, limits=options.limits, starts=QUICK)


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
        families: in metres.
        profile: numbers along the path.
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
    _spots: list[Family] = field(default_factory=list)

    def __post_init__(self) -> None:
        robot, task = self.robot, self.task
        self.families, self._near, self._ruler = measures(self.asked, task, self.given, self.options, self.tolerances)
        self._rank, self._scale = generic_rank(robot, task), joint_scale(robot, task)
        self._limits, self._rates = rate_limits(robot), self.path.rates
        positions = self._positions()
        stretch, share = self.path.split(positions)
        q = self.path.at(stretch, share)
        family, distance, self._feet = self._nearest(q, along=True)
        rates = np.full(len(q), np.nan)
        if self._rates is not None and np.isfinite(self._limits).any():
            rates = self._share_of_limit(self._rates).max(axis=1)[stretch]
        sigma = smallest_sigma(robot, task, q)
        ids = tuple(family.id for family in self._near)
        times = self.path.time(stretch, share)
        self.profile = Profile(positions + 1.0, times, distance, family, sigma, rates, ids)

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
        measured = self._ruler.measure(q, along=along, proven=False)
        family, least = measured.nearest()
        feet = measured.anywhere_foot.copy()
        rows = np.flatnonzero(family >= 0)
        feet[rows] = measured.foot[rows, family[rows]]
        return family, np.where(np.isfinite(least), least, np.nan), feet

    def stretches(self, crossings: Sequence[Stretch]) -> tuple[Stretch, ...]:
        """All parts of the path, worst first: by verdict, then by distance."""
        parts = [self._singular(crossing, with_lost=k < _LOST) for k, crossing in enumerate(crossings)]
        if len(crossings) > _LOST:
            self.remarks = (*self.remarks, ("lost", (_LOST, len(crossings))))
        first, last = self.path.place((0, 0.0)), self.path.place((len(self.path.control) - 1, 1.0))
        starts = [first, *(crossing.end for crossing in crossings)]
        ends = [*(crossing.start for crossing in crossings), last]
        free: list[tuple[Place, Place, int, int]] = []
        for start, end in zip(starts, ends, strict=True):
            if end.position > start.position:
                free += self._split_up(start, end)
        if not crossings and not free:  # the arm stands still in one place
            free = [(first, last, int(self.profile.family[0]), 0)]
        return tuple(sorted([*parts, *self._free(free)], key=_badness))

    def violations(self) -> tuple[Violation, ...]:
        """Joint limits that the path breaks, or may break: the worst rate, and every joint outside its range."""
        robot, control = self.robot, self.path.control
        if (fast := self._too_fast()) is None:
            over = []
        else:
            over = [fast]
        reached, bound = largest(control, lambda q: np.maximum(q - robot.upper, robot.lower - q), _BEYOND)
        samples = np.concatenate([control[:, 0], control[-1:, -1]])
        outside = (samples < robot.lower - _BEYOND) | (samples > robot.upper + _BEYOND)
        for j in np.flatnonzero((bound > _BEYOND).any(axis=0)).tolist():
            proven = bool((reached[:, j] > _BEYOND).any())
            excess, rows = (reached if proven else bound)[:, j], np.flatnonzero(outside[:, j])
            first = int(rows[0] if len(rows) else excess.argmax())
            place = self.path.place((first, 0.0) if first < len(control) else (first - 1, 1.0))
            far, foot = np.inf, np.zeros(0)
            over.append(Violation("range", j + 1, place, float(excess.max()), len(rows), proven, "", far, foot))
        return tuple(over)

    def _too_fast(self) -> Violation | None:
        """The largest rate as a multiple of its limit, where it exceeds it."""
        if self._rates is None or self.path.times is None or not np.isfinite(self._limits).any():
            return None
        reached = bound = self._share_of_limit(self._rates)
        if self.path.degree > 1:
            lasts = np.diff(self.path.times)[:, None, None]
            steps = self.path.degree * np.diff(self.path.control, axis=1) / lasts
            reached, bound = largest(steps, lambda rate: self._share_of_limit(np.abs(rate)), _KEPT)
        proven = bool((reached > _KEPT).any())
        shares = reached if proven else bound
        stretch, joint = (int(k) for k in np.unravel_index(int(shares.argmax()), shares.shape))
        amount, middle = float(shares[stretch, joint]), np.array([0.5])
        if amount <= _KEPT:
            return None
        family, distance, feet = self._nearest(self.path.at(np.array([stretch]), middle))
        name, far, foot = "", np.inf, np.zeros(0)
        if family[0] >= 0:
            name, far, foot = self._near[family[0]].name, float(distance[0]), feet[0]
        return Violation("rate", joint + 1, self.path.place((stretch, 0.5)), amount, 0, proven, name, far, foot)

    def _split_up(self, start: Place, stop: Place) -> Iterator[tuple[Place, Place, int, int]]:
        """A free part cut where the nearest family changes: start, end, family, index of the nearest place inside."""
        at, low, high = self.profile.position, start.position, stop.position
        inside = np.flatnonzero((at >= low) & (at <= high))
        if not len(inside):
            inside = np.array([int(np.abs(at - (low + high) / 2).argmin())])
        family = self.profile.family[inside]
        cuts = [0, *(np.flatnonzero(np.diff(family)) + 1).tolist(), len(inside)]
        for first, after in pairwise(cuts):
            mine = inside[first:after]
            if after == len(inside):
                end = stop
            else:
                end = self._place((at[inside[after - 1]] + at[inside[after]]) / 2 - 1.0)
            far = self.profile.distance[mine]
            if np.isfinite(far).any():
                values = np.where(np.isnan(far), np.inf, far)
            else:
                values = self.profile.sigma[mine]
            yield start, end, int(family[first]), int(mine[int(np.argmin(values))])
            start = end

    def _free(self, parts: list[tuple[Place, Place, int, int]]) -> Iterator[Stretch]:
        best = self._closest_places(parts)
        without = sorted((self.profile.sigma[part[3]], k) for k, part in enumerate(parts) if part[2] < 0)
        searched = {k for _, k in without[:SPOTS]}
        if len(without) > SPOTS:
            self.remarks = (*self.remarks, ("distances", (SPOTS, len(without))))
        for k, (start, end, family, row) in enumerate(parts):
            place = self._place(best[k])
            q, _ = self.path.configuration_and_slope(place)
            number, name, foot, distance = "", "", np.zeros(0), np.inf
            if family >= 0:
                foot = self._ruler.feet(q[None], family, self._feet[row][None])[0]
                distance = float(np.linalg.norm((foot - q) / self._scale))
                number, name = self._near[family].id, self._near[family].name
            elif k in searched:
                number, name, foot, distance = self._search_nearest(q)
            sigma = float(smallest_sigma(self.robot, self.task, q))
            closest = Closest(place, q, distance, foot, sigma, self._shares(place, q, 0)[0])
            free = Stretch(start, end, (start, end), FREE, closest, "covered", family=number, name=name)
            yield replace(free, **self._speeds(free))

    def _closest_places(self, parts: list[tuple[Place, Place, int, int]]) -> Array:
        """Positions of the closest approaches, from 0: grids around the nearest place, finer and finer."""
        at = self.profile.position - 1.0
        starts = np.array([start.position - 1.0 for start, _, _, _ in parts])
        ends = np.array([end.position - 1.0 for _, end, _, _ in parts])
        rows = np.array([part[3] for part in parts], dtype=np.int64)
        families = np.array([part[2] for part in parts], dtype=np.int64)
        best = np.clip(at[rows], starts, ends)
        low = np.maximum(at[np.maximum(rows - 1, 0)], starts)
        high = np.minimum(at[np.minimum(rows + 1, len(at) - 1)], ends)
        for family in set(families.tolist()):
            mine = np.flatnonzero(families == family)
            near, each = self._feet[rows[mine]].repeat(_NEAR, axis=0), np.arange(len(mine))
            for _ in range(_ZOOMS):
                grid = np.linspace(low[mine], high[mine], _NEAR, axis=1)
                q = self.path.at(*self.path.split(grid.reshape(-1)))
                values = np.linalg.norm((self._ruler.feet(q, family, near) - q) / self._scale, axis=1)
                if np.isnan(values).all():
                    values = smallest_sigma(self.robot, self.task, q)
                k = np.where(np.isnan(values), np.inf, values).reshape(grid.shape).argmin(axis=1)
                best[mine] = grid[each, k]
                low[mine], high[mine] = grid[each, np.maximum(k - 1, 0)], grid[each, np.minimum(k + 1, _NEAR - 1)]
        return best

    def _search_nearest(self, q: Array) -> tuple[str, str, Array, float]:
        """Id, name, foot and distance of the nearest singular configuration that a search finds."""
        try:
            nearest = nearest_singularity(
                self.robot, q, self.task, limits=self.options.limits, tolerances=self.tolerances
            )
        except RankdropError as error:
            self.remarks = (*self.remarks, ("no distance", error.what))
            nearest = None
        if nearest is None:
            return "", "", np.zeros(0), np.inf
        foot = np.array(nearest.q)
        return *self._name_singularity(foot, nearest.corank), foot, nearest.distance

    def _singular(self, part: Stretch, *, with_lost: bool) -> Stretch:
        """A part that reaches a singularity, or may, with its family and what is lost."""
        place, q = part.closest.place, part.closest.q
        weak, null = self._shares(place, q, part.corank)
        more: dict[str, Any] = self._speeds(part) | {"null_share": null}
        closest = replace(part.closest, weak=weak)
        if part.corank:
            more["family"], more["name"] = self._name_singularity(q, part.corank)
            if with_lost:
                framed = lost_seen_from(self.robot, q, self.task, part.corank, self.options.frame)
                length = counted_length(self.asked)
                more["lost"] = framed.sentences(length)
        if part.verdict == UNDECIDED:
            family, far, feet = self._nearest(q[None])
            closest = replace(closest, distance=np.inf, foot=np.zeros(0))
            if family[0] >= 0:
                closest = replace(closest, distance=float(far[0]), foot=feet[0])
                more["family"], more["name"] = self._near[family[0]].id, self._near[family[0]].name
        return replace(part, closest=closest, **more)

    def _speeds(self, part: Stretch) -> dict[str, Any]:
        """Largest joint rates of a part, and what they mean for the limits."""
        if self._rates is None:
            return {}
        first, last = part.start.row - 1, part.end.row - (part.end.share == 0.0)
        first = min(first, len(self._rates) - 1)
        rates = self._rates[first : max(last, first + 1)].max(axis=0)
        if not np.isfinite(self._limits).any():
            return {"rates": rates}
        shares = self._share_of_limit(rates)
        factor = 1.0 / max(1.0, float(shares.max()))
        return {"rates": rates, "speed_factor": factor, "slowest": int(shares.argmax()) + 1 if factor < 1.0 else 0}

    def _name_singularity(self, q: Array, corank: int) -> tuple[str, str]:
        """Id and name of the family that a singular configuration lies on; on the spot where none is known."""
        named = families_at(self.families, self.robot, q, self.task, self.tolerances, self.source)
        if named and named[0].family.corank >= corank:
            return named[0].family.id, named[0].family.name
        again = families_at(self._spots, self.robot, q, self.task, self.tolerances)
        if again and again[0].family.corank >= corank:
            return "", again[0].family.name
        name = named[0].family.name if named else ""
        if len(self._spots) >= SPOTS:
            return "", name
        from rankdrop.families.on_the_spot import name_on_the_spot  # arms whose families are known do without

        try:
            local = name_on_the_spot(self.robot, q, self.task, corank)
        except RankdropError:  # rounding: q is singular to the tolerance and not to that of its neighbours
            return "", name
        self._spots.append(local)
        return "", local.name

    def _place(self, position: float) -> Place:
        """The place at a position counted in stretches from 0."""
        stretch, share = self.path.split(np.array([position]))
        return self.path.place((int(stretch[0]), float(share[0])))

    def _shares(self, place: Place, q: Array, corank: int) -> tuple[float, float]:
        """Of the tool's travel along the direction that is lost first; of the joints' motion that does not move it."""
        travel = self.path.configuration_and_slope(place)[1]
        parts = decompose(self.robot, q, self.task)
        moved = _core.jacobian(chain_of(self.robot), task_view(self.robot, self.task), q[None])[0] @ travel
        size, joints, weak, null = float(np.linalg.norm(moved)), float(np.linalg.norm(travel)), np.nan, np.nan
        if self._rank and size > 0.0:
            weak = float(abs(parts.u[:, self._rank - 1] @ moved) / size)
        if corank and joints > 0.0:
            null = float(np.linalg.norm(parts.v[:, self._rank - corank : self._rank].T @ travel) / joints)
        return weak, null


def _badness(stretch: Stretch) -> tuple[object, ...]:
    """Worst first; free stretches that lead to a crossing say least and come last."""
    leads = stretch.verdict == FREE and stretch.closest.distance < LEADS
    return VERDICTS.index(stretch.verdict), leads, stretch.closest.distance, stretch.start
