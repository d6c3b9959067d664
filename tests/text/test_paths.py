"""Rows of a path in words: a count of nothing is no number."""

from __future__ import annotations

from types import SimpleNamespace

from rankdrop.text.paths import _verified_line


def test_no_enclosures_are_said_in_words() -> None:
    check = SimpleNamespace(source="catalogue", tool=None, evaluations=0)
    assert _verified_line(check) == "Verified: at its rows alone, without enclosures; families from the catalogue."
    check.evaluations = 1
    assert _verified_line(check) == "Verified: 1 enclosure covers it; families from the catalogue."
