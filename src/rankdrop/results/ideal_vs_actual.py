"""An arm and the ideal arm near it, and what the arm itself does where the ideal one is singular."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rankdrop.codec import Record, plain
from rankdrop.local.block import generic_rank
from rankdrop.results.analysis import robot_to_dict
from rankdrop.robot.ideal import Tolerance
from rankdrop.robot.model import Robot
from rankdrop.robot.square_up import ExactChange
from rankdrop.sections import words_of
from rankdrop.task import Task


@dataclass(frozen=True, slots=True)
class Spread:
    """Smallest, median and largest of some numbers."""

    least: float
    median: float
    most: float


@dataclass(frozen=True, slots=True)
class Nearby:
    """The arm itself where one family of the ideal arm is.

    Attributes:
        id, name, corank: of the family.
        points: how many random points of it were looked at.
        number: counted from 1, of the largest singular value that vanishes for the ideal arm there: r − corank + 1.
        sigma: that singular value of the arm itself at these points [1].
        singular: at how many of them the arm itself has this corank, or more.
        searched: from how many of them its own nearest singular configuration, of any corank, was looked for.
        distance: to it, where it was found [rad; slides divided by the length scale]; None where none was.
    """

    id: str
    name: str
    corank: int
    points: int
    number: int
    sigma: Spread
    singular: int
    searched: int
    distance: Spread | None


@dataclass(frozen=True, slots=True)
class Here:
    """The arm itself, at one configuration and where the ideal arm is singular next to it.

    Attributes:
        number: counted from 1, of the largest singular value that vanishes for the ideal arm there.
        sigma: it, of the arm itself, at the configuration [1].
        distance: from there to where the ideal arm is singular [rad]; 0 where it is so here, None where none was found.
        q: (n,) that place [rad, m].
        there: the singular value of the arm itself there [1].
    """

    number: int
    sigma: float
    distance: float | None
    q: tuple[float, ...] | None
    there: float | None


@dataclass(frozen=True, eq=False)
class Idealised:
    """An arm and the ideal one near it.

    Attributes:
        real, ideal: the arm that was given, and the one of exact structure, whose notes say so.
        tolerance: it was made with.
        changes: what was moved, and by how much.
    """

    real: Robot
    ideal: Robot
    tolerance: Tolerance
    changes: tuple[ExactChange, ...]

    def to_dict(self, task: Task, nearby: Sequence[Nearby] = ()) -> Record:
        """Plain data: the entry "ideal" of docs/json.md.

        Args:
            task: with the length scale that σ was worked out with.
            nearby: from `nearby`.
        """
        moved = [
            {"name": change.name, **plain(change), "by": change.by, "text": change.text} for change in self.changes
        ]
        return {
            "tolerance": {"text": self.tolerance.text, **plain(self.tolerance)},
            "moved": moved,
            "real": robot_to_dict(self.real, task, generic_rank(self.real, task)),
            "families": plain(tuple(nearby)),
        }

    @property
    def moved(self) -> str:
        """One sentence: how much was moved, at most by how much."""
        moved: str = words_of(self).moved_sentence(self)
        return moved
