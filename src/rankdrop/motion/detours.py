"""Local changes of the tool's path: led around a singularity that the joints would cross to the other side.

A joint path that goes from one side of a singularity to the other crosses it whatever is done to it nearby. The tool
can go on all the same: it is moved by ε B(t) along u, the direction that is lost at the crossing,

    T′(t) = exp(ε B(t) û) T(t),   u the left singular vector of σ_r at the crossing,

with B as in `motion.bumps`, and the joints follow on the branch that they are on. At a wrist they turn half around
while the tool passes by; at the edge of reach they stay bent. After the window the tool is on its old path, and the
arm on another branch of the inverse kinematics, up to the next crossing, where it may come back.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from typing import Self

import numpy as np

from rankdrop.kinematics import pose
from rankdrop.motion.bumps import Bumper, Change, Core, largest_move, step, tool_off
from rankdrop.motion.candidates import ToolPath
from rankdrop.motion.follow import Followed, follow
from rankdrop.motion.inverse import Aim, rotation
from rankdrop.motion.trajectory import Trajectory, regular_times
from rankdrop.robot.model import Array

_RAMP = 0.3  # shortest ramp of a path in time [s]
_SLOPE = 0.1  # … and of a path without times [rad]
_FINEST, _USUAL = 1e-2, 0.5  # sizes that are tried: shares of the clearance, at an edge of reach and else …
_WIDENED, _GROWING = 8.0, 2.0  # … up to so many times the bound, each so many times the one before
_GENTLER = 1.1  # times the size at which rates are expected to be kept
_LOOKS = 100  # places of a window at first, besides the rows
_NEARER = 0.9  # share of the clearance that is kept where the joints follow
_BACK = 1e-6  # a configuration so near to the old path is on it again [rad]


class Hindrance(StrEnum):
    """Why no detour was found at a crossing."""

    END = "end"
    TOOL = "tool"
    LIMIT = "limit"
    REST = "rest"


@dataclass(frozen=True, eq=False)
class Detour:
    """The tool led around one crossing.

    Attributes:
        low, high: the window, places counted in stretches from 0.
        place: (K,) places of its rows.
        q: (K, n) configurations there.
        off: how far the tool is from its path at most [m], [rad].
        kept: rates within their limits.
    """

    low: float
    high: float
    place: Array
    q: Array
    off: tuple[float, float]
    kept: bool


@dataclass(frozen=True, eq=False)
class NoDetour:
    """A crossing without a detour.

    Attributes:
        core: where it is.
        hindrance: why.
        needed: the size that would do where it is above the bound, else nan [rad; lengths by the length scale].
    """

    core: Core
    hindrance: Hindrance
    needed: float = np.nan


@dataclass(frozen=True, eq=False, kw_only=True)
class MovedTool(ToolPath):
    """A tool path with the tool moved along a task direction in a window.

    Attributes:
        twist: (m,) ε u, in the axes of `Aim` [rad; lengths divided by the length scale].
        ends: (4,) of the clock: where the ramps begin, where they end, and the same on the way back.
        clock: (T,) of the rows of the path.
    """

    twist: Array
    ends: tuple[float, float, float, float]
    clock: Array

    def _with(self, place: Array) -> Self:
        q = self.path.at(*self.path.split(place))
        time = np.interp(place, np.arange(len(self.clock)), self.clock)
        begin, full, back, end = self.ends
        share = np.where(time <= (full + back) / 2, step((time - begin) / (full - begin))[0],
                         step((end - time) / (end - back))[0])  # fmt: skip
        poses = moved_along(self.aim, pose(self.robot, q), share[:, None] * self.twist)
        return replace(self, place=place, q=q, poses=poses)


def moved_along(aim: Aim, poses: Array, twist: Array) -> Array:
    """(N, 4, 4) poses moved by twists (N, m) in the rows and axes of a task, lengths divided by ℓ."""
    whole = np.zeros((len(poses), 6))
    whole[:, aim.rows] = twist
    turn, here = rotation(whole[:, 3:]), poses[:, :3, :3]
    shift = aim.length * whole[:, :3]
    if aim.with_tip:
        shift = (here @ shift[:, :, None])[:, :, 0]
    out = poses.copy()
    out[:, :3, :3] = here @ turn if aim.with_tip else turn @ here
    out[:, :3, 3] += shift + (here - out[:, :3, :3]) @ aim.point
    return out


@dataclass(eq=False)
class Detourer:
    """Looks for detours around the crossings of one path to the other side.

    Attributes:
        bumper: the path, its clock and its limits.
        bound: largest size of a detour [rad; lengths divided by the length scale].
    """

    bumper: Bumper
    bound: float

    def found(self, crossings: list[Core], clearance: float) -> list[Detour | NoDetour]:
        """One for each crossing in order, up to the first that has none; between them the tool is on its path."""
        now: Array | None = None  # the configuration at the end of the last window; None: on the old path
        last, out = 0.0, list[Detour | NoDetour]()
        for k, core in enumerate(crossings):
            until = crossings[k + 1].low if k + 1 < len(crossings) else float(len(self.bumper.path.control))
            made = self._at_crossing(core, last, until, now, clearance)
            out.append(made)
            if isinstance(made, NoDetour):
                break
            last, now = made.high, None if self._back(made) else made.q[-1]
        return out

    def _back(self, made: Detour) -> bool:
        """After the window the joints are where they were on the old path."""
        return self._same(made.high, made.q[-1])

    def _same(self, place: float, q: Array) -> bool:
        return bool((np.abs(q - self.bumper.at(np.array([place]))[0]) < _BACK).all())

    def _at_crossing(
        self, core: Core, last: float, until: float, now: Array | None, clearance: float
    ) -> Detour | NoDetour:
        """The detour around one crossing.

        Of both ways along the lost direction: the one that comes back to the old path where the arm has left it,
        within the rates if one is, and the smallest.
        """
        bumper = self.bumper
        place = core.stretches[0].closest.place.position - 1.0
        jacobian = bumper.tool.aim.jacobian(bumper.at(np.array([place])))[0]
        lost = np.linalg.svd(jacobian)[0][:, bumper.tool.rank - 1]
        ends = self._ends(core, last, until)
        if ends is None:
            return NoDetour(core, Hindrance.END)
        low, high = bumper.place_at(np.array([ends[0], ends[3]])).tolist()
        start = bumper.at(np.array([low]))[0] if now is None else self._carried((last, now), low)
        if start is None:
            return NoDetour(core, Hindrance.REST)
        needed, limited = np.inf, False
        looks = list[tuple[tuple[bool, bool, float], MovedTool, Followed]]()
        for sign in (1.0, -1.0):
            for size, moved, found in self._clear(partial(self._look, ends, low, high, start), sign * lost, clearance):
                if not found.complete:
                    limited = True
                    break
                if size > self.bound * (1 + 1e-9):
                    needed = min(needed, size)
                    break
                kept = self._share(moved.place, found.q) <= 1.0
                astray = now is not None and not self._same(high, found.q[-1])
                looks.append(((astray, not kept, size), moved, found))
            if looks and not looks[-1][0][0]:
                break  # the rates of the other way are much the same
        for _, moved, _ in sorted(looks, key=lambda one: one[0]):
            made = self._made(moved, low, high, start, clearance)
            if made is not None:
                return made
        if np.isfinite(needed):
            return NoDetour(core, Hindrance.TOOL, needed)
        return NoDetour(core, Hindrance.LIMIT if limited else Hindrance.TOOL)

    def _clear(
        self, look: Callable[[Array], tuple[MovedTool, Followed]], along: Array, clearance: float
    ) -> Iterator[tuple[float, MovedTool, Followed]]:
        """The least size at which the joints follow, and one at which rates, that go as 1/ε, may keep their limits; or
        the first at which a joint reaches its limit.
        """
        least, most = _USUAL * clearance, _WIDENED * self.bound
        count = int(np.ceil(np.log(max(most / least, 1.0)) / np.log(_GROWING))) + 1
        usual = [size for size in least * _GROWING ** np.arange(count) if size <= most]
        for size in sorted({_FINEST * clearance, *usual, self.bound}):
            moved, found = look(size * along)
            if found.reason == "limit":  # larger ones turn the joints as far
                yield size, moved, found
                return
            if not found.complete or float(moved.room(found.q).min()) < _NEARER * clearance:
                continue
            yield size, moved, found
            slower = size * _GENTLER * self._share(moved.place, found.q)
            if size < slower <= self.bound:
                moved, found = look(slower * along)
                if found.complete and float(moved.room(found.q).min()) >= _NEARER * clearance:
                    yield slower, moved, found
            return

    def _ends(self, core: Core, last: float, until: float) -> tuple[float, float, float, float] | None:
        """Where the ramps of a window begin and end by the clock; None where there is no room for them."""
        bumper = self.bumper
        first, full, back, final = (float(x) for x in bumper.time(np.array([last, core.low, core.high, until])))
        shortest = _RAMP if bumper.path.times is not None else _SLOPE
        ramp = max(shortest, back - full)
        ahead, behind = min(ramp, 0.9 * (full - first)), min(ramp, 0.9 * (final - back))
        if min(ahead, behind) <= 0.0:
            return None
        return full - ahead, full, back, back + behind

    def _look(
        self, ends: tuple[float, float, float, float], low: float, high: float, start: Array, twist: Array
    ) -> tuple[MovedTool, Followed]:
        """The joints along the moved tool, at the rows and some places between."""
        bumper = self.bumper
        rows = np.arange(np.ceil(low), np.floor(high) + 1)
        place = np.unique(np.concatenate([[low], rows, np.linspace(low, high, _LOOKS), [high]]))
        plain = {name: getattr(bumper.tool, name) for name in ToolPath.__dataclass_fields__}
        moved = MovedTool(**plain, twist=twist, ends=ends, clock=bumper.clock)._with(place)
        return moved, moved.followed(start)

    def _made(self, moved: MovedTool, low: float, high: float, start: Array, clearance: float) -> Detour | None:
        """A detour at rows so close that the tool stays on its way between them; None where it comes too near."""

        def run(path: ToolPath) -> Followed:
            return path.followed(start)

        fine, found = moved.refined(run)
        if not found.complete or float(fine.room(found.q).min()) < _NEARER * clearance:
            return None
        off = self._off(fine.place, found.q)
        return Detour(low, high, fine.place, found.q, off, self._share(fine.place, found.q) <= 1.0)

    def _off(self, place: Array, q: Array) -> tuple[float, float]:
        """How far the tool leaves the old path at rows, and in the middle between two: [m], [rad]."""
        places = np.concatenate([place, (place[1:] + place[:-1]) / 2])
        return tool_off(self.bumper.robot, self.bumper.at(places), np.concatenate([q, (q[1:] + q[:-1]) / 2]))

    def _share(self, place: Array, q: Array) -> float:
        """The largest share of a rate limit that is used."""
        if self.bumper.path.times is None:
            return 0.0
        rate = np.abs(np.diff(q, axis=0)) / np.diff(self.bumper.time(place))[:, None]
        return float((rate / self.bumper.rates).max())

    def _carried(self, before: tuple[float, Array], low: float) -> Array | None:
        """The configuration at a place, followed from one on another branch at an earlier place."""
        last, q = before
        place = np.unique(np.concatenate([[last], np.linspace(last, low, 200), [low]]))
        found = follow(self.bumper.robot, pose(self.bumper.robot, self.bumper.at(place)), q, self.bumper.check.task,
                       limits=self.bumper.tool.limits)  # fmt: skip
        return found.q[-1] if found.complete else None

    def changes(self, detours: list[Detour]) -> list[Change]:
        """What each of them changes."""
        bumper, out = self.bumper, []
        for one in detours:
            start, end = (bumper.path.place(bumper.point(place)) for place in (one.low, one.high))
            moves = one.q - bumper.at(one.place)
            after = np.zeros_like(moves[-1]) if self._back(one) else moves[-1]
            out.append(Change(start, end, largest_move(moves), one.off, after))
        return out

    def trajectory(self, detours: list[Detour]) -> tuple[Trajectory, tuple[float, float]] | None:
        """The whole path: rows before the first window, and where the joints are back, as they were; and how far the
        tool is from the old path at most [m], [rad]. None where the rest cannot be followed.
        """
        bumper, count = self.bumper, len(self.bumper.path.control)
        rows = np.concatenate([bumper.path.control[:, 0], bumper.path.control[-1:, -1]])
        first = np.arange(int(np.ceil(detours[0].low)))
        places, values = [first.astype(np.float64)], [rows[first]]
        for k, one in enumerate(detours):
            until = detours[k + 1].low if k + 1 < len(detours) else count + 1.0
            places.append(one.place)
            values.append(one.q)
            rest = np.arange(int(np.floor(one.high)) + 1, min(int(np.ceil(until)), count + 1))
            if not len(rest):
                continue
            old = rows[rest]
            if not self._back(one):
                new = self._rest(one, rest.astype(np.float64))
                if new is None:
                    return None
                old = new
            places.append(rest.astype(np.float64))
            values.append(old)
        place, q = np.concatenate(places), np.concatenate(values)
        timed = bumper.path.times is not None
        made = Trajectory("", bumper.time(place) if timed else regular_times(len(place)), q, timed, ())
        return made, self._off(place, q)

    def _rest(self, one: Detour, rest: Array) -> Array | None:
        """(K, n) configurations at rows after a window, on the branch that the arm is on at its end."""
        place = np.concatenate([[one.high], rest])
        poses = pose(self.bumper.robot, self.bumper.at(place))
        found = follow(self.bumper.robot, poses, one.q[-1], self.bumper.check.task, limits=self.bumper.tool.limits)
        return found.q[1:] if found.complete else None

