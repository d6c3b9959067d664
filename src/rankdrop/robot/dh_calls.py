"""Calls of toolboxes: `Link([theta d a alpha])`, `Link('d', 0.1, 'a', 0, 'alpha', pi/2)`, `RevoluteMDH(d=0.1, a=0)`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from rankdrop.errors import RobotError
from rankdrop.robot.dh_code import (
    CallArguments,
    call_arguments,
    call_without_end,
    code_of,
    constants_in,
    line_at,
    line_starts,
)
from rankdrop.robot.dh_written import WrittenRow, WrittenTable, two_arms

_LONGEST_TARGET = 60  # characters in front of a call
_CALL = re.compile(r"\b(?:(?P<kind>Revolute|Prismatic)(?P<modified>M?)(?:DH)?|(?P<link>Link|link|DHLink))\s*\(")
_TARGET = re.compile(r"(?P<name>[\w.]{1,40}(?:[({\[]\d{1,3}[)}\]])?)\s*=\s*(?:\w{1,20}\.)?$")
_LATER = re.compile(
    r"(?P<name>[\w.]{1,40}(?:[({\[]\d{1,3}[)}\]])?)\.(?P<key>offset|qlim)\s*=\s*(?P<value>[^;\n]{1,120})"
)
_KEYWORD = re.compile(r"""^["']?(?P<key>[A-Za-z_]+)["']?\s*=\s*""")
_QUOTED = re.compile(r"""^["'](?P<text>\w+)["']$""")
_NUMBER = re.compile(r"[-+.(\d]|(?:\w{1,20}\.)?pi\b")
_BETWEEN_NUMBERS = re.compile(r"\s*,\s*|\s+")
_FLAGS = frozenset(("modified", "standard", "revolute", "prismatic", "sym"))
"""Quoted words of a call that no value follows."""
_ORDER = ("theta", "d", "a", "alpha", "sigma", "offset")
"""Order of the numbers of one bracket."""
_OLDER_ORDER = ("alpha", "a", "theta", "d", "sigma")
"""Order in the calls `link` of older versions."""
_PAIR = re.compile(r"\[\s*(?P<lower>[^,\s\]]+(?:\([^)]*\))?)\s*[,\s]\s*(?P<upper>[^\]]+?)\s*\](?P<factor>\s*\*.*)?")
_CONVERTED = re.compile(r"^(?:\w{1,20}\.)?(?:deg2rad|radians|d2r)\((?P<pair>.*)\)$")


@dataclass(frozen=True)
class _Call:
    """One call, on one line or over several.

    Attributes:
        text: its beginning, with the opening bracket.
        name: that it is assigned to; "" for none.
        line: of its beginning.
        entries: its arguments, by their names.
        stray: a number without a name; "" where there is none.
        empty: it has no argument, and is a row all the same: RevoluteDH().
        slides: its d is the joint variable.
        convention: "standard" or "modified".
        closed: it has a closing bracket.
    """

    text: str
    name: str
    line: int
    entries: Mapping[str, str]
    stray: str
    empty: bool
    slides: bool
    convention: str
    closed: bool


def table_of_calls(lines: list[str], file: str) -> WrittenTable | None:
    """The table that calls make; None where there are none.

    Raises:
        RobotError: a call without an end, a number without a name, two arms, or links of both conventions.
    """
    code = code_of(lines)
    calls = [call for call in _calls_in(code) if call.entries or call.stray or call.empty]
    if not any(call.entries for call in calls):
        return None
    _refuse_calls_without_end(calls, file)
    _refuse_strays(calls, file)
    _refuse_two_arms(calls, file)
    bare = code.splitlines()
    settings = _settings_in(bare)
    rows = tuple(_row_of(call, settings) for call in calls)
    convention = calls[0].convention
    if any(call.convention != convention for call in calls):
        raise RobotError("the links are of both conventions", where=file, allowed="all standard, or all modified")
    return WrittenTable(rows, convention, radians=True, constants=constants_in(bare))


def _calls_in(code: str) -> list[_Call]:
    """The calls in a text, without calls inside other calls."""
    calls: list[_Call] = []
    starts = line_starts(code)
    found = _CALL.search(code)
    while found is not None:
        arguments = call_arguments(code, found.end())
        before = code[max(0, found.start() - _LONGEST_TARGET) : found.start()]
        line = line_at(found.start(), starts)
        calls.append(_call_of(found, arguments, _target_of(before), line))
        found = _CALL.search(code, arguments.end)
    return calls


def _target_of(before: str) -> str:
    """The name that a call is assigned to, at the end of the text in front of the call; "" for none."""
    found = _TARGET.search(before)
    if found is None:
        return ""
    return found["name"]


def _call_of(found: re.Match[str], arguments: CallArguments, name: str, line: int) -> _Call:
    """The call that is found, with its arguments, the name that it is assigned to, and its line."""
    words = arguments.words
    flags = _flags_in(words)
    entries, stray = _entries_of(words, _order_of(found))
    slides = found["kind"] == "Prismatic" or "prismatic" in flags or entries.get("sigma") == "1"
    if found["link"] is not None and "theta" in entries and "d" not in entries:
        slides = True
    convention = "standard"
    if found["modified"] or "modified" in flags or entries.get("mdh") in ("1", "True", "true"):
        convention = "modified"
    empty = found["kind"] is not None and words == ("",)
    return _Call(found[0], name, line, entries, stray, empty, slides, convention, arguments.closed)


def _order_of(found: re.Match[str]) -> tuple[str, ...]:
    """The order of the numbers of one bracket."""
    if found["link"] == "link":
        return _OLDER_ORDER
    return _ORDER


def _flags_in(words: tuple[str, ...]) -> set[str]:
    """The quoted words of a call, in small letters."""
    quoted = [_QUOTED.match(word) for word in words]
    return {word["text"].lower() for word in quoted if word is not None}


def _entries_of(words: tuple[str, ...], order: tuple[str, ...]) -> tuple[dict[str, str], str]:
    """Arguments by key: 'd', 0.1 and d=0.1, and the numbers of one bracket; and the first number without a key."""
    entries: dict[str, str] = {}
    stray = ""
    waiting = ""  # a key whose value is the next argument
    for word in words:
        quoted = _QUOTED.match(word)
        keyword = _KEYWORD.match(word)
        if waiting:
            entries[waiting] = word
            waiting = ""
        elif quoted is not None:
            waiting = _key_before_value(quoted["text"])
        elif keyword is not None:
            entries[keyword["key"]] = word[keyword.end() :].strip()
        elif word.startswith("[") and not entries:
            numbers = _BETWEEN_NUMBERS.split(word.strip("[] "))
            entries.update(zip(order, numbers, strict=False))
        elif _NUMBER.match(word):
            stray = stray or word
    return entries, stray


def _key_before_value(quoted: str) -> str:
    """A quoted word as the key of the value behind it; "" where none follows."""
    if quoted.lower() in _FLAGS:
        return ""
    return quoted


def _refuse_calls_without_end(calls: list[_Call], file: str) -> None:
    for call in calls:
        if call.entries and not call.closed:
            raise call_without_end(call.text, f"{file}, line {call.line}")


def _refuse_strays(calls: list[_Call], file: str) -> None:
    """Refuse a number without the name of its parameter: its place says it in no toolbox alike."""
    for call in calls:
        if call.stray:
            raise RobotError("an argument has no name", where=f"{file}, line {call.line}", got=call.stray,
                             allowed="d=0.1, 'd', 0.1, or one bracket of numbers first")  # fmt: skip


def _refuse_two_arms(calls: list[_Call], file: str) -> None:
    lines: dict[str, int] = {}
    for call in calls:
        if call.name and call.name in lines:
            raise two_arms(f"{file}, line {call.line}", f"{call.name} again, first in line {lines[call.name]}")
        lines[call.name] = call.line


def _settings_in(lines: list[str]) -> dict[tuple[str, str], str]:
    """Offsets and limits that a statement of its own gives a link, `L(2).offset = pi/2`: by the link and the key."""
    settings: dict[tuple[str, str], str] = {}
    for line in lines:
        for found in _LATER.finditer(line):
            settings[found["name"], found["key"]] = found["value"]
    return settings


def _row_of(call: _Call, settings: Mapping[tuple[str, str], str]) -> WrittenRow:
    constant = "d"
    if call.slides:
        constant = "theta"
    entries = {key: call.entries[key] for key in ("a", "alpha", constant) if key in call.entries}
    entries["offset"] = settings.get((call.name, "offset"), call.entries.get("offset", "0"))
    limits = settings.get((call.name, "qlim"), call.entries.get("qlim", ""))
    return WrittenRow(entries | _limits_of(limits), call.line, call.slides)


def _limits_of(text: str) -> dict[str, str]:
    """lower and upper of `[-pi, pi]`, `[-165 165]*deg` or `deg2rad([-360 360])`; empty for anything else."""
    inside = text.strip()
    factor = ""
    converted = _CONVERTED.match(inside)
    if converted is not None:
        inside = converted["pair"]
        factor = "*pi/180"
    pair = _PAIR.match(inside)
    if pair is None:
        return {}
    factor = pair["factor"] or factor
    return {"lower": f"({pair['lower']}){factor}", "upper": f"({pair['upper']}){factor}"}
