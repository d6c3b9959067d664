"""Contradictions, remarks and unfinished work of a derivation are facts: each kind has a sentence of its own."""

from __future__ import annotations

from rankdrop.algebra.halt import Halt, HaltKind
from rankdrop.algebra.work import halt_of
from rankdrop.exact.arm.geometry import Deviation
from rankdrop.exact.remark import DerivationRemark, RemarkOn
from rankdrop.families.contradiction import TREE, Contradiction, ContradictionKind
from rankdrop.families.unfinished import Phase, Unfinished, UnfinishedKind
from rankdrop.results.known import shipped
from rankdrop.text.unfinished import halt_words

NEAR = Deviation("point", (4, 5, 6), 0.0125)
ELBOW = shipped("puma560").families[0].called


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
