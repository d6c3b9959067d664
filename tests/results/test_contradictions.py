"""What contradicts the derivation of an analysis is facts, in files too."""

from __future__ import annotations

import json
from dataclasses import replace

from rankdrop.codec import json_text
from rankdrop.families.contradiction import Contradiction, ContradictionKind
from rankdrop.families.derivation import AGREES, DIFFERS, Derivation
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import shipped

ELBOW = shipped("puma560").families[0].called


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
