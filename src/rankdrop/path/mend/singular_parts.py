"""Parts of a checked path that are singular, or too near to a singularity: where each begins and ends.

A core is a part whose first-order distance from a singularity, room = σ_r/‖∇σ_r‖, is below a clearance, and all that
lies between two crossings, where the path crosses and comes back.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from rankdrop.errors import TaskError
from rankdrop.local.block import joint_scale
from rankdrop.path.check.record import CROSSING, FREE, PathCheck, Stretch
from rankdrop.path.curve import Curve, Spot
from rankdrop.path.mend.joint_tool_path import JointToolPath
from rankdrop.path.mend.local_change import size_of_off
from rankdrop.poses.inverse import Aim
from rankdrop.robot.model import Array, Robot

_LOOKS = 160  # points between two crossings at which room is computed
_OUTWARDS = 48  # points of one step outwards from a crossing


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
class SingularParts:
    """The singular parts of one checked path, and its places by their number and by the clock.

    Attributes:
        check: the path.
        tool: places and poses of it.
    """

    check: PathCheck
    tool: JointToolPath

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

    def configurations(self, place: Array) -> Array:
        """(N, n) configurations of the path."""
        return self.path.at(*self.path.split(place))

    def time(self, place: Array | float) -> Array:
        """(N,) the clock at places."""
        return np.asarray(np.interp(place, np.arange(len(self.clock)), self.clock))

    def place_at(self, time: Array) -> Array:
        """(N,) places at times of the clock."""
        return np.asarray(np.interp(time, self.clock, np.arange(len(self.clock))))

    def spread(self, low: float, high: float, count: int) -> Array:
        """(count,) places between two, evenly along the joint path."""
        rows = np.arange(len(self.lengths))
        start, end = (float(np.interp(place, rows, self.lengths)) for place in (low, high))
        return np.asarray(np.clip(np.interp(np.linspace(start, end, count), self.lengths, rows), low, high))

    def size(self, off: tuple[float, float]) -> float:
        """A deviation as one number: lengths divided by the length scale."""
        return size_of_off(off, self.check.length_scale)

    def cores(self, clearance: float, deepest: float) -> tuple[list[Core], list[Core]]:
        """Parts to be lifted; and crossings to the other side, from which the path does not come back.

        Crossings of one family are paired with the next one where the part between them is the shallowest.

        Args:
            clearance: room that a core has nowhere [rad].
            deepest: room between two crossings that are paired, at most [rad].
        """
        bad = sorted(
            (stretch for stretch in self.check.stretches if stretch.verdict != FREE), key=lambda stretch: stretch.start
        )
        crossings = [stretch for stretch in bad if stretch.verdict == CROSSING]
        pairs, single = self._pairs(crossings, deepest)
        lifted = [(first, second) for first, second in pairs] + [
            (stretch, stretch) for stretch in bad if stretch.verdict != CROSSING
        ]
        near = self.check.options.min_distance
        lifted += [(stretch, stretch) for stretch in self.check.stretches
                   if stretch.verdict == FREE and stretch.closest.distance < near
                   and stretch.closest.distance > 1e-6]  # fmt: skip
        lifted_cores = [self._core(first, second, clearance) for first, second in lifted]
        return _merge_cores(lifted_cores), [self._core(stretch, stretch, clearance) for stretch in single]

    def _pairs(
        self, crossings: list[Stretch], deepest: float
    ) -> tuple[list[tuple[Stretch, Stretch]], list[Stretch]]:
        pairs, single = [], []
        for family in dict.fromkeys(crossing.family for crossing in crossings):
            left = [crossing for crossing in crossings if crossing.family == family]
            while len(left) > 1:
                depth = [self._depth(first, second) for first, second in pairwise(left)]
                k = int(np.argmin(depth))
                if depth[k] > deepest:
                    break
                pairs.append((left[k], left[k + 1]))
                del left[k : k + 2]
            single += left
        return pairs, sorted(single, key=lambda stretch: stretch.start)

    def _depth(self, first: Stretch, second: Stretch) -> float:
        """Largest room between two crossings."""
        low, high = first.closest.place.position - 1.0, second.closest.place.position - 1.0
        return float(self.tool.room(self.configurations(self.spread(low, high, _LOOKS))).max())

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

    def spot(self, core: Core) -> Spot:
        """Where a core is singular, or nearest to it."""
        return self.point(core.stretches[0].closest.place.position - 1.0)

    def point(self, place: float) -> Spot:
        """A place as a point of the path."""
        stretch, share = self.path.split(np.array([place]))
        return int(stretch[0]), float(share[0])


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
