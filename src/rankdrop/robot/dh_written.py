"""A Denavit–Hartenberg table as it is written: rows of texts, and facts that the written form states."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from rankdrop.errors import RobotError

KEYS = ("a", "alpha", "d", "theta", "offset", "lower", "upper")
NEEDED = frozenset(("a", "alpha", "d"))
"""Parameters that each form writes for every row."""
_TWIST = re.compile(r"alpha|twist", re.IGNORECASE)
_LETTERS = str.maketrans({"α": "alpha", "⍺": "alpha", "𝛼": "alpha", "θ": "theta", "ϑ": "theta", "𝜃": "theta",
                          "π": "pi", "−": "-", "–": "-",
                          "∘": "°", "º": "°", "˚": "°"})  # fmt: skip


@dataclass(frozen=True)
class WrittenRow:
    """One row: its entries as they are written, by `KEYS`, and the line of the text.

    Attributes:
        slides: its d is the joint variable.
        varies: an entry names the joint variable; None where the form does not write it.
        variable: that name; "" where there is none.
        label: the cell in front of the entries: the number or the name of the link.
        assumed: the variable is a name that may be a length too: d2, without a number.
    """

    entries: Mapping[str, str]
    line: int
    slides: bool = False
    varies: bool | None = None
    variable: str = ""
    label: str = ""
    assumed: bool = False


@dataclass(frozen=True)
class WrittenTable:
    """The rows that were found, and what their form says of them.

    Attributes:
        rows: base to tip.
        convention: "standard" or "modified"; "" where the form does not say.
        units: of the columns, by `KEYS`, where the heading states them.
        radians: the form has angles in radians, whatever their size.
        constants: names with the expressions that the text gives them.
    """

    rows: tuple[WrittenRow, ...]
    convention: str = ""
    units: Mapping[str, str] = field(default_factory=dict)
    radians: bool = False
    constants: Mapping[str, str] = field(default_factory=dict)


def plain_letters(text: str) -> str:
    """Greek letters by their names, and one minus sign and one degree sign for all that look alike.

    Example:
        >>> plain_letters("θ − 90˚")
        'theta - 90°'
    """
    return text.translate(_LETTERS)


def names_twist(text: str) -> bool:
    """Whether a text names the twist: every table has it, and other texts rarely do."""
    return _TWIST.search(text) is not None


def two_arms(where: str, got: str) -> RobotError:
    """The refusal of a text with the tables of two arms."""
    return RobotError("the file has two arms", where=where, got=got, mend="keep the rows of one arm")
