"""docs/arms.md is true: its rows are those of the shipped results, and of the makers' files analysed now.

The 98 files of `data/arms` anew: `pytest -m slow tests/known/test_arms_page.py` (a quarter of an hour); one by default.
"""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest
from scripts import tool

from rankdrop.results import known as shelf
from rankdrop.results.known import shipped
from rankdrop.robot.open import robot_names

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "arms.md"
QUICK = ("m1509_blue",)
AT_LEAST = 94
"""Of the makers' files so many end with exit code 0 from both commands."""
LONGEST = 20.0
"""CPU seconds that one command may take for one of them."""
LONG = ("fetch", "frankie", "tiago")
"""Eight to ten joints, with a lift or a mobile base."""


TOOL = tool("make_arms_page")
NAMES = [one["name"] for one in TOOL.skeletons()]
ANEW = [pytest.param(name, marks=() if name in QUICK else pytest.mark.by_hand) for name in NAMES]


@cache
def rows(heading: str) -> dict[str, list[str]]:
    """The cells of a table of the page, by the name of the arm."""
    assert PAGE.is_file(), "docs/arms.md is missing: run `python tools/make_arms_page.py`"
    lines = PAGE.read_text(encoding="utf-8").partition(f"## {heading}\n")[2].partition("\n## ")[0].splitlines()
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| `")]
    return {row[0].strip("`"): row for row in cells}


def catalogue() -> dict[str, list[str]]:
    """The table of the arms that have a name."""
    return rows("The catalogue")


def files() -> dict[str, list[str]]:
    """The table of the arms of `data/arms`."""
    return rows("Arms from their makers' files")


def codes(row: list[str]) -> tuple[int, int]:
    """The exit codes that a row tells: 0 and 0 where it is silent."""
    found = re.search(r"exit codes (\d+), (\d+): (.+)", row[4])
    if found is None:
        return 0, 0
    assert len(found[3]) > 10, "an arm that does not end well is listed with its reason"
    return int(found[1]), int(found[2])


def test_the_page_has_every_arm() -> None:
    assert tuple(catalogue()) == robot_names()
    assert list(files()) == NAMES
    assert len(NAMES) == 98


@pytest.mark.slow
def test_a_row_of_the_catalogue_is_what_is_shipped() -> None:
    for name, row in catalogue().items():
        found = shipped(name)
        assert row[2:4] == [TOOL.families_per_corank(found), TOOL.explained(found)], name
        assert codes(row)[0] == 0, f"{name}: an analysis that is not verified is not shipped"
        assert (name in shelf.conditions_names()) == (codes(row)[1] == 0), name


def test_a_row_of_the_catalogue_has_the_stored_number_of_aspects() -> None:
    for name, row in catalogue().items():
        assert len(row) == len(TOOL.ASPECTS_HEADS)
        assert row[5] == TOOL.aspects_of_row(name), name
    assert catalogue()["crx10ial"][5] == "2 c"


@pytest.mark.by_hand
@pytest.mark.shipped
def test_a_row_names_letters_or_numbers_as_they_are_shipped() -> None:
    for name in shelf.conditions_names():
        derived = shelf.shipped_conditions(name)
        assert catalogue()[name][4].startswith("letters" if derived.letters else "numbers"), name


def test_nearly_all_of_the_makers_files_end_well_and_the_others_say_why() -> None:
    fine = [name for name, row in files().items() if codes(row) == (0, 0)]
    assert len(fine) >= AT_LEAST
    assert f"{len(fine)} of {len(files())} end with exit code 0 from both commands" in PAGE.read_text(encoding="utf-8")


@pytest.mark.by_hand
@pytest.mark.slow_at("m1509_blue")
@pytest.mark.parametrize("name", ANEW)
def test_a_makers_file_fares_as_its_row_says(name: str) -> None:
    row = TOOL.skeleton_row(name)
    assert list(row.cells()) == files()[name]
    assert (row.analyze_exit, row.conditions_exit) == codes(files()[name])
    assert max(row.analyze_cpu, row.conditions_cpu) < LONGEST or name in LONG
