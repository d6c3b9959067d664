"""Numbers in URDF attributes: finite, and as many as expected."""

from __future__ import annotations

import re
from math import isfinite

from rankdrop.errors import RobotError

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def number(text: str, where: str, key: str) -> float:
    """One finite number.

    Raises:
        RobotError: not a number, or not finite.
    """
    word = text.strip()
    value = float(word) if _NUMBER.fullmatch(word) else None
    if value is None or not isfinite(value):
        limits = key in {"lower", "upper", "velocity"}
        raise RobotError(
            f"{key} is not a finite number", where=where, got=repr(text[:60]), allowed="a finite number",
            mend="leave the attribute out where there is no limit" if limits else "write the number out",
        )
    return value


def three(text: str, where: str, key: str) -> list[float]:
    """Three finite numbers.

    Raises:
        RobotError: another count, or one of them is not a finite number.
    """
    words = text.split()
    if len(words) != 3:
        raise RobotError(f"{key} is three numbers", where=where, got=repr(text[:60]), allowed=f'{key}="0 0 0"')
    return [number(word, where, key) for word in words]
