"""Which families does one corank have, and what did the search for them meet and perhaps miss?"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from math import inf

from rankdrop.families.record import Check, Family
from rankdrop.sections import words_of


class Estimator(StrEnum):
    """How the share of unseen sets was estimated: from the pieces of points, or where no start converged; or a sentence
    of a file that states neither."""

    NO_POINT = "no point"
    GOOD_TURING = "Good–Turing"
    NO_START = "no start"
    STORED = "old sentence"


@dataclass(frozen=True, slots=True)
class Unseen:
    """Share of the search's convergence mass that lies on sets without a point.

    Attributes:
        estimate: Good–Turing.
        upper: upper bound at 95 % confidence; where `once` is 0, or no start converged, by the rule of three.
        estimator: how both were estimated.
        once: number of pieces with one point.
        pieces: number of pieces with points.
        number: of points on these pieces; of starts where none converged.
        text: of the estimator STORED, the sentence.
    """

    estimate: float
    upper: float
    estimator: Estimator
    once: int = 0
    pieces: int = 0
    number: int = 0
    text: str = ""

    @property
    def how(self) -> str:
        """The estimator in words, with the counts it used."""
        how: str = words_of(self).unseen_words(self)
        return how


@dataclass(frozen=True, slots=True)
class CorankSummary:
    """What the search met at one corank.

    Attributes:
        corank, rank: corank k and the rank kept.
        starts, converged, near_misses, slow: of the cloud the families were made from.
        smallest_near_miss: smallest σ of a nonzero local minimum; None when there was none.
        completeness: fresh points of exactly this corank, and how many of them some named row explains.
        higher: fresh points whose corank is higher; they belong to the table of that corank and are not counted above.
        unseen: what sampling may have missed.
    """

    corank: int
    rank: int
    starts: int
    converged: int
    near_misses: int
    slow: int
    smallest_near_miss: float | None
    completeness: Check
    higher: int
    unseen: Unseen


@dataclass(frozen=True, slots=True)
class CorankFamilies:
    """All rows of one corank with their summary.

    Attributes:
        summary: what the search met.
        families: in their order.
        contradictions: derived families that points solved on them contradict, each with the largest dimension that the
            singular set can have there; None where no point of it is singular to its corank.
        mistaken: how many points the searches took for singular, σ being below its threshold, that are not.
        lowest: the smallest of the minima of σ next to these, worked out with 50 digits; inf where there are none.
    """

    summary: CorankSummary
    families: tuple[Family, ...]
    contradictions: tuple[tuple[Family, int | None], ...] = ()
    mistaken: int = 0
    lowest: float = inf
