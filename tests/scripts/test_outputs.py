"""The ground for refactoring: two records of the same code are equal, and whatever changes is told."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from known.arms import FEW

from scripts import tool

ARMS = ("planar2r", "planar3r")


RECORD, COMPARE = tool("record_outputs"), tool("compare_outputs")


@pytest.fixture
def records(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Path, Path]:
    """The same two arms recorded twice, `before` and `after`."""
    monkeypatch.setenv("COLUMNS", "100")  # set by the recorder, put back here
    monkeypatch.setenv("NO_COLOR", "1")
    for folder in ("before", "after"):
        for name in ARMS:
            RECORD.record((name, tmp_path / folder))
    return tmp_path / "before", tmp_path / "after"


@pytest.mark.by_hand
@pytest.mark.slow
@pytest.mark.shipped
def test_records_are_repeatable_and_a_change_is_told_by_its_kind(
    records: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    before, after = records
    paths = [str(path) for path in records]
    assert COMPARE.main(paths) == 0
    for label in ("analyze.txt", "conditions.json", "explain-k1.txt", "escape-k1.json", "nearest-regular.txt"):
        text = (after / ARMS[0] / label).read_text(encoding="utf-8")
        assert "internal error" not in text
        assert len(text) > 300
    capsys.readouterr()

    printed = after / ARMS[0] / "explain-k1.txt"
    text = printed.read_text(encoding="utf-8")
    printed.write_text(text.replace("--- exit code 4", "--- exit code 0").replace("is singular", "is regular"), "utf-8")
    assert printed.read_text(encoding="utf-8").count("regular") > text.count("regular")
    written = after / ARMS[1] / "find.json"
    found = json.loads(written.read_text(encoding="utf-8"))
    found["configurations"][0]["q"][0] += 1e-3
    written.write_text(json.dumps(found), encoding="utf-8")
    (after / ARMS[1] / "report.html").unlink()

    kinds = COMPARE.compare(before, after)
    assert ("explain-k1.txt", "--- exit code #") in kinds
    assert kinds["find.json", ".configurations[].q[]"].came == 1
    assert kinds["report.html", "(whole file)"].went == 1
    assert ("find.json", ".configurations[].q[]") not in COMPARE.compare(before, after, tolerance=1e-2)
    assert COMPARE.main(paths) == 1
    assert "kinds of difference" in capsys.readouterr().out


def test_the_few_that_are_asked_more_are_those_of_the_tests() -> None:
    assert RECORD.FEW == FEW
