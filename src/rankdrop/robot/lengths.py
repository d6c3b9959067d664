"""Letters for the lengths of an arm: what they may be called and which values they may have."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from typing import Any

from rankdrop.errors import RobotError
from rankdrop.robot.quantities import quantity

LETTERS_ALLOWED = "a letter, then letters and digits; not pi, sin, cos, nor s, c, t or q with a number"


def is_letter(name: object) -> bool:
    """Whether conditions can write a length with this name: nothing else that they contain is called so.

    Example:
        >>> is_letter("d3"), is_letter("upper_arm"), is_letter("c23"), is_letter("2a")
        (True, True, False, False)
    """
    shape = isinstance(name, str) and re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name)
    return bool(shape) and not re.fullmatch(r"[sctqθ]\d+|pi|sin|cos", str(name))


def checked_lengths(given: Iterable[tuple[Any, Any]], where: Callable[[str], str]) -> tuple[tuple[str, float], ...]:
    """Letters and their values [m], in the order given.

    Args:
        given: (letter, number in m or text with a unit of length).
        where: place of a letter in words, for errors.

    Raises:
        RobotError: a name that means something else in conditions, or that is there twice; a value that is not a
            length or not positive.
    """
    found: dict[str, float] = {}
    for name, value in given:
        place = where(str(name))
        if not is_letter(name):
            raise RobotError(
                "a length cannot have this name", where=place, got=repr(name), allowed=LETTERS_ALLOWED, mend="rename it"
            )
        if name in found:
            raise RobotError("two lengths have the same letter", where=place, got=repr(name), mend="rename one")
        length = quantity(value, "length", where=place)
        if length <= 0.0:
            raise RobotError(
                "a length with a letter is positive", where=place, got=value, allowed="a length > 0",
                mend="leave out lengths that are zero; write the value without its sign: −a is found too",
            )
        found[name] = length
    return tuple(found.items())
