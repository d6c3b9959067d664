"""Exact conditions beside the tables of an analysis: where they say more than a table, and how the two compare."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from rich.text import Text

from rankdrop.atlas.cells import joint_symbol
from rankdrop.joined import AGREES, NOT_DERIVED

if TYPE_CHECKING:
    from rankdrop.atlas.family import Family
    from rankdrop.joined import ExactRow, Joined
    from rankdrop.result import Analysis

_SAME = 1e-6  # values of a pinned joint that differ by less are the same [rad, m]
_BAD = "bold red"


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
    lines += [f"part of {' and '.join(family.conditions)}" for family in parts]
    said = [f"or {text}" if place else text for place, text in enumerate(lines)]
    return said, bool(lines) and not parts and not wider & {family.id for family in whole}


def _line(row: Family, family: ExactRow, *, alone: bool) -> str:
    """A family's conditions, without those of joints that the row has at the same values."""
    same = [_has(row, pinned.number, pinned.values) for pinned in family.pinned]
    rest = family.conditions[len(same) :]
    pins = [text for text, known in zip(family.conditions, same, strict=False) if not known]
    if not pins and not rest and not alone:
        return " and ".join(family.conditions)
    return " and ".join((*pins, *rest)) + (f"; {family.reality}" if family.reality and (pins or rest) else "")


def _has(row: Family, number: int, values: tuple[float, ...]) -> bool:
    for pinned in row.pinned:
        if pinned.number == number and len(pinned.values) == len(values):
            return bool(np.abs(np.sort(pinned.values) - np.sort(values)).max() <= _SAME)
    return False


def exact_section(analysis: Analysis) -> Iterator[Text]:
    """How the exact derivation and the tables compare; disagreements first and in red."""
    joined = analysis.exact
    if joined is None:
        return
    if joined.status == NOT_DERIVED:
        yield Text(f"Exact conditions: not derived; {joined.reason}.")
        return
    if joined.disagreements:
        yield Text("The exact derivation and the numeric search DIFFER; at least one of them is wrong:", style=_BAD)
        yield from (Text(f"  {text}", style=_BAD) for text in joined.disagreements)
    verdict = "agree with every row" if joined.status == AGREES else "do not agree with the rows"
    points = (
        f"{joined.numeric.agree:,} of {joined.numeric.tested:,} points of the rows lie on exact families, "
        f"{joined.exact.agree:,} of {joined.exact.tested:,} points of these on the rows"
    )
    shown = any(exact_conditions(row, joined)[0] for row in analysis.families)
    yield Text(f"Exact conditions, derived apart from the search, {verdict}: {points}.{_symbols(analysis) * shown}")
    for one in joined.wider:
        yield Text(
            f"The conditions of the exact family {one.family} also hold where less is lost ({one.elsewhere} of "
            f"{one.solved} random solutions): it is what of them is singular to its corank."
        )


def _symbols(analysis: Analysis) -> str:
    """What the letters of exact conditions mean."""
    joined = analysis.exact
    if joined is None:
        return ""
    kinds = [str(joint.kind) for joint in analysis.robot.variables]
    shifted = [
        f"{joint_symbol(i, kind)} = q{i} {'+' if shift > 0 else '−'} {abs(shift):.6g}"
        for i, (shift, kind) in enumerate(zip(joined.shifts, kinds, strict=True), 1)
        if shift
    ]
    letters = [f"{name} = {value:.6g} m".replace("-", "−") for name, value in (joined.letters or {}).items()]
    text = " In them s2 is sin θ2, c23 cos(θ2+θ3)" + (f", {', '.join(letters)}" if letters else "")
    return text + (f"; there {', '.join(shifted)}." if shifted else ".")
