"""What `rankdrop analyze` prints."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from rankdrop.cli.analyze import corank_section
from rankdrop.cli.terminal import screen, show
from rankdrop.families.evidence import FamilyEvidence, ObtainedFrom
from rankdrop.results.analysis import Analysis


def test_of_very_many_rows_three_are_shown_and_the_others_counted_by_their_kind(
    shapes: Analysis, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    one = shapes.families[1]
    console = screen()
    for count, told in ((24, 24), (30, 3)):
        shares = [replace(one.explained, agree=number) for number in range(count)]
        rows = tuple(
            replace(one, id=f"k1.f{i}", evidence=FamilyEvidence(ObtainedFrom.STORED, text="made up"), explained=share)
            for i, share in enumerate(shares)
        )
        show(console, corank_section(console, replace(shapes, families=rows), shapes.coranks[0]))
        text = capsys.readouterr().out
        shown = re.findall(r"^ *(\d+) +" + re.escape(one.name[:8]), text, re.MULTILINE)
        assert len(shown) == told
        assert ("and 27 more rows, all passed their test: 27 with" in " ".join(text.split())) == (count == 30)
    assert shown == ["28", "29", "30"], "those with the largest shares"
