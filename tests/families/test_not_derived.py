"""Why nothing was derived is a fact that has a sentence, and is read from it."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from rankdrop.codec import json_text
from rankdrop.families.derivation import NOT_DERIVED, Derivation
from rankdrop.families.not_derived import NotDerived, NotDerivedKind
from rankdrop.families.unfinished import Unfinished, UnfinishedKind
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import shipped


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
