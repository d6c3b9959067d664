"""The estimate of what sampling has not seen, and the evidence of a family, read from sentences of files."""

from __future__ import annotations

import pytest

from rankdrop.families.corank_families import Estimator, Unseen
from rankdrop.families.evidence import ObtainedFrom
from rankdrop.families.searching import none_found, unseen
from rankdrop.results.estimate import evidence_of_sentence, unseen_of_sentence


@pytest.mark.parametrize(
    "result",
    [unseen([500, 300]), unseen([90, 1, 2, 0]), unseen([]), none_found(2000),
     Unseen(0.5, 0.7, Estimator.STORED, text="Good–Turing: 0 of 5 pieces found once in 10 points, by hand"),
     Unseen(0.5, 0.7, Estimator.STORED, text=f"none of {'9' * 5000} starts converged; rule of three on the starts")],
)  # fmt: skip
def test_a_file_that_has_the_estimate_in_words_is_read_as_counts(result: Unseen) -> None:
    assert unseen_of_sentence(result.how, result.estimate, result.upper) == result


@pytest.mark.parametrize(("sentence", "kind"), [
    ("exact condition", ObtainedFrom.EXACT), ("values verified", ObtainedFrom.VALUES),
    ("fitted, then verified", ObtainedFrom.FITTED), ("shared values, verified", ObtainedFrom.SHARED_VALUES),
    ("12 points of the cloud and 3 fresh ones, no condition found", ObtainedFrom.STORED),
])  # fmt: skip
def test_the_evidence_of_a_file_keeps_its_sentence(sentence: str, kind: ObtainedFrom) -> None:
    found = evidence_of_sentence(sentence)
    assert (found.kind, str(found)) == (kind, sentence)
