"""Numbers in URDF attributes: finite, and as many as expected."""

from __future__ import annotations

import re
from math import isfinite

from rankdrop.errors import RobotError
from rankdrop.robot.budgets import LONGEST_TEXT
from rankdrop.robot.quantities import in_range

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def number(text: str, where: str, key: str, measure: str = "number") -> float:
    """One finite number in the range of its measure.

    Args:
        text: of the attribute.
        where: file, line, element.
        key: name of the attribute.
        measure: "angle" [rad], "length" [m] or "number".

    Raises:
        RobotError: not a number, not finite, or too large.
    """
    return in_range(finite(text, where, key), measure, where=f"{where}, {key}", got=text.strip())


def finite(text: str, where: str, key: str) -> float:
    """One finite number of any size.

    Raises:
        RobotError: not a number, or not finite.
    """
    word = text.strip()
    value = float(word) if len(word) <= LONGEST_TEXT and _NUMBER.fullmatch(word) else None
    if value is None or not isfinite(value):
        limits = key in {"lower", "upper", "velocity"}
        raise RobotError(
            f"{key} is not a finite number", where=where, got=repr(text[:60]), allowed="a finite number",
            mend="leave the attribute out where there is no limit" if limits else "write the number out",
        )
    return value


def three(text: str, where: str, key: str, measure: str = "number") -> list[float]:
    """Three finite numbers in the range of their measure.

    Raises:
        RobotError: another count, or one of them is not a finite number, or too large.
    """
    words = text.split(None, 3)
    if len(words) != 3:
        raise RobotError(f"{key} is three numbers", where=where, got=repr(text[:60]), allowed=f'{key}="0 0 0"')
    return [number(word, where, key, measure) for word in words]
