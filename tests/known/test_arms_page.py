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
from rankdrop.results.stored_conditions import shipped_conditions
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
CATALOGUE, FILES = "The catalogue", "Arms from their makers' files"
"""Headings of the page."""

TOOL = tool("make_arms_page")
NAMES = [one["name"] for one in TOOL.skeletons()]
ANEW = [pytest.param(name, marks=() if name in QUICK else pytest.mark.by_hand) for name in NAMES]


@cache
def part(heading: str) -> str:
    """A part of the page."""
    assert PAGE.is_file(), "docs/arms.md is missing: run `python tools/make_arms_page.py`"
    return PAGE.read_text(encoding="utf-8").partition(f"## {heading}\n")[2].partition("\n## ")[0]


def arms_of(heading: str) -> dict[str, tuple[str, str]]:
    """Arm -> the first two cells of its row."""
    lines = re.findall(r"^\| (.*) \| (.*) \| (`.*`) \|$", part(heading), re.MULTILINE)
    return {name: (one, other) for one, other, arms in lines for name in re.findall(r"`(\w+)`", arms)}


@cache
def catalogue() -> dict[str, tuple[str, str]]:
    """Arm -> (families per corank, aspects), of the arms that have a name."""
    return arms_of(CATALOGUE)


@cache
def files() -> dict[str, tuple[str, str]]:
    """Arm -> (joints, families per corank), of the arms of `data/arms`."""
    return arms_of(FILES)


@cache
def remarks(heading: str) -> dict[str, dict[str, str]]:
    """Arm -> what the lists of exceptions have of it."""
    found: dict[str, dict[str, str]] = {}
    for kind, text, arms in re.findall(r"^- (\w+): (.+?): (`.*`)$", part(heading), re.MULTILINE):
        for name in re.findall(r"`(\w+)`", arms):
            found.setdefault(name, {})[kind] = text
    return found


def codes(heading: str, name: str) -> tuple[int, int]:
    """The exit codes that the page has of an arm: 0 and 0 where it has none."""
    found = re.search(r"exit codes (\d+), (\d+): (.+)", remarks(heading).get(name, {}).get("exact", ""))
    if found is None:
        return 0, 0
    assert len(found[3]) > 10, "an arm that does not end well is listed with its reason"
    return int(found[1]), int(found[2])


def test_the_page_has_every_arm() -> None:
    assert sorted(catalogue()) == sorted(robot_names())
    assert sorted(files()) == sorted(NAMES)
    assert len(NAMES) == 98
    assert set(remarks(CATALOGUE)) < set(catalogue())
    assert set(remarks(FILES)) < set(files())
    assert remarks(FILES)["tiago"].keys() == {"exact", "near"}


@pytest.mark.slow
def test_a_row_of_the_catalogue_is_what_is_shipped() -> None:
    for name, (families, _) in catalogue().items():
        found = shipped(name)
        assert families == TOOL.families_per_corank(found), name
        assert remarks(CATALOGUE).get(name, {}).get("explained", "100 %") == TOOL.explained(found), name
        analyzed, derived = codes(CATALOGUE, name)
        assert analyzed == 0, f"{name}: an analysis that is not verified is not shipped"
        assert (name in shelf.conditions_names()) == (derived == 0), name


def test_a_row_of_the_catalogue_has_the_stored_number_of_aspects() -> None:
    for name, (_, aspects) in catalogue().items():
        assert aspects == TOOL.aspects_of_row(name), name
    assert catalogue()["crx10ial"][1] == "2 c"


@pytest.mark.by_hand
@pytest.mark.shipped
def test_a_row_names_letters_or_numbers_as_they_are_shipped() -> None:
    for name in shelf.conditions_names():
        derived = shipped_conditions(name)
        said = remarks(CATALOGUE).get(name, {}).get("exact", "letters")
        assert said.startswith("letters" if derived.letters else "numbers"), name


def test_nearly_all_of_the_makers_files_end_well_and_the_others_say_why() -> None:
    fine = [name for name in files() if codes(FILES, name) == (0, 0)]
    assert len(fine) >= AT_LEAST
    assert f"{len(fine)} of {len(files())} end with exit code 0 from both commands" in part(FILES)


@pytest.mark.by_hand
@pytest.mark.slow_at("m1509_blue")
@pytest.mark.parametrize("name", ANEW)
def test_a_makers_file_fares_as_the_page_says(name: str) -> None:
    row = TOOL.skeleton_row(name)
    assert (row.joints, row.families) == files()[name]
    assert row.remarks == remarks(FILES).get(name, {})
    assert (row.analyze_exit, row.conditions_exit) == codes(FILES, name)
    assert max(row.analyze_cpu, row.conditions_cpu) < LONGEST or name in LONG
