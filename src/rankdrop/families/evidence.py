"""How the conditions of a family were obtained, as facts; `rankdrop.text.family` has the words."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from rankdrop.sections import words_of


class ObtainedFrom(StrEnum):
    """What the conditions of a family were obtained from."""

    EXACT = "exact"
    VALUES = "values"
    FITTED = "fitted"
    SHARED_VALUES = "shared-values"
    CLOUD = "cloud"
    NEIGHBOURS = "neighbours"
    FULL_RANK = "full-rank"
    UNCLEAR_RANK = "unclear-rank"
    MEETING = "meeting"
    STORED = "stored"


@dataclass(frozen=True)
class FamilyEvidence:
    """How the conditions of a family were obtained.

    Attributes:
        kind: from what.
        neighbours: singular configurations around the given one with the same tangent shape.
        cloud: points of the search on a family without a condition.
        fresh: points of the tests on it.
        clear_rank: D has a clear rank at them; without it the dimension is an upper bound.
        parts: of the families that meet.
        text: of the kind STORED, the sentence.
    """

    kind: ObtainedFrom
    neighbours: int = 0
    cloud: int = 0
    fresh: int = 0
    clear_rank: bool = True
    parts: tuple[FamilyEvidence, ...] = ()
    text: str = ""

    def __str__(self) -> str:
        """In words: "fitted, then verified"."""
        words: str = words_of(self).evidence_words(self)
        return words
