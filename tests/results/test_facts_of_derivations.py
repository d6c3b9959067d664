"""Remarks, contradictions and unfinished work of a derivation are facts: each has a sentence, and old ones are read."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from rankdrop.algebra.halt import Halt, HaltKind
from rankdrop.algebra.work import Work, halt_of
from rankdrop.codec import encode, json_text
from rankdrop.errors import ResultFileError
from rankdrop.exact.arm.geometry import Deviation
from rankdrop.exact.family import EqualLengths, Unreal, UnrealSet
from rankdrop.exact.remark import DerivationRemark, RemarkOn
from rankdrop.families.contradiction import TREE, Contradiction, ContradictionKind
from rankdrop.families.not_derived import NotDerived, NotDerivedKind
from rankdrop.families.record import AGREES, DIFFERS, NOT_DERIVED, Derivation
from rankdrop.families.unfinished import Phase, Unfinished, UnfinishedKind
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import shipped
from rankdrop.results.old_files import exact_from_dict, negative_of_sentence
from rankdrop.results.old_sentences import contradictions_of_sentences, remarks_of_sentences
from rankdrop.schema.families import UNREAL
from rankdrop.text.unfinished import halt_words

NEAR = Deviation("point", (4, 5, 6), 0.0125)
ELBOW = shipped("puma560").families[0].called
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


def test_every_fact_has_a_sentence_of_its_own() -> None:
    remarks = {str(DerivationRemark(kind, deviation=NEAR if kind is RemarkOn.NEAR else None)) for kind in RemarkOn
               if kind is not RemarkOn.ROUNDED}  # fmt: skip
    contradictions = {str(Contradiction(kind, "k1.f1", ELBOW, "cofactors", TREE)) for kind in ContradictionKind}
    unfinished = {
        str(Unfinished(kind, halt_of(KeyboardInterrupt()), Phase.STEPS, "cofactors", conditions="θ5 = 0"))
        for kind in UnfinishedKind
    }
    halts = {halt_words(Halt(kind, message="it")) for kind in HaltKind}
    kinds = (ContradictionKind, UnfinishedKind, HaltKind)
    assert [len(remarks) + 1, *map(len, (contradictions, unfinished, halts))] == [len(RemarkOn), *map(len, kinds)]


def test_what_contradicts_an_analysis_is_read_back_as_facts() -> None:
    """With the name of the family, which is facts too; a file without them has its sentences read."""
    found = shipped("puma560")
    said = (Contradiction(ContradictionKind.DIMENSION, "k1.f1", ELBOW, dimension=4),)
    exact = replace(_derivation(), status=DIFFERS, disagreements=said)
    record = json.loads(json_text(replace(found, exact=exact).to_dict()))
    assert record["exact"]["disagreements"] == [str(said[0])]
    assert Analysis.from_dict(record, believe=True).exact == exact
    del record["exact"]["contradictions"]
    (old,) = Analysis.from_dict(record, believe=True).exact.disagreements
    assert (old.kind, old.dimension, str(old)) == (ContradictionKind.DIMENSION, 4, str(said[0]))


def _derivation() -> Derivation:
    return Derivation(AGREES, "auto", 30.0, letters={"a2": 0.4}, shifts=(0.0,) * 6)


def test_a_limit_is_a_fact() -> None:
    work = Work(-1.0)
    with pytest.raises(Exception, match="limit on work") as met:
        work.check()
    assert halt_of(met.value) == Halt(HaltKind.WORK)
    assert halt_words(halt_of(ValueError("no"))) == "ValueError: no"


@pytest.mark.parametrize(
    ("reason", "words", "same"),
    [(NotDerived(NotDerivedKind.TIME, seconds=0.001), "the derivation takes more than 0.001 s", True),
     (NotDerived(NotDerivedKind.INTERRUPTED), "interrupted", True),
     (NotDerived(NotDerivedKind.UNDIVIDED, number=1), "1 case was not taken apart", True),
     (NotDerived(NotDerivedKind.ERROR, "ValueError", "no"), "ValueError: no", False),
     (NotDerived(NotDerivedKind.ERROR, message="no flint"), "no flint", False),
     (NotDerived(NotDerivedKind.UNFINISHED, unfinished=(Unfinished(UnfinishedKind.SUPPRESSION, number=3),) * 2),
      "suppression did not finish 3 of its cases; suppression did not finish 3 of its cases", False)],
)  # fmt: skip
def test_why_nothing_was_derived_is_a_fact_that_files_hold_in_words(
    reason: NotDerived, words: str, same: bool
) -> None:
    found = replace(shipped("puma560"), exact=Derivation(NOT_DERIVED, "auto", 30.0, reason))
    record = json.loads(json_text(found.to_dict()))
    assert record["exact"]["reason"] == words
    read = Analysis.from_dict(record, believe=True).exact
    assert read.interrupted == (words == "interrupted")
    assert (str(read.reason), read.reason == reason) == (words, same)


REAL = {"": (), "real if and only if a1 − a2 ≥ 0": ("a1 − a2",),
        "real if and only if a1 − a2 ≥ 0 and (d3 + d5) (d3 − d5) ≥ 0": ("a1 − a2", "(d3 + d5) (d3 − d5)")}  # fmt: skip


@pytest.mark.parametrize("sentence", REAL)
def test_when_a_family_is_real_is_read_from_its_sentence_and_said_again(sentence: str) -> None:
    exact = exact_from_dict({"conditions": ["s5 = 0"], "latex": ["s_5 = 0"], "pinned": [], "reality": sentence})
    assert exact.not_negative == REAL[sentence]
    assert exact.reality == sentence


def test_a_sentence_that_does_not_say_when_a_family_is_real_is_refused() -> None:
    with pytest.raises(ResultFileError, match="this does not say when a family is real"):
        exact_from_dict({"conditions": ["s5 = 0"], "latex": ["s_5 = 0"], "pinned": [], "reality": "real for a1 ≥ 0"})


@pytest.mark.parametrize(("negative", "words"), [("a1 − a2", "a1 − a2 ≥ 0 does not hold"),
                                                 ("", "a negative discriminant")])  # fmt: skip
def test_what_excludes_real_points_is_in_files_in_words(negative: str, words: str) -> None:
    unreal = UnrealSet("θ4 = 0", Unreal.PROVEN, negative=negative)
    assert str(unreal) == f"θ4 = 0: not real, for {words}"
    assert encode(UNREAL, unreal) == {"conditions": "θ4 = 0", "reason": "proven", "tried": 0, "proof": words}
    assert negative_of_sentence(words) == negative
