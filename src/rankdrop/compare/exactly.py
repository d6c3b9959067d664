"""The conditions of a row for people: the exact ones where they are known, the fitted ones otherwise."""

from __future__ import annotations

import numpy as np

from rankdrop.compare.joined import ExactRow, Joined
from rankdrop.families.cells import COUPLED, coupled_conditions
from rankdrop.family.record import Family

EXACTLY = "exactly"
"""Label of an exact condition; a fitted one has that of a coupled joint."""
_LONGEST = 800  # characters of a condition that is printed
_SAME = 1e-6  # values of a pinned joint that differ by less are the same [rad, m]


def conditions_of(row: Family, joined: Joined | None) -> list[tuple[str, str]]:
    """(label, text) of every condition of a row that its table does not say.

    Exact ones stand in place of fitted ones. Where they hold on more than the row, the fitted ones stay, and long ones
    are only counted: programs find them in the JSON.
    """
    exactly, instead = exact_conditions(row, joined)
    fitted = [] if instead else coupled_conditions(row, folded=bool(exactly))
    return [*((COUPLED, text) for text in fitted), *((EXACTLY, text) for text in exactly)]


def exact_conditions(row: Family, joined: Joined | None) -> tuple[list[str], bool]:
    """The exact conditions of a row: (lines, whether they may stand in place of the fitted ones).

    No line where the table says it all: joints at simple values.
    """
    if joined is None:
        return [], False
    whole, parts = joined.of_row(row.id)
    wider = {one.family for one in joined.wider}
    lines = [_line(row, family, alone=len(whole) == 1) for family in whole]
    lines = [
        text + (" (and elsewhere, see the end)" if family.id in wider else "")
        for text, family in zip(lines, whole, strict=True)
        if text
    ]
    lines += [f"part of {' and '.join(map(_short, family.conditions))}" for family in parts]
    said = [f"or {text}" if place else text for place, text in enumerate(lines)]
    return said, bool(lines) and not parts and not wider & {family.id for family in whole}


def _line(row: Family, family: ExactRow, *, alone: bool) -> str:
    """A family's conditions, without those of joints that the row has at the same values."""
    same = [_has(row, pinned.number, pinned.values) for pinned in family.pinned]
    rest = [_short(text) for text in family.conditions[len(same) :]]
    pins = [text for text, known in zip(family.conditions, same, strict=False) if not known]
    if not pins and not rest and not alone:
        return " and ".join((*family.conditions[: len(same)], *rest))
    return " and ".join((*pins, *rest)) + (f"; {family.reality}" if family.reality and (pins or rest) else "")


def _short(text: str) -> str:
    """A condition for reading; a very long one is only counted."""
    whole = "whole with --json, or with `rankdrop conditions --latex`"
    return text if len(text) <= _LONGEST else f"a condition of {len(text):,} characters ({whole})"


def _has(row: Family, number: int, values: tuple[float, ...]) -> bool:
    for pinned in row.pinned:
        if pinned.number == number and len(pinned.values) == len(values):
            return bool(np.abs(np.sort(pinned.values) - np.sort(values)).max() <= _SAME)
    return False


