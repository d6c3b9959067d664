"""What a derivation did not finish, as facts; `rankdrop.text.unfinished` has the words."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from rankdrop.algebra.halt import Halt
from rankdrop.sections import words_of


class Phase(StrEnum):
    """A phase of a derivation."""

    TREE = "tree"
    FAMILIES = "families"
    METHOD = "method"
    HIGHER = "higher coranks"
    STEPS = "steps"
    DETERMINANT = "determinant"
    POINTS = "points"
    UNDIVIDED = "undivided"
    CASES = "cases"
    ASSUMPTIONS = "assumptions"
    SPECIAL = "special"


class UnfinishedKind(StrEnum):
    """What was not finished: a phase, sets of the rank tree or their real points, or a method."""

    PHASE = "phase ended"
    NOT_RUN = "phase not run"
    SCREWS = "screws"
    RANK = "sets of a rank"
    SYSTEMS = "systems"
    UNSEARCHED = "sets not searched"
    STRAYS = "strays"
    DEPENDENT = "dependent conditions"
    REAL_POINTS = "real points"
    NO_POINTS = "sets without points"
    METHOD = "method ended"
    ZERO_LENGTHS = "zero of lengths"
    FACTORS = "factors"
    SUPPRESSION = "cases of suppression"
    NUMERIC = "numeric configurations"
    ASSUMPTION = "assumption"


@dataclass(frozen=True)
class Unfinished:
    """One thing that a derivation did not finish.

    Attributes:
        kind: what it is.
        halt: what ended it, where something did.
        phase: of the derivation, of the kinds PHASE and NOT_RUN.
        method: that did not finish, "" for the rank tree.
        corank: that was derived, or from which on nothing was tried.
        rank: below which, or of which, sets were looked for.
        number: of sets, systems, polynomials or cases.
        total: of which there are so many.
        conditions: of the set, or the assumption, or the lengths that are zero.
        letters: whether lengths are letters.
    """

    kind: UnfinishedKind
    halt: Halt | None = None
    phase: Phase | None = None
    method: str = ""
    corank: int = 1
    rank: int = 0
    number: int = 0
    total: int = 0
    conditions: str = ""
    letters: bool = False

    def __str__(self) -> str:
        """In words: "suppression did not finish 3 of its cases"."""
        words: str = words_of(self).unfinished_words(self)
        return words
