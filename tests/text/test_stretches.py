"""How stretches of a path are worded."""

from __future__ import annotations

from types import SimpleNamespace

from rankdrop.path.curve import Place
from rankdrop.text.places import interval_words
from rankdrop.text.stretches import span_words


def place(position: float, pose: float | None = None) -> Place:
    return Place(int(position), position % 1.0, None, pose)


def test_a_stretch_within_one_row_names_it_once() -> None:
    short = SimpleNamespace(bracket=(place(38.999), place(39.001)))
    assert span_words(short) == "at row 39"
    assert span_words(SimpleNamespace(bracket=(place(38.5), place(39.25)))) == "rows 38.5 to 39.25"


def test_a_stretch_of_a_tool_path_names_poses() -> None:
    assert span_words(SimpleNamespace(bracket=(place(38.5, 1.25), place(39.25, 1.5)))) == "poses 1.25 to 1.5"
    assert span_words(SimpleNamespace(bracket=(place(38.999, 1.3), place(39.001, 1.3)))) == "at pose 1.3"
    assert interval_words(place(38.999), place(39.001)) == "at row 39"
    assert interval_words(place(38.5), place(39.25)) == "between rows 38.5 and 39.25"
