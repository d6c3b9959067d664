"""Coranks above 1 by reciprocal screws, compared with the rank tree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rankdrop.algebra.work import Work
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.conjunctions import SetDerivation
from rankdrop.exact.methods import derive
from rankdrop.exact.tree import RankTree
from rankdrop.families.contradiction import Contradiction, ContradictionKind
from rankdrop.families.record import Check
from rankdrop.families.unfinished import Unfinished
from rankdrop.lists import flat_map

UNTRIED = Check(0, 0)
"""Nothing was tried."""


@dataclass(frozen=True)
class HigherCorank:
    """A derivation of one corank above 1, and how it compares with what was derived and found otherwise.

    Attributes:
        derived: by reciprocal screws.
        sets: of the rank tree, at random points of which modulo a prime the conditions were tried: those of this
            corank or more have to satisfy them, the others not.
        singular: configurations of this corank found numerically, and how many satisfy the conditions.
        regular: configurations of a lower corank, and how many satisfy none.
    """

    derived: SetDerivation
    sets: Check = UNTRIED
    singular: Check = UNTRIED
    regular: Check = UNTRIED

    @property
    def corank(self) -> int:
        """k: the rank is lower by k or more."""
        return self.derived.corank


def higher_coranks(
    chain: Chain,
    highest: int,
    tree: RankTree,
    work: Work,
    *,
    basic: tuple[int, ...] | None = None,
    frame: int | None = None,
) -> tuple[HigherCorank, ...]:
    """Derive the coranks 2 to `highest`, up to the first one that no configuration has.

    Args:
        chain: the arm.
        highest: corank that was asked for.
        tree: of the arm.
        work: deadline.
        basic, frame: as for `derive`.
    """
    coranks: list[HigherCorank] = []
    for corank in range(2, min(highest, tree.generic_rank) + 1):
        derived = derive(chain, "reciprocity", max(work.remaining, 0.1), frame=frame, basic=basic, corank=corank)
        if derived.complete:
            coranks.append(HigherCorank(derived, _on_sets(derived, tree)))
        else:
            coranks.append(HigherCorank(derived))
        if not derived.conditions:
            break
    return tuple(coranks)


def _on_sets(derived: SetDerivation, tree: RankTree) -> Check:
    """On how many sets of the tree the conditions of a finished derivation are right."""
    limit = tree.generic_rank - derived.corank
    right = 0
    for drop in tree.drops:
        wanted = drop.rank <= limit
        right += all(derived.holds_at(point) == wanted for point in drop.piece.samples)
    return Check(len(tree.drops), right)


def unfinished_coranks(higher: Sequence[HigherCorank]) -> list[Unfinished]:
    """What was not finished of coranks above 1."""
    return flat_map(lambda corank: corank.derived.left, higher)


def wrong_coranks(higher: Sequence[HigherCorank]) -> list[Contradiction]:
    """Coranks above 1 with conditions that the rank tree or numeric configurations contradict."""
    contradictions = []
    for corank in higher:
        compared = (
            (ContradictionKind.HIGHER_SETS, corank.sets),
            (ContradictionKind.HIGHER_SINGULAR, corank.singular),
            (ContradictionKind.HIGHER_REGULAR, corank.regular),
        )
        for kind, check in compared:
            wrong = check.tested - check.agree
            if wrong:
                contradictions.append(
                    Contradiction(kind, method="reciprocity", corank=corank.corank, wrong=wrong, tested=check.tested)
                )
    return contradictions
