"""`python -m papers` on the command line."""

from __future__ import annotations

import json

import pytest

pytest.importorskip("flint")

from papers import __main__ as papers
from papers import run as reproduction
from papers.item import Sheet


@pytest.fixture
def command(capsys, monkeypatch):
    def once(*argv, width=100):
        monkeypatch.setenv("COLUMNS", str(width))
        code = papers.main(argv)
        printed = capsys.readouterr()
        return code, printed.out, printed.err

    return once


@pytest.mark.parametrize("width", [60, 80, 140])
def test_a_table_with_counts_and_reasons(command, width):
    code, out, _ = command("GR", "--quiet", width=width)
    assert code == 0
    assert max(map(len, out.splitlines())) <= width
    assert "7 erratum" in out
    assert "printed" in out
    assert "erratum: section 5, joints that lead out of the singularity:" in " ".join(out.split())


def test_json_on_stdout_and_nothing_else(command):
    code, out, _ = command("gr", "--json", "-", "--quiet")
    record = json.loads(out)
    assert code == 0
    assert record["documents"][0]["counts"]["differs"] == 0
    assert {"document", "item", "printed", "ours", "verdict", "reason"} <= record["items"][0].keys()


@pytest.mark.slow
def test_files_are_written(command, tmp_path):
    pytest.importorskip("matplotlib")
    page, data, folder = tmp_path / "page.md", tmp_path / "data.json", tmp_path / "figures"
    files = ("--json", str(data), "--markdown", str(page), "--figures", str(folder))
    code, out, _ = command("GR", "--quiet", *files)
    assert code == 0
    assert "GR" in out
    assert page.read_text().startswith("# The five documents, reproduced")
    assert len(json.loads(data.read_text())["items"]) > 30
    assert (folder / "GR-figure-2.svg").exists()


def test_an_item_that_differs_ends_with_3(command, monkeypatch):
    def part(sheet: Sheet) -> None:
        sheet.numbers("Table 1", "a number", "0.5", 0.9)

    monkeypatch.setattr(reproduction, "_sections", lambda name: [("made up", part)])
    code, out, _ = command("GR", "--quiet")
    assert code == 3
    assert "differs: Table 1" not in out, "there is no reason to tell"
    assert "1 differs" in out


def test_what_is_wrong_is_told_in_one_line(command, tmp_path):
    for argv, told in (
        (("XX",), "there is no such document"),
        (("JL", "--quiet", "--json", str(tmp_path / "no" / "a.json")), "a.json"),
        (("GR", "--figures", str(tmp_path / "no" / "folder")), "--figures"),
    ):
        code, _, err = command(*argv)
        assert code == 2
        assert told in err
        assert len(err.splitlines()) == 1


def test_ctrl_c_shows_what_was_done(command, monkeypatch):
    def first(sheet: Sheet) -> None:
        sheet.claim("section 1", "something", "so", "so", True)

    def second(sheet: Sheet) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(reproduction, "_sections", lambda name: [("a", first), ("b", second)])
    code, out, _ = command("GR", "--quiet")
    assert code == 130
    assert "1 agrees" in out
