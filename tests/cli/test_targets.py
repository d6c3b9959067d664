"""Files of results are refused before the work, each with what is wrong and how to mend it."""

from __future__ import annotations

from pathlib import Path

import pytest

from rankdrop.cli.targets import check_target, check_targets, write
from rankdrop.errors import OptionError


@pytest.mark.parametrize(("name", "said"), [
    ("--json", "needs the name of a file"), ("a.txt", "the ending names no format"),
    ("none/a.json", "there is no such folder"), ("folder.json", "it is a folder"),
])  # fmt: skip
def test_a_file_that_cannot_be_written_is_refused(
    name: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.json").mkdir()
    with pytest.raises(OptionError, match=said):
        check_target(name, "--json", (".json", "-"))


def test_two_results_are_not_written_to_one_file(tmp_path: Path) -> None:
    file = str(tmp_path / "a.json")
    with pytest.raises(OptionError, match="it is the file of --json as well"):
        check_targets({"--json": file, "--out": file})
    with pytest.raises(OptionError, match="stdout is taken by --json"):
        check_targets({"--json": "-", "--latex": "-"})
    check_targets({"--json": file, "--out": None, "--latex": "-"})


def test_what_is_written_is_the_content(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for content, expected in ((b"\x00\x01", b"\x00\x01"), ("θ\n", "θ\n".encode())):
        write(content, str(tmp_path / "file"))
        assert (tmp_path / "file").read_bytes() == expected
    write({"rank": 5}, "-")
    assert '"rank": 5' in capsys.readouterr().out
