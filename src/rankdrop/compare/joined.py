"""The exact conditions beside an analysis: what was derived, and whether it is what was found. A record for JSON.

The conditions of a row for people: the exact ones where they are known, the fitted ones otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from rankdrop.compare.match import Match, Wider
from rankdrop.exact.arm.verify import Check
from rankdrop.families.cells import COUPLED, coupled_conditions
from rankdrop.family.record import Family, Pinned

AGREES, DIFFERS, NOT_DERIVED = "agrees", "differs", "not derived"
INTERRUPTED = "interrupted"
ASKED = ("auto", "on", "off")
UNTRIED = Check(0, 0)


@dataclass(frozen=True, slots=True)
class ExactRow:
    """One exact family, ready to be shown.

    Attributes:
        id: "k1.f1", among the exact families.
        name: in words.
        corank, dimension: as of a numeric family.
        pinned: joints at fixed values of q; their conditions are the first of `conditions`.
        conditions: for people: "θ4 = 0 or π", "a2 c2 + a3 c23 = 0".
        latex: the same as LaTeX mathematics.
        reality: "" where the family is real whatever the lengths are; else when it is.
    """

    id: str
    name: str
    corank: int
    dimension: int
    pinned: tuple[Pinned, ...]
    conditions: tuple[str, ...]
    latex: tuple[str, ...]
    reality: str


@dataclass(frozen=True, slots=True)
class Joined:
    """The exact families of an arm, held against the numeric ones.

    Attributes:
        status: "agrees", "differs" or "not derived".
        asked: "auto" or "on".
        seconds: the time limit; not what was spent, which no file holds.
        reason: why nothing was derived; else "".
        letters: lengths that are symbols, and their values [m].
        shifts: θ = q + shift, per joint: exact conditions speak of θ [rad, m].
        families: exact ones, of every corank.
        matches: for each numeric family the exact ones it consists of.
        numeric: points of numeric families, and how many lie on an exact one.
        exact: points of exact families, and how many lie on a numeric one.
        disagreements: sentences; none where the two agree.
        wider: exact families whose conditions hold on more than the family.
    """

    status: str
    asked: str
    seconds: float
    reason: str = ""
    letters: Mapping[str, float] | None = None
    shifts: tuple[float, ...] = ()
    families: tuple[ExactRow, ...] = ()
    matches: tuple[Match, ...] = ()
    numeric: Check = UNTRIED
    exact: Check = UNTRIED
    disagreements: tuple[str, ...] = ()
    wider: tuple[Wider, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether the two agree; under "auto" also where nothing was derived."""
        return self.status == AGREES or (self.status == NOT_DERIVED and self.asked == "auto")

    @property
    def interrupted(self) -> bool:
        """Whether the user asked to stop (Ctrl-C) before the conditions were derived."""
        return self.reason == INTERRUPTED

    def of_row(self, row: str) -> tuple[tuple[ExactRow, ...], tuple[ExactRow, ...]]:
        """(exact families on a numeric one, exact families that are partly on it), by the id of the numeric one."""
        known = {family.id: family for family in self.families}
        for match in self.matches:
            if match.row == row:
                return tuple(known[i] for i in match.families), tuple(known[i] for i in match.parts)
        return (), ()


def joined_from_dict(record: Mapping[str, Any]) -> Joined:
    """The record that `plain` made data of; entries of later versions are ignored."""
    families = [
        ExactRow(
            id=one["id"],
            name=one["name"],
            corank=one["corank"],
            dimension=one["dimension"],
            pinned=tuple(Pinned(pin["joint"], pin["number"], tuple(pin["values"])) for pin in one["pinned"]),
            conditions=tuple(one["conditions"]),
            latex=tuple(one["latex"]),
            reality=one["reality"],
        )
        for one in record["families"]
    ]
    return Joined(
        status=record["status"],
        asked=record["asked"],
        seconds=record["seconds"],
        reason=record["reason"],
        letters=record["letters"],
        shifts=tuple(record["shifts"]),
        families=tuple(families),
        matches=tuple(Match(m["row"], tuple(m["families"]), tuple(m["parts"])) for m in record["matches"]),
        numeric=Check(record["numeric"]["tested"], record["numeric"]["agree"]),
        exact=Check(record["exact"]["tested"], record["exact"]["agree"]),
        disagreements=tuple(record["disagreements"]),
        wider=tuple(Wider(w["family"], w["solved"], w["elsewhere"]) for w in record["wider"]),
    )


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
