"""One configuration on the command line: --q 0,0.5,pi/2 (rad and m), or with --deg."""

from __future__ import annotations

import re
from math import radians
from typing import TYPE_CHECKING

from rankdrop.errors import ConfigurationError, RobotError

if TYPE_CHECKING:
    from rankdrop.robot import Robot

_SEPARATOR = re.compile(r"\s*[,;]\s*|\s+")
_AS_TYPED = str.maketrans({"−": "-", "–": "-", "π": "pi", "{": " ", "}": " "})  # as copied from what is printed


def parse_configuration(text: str, robot: Robot, *, deg: bool, option: str = "--q") -> list[float]:
    """The joint values that a text writes, one per joint, in rad and m.

    Numbers are separated by commas, semicolons or blanks; each is arithmetic with pi and sqrt, and may carry a unit
    (deg, rad, m, mm …). A number without a unit is in rad, or in degrees with `deg`; slides are in m. The signs − and
    π are understood: what was printed can be pasted.

    Raises:
        ConfigurationError: not one number for each joint, or a word that is no number.
    """
    body = _without_brackets(text.translate(_AS_TYPED).strip()).strip().rstrip(",;")
    words = _SEPARATOR.split(body) if body else []
    joints = robot.variables
    if len(words) != len(joints):
        raise ConfigurationError(
            f"{len(joints)} joint values are needed", where=option, got=f"{len(words)} in {text!r}",
            allowed=", ".join(f"{joint.name} [{_unit(joint.unit, deg=deg)}]" for joint in joints),
            mend=f'write them as {option}="0,0.5,…"',
        )  # fmt: skip
    return [_value(word, joint.name, joint.unit, option, deg=deg) for word, joint in zip(words, joints, strict=True)]


def _without_brackets(text: str) -> str:
    """[…] and (…) around the whole list, not those of the first and the last number."""
    if text[:1] == "[" and text[-1:] == "]":
        return text[1:-1]
    if text[:1] != "(" or text[-1:] != ")":
        return text
    depth = 0
    for place, letter in enumerate(text):
        depth += (letter == "(") - (letter == ")")
        if depth == 0:
            return text[1:-1] if place == len(text) - 1 else text
    return text


def _unit(unit: str, *, deg: bool) -> str:
    return "deg" if deg and unit == "rad" else unit


def _value(word: str, name: str, unit: str, option: str, *, deg: bool) -> float:
    from rankdrop.robot import quantity

    try:
        value = quantity(word, "length" if unit == "m" else "angle", where=f"{option}, joint {name}")
    except RobotError as error:
        raise ConfigurationError(
            error.what, where=error.where, got=error.got, allowed=error.allowed, mend=error.mend,
            typed=error.typed,
        ) from error
    plain = not re.search(r"(deg|rad|°)$", word)
    return radians(value) if deg and unit == "rad" and plain else value
