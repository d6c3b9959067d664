"""The page of benchmarks: made in parts, and the figures told elsewhere are those of the newest one that has them."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
TABLES = sorted((ROOT / "benchmarks" / "results").glob("*.md"))
NUMBER = re.compile(r"(?<![\w.-])\d+(?:[  ]\d{3})*(?:\.\d+)?(?:e[+-]?\d+)?(?!\w|\.\d)")
TOLD = {
    "benchmarks/README.md": r"^\| `(\w+)\.py` \|[^|]*\|([^|]*)\|$",
    "docs/howto/control-loop.md": r"^(A step) takes (.*) of processor time .*`benchmarks/monitor\.py`.*$",
}
"""Where figures are told: a line with the script, and the part of it that has them."""


def numbers(text: str) -> list[str]:
    """As they are written; names of arms and libraries have none that stand alone."""
    return [found.replace(" ", "").replace(" ", "") for found in NUMBER.findall(text)]


def is_there(told: str, measured: list[float]) -> bool:
    """Whether a number that was measured rounds to the one that is told, to the digits told."""
    decimals = len(told.partition(".")[2])
    return any(abs(one - float(told)) <= 0.5 * 10.0**-decimals * (1 + 1e-9) for one in measured)


def parts(page: str) -> dict[str, str]:
    return {part.split("\n", 1)[0]: part for part in re.split(r"^### ", page, flags=re.MULTILINE)[1:]}


@pytest.mark.parametrize("document", TOLD)
def test_figures_told_are_those_of_the_newest_table(document: str) -> None:
    measured: dict[str, str] = {}
    for table in TABLES:
        measured |= parts(table.read_text(encoding="utf-8"))
    lines = re.findall(TOLD[document], (ROOT / document).read_text(encoding="utf-8"), flags=re.MULTILINE)
    checked = [("monitor" if name == "A step" else name, text) for name, text in lines]
    checked = [(name, text) for name, text in checked if name in measured]
    assert checked
    for name, text in checked:
        there = [float(one) for one in numbers(measured[name])]
        missing = [one for one in numbers(text) if not is_there(one, there)]
        assert not missing, f"{document}, {name}: {missing} are not in the newest table that has it"


def test_a_figure_that_was_not_measured_is_noticed() -> None:
    assert is_there("0.57", [0.5678])
    assert not is_there("0.58", [0.5678])
    assert numbers("PA-10 0.57 µs, 3 008 of 7R") == ["0.57", "3008"]


@pytest.mark.slow
def test_parts_of_one_day_are_kept(tmp_path: Path) -> None:
    """A run of one script replaces its own part; what else was measured that day stays as it was."""
    pages = [table.read_text(encoding="utf-8") for table in TABLES]
    old = next(text for text in reversed(pages) if "batches" in parts(text))
    page = tmp_path / "day.md"
    page.write_text(old, encoding="utf-8")
    command = [sys.executable, "-m", "benchmarks", "--quick", "--only", "batches", "--out", str(page)]
    subprocess.run(command, cwd=ROOT, capture_output=True, check=False)
    before, after = parts(old), parts(page.read_text(encoding="utf-8"))
    assert len(before) > 1
    assert after["batches"] != before["batches"]
    assert list(after) == list(before)
    same = {name: re.sub(r"\s*## \w+\s*$", "", text).strip() for name, text in before.items() if name != "batches"}
    assert {name: re.sub(r"\s*## \w+\s*$", "", text).strip() for name, text in after.items() if name in same} == same
