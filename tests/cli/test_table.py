"""The tables: what stands in them, and that they fit the window."""

from __future__ import annotations

import re

import pytest

from rankdrop.cli.analyze import corank_section
from rankdrop.cli.terminal import screen, show
from rankdrop.results.analysis import Analysis
from rankdrop.text.lost import lost_sentences


@pytest.fixture
def drawn(shapes: Analysis, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    """drawn(width): the tables of every corank as text."""

    def draw(width: int) -> str:
        monkeypatch.setenv("COLUMNS", str(width))
        console = screen()
        for summary in shapes.coranks:
            show(console, corank_section(console, shapes, summary))
        return capsys.readouterr().out

    return draw


@pytest.mark.parametrize("width", [30, 50, 66, 72, 80, 100, 120, 140, 200])
def test_no_line_is_wider_than_the_window_and_nothing_is_cut(drawn, shapes: Analysis, width: int) -> None:
    text = drawn(width)
    assert max(map(len, text.splitlines())) <= width
    assert "…" not in text
    words = set(re.findall(r"[^\s,;:]+", text))
    for row in shapes.families:
        assert set(re.findall(r"[^\s,;:]+", " ".join((row.name, *lost_sentences(row.lost_freedoms))))) <= words
    for value in ("π", "±π/2", "±0.7731", "(±44.30°)"):
        assert value in words


def test_no_line_ends_in_a_blank(drawn) -> None:
    assert not [line for line in drawn(100).splitlines() if line != line.rstrip()]


def test_lost_directions_stand_in_the_row_of_a_wide_window_only(drawn) -> None:
    assert "lost direction" in drawn(140)
    assert "lost direction" not in drawn(80)
    assert "lost cannot translate" in drawn(80)


def test_a_window_too_narrow_for_columns_gets_a_list(drawn) -> None:
    text = " ".join(drawn(50).split())
    assert "θ4 = 0, π; θ1, θ2, θ3, θ5, θ6, θ7 free" in text
    assert "θ2, θ3 coupled" in text


def test_a_corank_that_was_not_found_is_no_proof(drawn) -> None:
    text = " ".join(drawn(100).split())
    assert "Corank 2 (rank 4 of 6): none found of 10,000 starts, smallest σ5 found 0.3273" in text
    assert "Not finding one proves nothing" in text


def test_a_near_miss_is_not_called_singular(drawn) -> None:
    assert "1 near miss, 0 slow. Smallest near miss: σ6 = 0.0053, not singular." in " ".join(drawn(140).split())
