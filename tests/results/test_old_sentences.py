"""Sentences of old files on remarks and contradictions are read as the facts that they word."""

from __future__ import annotations

import pytest

from rankdrop.exact.arm.geometry import Deviation
from rankdrop.exact.family import EqualLengths
from rankdrop.exact.remark import DerivationRemark, RemarkOn
from rankdrop.families.contradiction import Contradiction, ContradictionKind
from rankdrop.results.old_sentences import contradictions_of_sentences, remarks_of_sentences

NEAR = Deviation("point", (4, 5, 6), 0.0125)
READ = {
    DerivationRemark(RemarkOn.NEAR, deviation=NEAR): "the axes of joints 4, 5, 6 miss a common point by 12.5 mm",
    DerivationRemark(RemarkOn.ONE_LETTER, equal=(EqualLengths("d4", -1, "a2"), EqualLengths("d5", 1, "a3"))):
        "d4 = −a2, d5 = a3 for this arm: derived with one letter for both",
    DerivationRemark(RemarkOn.RULED_OUT, polynomial="a2 − d4"):
        "a2 − d4 = 0 for these lengths, which letters rule out: derived with numbers",
    DerivationRemark(RemarkOn.FOLLOWER, part="B", leader="A", column=2, factor=-1.0):
        "joint B follows joint A: column 2 of the Jacobian contains −1 times the screw of B",
    DerivationRemark(RemarkOn.NEAR_MISSES, corank=2, number=1200, followed=64, sigma=0.25):
        "corank 2: 1,200 configurations with a small σ on no family left out: 64 of them, spread over all their σ, "
        "followed with 50 digits, the rank does not drop there (smallest σ 0.25)",
    DerivationRemark(RemarkOn.UNDIVIDED_WITH_LETTERS, number=1):
        "lengths are numbers: with letters 1 system of conditions could not be taken apart",
    **{DerivationRemark(kind): "" for kind in (RemarkOn.DEPENDENT, RemarkOn.SEVERAL_FACTORS, RemarkOn.MISSED_BY_LETTERS,
                                               RemarkOn.LONGER_WITH_LETTERS, RemarkOn.NUMBERS_OF_VARIABLES)},
}  # fmt: skip
CONTRADICTED = {
    Contradiction(ContradictionKind.GENERIC_RANK, full_rank=3, rank=4):
        "the rank is 3 almost everywhere exactly, 4 numerically",
    Contradiction(ContradictionKind.RANK, "k1.f1", rank=3, wrong=2, tested=6):
        "k1.f1: the rank modulo a prime is not 3 at 2 of 6 random points",
    Contradiction(ContradictionKind.OFF_FAMILIES, corank=1, wrong=3, tested=1000, q=(0.5, -1.0)):
        "corank 1: 3 of 1,000 configurations found numerically lie on no family, q = (0.5, −1) is one",
}  # fmt: skip


@pytest.mark.parametrize("remark", READ, ids=lambda one: one.kind.name)
def test_a_remark_of_an_old_file_is_read_as_the_fact(remark: DerivationRemark) -> None:
    assert READ[remark] in ("", str(remark))
    assert remarks_of_sentences([str(remark)]) == (remark,)


@pytest.mark.parametrize("contradiction", CONTRADICTED, ids=lambda one: one.kind.name)
def test_a_contradiction_of_an_old_file_is_read_as_the_fact(contradiction: Contradiction) -> None:
    assert str(contradiction) == CONTRADICTED[contradiction]
    assert contradictions_of_sentences([str(contradiction)]) == (contradiction,)


@pytest.mark.parametrize("sentence", ["θ5 = 0 was asked for", "axes 2 and 3 are 1.23456° from parallel"])
def test_a_sentence_that_facts_word_otherwise_is_kept(sentence: str) -> None:
    """The second one has more digits than are printed: its fact would lose some."""
    (remark,), (contradiction,) = remarks_of_sentences([sentence]), contradictions_of_sentences([sentence])
    assert (remark.kind, str(remark)) == (RemarkOn.STORED, sentence)
    assert (contradiction.kind, str(contradiction)) == (ContradictionKind.STORED, sentence)
