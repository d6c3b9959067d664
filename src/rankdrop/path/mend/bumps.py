"""Local changes of a joint path: a bump of the joints around each place where it is singular, or too near to it.

    q′(t) = q(t) + h B(t) d,   B = 1 on the core, s(τ) = τ³ (10 − 15 τ + 6 τ²) on the ramps to it, 0 beyond them

Where the core begins and ends: `path.mend.singular_parts`; the path with its bumps: `path.mend.bumped_path`. A path
that crosses and comes back is kept on the side on which it was before.

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

import numpy as np

from rankdrop.families.record import Family
from rankdrop.path.check.crossings import Signs, signs
from rankdrop.path.mend.bumped_path import Bump, BumpedPath, move_joints, window_of
from rankdrop.path.mend.local_change import ON_PATH, tool_off
from rankdrop.path.mend.lost_direction import lost_motions
from rankdrop.path.mend.singular_parts import Core, SingularParts
from rankdrop.problem import Mask
from rankdrop.robot.model import Array

CLEARANCE = np.radians(0.2)
"""First-order distance that a bump leaves to a singularity where no distance is asked for [rad]."""
SPARE = 1.15  # times a distance that is asked for: room is of first order
_LOOKS = 160  # points of a window at which room and tool are computed
_HEIGHTS, _BISECTIONS = 14, 12  # of the height
_WIDENED = 8.0  # times the bound: heights up to there are tried, to say how far it would have to be widened
_TURNED = 0.25  # share of the largest component of n that a single joint has at least
_SIMPLER = 1.05  # a single joint whose tool leaves its path by no more than so many times the least is taken
_DAMPED = (1e-4, 1e-2)  # λ, of J with lengths divided by ℓ
_WEIGHTED, _SMALLEST = 12, 1e-2  # rounds of weighing; share of the larger of way and turn that counts at least
_RAMP = 0.3  # shortest ramp of a path in time [s]
_SLOPE = 4.0  # … and of a path without times, in heights
_RAMPS = 7  # lengths of a ramp that are tried, each twice the one before
_LEAST, _GROWING = 0.3, 2.0  # share of that by which the tool is led aside at first; each time so many times more


class Obstacle(StrEnum):
    """Why a place has no bump."""

    SIDE = "side"
    END = "end"
    HEIGHT = "height"
    RATE = "rate"


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
        parts: the path, and where it is singular or too near.
        families: whose conditions tell the sides of an arm that is not square.
        bound: largest height [rad].
        rates, accelerations: (n,) limits; inf where there are none.
    """

    parts: SingularParts
    families: tuple[Family, ...]
    bound: float
    rates: Array
    accelerations: Array

    @cached_property
    def sides(self) -> list[Signs]:
        """Signs of the determinant of a square arm; else of the conditions of families of one condition."""
        sign_functions = signs(self.parts.robot, self.parts.check.task, self.families)
        if "" in sign_functions:
            return [sign_functions[""]]
        return list(sign_functions.values())

    def cores(self, clearance: float) -> tuple[list[Core], list[Core]]:
        """Parts to be lifted; and crossings to the other side, from which the path does not come back."""
        return self.parts.cores(clearance, _WIDENED * self.bound)

    def bump(self, core: Core, clearance: float) -> Bump | NoBump:
        """The bump of a core whose tool leaves its path least, the simplest of those that are nearly as good."""
        if core.low <= 0.0 or core.high >= len(self.parts.path.control):
            return NoBump(core, Obstacle.END)
        places = self.parts.spread(core.low, core.high, _LOOKS)
        q, home = self.parts.configurations(places), self.parts.configurations(np.array([core.low, core.high]))
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
            moved = move_joints(self.parts, q, height * way, null=null)
            off = tool_off(self.parts.robot, q, moved, self.parts.aim)
            alone = np.count_nonzero(way) == 1
            bumps.append((self.parts.size(off), not alone, Bump(core, way, height, null, off=off)))
        if not bumps:
            return NoBump(core, Obstacle.HEIGHT, min(too_high, default=np.nan))
        least = min(size for size, _, _ in bumps)
        near = [candidate for candidate in bumps if candidate[0] <= _SIMPLER * least]
        return self._add_ramps(min(near, key=lambda candidate: (candidate[1], candidate[0]))[2])

    def lead_aside(self, bump: Bump, clearance: float) -> Bump:
        """A bump with the tool brought back to its path, led aside along the lost direction by the
        least that leaves room; the bump itself where that is no better.
        """
        size = self.parts.size(bump.off)
        if size <= ON_PATH or self.parts.aim is None or self.parts.path.degree != 1:
            return bump
        crossing = self.parts.configurations(np.array([bump.core.stretches[0].closest.place.position - 1.0]))[0]
        for motion in lost_motions(self.parts.aim, self.parts.tool.rank, crossing):
            led = self._lead_along(bump, motion, size, clearance)
            if led is not None and self.parts.size(led.off) < size:
                return led
        return bump

    def _lead_along(self, bump: Bump, motion: Array, most: float, clearance: float) -> Bump | None:
        """A bump with the tool led aside along a tool motion (m,) of size 1, to either side, by the least that leaves
        room and keeps limits; None where that is not below `most`.
        """
        place = self.parts.spread(*window_of(self.parts, bump), _LOOKS)
        before = self.parts.configurations(place)
        inner = (place >= bump.core.low) & (place <= bump.core.high)

        def good(way: Array, size: float) -> bool:
            led = replace(bump, twist=size * way)
            q = BumpedPath(self.parts, [led]).configurations(place)
            if not np.isfinite(q).all() or (self.parts.tool.limits and not self.parts.tool.in_limits(q).all()):
                return False
            if np.abs((q - before) / self.parts.scale).max() > self.bound:
                return False
            clear = bool((self.parts.tool.room(q[inner]) >= clearance).all())
            return clear and self._feasible(led)

        too_small, size = 0.0, _LEAST * ON_PATH
        while size < most:
            for way in (motion, -motion):
                if not good(way, size):
                    continue
                if size > ON_PATH:
                    size = _bisect_least(partial(good, way), too_small, size)
                led = replace(bump, twist=size * way)
                return replace(led, off=BumpedPath(self.parts, [led]).off())
            too_small, size = size, _GROWING * size
        return None

    def _ways(self, core: Core, home: Array) -> Iterator[tuple[Array, bool]]:
        """Directions of joint motion away from the singular set, and whether the tool is brought back."""
        normal = self.parts.tool.rising(home[:1])[1][0]
        normal = normal / max(float(np.linalg.norm(normal)), 1e-300)
        middle = self.parts.configurations(np.array([(core.low + core.high) / 2]))
        kinds: list[tuple[Array, bool]] = [
            (np.eye(self.parts.robot.n)[joint] * np.sign(normal[joint]), False)
            for joint in np.flatnonzero(np.abs(normal) >= _TURNED * np.abs(normal).max())
        ]
        kinds.append((normal, False))
        if self.parts.aim is not None:
            jacobian = self.parts.aim.jacobian(middle)[0]
            for damped in _DAMPED:
                least = np.linalg.solve(jacobian.T @ jacobian + damped * np.eye(self.parts.robot.n), normal)
                kinds.append((least, False))
            ways = np.array([row < 3 for row in self.parts.aim.rows])
            kinds.append((least_motion(jacobian, ways, normal), False))
            if self.parts.tool.redundant and self.parts.path.degree == 1:
                null = np.linalg.svd(self.parts.aim.jacobian(home[:1])[0])[2][self.parts.tool.rank :]
                along = null.T @ (null @ normal)
                if np.linalg.norm(along) > 1e-3:
                    kinds += [(along, True)]
        for way, null_motion in kinds:
            direction = self.parts.scale * way / np.abs(way).max()
            yield direction, null_motion
            if not core.crossed:  # either side will do
                yield -direction, null_motion

    def _height(
        self, q: Array, way: Array, sides: list[tuple[Signs, Array]], clearance: float, *, null: bool
    ) -> float | None:
        """The least height at which all of a core is clear, on the side of its ends."""

        def clear(height: float) -> bool:
            moved = move_joints(self.parts, q, height * way, null=null)
            if not np.isfinite(moved).all() or (self.parts.tool.limits and not self.parts.tool.in_limits(moved).all()):
                return False
            right = all((side(moved) == at[0]).all() for side, at in sides if (at != 0).all())
            return bool(right and (self.parts.tool.room(moved) >= clearance).all())

        too_low = 0.0
        for height in np.geomspace(clearance / 4, _WIDENED * self.bound, _HEIGHTS).tolist():
            if clear(height):
                return _bisect_least(clear, too_low, height)
            too_low = height
        return None

    def _add_ramps(self, bump: Bump) -> Bump | NoBump:
        """With the shortest ramps that keep limits."""
        if self.parts.path.times is not None:
            first = _RAMP
        else:
            first = _SLOPE * bump.height
        low, high = (float(x) for x in self.parts.time(np.array([bump.core.low, bump.core.high])))
        before, after = low - float(self.parts.clock[0]), float(self.parts.clock[-1]) - high
        for k in range(_RAMPS):
            length = first * 2.0**k
            ramps = min(length, before), min(length, after)
            wide = replace(bump, ramps=ramps)
            if self._feasible(wide):
                return replace(wide, off=BumpedPath(self.parts, [wide]).off())
            if length >= max(before, after):
                break
        return NoBump(bump.core, Obstacle.RATE)

    def _feasible(self, bump: Bump) -> bool:
        """The tool is brought back wherever it has to be, and rates and accelerations are within their limits, or no
        larger than before.
        """
        low, high = window_of(self.parts, bump)
        bumped = BumpedPath(self.parts, [bump])
        if not np.isfinite(bumped.configurations(bumped.places(low, high))).all():
            return False
        if self.parts.path.times is None:
            return True
        first, last = max(0.0, np.floor(low) - 2), min(len(self.parts.clock) - 1.0, np.ceil(high) + 2)
        now, was = self._needs(bumped, first, last), self._needs(BumpedPath(self.parts, ()), first, last)
        return all(new <= max(1.0, old) * (1 + 1e-9) for new, old in zip(now, was, strict=True))

    def _needs(self, bumped: BumpedPath, first: float, last: float) -> tuple[float, float]:
        """Shares of the rate and acceleration limits between two rows."""
        place = bumped.places(first, last)
        q, times = bumped.configurations(place), self.parts.time(place)
        speed = np.diff(q, axis=0) / np.diff(times)[:, None]
        rate = float((np.abs(speed) / self.rates).max(initial=0.0))
        bend = np.diff(speed, axis=0) / ((times[2:] - times[:-2]) / 2)[:, None]
        return rate, float((np.abs(bend) / self.accelerations).max(initial=0.0))


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


def _bisect_least(clear: Callable[[float], bool], too_low: float, enough: float) -> float:
    """A height that is enough, next to one that is too low."""
    for _ in range(_BISECTIONS):
        middle = (too_low + enough) / 2
        if clear(middle):
            enough = middle
        else:
            too_low = middle
    return enough
