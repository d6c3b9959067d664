"""Units of a Denavit–Hartenberg table in a text: as its heading or a line states them, else as its numbers show them.

Numbers that fit two units are refused with the line to add.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import pi
from typing import NamedTuple

from rankdrop.errors import RobotError
from rankdrop.robot.dh_written import WrittenTable

LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
ANGLES = {"rad": 1.0, "deg": pi / 180, "°": pi / 180}

_OF_LENGTHS = re.compile(
    r"\b(?:lengths?|units?|dimensions)\b[^\n]{0,20}?\b(mm|cm|m)\b|\b(?:all|everything|numbers|values)\sin\s(mm|cm|m)\b",
    re.IGNORECASE,
)
_IN_PASSING = re.compile(
    r"\bfor\s[\w, ]{1,20}\sin\s"  # a loop of code
    r"|\bin\s(mm|cm|m|(?:milli|centi)?m(?:eter|etre)s)\b"
    r"|(?:^|(?<=[\s,;(\[]))(mm|cm|m)\s?(?:,|/|&|and)\s?(?:rad|deg|°)", re.IGNORECASE | re.MULTILINE
)  # fmt: skip
_SHORT = {"milli": "mm", "centi": "cm", "meter": "m", "metre": "m"}
_DEGREES = re.compile(r"\b(?:degrees?|deg)\b", re.IGNORECASE)
_RADIANS = re.compile(r"\brad(?:ians?)?\b", re.IGNORECASE)
_LARGEST_ARM = 10.0  # [m]: an arm of larger numbers is in mm, or in cm
_LEAST_MILLIMETRES = 50.0  # the longest link of an arm is longer; a table in cm has smaller numbers
_FRACTION_OF_MILLIMETRE, _NOISE = 0.5, 1e-9  # no arm has so short an offset by design, in mm
_LEAST_DEGREES = 15.0  # of the largest angle of a table
_MOST_RADIANS = 2 * pi + 0.01


class Unit(NamedTuple):
    """A unit: "length" or "angle", and its size [m or rad]."""

    measure: str
    size: float


def unit_named(name: str) -> Unit:
    """The unit of a sign: m, cm, mm, deg, ° or rad."""
    if name in LENGTHS:
        return Unit("length", LENGTHS[name])
    return Unit("angle", ANGLES[name])


def length_unit(table: WrittenTable, text: str, file: str, sizes: Sequence[float]) -> str:
    """The unit of lengths without one.

    Args:
        table: with the units of its heading.
        text: that the table stands in.
        file: for errors.
        sizes: of the lengths without a unit, 0 among them.

    Raises:
        RobotError: it is in doubt.
    """
    headed = {unit for unit in table.units.values() if unit in LENGTHS}
    for stated in (headed, _named(_OF_LENGTHS, text)):
        if len(stated) == 1:
            return stated.pop()
    if not any(sizes):  # each length has its own unit
        return "m"
    named = _named(_OF_LENGTHS, text) or _named(_IN_PASSING, text)
    shown = _shown_by(sizes)
    if len(named) == 1 and shown.issuperset(named):
        return named.pop()
    if named or len(shown) != 1:
        least = min(filter(None, sizes), default=0.0)
        raise RobotError("the unit of the lengths is in doubt", where=file,
                         got=" and ".join([f"{least:.3g} at least, {max(sizes):g} at most", *sorted(named)]),
                         allowed="mm, cm or m",
                         mend="name the unit in the heading: a [cm]; or in a line: lengths in cm")  # fmt: skip
    return shown.pop()


def _named(pattern: re.Pattern[str], text: str) -> set[str]:
    """The units of length that a text names."""
    return {_short_unit(word) for word in map("".join, pattern.findall(text)) if word}


def _shown_by(sizes: Sequence[float]) -> set[str]:
    """The units in which lengths of these sizes are those of an arm."""
    largest, least = max(sizes), min((size for size in sizes if size > _NOISE), default=0.0)
    if largest <= _LARGEST_ARM:
        return {"m"}
    if largest >= _LEAST_MILLIMETRES and least >= _FRACTION_OF_MILLIMETRE:
        return {"mm"}
    return set(LENGTHS)


def _short_unit(word: str) -> str:
    """A unit of length by its sign: mm for "millimetres"."""
    return _SHORT.get(word.lower()[:5], word.lower())


def angle_unit(table: WrittenTable, text: str, file: str, sizes: Sequence[float]) -> str:
    """The unit of angles without one.

    Args:
        table, text, file: as for `length_unit`.
        sizes: of the angles without a unit, 0 among them.

    Raises:
        RobotError: it is in doubt.
    """
    largest = max(sizes)
    if table.radians:
        return _radians_of_calls(largest, file)
    if "deg" in table.units.values():
        return "deg"
    named = _named_angle(text)
    if largest <= _MOST_RADIANS:
        whole = 0 < largest <= pi and largest == round(largest)
        return _unless("rad", named == "deg" and whole, largest, file)
    in_radians = named == "rad" and "rad" not in table.units.values()
    return _unless("deg", in_radians or largest < _LEAST_DEGREES, largest, file)


def _named_angle(text: str) -> str:
    """The unit of angles that a text names; "" where it names none, or both."""
    named = [unit for unit, pattern in (("deg", _DEGREES), ("rad", _RADIANS)) if pattern.search(text)]
    if len(named) == 1:
        return named[0]
    return ""


def _radians_of_calls(largest: float, file: str) -> str:
    if largest > 2 * _MOST_RADIANS:
        raise RobotError("an angle of many turns in radians", where=file, got=f"{largest:g}",
                         mend="write pi/2 or deg2rad(90)")  # fmt: skip
    return "rad"


def _unless(unit: str, in_doubt: bool, largest: float, file: str) -> str:
    if in_doubt:
        raise RobotError("the unit of the angles is in doubt", where=file, got=f"{largest:g}", allowed="rad or deg",
                         mend="name the unit in the heading, alpha [deg], or behind each number: 90deg")  # fmt: skip
    return unit
