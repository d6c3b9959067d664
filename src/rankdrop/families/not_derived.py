"""Why the families of an arm were not derived, as facts; `rankdrop.text.unfinished` has the words."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from rankdrop.families.contradiction import Contradiction
from rankdrop.families.unfinished import Unfinished
from rankdrop.sections import words_of


class NotDerivedKind(StrEnum):
    """What kept the families from being derived: an error, a limit, or work that was not finished."""

    ERROR = "error"
    TIME = "time limit"
    INTERRUPTED = "interrupted"
    UNDIVIDED = "undivided cases"
    UNFINISHED = "unfinished"
    STORED = "sentence of a file"


@dataclass(frozen=True)
class NotDerived:
    """Why the families of an arm were not derived.

    Attributes:
        kind: an error, a limit, or work that was not finished.
        error: class of an error that rankdrop does not raise on purpose, of the kind ERROR; else "".
        message: text of the error.
        seconds: the time limit, of the kind TIME [s].
        number: of cases that were not taken apart, of the kind UNDIVIDED.
        unfinished: what was not finished, and what contradicts an unfinished derivation, of the kind UNFINISHED.
        text: of the kind STORED, the sentence.
    """

    kind: NotDerivedKind
    error: str = ""
    message: str = ""
    seconds: float = 0.0
    number: int = 0
    unfinished: tuple[Unfinished | Contradiction, ...] = ()
    text: str = ""

    def __str__(self) -> str:
        """In words: "the derivation takes more than 30 s"."""
        words: str = words_of(self).not_derived_words(self)
        return words
