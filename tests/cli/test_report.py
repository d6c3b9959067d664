"""The options of `rankdrop report`."""

from __future__ import annotations

from pathlib import Path

import pytest

from rankdrop.cli import main


@pytest.mark.parametrize(
    ("options", "part"),
    [
        (["--out", "nowhere/x.html"], "there is no such folder"),
        (["--out", "x.docx"], "the ending names no format"),
        (["--figure", "arm"], "figures are files"),
        (["--format", "png", "--out", "one.png"], "one file holds one figure"),
        (["--exact-seconds", "-1"], "at least 0"),
        (["--format", "gif"], "gif"),
    ],
)
def test_bad_options_are_one_line(
    options: list[str], part: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main.run(["report", "planar2r", *options]) == 2
    told = capsys.readouterr().err
    assert part in told
    assert len(told.strip().splitlines()) == 1
    assert not list(tmp_path.iterdir())
