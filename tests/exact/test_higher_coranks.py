"""Coranks above 1 by reciprocal screws, as `conditions` derives them beside the rank tree; faults are found."""

from __future__ import annotations

import pytest
from exact.derived import derived

from rankdrop.algebra.halt import Halt, HaltKind
from rankdrop.exact import higher_coranks
from rankdrop.exact.conjunctions import SetDerivation


@pytest.mark.slow
def test_higher_coranks_are_derived_by_reciprocity_and_agree_with_the_tree() -> None:
    found = derived("puma560", steps=True)
    assert found.verified
    assert [step.title for step in found.steps] == ["Method: reciprocity", "Method: reciprocity, corank 2"]
    assert "coranks 1 and 2 derived twice: rank tree and the reciprocity method agree" in str(found)


def test_one_corank_is_derived_as_before() -> None:
    found = derived("scara", 1, steps=True)
    assert [step.title for step in found.steps] == ["Method: reciprocity"]
    assert "corank 1 derived twice: rank tree and the reciprocity method agree" in str(found)


def test_what_is_not_finished_of_a_higher_corank_is_stated(monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(*given, corank: int, **options) -> SetDerivation:
        found = SetDerivation(given[0], "reciprocity", 1.0, corank=corank)
        found.halt(Halt(HaltKind.EXCEPTIONAL_CASES, number=7))
        return found

    monkeypatch.setattr(higher_coranks, "derive", stopped)
    found = derived("scara")
    assert "reciprocity, corank 2: 7 exceptional cases" in map(str, found.left)
    assert found.verdict.word == "incomplete"
