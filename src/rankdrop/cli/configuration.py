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
    words = split_values(text)
    joints = robot.variables
    if len(words) != len(joints):
        raise ConfigurationError(
            f"{len(joints)} joint values are needed", where=option, got=f"{len(words)} in {text!r}",
            allowed=", ".join(f"{joint.name} [{_unit(joint.unit, deg=deg)}]" for joint in joints),
            mend=f'write them as {option}="0,0.5,…"',
        )  # fmt: skip
    return [
        value_of(word, joint.unit, f"{option}, joint {joint.name}", deg=deg)
        for word, joint in zip(words, joints, strict=True)
    ]


def split_values(text: str) -> list[str]:
    """The words of a list of quantities, however it is bracketed and separated."""
    body = _without_brackets(text.translate(_AS_TYPED).strip()).strip().rstrip(",;")
    return _SEPARATOR.split(body) if body else []


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


def value_of(word: str, unit: str, where: str, *, deg: bool) -> float:
    """One quantity in rad or m; an angle without a unit is in degrees with `deg`.

    Raises:
        ConfigurationError: it is none.
    """
    from rankdrop.robot import quantity

    try:
        value = quantity(word, "length" if unit == "m" else "angle", where=where)
    except RobotError as error:
        raise ConfigurationError(
            error.what, where=error.where, got=error.got, allowed=error.allowed, mend=error.mend,
            typed=error.typed,
        ) from error
    plain = not re.search(r"(deg|rad|°)$", word)
    return radians(value) if deg and unit == "rad" and plain else value
