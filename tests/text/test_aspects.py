"""How aspects are worded: what is proven, what is searched for, what is not decided."""

from __future__ import annotations

import pytest

from rankdrop.cli import main
from rankdrop.results.aspect_summary import CUSPIDAL, NOT_ASKED, NOT_CUSPIDAL, NOT_FOUND, AspectSummary
from rankdrop.text.aspects import aspects_and_verdict_cell, aspects_cell, aspects_line


def test_the_words_say_what_is_proven() -> None:
    lines = {
        AspectSummary(8, 8, True, NOT_CUSPIDAL): ("8", "The arm has 8 aspects (proven): it cannot change its posture"),
        AspectSummary(1, 1, True, NOT_ASKED): ("1", "The arm has 1 aspect (proven)."),
        AspectSummary(2, 8, True, None): ("2 … 8", "The arm has at least 2 aspects (proven) and at most 8 (proven)."),
        AspectSummary(2, 8, False, CUSPIDAL): ("≥ 2", "The arm has at least 2 aspects (proven): it can change its"),
        AspectSummary(None, None, False, None): ("–", "The aspects of the arm were not counted: rankdrop aspects says"),
    }
    for summary, (cell, line) in lines.items():
        assert aspects_cell(summary) == cell
        assert aspects_line(summary).startswith(line)
    assert aspects_cell(None) == "–"
    assert aspects_line(None) == ""


def test_a_cell_of_a_comparison_says_what_is_cuspidal_and_what_is_not_decided() -> None:
    cells = {CUSPIDAL: "2, cuspidal", NOT_FOUND: "2, undecided", NOT_CUSPIDAL: "2", NOT_ASKED: "2", None: "2"}
    for change, cell in cells.items():
        assert aspects_and_verdict_cell(AspectSummary(2, 2, True, change)) == cell


@pytest.mark.slow
def test_the_command_prints_the_number(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["analyze", "planar2r", "--starts", "50", "--quiet"]) == 0
    assert "The arm has 2 aspects (proven): it cannot change its posture" in capsys.readouterr().out
