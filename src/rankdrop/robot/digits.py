"""Angles that a file writes as rounded decimals: 1.5708 stands for π/2.

A decimal that equals a multiple of π/12, rounded or cut to the decimal's own places, is that angle: a file with 1.5708
means a right angle, and taken literally its axes miss parallel and perpendicular by 3.7e-6 rad. With few places a
decimal says less, so it has to be a rarer angle: a multiple of π/4 with three places, of π/2 with two. No threshold is
needed, and zero stays zero.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from decimal import ROUND_DOWN, ROUND_HALF_EVEN, Decimal, localcontext
from typing import Any

from rankdrop.robot.quantities import quantity

_PI = Decimal("3.14159265358979323846264338327950288419716939937510582")
_DIGITS = 60  # of the arithmetic: more than any file prints, and than π above has
_PARTS = {2: 2, 3: 4}  # places -> parts of π
_FINEST = 12
_LARGEST = 8 * 3.15  # [rad], four turns: no drawing has a larger fixed angle
_DECIMAL = re.compile(r"[+-]?\d*\.(\d*)(?:[eE]([+-]?\d{1,3}))?", re.ASCII)
_RADIANS = re.compile(r"\s*rad\s*\Z")


class Written(float):
    """A float that knows how it was written; for `tomllib.loads(…, parse_float=Written)`."""

    text: str

    def __new__(cls, text: str) -> Written:
        """The float of a text, with the text."""
        made = super().__new__(cls, text)
        made.text = text
        return made


@dataclass(slots=True)
class Angles:
    """Reads the fixed angles of one file, and remembers what it changed.

    Attributes:
        as_written: take every number literally.
        changes: angle taken less angle written [rad], for each number that was changed.
    """

    as_written: bool = False
    changes: list[float] = field(default_factory=list)

    def take(self, text: str) -> float:
        """The angle [rad] that a decimal text stands for."""
        value, change = (float(text), 0.0) if self.as_written else angle(text)
        if change:
            self.changes.append(change)
        return value

    def quantity(self, value: Any, *, where: str) -> float:
        """The angle [rad] of an entry of a table, as `quantity` reads it; decimals in radians by the rule of digits.

        Raises:
            RobotError: as `quantity`.
        """
        read = quantity(value, "angle", where=where)
        text = value.text if isinstance(value, Written) else _RADIANS.sub("", value) if isinstance(value, str) else ""
        return self.take(text.strip()) if _DECIMAL.fullmatch(text.strip()) else read


def angle(text: str) -> tuple[float, float]:
    """The angle [rad] that a decimal stands for, and by how much that changes the number.

    Args:
        text: a number as a file writes it, "-1.5708" or "1.5708e+00"; places count after the point of the plain
            decimal.

    Returns:
        (angle, angle less the number as written): the nearest double of the multiple of π/12, and what that changes;
        (the number itself, 0.0) where the rule says nothing.

    Example:
        >>> angle("1.5708"), angle("0.35")
        ((1.5707963267948966, -3.673205103380...e-06), (0.35, 0.0))
    """
    value = float(text)
    match = _DECIMAL.fullmatch(text.strip())
    if match is None or value == 0.0 or abs(value) > _LARGEST:
        return value, 0.0
    places = len(match[1]) - int(match[2] or 0)
    if not 2 <= places <= _DIGITS - 10:
        return value, 0.0
    with localcontext() as context:
        context.prec = _DIGITS
        written = Decimal(text.strip())
        part = _PI / _PARTS.get(places, _FINEST)
        exact = round(written / part) * part
        last = Decimal(1).scaleb(-places)
        ways = [exact.quantize(last, rounding=way) for way in (ROUND_HALF_EVEN, ROUND_DOWN)]
        if exact == 0 or written not in ways:
            return value, 0.0
        taken = float(exact)
        return taken, float(exact - written) if taken != value else 0.0
