"""How stretches of a path are worded."""

from __future__ import annotations

from types import SimpleNamespace

from rankdrop.text.places import interval_words
from rankdrop.text.stretches import span_words


def place(position: float) -> SimpleNamespace:
    return SimpleNamespace(row=int(position), share=position % 1.0, position=position, time=None)


def test_a_stretch_within_one_row_names_it_once() -> None:
    short = SimpleNamespace(bracket=(place(38.999), place(39.001)))
    assert span_words(short) == "at row 39"
    assert span_words(SimpleNamespace(bracket=(place(38.5), place(39.25)))) == "rows 38.5 to 39.25"
    assert interval_words(place(38.999), place(39.001)) == "at row 39"
    assert interval_words(place(38.5), place(39.25)) == "between rows 38.5 and 39.25"
