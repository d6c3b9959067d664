"""Local changes of a joint path: a bump of the joints around each place where it is singular, or too near to it.

    q′(t) = q(t) + h B(t) d,   B = 1 on the core, s(τ) = τ³ (10 − 15 τ + 6 τ²) on the ramps to it, 0 beyond them

B and its first two derivatives are continuous, and the path outside the window stays as it is, to the last bit. The
core is the part whose first-order distance from a singularity, room = σ_r/‖∇σ_r‖, is below a clearance, and all that
lies between two crossings: a path that crosses and comes back is kept on the side on which it was before.

The direction d is the one whose tool leaves its path least: a single joint, the normal n of the singular set in joint
space, the least tool motion for its share along n, d ∝ (JᵀJ + λ)⁻¹ n, or, of a redundant arm, the null motion nearest
to n. A null motion is brought back to the poses of the old path by Newton's method, so that the tool stays.

Such a bump takes the tool off its path by the second order of its height. Where they can, the joints bring it back:

    T(q′(t)) = exp(ε B(t) w) T(q(t)),   q′ the solution next to the bump,   w the lost direction, its way or its turn

At the edge of reach an elbow bent by φ takes only φ² of the reach, so that a small ε leaves room where the old path
meets the edge. Between its two crossings the elbow stays bent to the side on which it was. B is 0 at both ends of the
window, where q′ = q.

A path that ends on the other side of the singularity than it began at has no such bump: every joint path between the
two sides crosses it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property, partial
from itertools import pairwise

import numpy as np

from rankdrop.errors import TaskError
from rankdrop.families.record import Family
from rankdrop.kinematics import pose
from rankdrop.local.block import joint_scale
from rankdrop.path.check.crossings import Signs, signs
from rankdrop.path.check.record import CROSSING, FREE, PathCheck, Stretch
from rankdrop.path.curve import Curve, Spot
from rankdrop.path.mend.joint_tool_path import JointToolPath
from rankdrop.path.mend.local_change import ON_PATH, largest_move, step, tool_off
from rankdrop.path.mend.lost_direction import lost_motions, moved_along
from rankdrop.path.mend.retime import derivatives
from rankdrop.path.read.trajectory import Trajectory, regular_times
from rankdrop.poses.inverse import Aim
from rankdrop.problem import Mask
from rankdrop.robot.model import Array, Robot

CLEARANCE = np.radians(0.2)
"""First-order distance that a bump leaves to a singularity where no distance is asked for [rad]."""
SPARE = 1.15  # times a distance that is asked for: room is of first order
_LOOKS = 160  # points of a window at which room and tool are computed
_OUTWARDS = 48  # points of one step outwards from a crossing
_HEIGHTS, _BISECTIONS = 14, 12  # of the height
_WIDENED = 8.0  # times the bound: heights up to there are tried, to say how far it would have to be widened
_TURNED = 0.25  # share of the largest component of n that a single joint has at least
_SIMPLER = 1.05  # a single joint whose tool leaves its path by no more than so many times the least is taken
_DAMPED = (1e-4, 1e-2)  # λ, of J with lengths divided by ℓ
_WEIGHTED, _SMALLEST = 12, 1e-2  # rounds of weighing; share of the larger of way and turn that counts at least
_RAMP = 0.3  # shortest ramp of a path in time [s]
_SLOPE = 4.0  # … and of a path without times, in heights
_RAMPS = 7  # lengths of a ramp that are tried, each twice the one before
_ROWS = 24  # of a ramp at least
_LEAST, _GROWING = 0.3, 2.0  # share of that by which the tool is led aside at first; each time so many times more


class Obstacle(StrEnum):
    """Why a place has no bump."""

    SIDE = "side"
    END = "end"
    HEIGHT = "height"
    RATE = "rate"


@dataclass(frozen=True, eq=False)
class Core:
    """A part of a path that a bump has to lift.

    Attributes:
        low, high: its ends, counted in stretches from 0.
        stretches: that are not free there, or too near.
        crossed: signs change inside, and back again.
    """

    low: float
    high: float
    stretches: tuple[Stretch, ...]
    crossed: bool


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
class NoBump:
    """A core without a bump.

    Attributes:
        core: the part of the path.
        obstacle: why.
        needed: height that would be needed, where it is above the bound [rad]; nan where none was found.
    """

    core: Core
    obstacle: Obstacle
    needed: float = np.nan


@dataclass(frozen=True, eq=False)
class Bumper:
    """Looks for bumps of one checked path.

    Attributes:
        check: the path.
        tool: places and poses of it.
        families: whose conditions tell the sides of an arm that is not square.
        bound: largest height [rad].
        rates, accelerations: (n,) limits; inf where there are none.
    """

    check: PathCheck
    tool: JointToolPath
    families: tuple[Family, ...]
    bound: float
    rates: Array
    accelerations: Array

    @property
    def robot(self) -> Robot:
        """The arm."""
        return self.check.robot

    @property
    def path(self) -> Curve:
        """The path."""
        return self.check.curve

    @cached_property
    def aim(self) -> Aim | None:
        """Newton's method to the poses; None where they do not determine what the task wants."""
        try:
            return self.tool.aim
        except TaskError:
            return None

    @cached_property
    def lengths(self) -> Array:
        """(T,) joint motion up to each row, increasing [rad; slides divided by the length scale]."""
        scale = self.scale
        steps = np.linalg.norm(np.diff(self.path.control, axis=1) / scale, axis=2).sum(axis=1)
        return np.concatenate([[0.0], np.cumsum(steps + 1e-12)])

    @cached_property
    def scale(self) -> Array:
        """(n,) of joint motions."""
        return joint_scale(self.robot, self.check.task)

    @cached_property
    def clock(self) -> Array:
        """(T,) what ramps are measured by: times, or lengths where there are none."""
        if self.path.times is None:
            return self.lengths
        return self.path.times

    @cached_property
    def sides(self) -> list[Signs]:
        """Signs of the determinant of a square arm; else of the conditions of families of one condition."""
        sign_functions = signs(self.robot, self.check.task, self.families)
        if "" in sign_functions:
            return [sign_functions[""]]
        return list(sign_functions.values())

    def configurations(self, place: Array) -> Array:
        """(N, n) configurations of the path."""
        return self.path.at(*self.path.split(place))

    def time(self, place: Array | float) -> Array:
        """(N,) the clock at places."""
        return np.asarray(np.interp(place, np.arange(len(self.clock)), self.clock))

    def place_at(self, time: Array) -> Array:
        """(N,) places at times of the clock."""
        return np.asarray(np.interp(time, self.clock, np.arange(len(self.clock))))

    def _spread(self, low: float, high: float, count: int) -> Array:
        """(count,) places between two, evenly along the joint path."""
        rows = np.arange(len(self.lengths))
        start, end = (float(np.interp(place, rows, self.lengths)) for place in (low, high))
        return np.asarray(np.clip(np.interp(np.linspace(start, end, count), self.lengths, rows), low, high))

    def cores(self, clearance: float) -> tuple[list[Core], list[Core]]:
        """Parts to be lifted; and crossings to the other side, from which the path does not come back.

        Crossings of one family are paired with the next one where the part between them is the shallowest.
        """
        bad = sorted(
            (stretch for stretch in self.check.stretches if stretch.verdict != FREE), key=lambda stretch: stretch.start
        )
        pairs, single = self._pairs([stretch for stretch in bad if stretch.verdict == CROSSING])
        lifted = [(first, second) for first, second in pairs] + [
            (stretch, stretch) for stretch in bad if stretch.verdict != CROSSING
        ]
        near = self.check.options.min_distance
        lifted += [(stretch, stretch) for stretch in self.check.stretches
                   if stretch.verdict == FREE and stretch.closest.distance < near
                   and stretch.closest.distance > 1e-6]  # fmt: skip
        lifted_cores = [self._core(first, second, clearance) for first, second in lifted]
        return _merge_cores(lifted_cores), [self._core(stretch, stretch, clearance) for stretch in single]

    def _pairs(self, crossings: list[Stretch]) -> tuple[list[tuple[Stretch, Stretch]], list[Stretch]]:
        pairs, single = [], []
        for family in dict.fromkeys(crossing.family for crossing in crossings):
            left = [crossing for crossing in crossings if crossing.family == family]
            while len(left) > 1:
                depth = [self._depth(first, second) for first, second in pairwise(left)]
                k = int(np.argmin(depth))
                if depth[k] > _WIDENED * self.bound:
                    break
                pairs.append((left[k], left[k + 1]))
                del left[k : k + 2]
            single += left
        return pairs, sorted(single, key=lambda stretch: stretch.start)

    def _depth(self, first: Stretch, second: Stretch) -> float:
        """Largest room between two crossings."""
        low, high = first.closest.place.position - 1.0, second.closest.place.position - 1.0
        return float(self.tool.room(self.configurations(self._spread(low, high, _LOOKS))).max())

    def core(self, stretch: Stretch, clearance: float) -> Core:
        """The part of a path around one stretch that is nearer to a singularity than the clearance."""
        return self._core(stretch, stretch, clearance)

    def _core(self, first: Stretch, second: Stretch, clearance: float) -> Core:
        low, high = first.closest.place.position - 1.0, second.closest.place.position - 1.0
        if first is second and first.verdict not in (CROSSING, FREE):
            low, high = first.start.position - 1.0, first.end.position - 1.0
        low, high = self._outwards(low, clearance, -1.0), self._outwards(high, clearance, 1.0)
        stretches = (first,) if first is second else (first, second)
        return Core(low, high, stretches, first is not second)

    def _outwards(self, place: float, clearance: float, sign: float) -> float:
        """The place before or after another from which on the room is above the clearance."""
        rows = np.arange(len(self.lengths))
        start = float(np.interp(place, rows, self.lengths))
        last, far = (0.0 if sign < 0.0 else float(self.lengths[-1])), 4.0 * clearance
        while True:
            end = float(np.clip(start + sign * far, 0.0, self.lengths[-1]))
            place_at = np.interp(np.linspace(start, end, _OUTWARDS), self.lengths, rows)
            clear = self.tool.room(self.configurations(place_at)) >= clearance
            if clear.any():
                return float(place_at[clear.argmax()])
            if end == last:
                return float(place_at[-1])
            far *= 2.0

    def bump(self, core: Core, clearance: float) -> Bump | NoBump:
        """The bump of a core whose tool leaves its path least, the simplest of those that are nearly as good."""
        if core.low <= 0.0 or core.high >= len(self.path.control):
            return NoBump(core, Obstacle.END)
        places = self._spread(core.low, core.high, _LOOKS)
        q, home = self.configurations(places), self.configurations(np.array([core.low, core.high]))
        sides = [(side, np.asarray(side(home), dtype=np.float64)) for side in self.sides]
        if any((at != 0).all() and at[0] != at[1] for _, at in sides):
            return NoBump(core, Obstacle.SIDE)
        bumps: list[tuple[float, bool, Bump]] = []
        too_high: list[float] = []
        for way, null in self._ways(core, home):
            height = self._height(q, way, sides, clearance, null=null)
            if height is None:
                continue
            if height > self.bound:
                too_high.append(height)
                continue
            off = self._off(q, self._move_joints(q, height * way, null=null))
            alone = np.count_nonzero(way) == 1
            bumps.append((self.size(off), not alone, Bump(core, way, height, null, off=off)))
        if not bumps:
            return NoBump(core, Obstacle.HEIGHT, min(too_high, default=np.nan))
        least = min(size for size, _, _ in bumps)
        near = [candidate for candidate in bumps if candidate[0] <= _SIMPLER * least]
        return self._add_ramps(min(near, key=lambda candidate: (candidate[1], candidate[0]))[2])

    def lead_aside(self, bump: Bump, clearance: float) -> Bump:
        """A bump with the tool brought back to its path, led aside along the lost direction by the
        least that leaves room; the bump itself where that is no better.
        """
        size = self.size(bump.off)
        if size <= ON_PATH or self.aim is None or self.path.degree != 1:
            return bump
        crossing = self.configurations(np.array([bump.core.stretches[0].closest.place.position - 1.0]))[0]
        for motion in lost_motions(self.aim, self.tool.rank, crossing):
            led = self._lead_along(bump, motion, size, clearance)
            if led is not None and self.size(led.off) < size:
                return led
        return bump

    def _lead_along(self, bump: Bump, motion: Array, most: float, clearance: float) -> Bump | None:
        """A bump with the tool led aside along a tool motion (m,) of size 1, to either side, by the least that leaves
        room and keeps limits; None where that is not below `most`.
        """
        place = self._spread(*self.window(bump), _LOOKS)
        before = self.configurations(place)
        inner = (place >= bump.core.low) & (place <= bump.core.high)

        def good(way: Array, size: float) -> bool:
            led = replace(bump, twist=size * way)
            q = self.changed_configurations([led], place)
            if not np.isfinite(q).all() or (self.tool.limits and not self.tool.in_limits(q).all()):
                return False
            if np.abs((q - before) / self.scale).max() > self.bound:
                return False
            clear = bool((self.tool.room(q[inner]) >= clearance).all())
            return clear and self._feasible(led)

        too_small, size = 0.0, _LEAST * ON_PATH
        while size < most:
            for way in (motion, -motion):
                if not good(way, size):
                    continue
                if size > ON_PATH:
                    size = _bisect_least(partial(good, way), too_small, size)
                led = replace(bump, twist=size * way)
                return replace(led, off=self._window_off(led))
            too_small, size = size, _GROWING * size
        return None

    def size(self, off: tuple[float, float]) -> float:
        """A deviation as one number: lengths divided by the length scale."""
        return off[0] / self.check.length_scale + off[1]

    def _ways(self, core: Core, home: Array) -> Iterator[tuple[Array, bool]]:
        """Directions of joint motion away from the singular set, and whether the tool is brought back."""
        normal = self.tool.rising(home[:1])[1][0]
        normal = normal / max(float(np.linalg.norm(normal)), 1e-300)
        middle = self.configurations(np.array([(core.low + core.high) / 2]))
        kinds: list[tuple[Array, bool]] = [
            (np.eye(self.robot.n)[joint] * np.sign(normal[joint]), False)
            for joint in np.flatnonzero(np.abs(normal) >= _TURNED * np.abs(normal).max())
        ]
        kinds.append((normal, False))
        if self.aim is not None:
            jacobian = self.aim.jacobian(middle)[0]
            for damped in _DAMPED:
                least = np.linalg.solve(jacobian.T @ jacobian + damped * np.eye(self.robot.n), normal)
                kinds.append((least, False))
            ways = np.array([row < 3 for row in self.aim.rows])
            kinds.append((least_motion(jacobian, ways, normal), False))
            if self.tool.redundant and self.path.degree == 1:
                null = np.linalg.svd(self.aim.jacobian(home[:1])[0])[2][self.tool.rank :]
                along = null.T @ (null @ normal)
                if np.linalg.norm(along) > 1e-3:
                    kinds += [(along, True)]
        for way, null_motion in kinds:
            direction = self.scale * way / np.abs(way).max()
            yield direction, null_motion
            if not core.crossed:  # either side will do
                yield -direction, null_motion

    def _move_joints(self, q: Array, move: Array, *, null: bool) -> Array:
        """(N, n) configurations moved; nan where the tool cannot be brought back to its place."""
        moved = q + move
        if not null or self.aim is None:
            return moved
        solved, arrived = self.aim.solve(pose(self.robot, q), moved)
        return np.where(arrived[:, None], solved, np.nan)

    def _lead_tool(self, q: Array, move: Array, twist: Array) -> Array:
        """(N, n) configurations moved, the tool then brought to its place moved by twists (N, m); nan where it cannot
        be.
        """
        assert self.aim is not None
        solved, rounds = self.aim.descend(moved_along(self.aim, pose(self.robot, q), twist), q + move)
        return np.where(rounds[:, None] >= 0, solved, np.nan)

    def _height(
        self, q: Array, way: Array, sides: list[tuple[Signs, Array]], clearance: float, *, null: bool
    ) -> float | None:
        """The least height at which all of a core is clear, on the side of its ends."""

        def clear(height: float) -> bool:
            moved = self._move_joints(q, height * way, null=null)
            if not np.isfinite(moved).all() or (self.tool.limits and not self.tool.in_limits(moved).all()):
                return False
            right = all((side(moved) == at[0]).all() for side, at in sides if (at != 0).all())
            return bool(right and (self.tool.room(moved) >= clearance).all())

        too_low = 0.0
        for height in np.geomspace(clearance / 4, _WIDENED * self.bound, _HEIGHTS).tolist():
            if clear(height):
                return _bisect_least(clear, too_low, height)
            too_low = height
        return None

    def _off(self, q: Array, moved: Array) -> tuple[float, float]:
        """How far the tool is moved at most [m], [rad]."""
        return tool_off(self.robot, q, moved)

    def _add_ramps(self, bump: Bump) -> Bump | NoBump:
        """With the shortest ramps that keep limits."""
        if self.path.times is not None:
            first = _RAMP
        else:
            first = _SLOPE * bump.height
        low, high = (float(x) for x in self.time(np.array([bump.core.low, bump.core.high])))
        before, after = low - float(self.clock[0]), float(self.clock[-1]) - high
        for k in range(_RAMPS):
            length = first * 2.0**k
            ramps = min(length, before), min(length, after)
            wide = replace(bump, ramps=ramps)
            if self._feasible(wide):
                return replace(wide, off=self._window_off(wide))
            if length >= max(before, after):
                break
        return NoBump(bump.core, Obstacle.RATE)

    def _feasible(self, bump: Bump) -> bool:
        """The tool is brought back wherever it has to be, and rates and accelerations are within their limits, or no
        larger than before.
        """
        low, high = self.window(bump)
        if not np.isfinite(self.changed_configurations([bump], self._places([bump], low, high))).all():
            return False
        if self.path.times is None:
            return True
        first, last = max(0.0, np.floor(low) - 2), min(len(self.clock) - 1.0, np.ceil(high) + 2)
        now, was = self._needs([bump], first, last), self._needs([], first, last)
        return all(new <= max(1.0, old) * (1 + 1e-9) for new, old in zip(now, was, strict=True))

    def _needs(self, bumps: list[Bump], first: float, last: float) -> tuple[float, float]:
        """Shares of the rate and acceleration limits between two rows."""
        place = self._places(bumps, first, last)
        q, times = self.changed_configurations(bumps, place), self.time(place)
        speed = np.diff(q, axis=0) / np.diff(times)[:, None]
        rate = float((np.abs(speed) / self.rates).max(initial=0.0))
        bend = np.diff(speed, axis=0) / ((times[2:] - times[:-2]) / 2)[:, None]
        return rate, float((np.abs(bend) / self.accelerations).max(initial=0.0))

    def _window_off(self, bump: Bump) -> tuple[float, float]:
        place = self._places([bump], *self.window(bump))
        q = self.changed_configurations([bump], place)
        if bump.twist is not None:  # between rows the joints go straight
            place = np.concatenate([place, (place[1:] + place[:-1]) / 2])
            q = np.concatenate([q, (q[1:] + q[:-1]) / 2])
        return self._off(self.configurations(place), q)

    def window(self, bump: Bump) -> tuple[float, float]:
        """Places between which a path is changed."""
        low, high = (float(x) for x in self.time(np.array([bump.core.low, bump.core.high])))
        ends = self.place_at(np.array([low - bump.ramps[0], high + bump.ramps[1]]))
        return float(ends[0]), float(ends[1])

    def ends(self, bump: Bump) -> tuple[Spot, Spot]:
        """The window as points of the path."""
        low, high = self.window(bump)
        return self.point(low), self.point(high)

    def spot(self, core: Core) -> Spot:
        """Where a core is singular, or nearest to it."""
        return self.point(core.stretches[0].closest.place.position - 1.0)

    def point(self, place: float) -> Spot:
        """A place as a point of the path."""
        stretch, share = self.path.split(np.array([place]))
        return int(stretch[0]), float(share[0])

    def most_moved(self, bump: Bump) -> Array:
        """(n,) how far each joint is moved from the old path at most, with its sign [rad, m]."""
        place = self._places([bump], *self.window(bump))
        return largest_move(self.changed_configurations([bump], place) - self.configurations(place))

    def _places(self, bumps: list[Bump], first: float = 0.0, last: float = np.inf) -> Array:
        """Rows between two places, and places between those of ramps that are far apart."""
        added = []
        for bump in bumps:
            low, high = self.window(bump)
            for start, end, ramp in ((low, bump.core.low, bump.ramps[0]), (bump.core.high, high, bump.ramps[1])):
                rows = np.arange(int(np.floor(start)), int(np.ceil(end)))
                gaps = np.diff(self.clock)[rows]
                parts = np.ceil(gaps / (ramp / _ROWS)).astype(np.int64)
                added += [row + np.arange(1, part) / part for row, part in zip(rows, parts, strict=True) if part > 1]
            ends = np.array([low, bump.core.low, bump.core.high, high])
            sparse = np.diff(self.clock)[np.floor(ends).astype(np.int64).clip(0, len(self.clock) - 2)]
            added.append(ends[sparse > min(bump.ramps) / _ROWS])
        place = np.unique(np.concatenate([np.arange(len(self.clock), dtype=np.float64), *added]))
        return place[(place >= first) & (place <= last)]

    def changed_configurations(self, bumps: list[Bump], place: Array) -> Array:
        """(N, n) configurations of the changed path."""
        q = self.configurations(place)
        moved, pull = q.copy(), np.zeros_like(q)
        twist = np.zeros((len(place), self.check.task.m))
        time = self.time(place)
        for bump in bumps:
            share = self._shape(bump, time)[0][:, None]
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
            moved[held] = self._move_joints(moved[held], pull[held], null=True)
        if led.any():
            moved[led] = self._lead_tool(moved[led], pull[led], twist[led])
        return moved

    def _shape(self, bump: Bump, time: Array) -> tuple[Array, Array, Array]:
        """(N,) each: B at times, and its first two derivatives."""
        low, high = (float(x) for x in self.time(np.array([bump.core.low, bump.core.high])))
        rise = step((time - (low - bump.ramps[0])) / bump.ramps[0])
        fall = step(((high + bump.ramps[1]) - time) / bump.ramps[1])
        early = time <= (low + high) / 2
        value = np.where(early, rise[0], fall[0])
        slope = np.where(early, rise[1] / bump.ramps[0], -fall[1] / bump.ramps[1])
        bend = np.where(early, rise[2] / bump.ramps[0] ** 2, fall[2] / bump.ramps[1] ** 2)
        return value, slope, bend

    def trajectory(self, bumps: list[Bump]) -> Trajectory:
        """The changed path: rows outside its windows as they were."""
        place = self._places(bumps)
        q, whole = self.changed_configurations(bumps, place), place == np.floor(place)
        rows = self.path.samples
        still = np.ones(len(place), dtype=np.bool_)
        for bump in bumps:
            low, high = self.window(bump)
            still &= (place <= low) | (place >= high)
        q[whole & still] = rows[place[whole & still].astype(np.int64)]
        times = self.path.times
        timed = times is not None
        if timed:
            at = self.time(place)
        else:
            at = regular_times(len(place))
        velocities, accelerations = self._derivatives(bumps, place)
        return Trajectory("", at, q, timed, (), velocities, accelerations)

    def _derivatives(self, bumps: list[Bump], place: Array) -> tuple[Array | None, Array | None]:
        """Rates, and of quintics accelerations, of the changed rows; None of straight paths."""
        if self.path.degree == 1 or self.path.times is None:
            return None, None
        stretch, share = self.path.split(place)
        _, velocities, accelerations = derivatives(self.path, stretch, share)
        time = self.time(place)
        for bump in bumps:
            _, slope, bend = self._shape(bump, time)
            velocities = velocities + bump.height * slope[:, None] * bump.way
            accelerations = accelerations + bump.height * bend[:, None] * bump.way
        return velocities, accelerations if self.path.degree == 5 else None


def least_motion(jacobian: Array, ways: Mask, normal: Array) -> Array:
    """Joint motion d with n·d = 1 and the least tool motion |J_v d| + |J_ω d|, by least squares that are weighted anew.

    A weight is 1 over the way, or the turn, of the last round: where that no longer changes, the sum of both is least.

    Args:
        jacobian: (m, n) of scaled joints, lengths divided by the length scale.
        ways: (m,) rows that are ways of the tool; the others are turns.
        normal: (n,) n.

    Returns:
        (n,) d.
    """
    weights = np.ones(len(ways))
    motion = normal
    for _ in range(_WEIGHTED):
        gram = (jacobian.T * weights) @ jacobian
        motion = np.linalg.solve(gram + _DAMPED[0] * weights.max() * np.eye(len(normal)), normal)
        motion = motion / (normal @ motion)
        moved = jacobian @ motion
        sizes = np.where(ways, np.linalg.norm(moved[ways]), np.linalg.norm(moved[~ways]))
        weights = 1.0 / np.maximum(sizes, _SMALLEST * sizes.max())
    return np.asarray(motion)


def _merge_cores(cores: list[Core]) -> list[Core]:
    """Cores that overlap as one."""
    out: list[Core] = []
    for core in sorted(cores, key=lambda core: core.low):
        if out and core.low <= out[-1].high:
            last = out[-1]
            out[-1] = Core(last.low, max(last.high, core.high), (*last.stretches, *core.stretches),
                           last.crossed or core.crossed)  # fmt: skip
        else:
            out.append(core)
    return out


def _bisect_least(clear: Callable[[float], bool], too_low: float, enough: float) -> float:
    """A height that is enough, next to one that is too low."""
    for _ in range(_BISECTIONS):
        middle = (too_low + enough) / 2
        if clear(middle):
            enough = middle
        else:
            too_low = middle
    return enough
