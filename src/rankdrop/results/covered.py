"""What `cover` returns: the boxes, what known families explain of them, and what may be said."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from rankdrop.codec import Result
from rankdrop.cover.covering import Covering
from rankdrop.cover.spots import UnexplainedBoxes
from rankdrop.families.record import Family
from rankdrop.proof.boxes import digest
from rankdrop.robot.model import Robot
from rankdrop.sections import Section, words_of
from rankdrop.task import Task


@dataclass(frozen=True, eq=False)
class Account:
    """The boxes of a covering beside known families.

    Attributes:
        families: the families asked.
        source: where they come from: "catalogue", "analysis", "made here".
        explained: (F,) boxes that each explains, the first that does.
        freed: boxes that no family explained and a closer look proved free.
        spots: what is left, in groups.
        diagonal: of a leaf; no singular configuration of an explained box is farther from a known family [rad].
    """

    families: tuple[Family, ...]
    source: str
    explained: NDArray[np.int64]
    freed: int
    spots: tuple[UnexplainedBoxes, ...]
    diagonal: float


@dataclass(frozen=True, eq=False)
class Covered(Result):
    """Every singular configuration, of the corank asked for or more, is in a box of `covering`.

    Attributes:
        robot, task: what was covered.
        covering: the boxes.
        account: what known families explain of them; None where that was not asked, or the covering is not complete.
    """

    robot: Robot
    task: Task
    covering: Covering
    account: Account | None
    FILE: ClassVar[str] = "cover"

    @property
    def complete(self) -> bool:
        """The whole joint space was covered."""
        return self.covering.complete

    @property
    def holds(self) -> bool:
        """Complete, and nothing but known families was found down to the width, where families were asked."""
        return self.complete and (self.account is None or not self.account.spots)

    @property
    def width(self) -> float:
        """The widest side of a leaf [rad; slides divided by the length scale]."""
        shape = self.covering.tree.shape
        sides = (np.array(self.covering.plan.upper) - self.covering.plan.lower) / shape.cells(shape.levels)
        turns = [self.robot.variables[j - 1].unit == "rad" for j in self.covering.plan.variables]
        return float(np.where(turns, sides, sides / self.task.scale(self.robot)).max())

    @property
    def sha256(self) -> str:
        """Hash of plan and boxes: the same for every way the covering was made; "" where it is not complete."""
        if self.complete:
            return digest(self.covering.plan, self.covering.tree)
        return ""

    @property
    def sentence(self) -> str:
        """What may be said, in one sentence."""
        sentence: str = words_of(self).cover_sentence(self)
        return sentence

    def sections(self, *, deg: bool = True) -> tuple[Section, ...]:
        """As sections of text; angles of places in degrees, or radians."""
        sections: tuple[Section, ...] = words_of(self).cover_sections(self, deg=deg)
        return sections
