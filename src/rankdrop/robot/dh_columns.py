"""The columns that a heading of a table names: their keys, their units, and whether they count the link before."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass

from rankdrop.robot.dh_cells import cells_of_heading, without_assignment
from rankdrop.robot.dh_written import KEYS, NEEDED, names_twist, plain_letters

_LONGEST_HEADING = 400  # characters
_UNIT = re.compile(r"[(\[{]\s*(?P<unit>mm|cm|m|deg(?:rees?)?|°|rad(?:ians?)?)\s*(?:[)\]}]|$)", re.IGNORECASE)
_BEFORE_UNIT = re.compile(r"(?<=\w)[ \t]+(?=[(\[](?:mm|cm|m|deg|°|rad)[)\]])", re.IGNORECASE)
_HEADS = (
    ("alpha", re.compile(r"(?:link\s?)?(?:alpha|twist)(?:\s?angle)?")),
    ("offset", re.compile(r"(?:theta)?(?:off(?:set)?|0)")),
    ("theta", re.compile(r"theta|q|joint\s?angle|angle")),
    ("a", re.compile(r"a|link\s?length|length")),
    ("d", re.compile(r"d|r|link\s?offset|joint\s?distance")),
    ("lower", re.compile(r"q-|q\(?min\)?|min|lower(?:\s?limit)?")),
    ("upper", re.compile(r"q\+|q\(?max\)?|max|upper(?:\s?limit)?")),
)
_LINK_BEFORE = re.compile(r"\(?[ijnk]?-1\)?$")
_INDEX = re.compile(r"[_{}( ]*[ijnk]?[})]?$")
_NAMED_R = re.compile(r"r[_{]?[ijnk]?}?")
_NO_LETTERS = str.maketrans("", "", "\\$*")


@dataclass(frozen=True)
class Heading:
    """What a heading says.

    Attributes:
        keys: of the columns, by `KEYS`; "" for another column.
        units: of the columns that state one, by key.
        convention: "modified" where a column counts the link before, or has the name r; "" where none does.
    """

    keys: tuple[str, ...]
    units: Mapping[str, str]
    convention: str


@dataclass(frozen=True)
class _HeadCell:
    """What one cell of a heading says.

    Attributes:
        key: of `KEYS`; "" for none.
        unit: as `Heading.units` has it; "" for none.
        link_before: its index is that of the link before: a_{i-1}.
    """

    key: str
    unit: str
    link_before: bool


def heading_in(line: str) -> Heading | None:
    """The heading in a line; None where it names no a, alpha and d.

    Example:
        >>> heading_in("i | a_{i-1} [mm] | alpha_{i-1} | d_i | theta_i")
        Heading(keys=('', 'a', 'alpha', 'd', 'theta'), units={'a': 'mm'}, convention='modified')
    """
    if len(line) > _LONGEST_HEADING or not names_twist(line):
        return None
    bare = without_assignment(line.lstrip("#%/* "))
    cells = cells_of_heading(_BEFORE_UNIT.sub("", bare))
    heads = [_head_of(cell) for cell in cells]
    keys = _keys_of(heads, cells)
    if not _names_each_once(keys):
        return None
    units = {key: head.unit for key, head in zip(keys, heads, strict=True) if key and head.unit}
    return Heading(tuple(keys), units, _convention_of(heads, cells))


def _keys_of(heads: list[_HeadCell], cells: list[str]) -> list[str]:
    """The keys of the columns."""
    keys = [head.key for head in heads]
    if "a" in keys or not _has_r(cells):
        return keys
    return list(map(_key_next_to_r, cells, keys))


def _convention_of(heads: list[_HeadCell], cells: list[str]) -> str:
    """The convention of a heading; "" where the heading does not show it."""
    if _has_r(cells) or any(head.link_before for head in heads):
        return "modified"
    return ""


def _has_r(cells: list[str]) -> bool:
    """Whether a column is called r, as in tables with the lengths d and r."""
    return any(_NAMED_R.fullmatch(cell.strip().lower()) for cell in cells)


def _names_each_once(keys: list[str]) -> bool:
    """Whether keys name a, alpha and d, and none of them twice."""
    most = max(keys.count(key) for key in KEYS)
    return most == 1 and all(key in keys for key in NEEDED)


def _key_next_to_r(cell: str, key: str) -> str:
    """The key in a table with d and r: d is the length that others call a, and r their d."""
    if key == "d" and not cell.strip().lower().startswith("r"):
        return "a"
    return key


def _head_of(cell: str) -> _HeadCell:
    """What a cell of a heading says."""
    name = _plain_name(cell)
    bare = name.strip("{}")
    shorter = _LINK_BEFORE.sub("", bare).rstrip("_{( ")
    link_before = shorter != bare and not name.startswith("q")
    if not link_before:
        shorter = name
    key = _key_of(shorter) or _key_of(_INDEX.sub("", shorter))
    if not key:
        return _HeadCell("", "", link_before=False)
    return _HeadCell(key, _unit_in(cell), link_before)


def _plain_name(cell: str) -> str:
    """The name in a cell: in small letters, indices as plain digits, without its unit and without signs of LaTeX."""
    decomposed = unicodedata.normalize("NFKD", _UNIT.sub("", cell))
    name = plain_letters(decomposed).lower()
    name = name.translate(_NO_LETTERS).strip(" _'\"`")
    return re.sub(r"\s+", " ", name)


def _key_of(name: str) -> str:
    """The key that a name of a column stands for; "" for none."""
    for key, pattern in _HEADS:
        if pattern.fullmatch(name):
            return key
    return ""


def _unit_in(cell: str) -> str:
    """The unit that a cell states: m, cm, mm, deg or rad; "" where it states none."""
    found = _UNIT.search(cell)
    if found is None:
        return ""
    unit = found["unit"].lower()
    if unit == "°":
        return "deg"
    return unit[:3]
