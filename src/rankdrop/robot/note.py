"""Notes for the reader of a robot description, as facts: choices that were made, things that were tolerated.

`rankdrop.text.robots` has the words.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from math import inf

from rankdrop.sections import words_of


class NoteOn(StrEnum):
    """What a note is about."""

    BASE = "base-chosen"
    TIP = "tip-chosen"
    LEFT_OUT = "joint-left-out"
    NO_LIMITS = "no-limits"
    NO_AXIS = "no-axis"
    ONE_LIMIT = "limit-missing"
    NO_LIMIT = "infinite-limit"
    NO_RATE = "zero-velocity"
    FOLLOWS = "mimic"
    FOLLOWS_OUTSIDE = "mimic-leader-outside"
    FOLLOWS_TOGETHER = "mimic-leader-shared"
    COUPLED = "joints-coupled"
    FLOATS = "floating-body"
    TURNS = "limits-many-turns"
    TURNS_WITHOUT_UNITS = "limits-many-turns-no-units"
    FIXED_TURNS = "fixed-angle-many-turns"
    SQUARED = "numbers-made-exact"
    IDEAL = "ideal-arm"
    NO_HOME = "no-home-pose"
    SCREW_LINES = "screw-lines"
    DH_TEXT = "dh-table-in-text"
    SLIDES = "joint-slides"
    NOT_PLACED = "tool-or-base-not-read"
    SIZE = "reach-in-millimetres"
    PACKAGE = "package-found"
    NO_PACKAGE = "package-missing"
    GIVEN = "given-text"


@dataclass(frozen=True)
class Moved:
    """How many numbers were moved, and at most by how much [rad or m]."""

    number: int = 0
    most: float = 0.0


@dataclass(frozen=True)
class RobotNote:
    """One note on how a robot description was read.

    Attributes:
        kind: what it is about.
        name: of the link, joint, body or package that it is about.
        other: name of the joint that it follows or is coupled to, of the link that is missing; folder of a package.
        instead: joint of the chain that follows the same one, and is followed in its place.
        end: which link of the joint is missing ("parent", "child"), which limit ("lower", "upper", "velocity").
        value: of the limit, the fixed angle or the reach [rad, m, rad/s, m/s].
        limits: lower and upper one [rad].
        number: of moving joints on the way to the tip.
        fixed: links fixed to the tip.
        gripper: joints of the gripper after the tip, which are left out.
        rounded: angles that were read as multiples of 15°, of which the file has rounded decimals.
        turned, moved: angles and lengths that were changed.
        within: tolerance of an ideal arm, as it was given.
        text: of the kind GIVEN, what the description says.
    """

    kind: NoteOn
    name: str = ""
    other: str = ""
    instead: str = ""
    end: str = ""
    value: float = 0.0
    limits: tuple[float, float] = (-inf, inf)
    number: int = 0
    fixed: tuple[str, ...] = ()
    gripper: tuple[str, ...] = ()
    rounded: Moved = Moved()
    turned: Moved = Moved()
    moved: Moved = Moved()
    within: str = ""
    text: str = ""

    def __str__(self) -> str:
        """In words: "base 'base_link' chosen: the root link"."""
        words: str = words_of(self).robot_note_words(self)
        return words


def as_note(given: RobotNote | str) -> RobotNote:
    """A note, or a text that somebody gave as one."""
    if isinstance(given, RobotNote):
        return given
    return RobotNote(NoteOn.GIVEN, text=given)
