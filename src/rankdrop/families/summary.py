"""What an arm has, as facts: how many families of each rank, their names, and which are combinations of others.

A family is a combination where its witness lies on two or more families of the smallest corank. Whether it lies on one
is read off the equations: at witnesses of the catalogue's arms they are below 1e-8 of their coefficients, or above
1e-3.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

import numpy as np

from rankdrop.families.name import FamilyName
from rankdrop.formula.equation import Equation

_ON = 1e-6  # |f| / Σ|coefficients| up to which a witness lies on a family: the gap is from 1e-8 to 1e-3

VERIFIED, UNCHECKED, CONTRADICTED, UNSOUND, INCOMPLETE, INEXACT, INTERRUPTED = (
    "verified", "unchecked", "contradicted", "unsound", "incomplete", "not exact", "interrupted",
)  # fmt: skip


class Evidence(StrEnum):
    """How the families of an arm were verified."""

    DERIVED_AND_TESTED = "derived and tested"
    DERIVED = "derived"
    TESTED = "tested"
    NONE = "none"


class Summarised(Protocol):
    """What a summary needs to know about a family."""

    @property
    def called(self) -> FamilyName:
        """Its name."""

    @property
    def corank(self) -> int:
        """Rank lost on the family."""

    @property
    def witness(self) -> tuple[float, ...]:
        """A configuration on it, of exactly this corank [rad, m]."""

    @property
    def equations(self) -> tuple[Equation, ...]:
        """Every condition; empty where they are not known."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """What may be claimed.

    Attributes:
        word: "verified"; "unchecked", derived completely and tried on nothing; "contradicted", two ways differ;
            "unsound", a row's conditions hold elsewhere too; "incomplete"; "not exact", the condition that was asked
            about; "interrupted".
        claims: of "sampled" and "derived exactly", what was done and holds.
        sentence: for people.
    """

    word: str
    claims: tuple[str, ...]
    sentence: str

    @property
    def holds(self) -> bool:
        """Whether nothing speaks against what is claimed: exit code 0."""
        return self.word in (VERIFIED, UNCHECKED)

    def headlines(self, answer: str) -> tuple[str, str]:
        """An answer and how sure it is; the other way round where something speaks against it."""
        if self.holds:
            return (answer, self.sentence)
        return (self.sentence, answer)

    def to_dict(self) -> dict[str, object]:
        """The entries of a JSON file."""
        return {"verdict": self.word, "claims": list(self.claims), "sentence": self.sentence}


@dataclass(frozen=True, slots=True)
class RankSummary:
    """The families of one rank.

    Attributes:
        rank: of the task Jacobian on them.
        corank: generic rank minus rank.
        families: how many there are.
        combinations: how many of these lie on two or more families of the smallest corank.
        names: short name -> number of families that have it, in the order of the families.
    """

    rank: int
    corank: int
    families: int
    combinations: int
    names: dict[str, int]


@dataclass(frozen=True, slots=True)
class FamilySummary:
    """What an arm has.

    Attributes:
        arm: its name.
        generic_rank: rank of the task Jacobian almost everywhere.
        ranks: one entry per rank that has families, the highest rank first.
        evidence: how the families were verified.
        tests: random singular configurations that were compared with the families.
    """

    arm: str
    generic_rank: int
    ranks: tuple[RankSummary, ...]
    evidence: Evidence = Evidence.NONE
    tests: int = 0

    @property
    def families(self) -> int:
        """Number of families of every rank."""
        return sum(rank.families for rank in self.ranks)


def summarise_families(
    arm: str, generic_rank: int, families: Sequence[Summarised], evidence: Evidence = Evidence.NONE, tests: int = 0,
    label: Callable[[Summarised], str] | None = None,
) -> FamilySummary:  # fmt: skip
    """Count the families of an arm by rank.

    Args:
        arm: name.
        generic_rank: rank of the task Jacobian almost everywhere.
        families: of every corank, in their order.
        evidence, tests: how they were verified.
        label: a family of the highest rank in a word or two; None: its short name.

    Example:
        >>> from rankdrop.results.known import shipped
        >>> known = shipped("ur5e")
        >>> found = summarise_families("ur5e", 6, known.families)
        >>> [(one.rank, one.families, one.combinations) for one in found.ranks]
        [(5, 3, 0), (4, 5, 5), (3, 1, 1)]
        >>> list(found.ranks[0].names)
        ['shoulder', 'elbow', 'wrist']
    """
    coranks = sorted({family.corank for family in families})
    first = [family for family in families if family.corank == coranks[0]]
    ranks = []
    for corank in coranks:
        mine = [family for family in families if family.corank == corank]
        names: dict[str, int] = {}
        for family in mine:
            if label is None or corank > coranks[0]:
                name = family.called.short
            else:
                name = label(family)
            names[name] = names.get(name, 0) + 1
        if corank == coranks[0]:
            combined = 0
        else:
            combined = sum(_is_combination(family, first) for family in mine)
        ranks.append(RankSummary(generic_rank - corank, corank, len(mine), combined, names))
    return FamilySummary(arm, generic_rank, tuple(ranks), evidence, tests)


def _is_combination(family: Summarised, first: Sequence[Summarised]) -> bool:
    q = np.array(family.witness)
    return sum(bool(family.equations) and all(_vanishes(f, q) for f in family.equations) for family in first) >= 2


def _vanishes(equation: Equation, q: np.ndarray[tuple[int], np.dtype[np.float64]]) -> bool:
    scale = sum(abs(term.coefficient) for term in equation.terms)
    return abs(float(equation(q))) <= _ON * scale
