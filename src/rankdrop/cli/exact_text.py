"""How exact conditions and the tables of an analysis compare, in lines below the tables."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rich.text import Text

from rankdrop.compare import AGREES, NOT_DERIVED, exact_conditions
from rankdrop.families import joint_symbol

if TYPE_CHECKING:
    from rankdrop.results import Analysis

_BAD = "bold red"


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
    points = f"{points[0].upper()}{points[1:]}"
    shown = any(exact_conditions(row, joined)[0] for row in analysis.families)
    yield Text(f"Exact conditions, derived apart from the search, {verdict}. {points}.{_symbols(analysis) * shown}")
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
