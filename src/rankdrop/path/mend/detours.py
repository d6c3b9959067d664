"""Local changes of the tool's path: led around a singularity that the joints would cross to the other side.

A joint path that goes from one side of a singularity to the other crosses it whatever is done to it nearby. The tool
can go on all the same: it is moved along u, the direction that is lost at the crossing,

    T′(t) = exp(ε B(t) w) T(t),   u the left singular vector of σ_r at the crossing,

with B as in `path.mend.bumped_path` and w the way or the turn of u with the larger share, or else the other one; the
least ε is taken that leaves room. The joints follow on the branch that they are on. At a wrist they turn half around
while the tool passes by; at the edge of reach they stay bent. After the window the tool is on its old path, and the arm
on another branch of the inverse kinematics, up to the next crossing, where it may come back.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Self

import numpy as np

from rankdrop.kinematics import pose
from rankdrop.path.check.tool_branch import Followed
from rankdrop.path.mend.joint_tool_path import JointToolPath
from rankdrop.path.mend.local_change import LocalChange, largest_move, step, tool_off
from rankdrop.path.mend.lost_direction import lost_motions, moved_along
from rankdrop.path.mend.singular_parts import Core, SingularParts
from rankdrop.path.read.trajectory import Trajectory, regular_times
from rankdrop.robot.model import Array

_RAMP = 0.3  # shortest ramp of a path in time [s]
_SLOPE = 0.1  # … and of a path without times [rad]
_FINEST, _USUAL = 1e-2, 0.5  # sizes that are tried: shares of the clearance, at an edge of reach and else …
_WIDENED, _GROWING = 8.0, 2.0  # … up to so many times the bound, each so many times the one before
_FINER, _TRIES = 1.02, 6  # … made smaller until the room is about what is kept; smaller sizes that are tried
_LOOKS = 101  # places of a window at first, close together near the crossing, besides the rows
_NEARER = 0.9  # share of the clearance that is kept where the joints follow
_BACK = 1e-6  # a configuration so near to the old path is on it again [rad]


class Hindrance(StrEnum):
    """Why no detour was found at a crossing."""

    END = "end"
    TOOL = "tool"
    LIMIT = "limit"
    RANGE = "range"
    REST = "rest"


@dataclass(frozen=True, eq=False)
class Detour:
    """The tool led around one crossing.

    Attributes:
        low, high: the window, places counted in stretches from 0.
        place: (K,) places of its rows.
        q: (K, n) configurations there.
        off: how far the tool is from its path at most [m], [rad].
        rest: places and configurations after it, up to the next window or the end; None where the joints are back on
            the old path.
    """

    low: float
    high: float
    place: Array
    q: Array
    off: tuple[float, float]
    rest: tuple[Array, Array] | None = None


@dataclass(frozen=True, eq=False)
class Window:
    """Where the tool is moved.

    Attributes:
        ends: (4,) of the clock: where the ramps begin, where they end, and the same on the way back.
        low, high: its ends, places counted in stretches from 0.
        middle: the crossing.
        start: (n,) configuration at its beginning; None: the one of the old path.
    """

    ends: tuple[float, float, float, float]
    low: float
    high: float
    middle: float
    start: Array | None


@dataclass(frozen=True, eq=False)
class NoDetour:
    """A crossing without a detour.

    Attributes:
        core: where it is.
        hindrance: why.
        needed: the size that would do where it is above the bound, else nan [rad; lengths by the length scale].
        joints: numbers from 1 of those that reached their limits, each in one of the ways that were tried.
    """

    core: Core
    hindrance: Hindrance
    needed: float = np.nan
    joints: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False, kw_only=True)
class MovedTool(JointToolPath):
    """A tool path with the tool moved along a task direction in a window.

    Attributes:
        twist: (m,) ε u, in the axes of `Aim` [rad; lengths divided by the length scale].
        ends: (4,) of the clock: where the ramps begin, where they end, and the same on the way back.
        clock: (T,) of the rows of the path.
    """

    twist: Array
    ends: tuple[float, float, float, float]
    clock: Array

    def at_places(self, place: Array) -> Self:
        """The same moved tool path at other places (K,)."""
        q = self.path.at(*self.path.split(place))
        time = np.interp(place, np.arange(len(self.clock)), self.clock)
        begin, full, back, end = self.ends
        share = np.where(time <= (full + back) / 2, step((time - begin) / (full - begin))[0],
                         step((end - time) / (end - back))[0])  # fmt: skip
        poses = moved_along(self.aim, pose(self.robot, q), share[:, None] * self.twist)
        return replace(self, place=place, q=q, poses=poses)


@dataclass(eq=False)
class Detourer:
    """Looks for detours around the crossings of one path to the other side.

    Attributes:
        parts: the path, its clock and where it is singular.
        bound: largest size of a detour [rad; lengths divided by the length scale].
    """

    parts: SingularParts
    bound: float

    def find_detours(self, crossings: list[Core], clearance: float) -> list[Detour | NoDetour]:
        """One for each crossing in order, up to the first that has none; between them the tool is on its path."""
        start: Array | None = None  # at the beginning of the next window; None: on the old path
        final, out = float(len(self.parts.path.control)), list[Detour | NoDetour]()
        last = 0.0
        for k, core in enumerate(crossings):
            if k + 1 < len(crossings):
                until = crossings[k + 1].low
            else:
                until = final
            ends = self._ends(core, last, until)
            if ends is None:
                return [*out, NoDetour(core, Hindrance.END)]
            low, high = self.parts.place_at(np.array([ends[0], ends[3]])).tolist()
            if k > 0 and start is not None:
                rest = self._rest(last, low, start)
                if rest is None:
                    return [*out, NoDetour(core, Hindrance.REST)]
                before = out[-1]
                assert isinstance(before, Detour)
                out[-1], start = replace(before, rest=(rest[0][:-1], rest[1][:-1])), rest[1][-1]
            outcome = self._at_crossing(core, ends, low, high, start, clearance)
            out.append(outcome)
            if isinstance(outcome, NoDetour):
                return out
            last, start = high, None if self._back_on_path(outcome) else outcome.q[-1]
        if start is not None:
            rest, before = self._rest(last, final, start), out[-1]
            assert isinstance(before, Detour)
            if rest is None:
                out[-1] = NoDetour(crossings[-1], Hindrance.REST)
            else:
                out[-1] = replace(before, rest=rest)
        return out

    def _back_on_path(self, detour: Detour) -> bool:
        """After the window the joints are where they were on the old path."""
        return self._same(detour.high, detour.q[-1])

    def _same(self, place: float, q: Array) -> bool:
        return bool((np.abs(q - self.parts.configurations(np.array([place]))[0]) < _BACK).all())

    def _at_crossing(
        self, core: Core, ends: tuple[float, float, float, float], low: float, high: float, start: Array | None,
        clearance: float,
    ) -> Detour | NoDetour:  # fmt: skip
        """The detour around one crossing along the larger share of the lost direction, or else along the other."""
        window = Window(ends, low, high, core.stretches[0].closest.place.position - 1.0, start)
        first, *others = self._motions(core)
        detour = self._led_along(first, core, window, clearance)
        for motion in others:
            if isinstance(detour, Detour):
                break
            other = self._led_along(motion, core, window, clearance)
            if isinstance(other, Detour):
                detour = other
        return detour

    def _led_along(self, motion: Array, core: Core, window: Window, clearance: float) -> Detour | NoDetour:
        """The detour along a tool motion (m,) of size 1, of the least size at which the joints follow.

        Of both ways along it the one that comes back to the old path where the arm has left it. Rates go as 1/ε; where
        they break limits a new time law keeps them.
        """
        limited: set[int] = set()
        ways, before = [motion, -motion], 0.0
        for size in self._sizes(clearance):
            looks = [(way, *self._look(window, size * way)) for way in ways]
            limited.update(followed.joint for _, _, followed in looks)  # 0: none
            ways = [way for way, _, followed in looks if not followed.joint]  # larger ones turn the joints as far
            clear = [look for look in looks if self._clear(look[1], look[2], clearance)]
            if not clear:
                before = size
                continue
            if size > self.bound * (1 + 1e-9):
                return NoDetour(core, Hindrance.TOOL, size)
            clear.sort(key=lambda look: window.start is not None and not self._same(window.high, look[2].q[-1]))
            for way, moved, followed in clear:
                paths = self._smaller(window, way, (before, size), followed, clearance)
                for path in (*reversed(paths), moved):
                    detour = self._refine_detour(path, window, clearance)
                    if detour is not None:
                        return detour
            before = size
        joints = tuple(sorted(limited - {0}))
        if joints:
            return NoDetour(core, Hindrance.LIMIT, joints=joints)
        return NoDetour(core, Hindrance.TOOL)

    def _smaller(
        self, window: Window, way: Array, sizes: tuple[float, float], followed: Followed, clearance: float
    ) -> list[MovedTool]:
        """Tool paths moved along a way by ever smaller sizes that are enough, from the larger of two that is, to the
        smaller one that is not. The room at size ε grows as ε, or at an edge of reach as √ε: both guesses are enough.
        """
        paths: list[MovedTool] = []
        too_small, enough = sizes
        wanted = _FINER * _NEARER * clearance
        room = float(self.parts.tool.room(followed.q).min())
        for _ in range(_TRIES):
            if room <= _FINER * wanted:
                break
            guess = enough * wanted / room
            if guess <= too_small:
                guess = float(np.sqrt(too_small * enough))
            moved, followed = self._look(window, guess * way)
            if self._clear(moved, followed, clearance):
                paths.append(moved)
                enough, room = guess, float(moved.room(followed.q).min())
            else:
                too_small = guess
        return paths

    def _motions(self, core: Core) -> list[Array]:
        """Tool motions along the direction that is lost at a crossing, in the axes of `Aim`."""
        parts = self.parts
        place = core.stretches[0].closest.place.position - 1.0
        return lost_motions(parts.tool.aim, parts.tool.rank, parts.configurations(np.array([place]))[0])

    def _clear(self, moved: MovedTool, followed: Followed, clearance: float) -> bool:
        return followed.complete and float(moved.room(followed.q).min()) >= _NEARER * clearance

    def _sizes(self, clearance: float) -> list[float]:
        """Sizes of detours that are tried, the least first."""
        least, most = _USUAL * clearance, _WIDENED * self.bound
        count = int(np.ceil(np.log(max(most / least, 1.0)) / np.log(_GROWING))) + 1
        usual = [float(size) for size in least * _GROWING ** np.arange(count) if size <= most]
        return sorted({_FINEST * clearance, *usual, self.bound})

    def _ends(self, core: Core, last: float, until: float) -> tuple[float, float, float, float] | None:
        """Where the ramps of a window begin and end by the clock; None where there is no room for them."""
        parts = self.parts
        first, full, back, final = (float(x) for x in parts.time(np.array([last, core.low, core.high, until])))
        if parts.path.times is not None:
            shortest = _RAMP
        else:
            shortest = _SLOPE
        ramp = max(shortest, back - full)
        ahead, behind = min(ramp, 0.9 * (full - first)), min(ramp, 0.9 * (final - back))
        if min(ahead, behind) <= 0.0:
            return None
        return full - ahead, full, back, back + behind

    def _look(self, window: Window, twist: Array) -> tuple[MovedTool, Followed]:
        """The joints along the moved tool, at the rows and some places between, most near the crossing."""
        parts, low, high = self.parts, window.low, window.high
        rows = np.arange(np.ceil(low), np.floor(high) + 1)
        u = np.linspace(-1.0, 1.0, _LOOKS)
        close = window.middle + np.where(u < 0.0, window.middle - low, high - window.middle) * np.sign(u) * u * u
        place = np.unique(np.concatenate([rows, close.clip(low, high), [low, high]]))
        plain = {name: getattr(parts.tool, name) for name in JointToolPath.__dataclass_fields__}
        moved = MovedTool(**plain, twist=twist, ends=window.ends, clock=parts.clock).at_places(place)
        return moved, moved.follow_branch(self._begin(window))

    def _begin(self, window: Window) -> Array:
        """(n,) the configuration at the beginning of a window."""
        if window.start is None:
            return np.asarray(self.parts.configurations(np.array([window.low]))[0])
        return window.start

    def _refine_detour(self, moved: MovedTool, window: Window, clearance: float) -> Detour | None:
        """A detour at rows so close that the tool stays on its way between them; None where it comes too near."""
        start = self._begin(window)

        def run(path: JointToolPath) -> Followed:
            return path.follow_branch(start)

        fine, followed = moved.refine_run(run)
        if not followed.complete or float(fine.room(followed.q).min()) < _NEARER * clearance:
            return None
        off = self._off(fine.place, followed.q)
        return Detour(window.low, window.high, fine.place, followed.q, off)

    def _off(self, place: Array, q: Array) -> tuple[float, float]:
        """How far the tool leaves the old path at rows, and in the middle between two: [m], [rad]."""
        places = np.concatenate([place, (place[1:] + place[:-1]) / 2])
        old, new = self.parts.configurations(places), np.concatenate([q, (q[1:] + q[:-1]) / 2])
        return tool_off(self.parts.robot, old, new, self.parts.aim)

    def changes(self, detours: list[Detour]) -> list[LocalChange]:
        """What each of them changes."""
        parts, out = self.parts, []
        for detour in detours:
            start, end = (parts.path.place(parts.point(place)) for place in (detour.low, detour.high))
            moves = detour.q - parts.configurations(detour.place)
            if self._back_on_path(detour):
                after = np.zeros_like(moves[-1])
            else:
                after = moves[-1]
            out.append(LocalChange(start, end, largest_move(moves), detour.off, after))
        return out

    def trajectory(self, detours: list[Detour]) -> tuple[Trajectory, tuple[float, float]]:
        """The whole path: rows before the first window, and where the joints are back, as they were; and how far the
        tool is from the old path at most [m], [rad].
        """
        parts, count = self.parts, len(self.parts.path.control)
        rows = parts.path.samples
        first = np.arange(int(np.ceil(detours[0].low)))
        places, values = [first.astype(np.float64)], [rows[first]]
        for k, detour in enumerate(detours):
            places.append(detour.place)
            values.append(detour.q)
            if detour.rest is not None:
                places.append(detour.rest[0])
                values.append(detour.rest[1])
                continue
            if k + 1 < len(detours):
                until = int(np.ceil(detours[k + 1].low))
            else:
                until = count + 1
            after = np.arange(int(np.floor(detour.high)) + 1, until)
            places.append(after.astype(np.float64))
            values.append(rows[after])
        place, q = np.concatenate(places), np.concatenate(values)
        timed = parts.path.times is not None
        trajectory = Trajectory("", parts.time(place) if timed else regular_times(len(place)), q, timed, ())
        return trajectory, self._off(place, q)

    def _rest(self, low: float, high: float, start: Array) -> tuple[Array, Array] | None:
        """Places after one up to another, and the configurations there on the branch of the one at the first place."""
        tool = self.parts.tool
        between = tool.place[(tool.place > low) & (tool.place < high)]
        place = np.concatenate([[low], between, [high]])

        def run(path: JointToolPath) -> Followed:
            return path.follow_branch(start)

        fine, followed = tool.at_places(place).refine_run(run)
        if followed.complete:
            return (fine.place[1:], followed.q[1:])
        return None
