"""Tables that are written one parameter after the other: `a = [0, -0.425, …]`, or by numbered names, `a1 = 0.4`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

from rankdrop.robot.dh_code import code_of, constants_in, without_comment
from rankdrop.robot.dh_variable import constant_part, names_variable
from rankdrop.robot.dh_written import NEEDED, WrittenRow, WrittenTable, two_arms

_LIST = re.compile(
    r"(?:^|[\s.;,{\"'])(?P<name>[A-Za-z]\w{0,30})[\"']?\s*[=:]\s*[\w.]*\(?\s*[\[{](?P<items>[^\[\]{}]{1,2000})[\]}]"
)
_NAME_OF_LIST = re.compile(
    r"(?:(?P<before>\w{1,20}?)_|dh)??(?P<key>theta_offset|alpha|theta|offset|a|d)s?(?:_(?P<after>\w{1,20}))?"
)
_BETWEEN_ITEMS = re.compile(r"\s*[,;]\s*|\s+")
_NUMBERED = re.compile(
    r"(?<!\w)(?P<key>alpha|a|d|q|theta|th|offset)_?(?P<number>\d{1,2})\s*[=:]\s*(?P<value>[^=;,:#%\n{}]{1,60})"
)
_THETA = frozenset(("q", "th"))
"""Other names of theta."""

_Arm = tuple[str | None, str | None]
"""What stands before and behind the names of the lists of one arm: ("ur5", None) of `ur5_alpha`."""


class _NumberedEntry(NamedTuple):
    """The value of a numbered name, and its line."""

    text: str
    line: int


def table_of_lists(lines: list[str], file: str) -> WrittenTable | None:
    """The table of lists, one for each parameter; None where a, alpha or d has none, or their lengths differ.

    Raises:
        RobotError: two arms.
    """
    code = code_of(lines)
    arms = _lists_by_arm(code, file)
    whole = [lists for lists in arms.values() if _is_whole(lists)]
    if not whole:
        return None
    if len(whole) > 1:
        raise two_arms(file, f"{len(whole)} lists of alpha")
    lists = whole[0]
    rows: list[WrittenRow] = []
    for values in zip(*lists.values(), strict=True):
        entries = dict(zip(lists, values, strict=True))
        rows.append(WrittenRow(entries, line=1))
    return WrittenTable(tuple(rows), constants=constants_in(code.splitlines()))


def _lists_by_arm(code: str, file: str) -> dict[_Arm, dict[str, list[str]]]:
    """The lists of parameters, by arm and key.

    Raises:
        RobotError: two different lists of one name.
    """
    arms: dict[_Arm, dict[str, list[str]]] = {}
    for found in _LIST.finditer(code):
        name = _NAME_OF_LIST.fullmatch(found["name"].lower())
        if name is None:
            continue
        lists = arms.setdefault((name["before"], name["after"]), {})
        key = name["key"].removeprefix("theta_")
        items = _items_of(found["items"])
        before = lists.setdefault(key, items)
        if before != items:
            raise two_arms(file, f"{found['name']} again")
    return arms


def _items_of(text: str) -> list[str]:
    """The items of a list, between commas, semicolons or blanks."""
    items = _BETWEEN_ITEMS.split(text.strip(" \t\r\n,;"))
    return [item for item in items if item]


def _is_whole(lists: Mapping[str, list[str]]) -> bool:
    """Whether there are all parameters, each for every joint."""
    lengths = {len(items) for items in lists.values()}
    return lists.keys() >= NEEDED and len(lengths) == 1


def table_of_numbered_names(lines: list[str]) -> WrittenTable | None:
    """The table of numbered names; None where a, alpha or d has none, or there are fewer than two rows.

    It is modified where alpha counts from 0 and d from 1: alpha0 and a0 are those of the link before joint 1.
    """
    entries = _numbered_entries(lines)
    if not entries.keys() >= NEEDED:
        return None
    shift, convention = 0, ""
    if min(entries["alpha"]) == 0 and min(entries["d"]) == 1:
        shift, convention = 1, "modified"
    rows = tuple(_numbered_row(entries, number, shift) for number in sorted(entries["d"]))
    if len(rows) < 2:
        return None
    return WrittenTable(rows, convention, constants=constants_in(lines))


def _numbered_entries(lines: list[str]) -> dict[str, dict[int, _NumberedEntry]]:
    """Values of numbered names, by key and number; the last of each."""
    entries: dict[str, dict[int, _NumberedEntry]] = {}
    for line_number, line in enumerate(lines, 1):
        for found in _NUMBERED.finditer(without_comment(line)):
            key = found["key"]
            if key in _THETA:
                key = "theta"
            by_number = entries.setdefault(key, {})
            text = found["value"].strip().rstrip(")}]")
            by_number[int(found["number"])] = _NumberedEntry(text, line_number)
    return entries


def _numbered_row(by_key: Mapping[str, Mapping[int, _NumberedEntry]], number: int, shift: int) -> WrittenRow:
    """The row of the d with a number.

    Args:
        by_key: entries by key and number.
        number: of d, theta and offset.
        shift: how much lower the numbers of a and alpha are.
    """
    numbers = {"a": number - shift, "alpha": number - shift, "d": number, "theta": number, "offset": number}
    entries: dict[str, str] = {}
    for key, own_number in numbers.items():
        entry = by_key.get(key, {}).get(own_number)
        if entry is not None:
            entries[key] = entry.text
    varies = None
    if "theta" in entries:
        varies = names_variable(entries["theta"])
        entries["theta"] = constant_part(entries["theta"])
    return WrittenRow(entries, by_key["d"][number].line, varies=varies)
