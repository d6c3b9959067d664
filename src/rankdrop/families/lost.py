"""Motions that a family of singular configurations takes away, as facts: a direction, its frame, and where it holds.

Sentences are made of them in `rankdrop.text.lost`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from math import hypot

from rankdrop.local.directions import ENTRY_SHARE, NEARLY_SHARE, FramedDirections, lost_in_sparsest_frame
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Frame, Task
from rankdrop.units import counted_length, given_exponent, shift_decimal

_DECIMALS = 10


class MotionKind(StrEnum):
    """What a lost direction u = (v; ω) takes away.

    TRANSLATION and ROTATION: ω = 0, v = 0; that motion cannot be made. TIED: both parts are there, and translation and
    rotation are tied together by u · (v; ω) = 0.
    """

    TRANSLATION = "translation"
    ROTATION = "rotation"
    TIED = "tied"


@dataclass(frozen=True, slots=True)
class LostFreedom:
    """One freedom of the tool that a family takes away.

    Attributes:
        direction: u = (v; ω), a unit vector in `frame`: u · (vx vy vz ωx ωy ωz) = 0 for every twist the joints can
            make, `length` counted as 1 rad [1]; ten decimals, which are the same with every library of linear algebra.
        frame: axes and reference point [m].
        everywhere: whether u is the same, in this frame, on the whole family; else it is that of the witness.
        length: see `rankdrop.units.counted_length` [m].
    """

    direction: tuple[float, float, float, float, float, float]
    frame: Frame
    everywhere: bool
    length: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "direction", tuple(round(x, _DECIMALS) + 0.0 for x in self.direction))

    @property
    def kind(self) -> MotionKind:
        """Translation, rotation, or both tied together."""
        slide, turn = self._sizes
        if turn <= ENTRY_SHARE * slide:
            return MotionKind.TRANSLATION
        if slide <= ENTRY_SHARE * turn:
            return MotionKind.ROTATION
        return MotionKind.TIED

    @property
    def nearly(self) -> MotionKind:
        """As `kind`, where a part below `NEARLY_SHARE` of the whole counts as nothing."""
        slide, turn = self._sizes
        if min(slide, turn) > NEARLY_SHARE * hypot(slide, turn):
            return MotionKind.TIED
        if slide >= turn:
            return MotionKind.TRANSLATION
        return MotionKind.ROTATION

    @property
    def _sizes(self) -> tuple[float, float]:
        """|v| and |ω|."""
        return hypot(*self.direction[:3]), hypot(*self.direction[3:])

    def rescaled(self, power: int) -> LostFreedom:
        """The same of the arm with lengths 10 to a power as large in numbers: u is in `length`, and stays."""
        x, y, z = (shift_decimal(part, power) for part in self.frame.point)
        return replace(self, frame=replace(self.frame, point=(x, y, z)), length=shift_decimal(self.length, power))


def freedoms_of(robot: Robot, framed: FramedDirections, *, everywhere: bool) -> tuple[LostFreedom, ...]:
    """Directions seen in one frame as the freedoms that a family takes away, in the unit that the arm was given in.

    Args:
        robot: the arm, in any unit.
        framed: (k, 6) directions and their frame.
        everywhere: whether they are the same on the whole family.
    """
    x, y, z = (shift_decimal(part, given_exponent(robot)) for part in framed.frame.point)
    frame, length = replace(framed.frame, point=(x, y, z)), counted_length(robot)
    return tuple(LostFreedom(tuple(row), frame, everywhere, length) for row in framed.directions.tolist())


def freedoms_at_witness(robot: Robot, q: Array, task: Task, corank: int) -> tuple[LostFreedom, ...]:
    """The freedoms lost at one configuration, in the frame in which they have the fewest entries."""
    return freedoms_of(robot, lost_in_sparsest_frame(robot, q, task, corank), everywhere=False)
