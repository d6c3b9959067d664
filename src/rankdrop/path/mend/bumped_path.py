"""A joint path with bumps.

    q′(t) = q(t) + h B(t) d,   B = 1 on the core, s(τ) = τ³ (10 − 15 τ + 6 τ²) on the ramps to it, 0 beyond them

B and its first two derivatives are continuous, and the path outside the window stays as it is, to the last bit. Where
the joints bring the tool back, T(q′(t)) = exp(ε B(t) w) T(q(t)): q′ is the solution next to the bump.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rankdrop.kinematics import pose
from rankdrop.path.curve import Spot
from rankdrop.path.mend.local_change import largest_move, step, tool_off
from rankdrop.path.mend.lost_direction import moved_along
from rankdrop.path.mend.retime import derivatives
from rankdrop.path.mend.singular_parts import Core, SingularParts
from rankdrop.path.read.trajectory import Trajectory, regular_times
from rankdrop.robot.model import Array

_ROWS = 24  # of a ramp at least


@dataclass(frozen=True, eq=False)
class Bump:
    """A bump around one core.

    Attributes:
        core: what it lifts.
        way: (n,) d, the joint motion at height one; no joint moves more than 1 rad, slides by the length scale.
        height: h [rad].
        null: the tool is brought back to its path.
        ramps: lengths of the ramps before and after the core, by the clock of the path [s, or rad without times].
        off: how far the tool is from the old path at most [m], [rad].
        twist: (m,) ε w, by which the tool is led aside of its old path; None: it goes where the bump takes it.
    """

    core: Core
    way: Array
    height: float
    null: bool
    ramps: tuple[float, float] = (0.0, 0.0)
    off: tuple[float, float] = (0.0, 0.0)
    twist: Array | None = None


@dataclass(frozen=True, eq=False)
class BumpedPath:
    """A path with bumps.

    Attributes:
        parts: the path before.
        bumps: none or more, in any order.
    """

    parts: SingularParts
    bumps: Sequence[Bump]

    def configurations(self, place: Array) -> Array:
        """(N, n) configurations of the changed path."""
        q = self.parts.configurations(place)
        moved, pull = q.copy(), np.zeros_like(q)
        twist = np.zeros((len(place), self.parts.check.task.m))
        time = self.parts.time(place)
        for bump in self.bumps:
            share = _shape(self.parts, bump, time)[0][:, None]
            lift = bump.height * share * bump.way
            if bump.twist is not None:
                twist += share * bump.twist
            if bump.null or bump.twist is not None:
                pull += lift
            else:
                moved += lift
        led = twist.any(axis=1)
        held = pull.any(axis=1) & ~led
        if held.any():
            moved[held] = move_joints(self.parts, moved[held], pull[held], null=True)
        if led.any():
            moved[led] = lead_tool(self.parts, moved[led], pull[led], twist[led])
        return moved

    def places(self, first: float = 0.0, last: float = np.inf) -> Array:
        """Rows between two places, and places between those of ramps that are far apart."""
        added = []
        for bump in self.bumps:
            low, high = window_of(self.parts, bump)
            for start, end, ramp in ((low, bump.core.low, bump.ramps[0]), (bump.core.high, high, bump.ramps[1])):
                rows = np.arange(int(np.floor(start)), int(np.ceil(end)))
                gaps = np.diff(self.parts.clock)[rows]
                counts = np.ceil(gaps / (ramp / _ROWS)).astype(np.int64)
                added += [row + np.arange(1, n) / n for row, n in zip(rows, counts, strict=True) if n > 1]
            ends = np.array([low, bump.core.low, bump.core.high, high])
            sparse = np.diff(self.parts.clock)[np.floor(ends).astype(np.int64).clip(0, len(self.parts.clock) - 2)]
            added.append(ends[sparse > min(bump.ramps) / _ROWS])
        place = np.unique(np.concatenate([np.arange(len(self.parts.clock), dtype=np.float64), *added]))
        return place[(place >= first) & (place <= last)]

    def trajectory(self) -> Trajectory:
        """The changed path: rows outside its windows as they were."""
        place = self.places()
        q, whole = self.configurations(place), place == np.floor(place)
        rows = self.parts.path.samples
        still = np.ones(len(place), dtype=np.bool_)
        for bump in self.bumps:
            low, high = window_of(self.parts, bump)
            still &= (place <= low) | (place >= high)
        q[whole & still] = rows[place[whole & still].astype(np.int64)]
        times = self.parts.path.times
        timed = times is not None
        if timed:
            at = self.parts.time(place)
        else:
            at = regular_times(len(place))
        velocities, accelerations = self._derivatives(place)
        return Trajectory("", at, q, timed, (), velocities, accelerations)

    def _derivatives(self, place: Array) -> tuple[Array | None, Array | None]:
        """Rates, and of quintics accelerations, of the changed rows; None of straight paths."""
        if self.parts.path.degree == 1 or self.parts.path.times is None:
            return None, None
        stretch, share = self.parts.path.split(place)
        _, velocities, accelerations = derivatives(self.parts.path, stretch, share)
        time = self.parts.time(place)
        for bump in self.bumps:
            _, slope, bend = _shape(self.parts, bump, time)
            velocities = velocities + bump.height * slope[:, None] * bump.way
            accelerations = accelerations + bump.height * bend[:, None] * bump.way
        return velocities, accelerations if self.parts.path.degree == 5 else None

    def most_moved(self) -> Array:
        """(n,) how far each joint is moved from the old path at most, with its sign [rad, m]."""
        place = self._window_places()
        return largest_move(self.configurations(place) - self.parts.configurations(place))

    def off(self) -> tuple[float, float]:
        """How far the tool is from the old path at most [m], [rad]: at rows, and where it is led aside between them."""
        place = self._window_places()
        q = self.configurations(place)
        if any(bump.twist is not None for bump in self.bumps):  # between rows the joints go straight
            place = np.concatenate([place, (place[1:] + place[:-1]) / 2])
            q = np.concatenate([q, (q[1:] + q[:-1]) / 2])
        return tool_off(self.parts.robot, self.parts.configurations(place), q, self.parts.aim)

    def _window_places(self) -> Array:
        windows = [window_of(self.parts, bump) for bump in self.bumps]
        return self.places(min(low for low, _ in windows), max(high for _, high in windows))


def _shape(parts: SingularParts, bump: Bump, time: Array) -> tuple[Array, Array, Array]:
    """(N,) each: B at times, and its first two derivatives."""
    low, high = (float(x) for x in parts.time(np.array([bump.core.low, bump.core.high])))
    rise = step((time - (low - bump.ramps[0])) / bump.ramps[0])
    fall = step(((high + bump.ramps[1]) - time) / bump.ramps[1])
    early = time <= (low + high) / 2
    value = np.where(early, rise[0], fall[0])
    slope = np.where(early, rise[1] / bump.ramps[0], -fall[1] / bump.ramps[1])
    bend = np.where(early, rise[2] / bump.ramps[0] ** 2, fall[2] / bump.ramps[1] ** 2)
    return value, slope, bend


def window_of(parts: SingularParts, bump: Bump) -> tuple[float, float]:
    """Places between which a path is changed."""
    low, high = (float(x) for x in parts.time(np.array([bump.core.low, bump.core.high])))
    ends = parts.place_at(np.array([low - bump.ramps[0], high + bump.ramps[1]]))
    return float(ends[0]), float(ends[1])


def ends_of(parts: SingularParts, bump: Bump) -> tuple[Spot, Spot]:
    """The window as points of the path."""
    low, high = window_of(parts, bump)
    return parts.point(low), parts.point(high)


def move_joints(parts: SingularParts, q: Array, move: Array, *, null: bool) -> Array:
    """(N, n) configurations moved; nan where the tool cannot be brought back to its place."""
    moved = q + move
    if not null or parts.aim is None:
        return moved
    solved, arrived = parts.aim.solve(pose(parts.robot, q), moved)
    return np.where(arrived[:, None], solved, np.nan)


def lead_tool(parts: SingularParts, q: Array, move: Array, twist: Array) -> Array:
    """(N, n) configurations moved, the tool then brought to its place moved by twists (N, m); nan where it cannot
    be.
    """
    assert parts.aim is not None
    solved, rounds = parts.aim.descend(moved_along(parts.aim, pose(parts.robot, q), twist), q + move)
    return np.where(rounds[:, None] >= 0, solved, np.nan)
