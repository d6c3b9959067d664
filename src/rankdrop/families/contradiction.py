"""What two methods, or a derivation and a test of it, find differently, as facts.

`rankdrop.text.contradictions` has the words.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from rankdrop.families.name import FamilyName
from rankdrop.sections import words_of

TREE = "tree"
"""The rank tree, as a method."""


class ContradictionKind(StrEnum):
    """What does not agree: sets or conditions of two methods, ranks, or a derived family and points."""

    SETS = "sets"
    WITNESS = "witness"
    REGULAR = "regular configurations"
    HIGHER_SETS = "higher corank: sets"
    HIGHER_SINGULAR = "higher corank: singular"
    HIGHER_REGULAR = "higher corank: regular"
    RANK = "rank of a family"
    NOT_SINGULAR = "family not singular"
    CASE_NOT_SINGULAR = "case not singular"
    OFF_FAMILIES = "off families"
    GENERIC_RANK = "rank almost everywhere"
    NOT_LISTED = "family not listed"
    NO_POINT = "family without a point"
    DIMENSION = "dimension of a family"
    STORED = "old sentence"


@dataclass(frozen=True)
class Contradiction:
    """One result that another one contradicts.

    Attributes:
        kind: what does not agree.
        family: id of the family, or number of the case; "" where it is about none.
        called: name of the family, where the words have it.
        method: by which more, or less, is singular.
        other: the method that it is compared with.
        corank: of the family or of the configurations.
        rank: at the configuration `q`; of a family by its derivation; found numerically.
        full_rank: at almost every configuration.
        number: of sets; of the singular value, from 1.
        wrong: sets or configurations that contradict it.
        tested: sets or configurations that were tried.
        dimension: the largest that points allow.
        q: one configuration [rad, m]; () where there is none.
        text: of the kind STORED, the sentence.
    """

    kind: ContradictionKind
    family: str = ""
    called: FamilyName | None = None
    method: str = ""
    other: str = ""
    corank: int = 0
    rank: int = 0
    full_rank: int = 0
    number: int = 0
    wrong: int = 0
    tested: int = 0
    dimension: int = 0
    q: tuple[float, ...] = ()
    text: str = ""

    def __str__(self) -> str:
        """In words: "the rank is 3 almost everywhere exactly, 4 numerically"."""
        words: str = words_of(self).contradiction_words(self)
        return words
