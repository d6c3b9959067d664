"""What the pages of the project say of its tests and rooms is so."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
PAGES = sorted([*HERE.parent.glob("docs/**/*.md"), HERE.parent / "CONTRIBUTING.md"])


@pytest.fixture(scope="module")
def names() -> set[str]:
    """Functions of all tests."""
    return {
        node.name for file in HERE.rglob("test_*.py") for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    }  # fmt: skip


def test_every_test_that_a_page_names_is_there(names: set[str]) -> None:
    told = {(page.name, name) for page in PAGES
            for name in re.findall(r"`(test_\w+)`", page.read_text(encoding="utf-8"))}  # fmt: skip
    assert len(told) >= 20
    assert {one for one in told if one[1] not in names} == set()


def test_every_file_of_tests_that_a_page_names_is_there() -> None:
    told = {(page.name, name) for page in PAGES
            for name in re.findall(r"`(tests/[a-z_/.]+)`", page.read_text(encoding="utf-8"))}  # fmt: skip
    assert {one for one in told if not (HERE.parent / one[1]).exists()} == set()


def test_every_room_is_in_the_table_of_rooms() -> None:
    table = (HERE.parent / "docs" / "rooms.md").read_text(encoding="utf-8")
    rooms = {place.name for place in (HERE.parent / "src" / "rankdrop").iterdir() if any(place.glob("*.py"))}
    assert {room for room in rooms if f"`{room}/`" not in table} == set()


def test_every_line_of_the_changelog_is_short() -> None:
    text = (HERE.parent / "CHANGELOG.md").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if line.startswith("- ")]
    assert lines
    assert [line for line in lines if len(line.split()) > 26] == []  # 25 words and the dash
