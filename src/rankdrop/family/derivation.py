"""The exact derivation that an analysis rests on: what was derived, and what points found numerically show against it.

`Derivation` is the record for JSON; what is printed of it stands in `text/families.py`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from rankdrop.family.record import Pin

AGREES, DIFFERS, NOT_DERIVED = "agrees", "differs", "not derived"
INTERRUPTED = "interrupted"
ASKED = ("auto", "on", "off")


@dataclass(frozen=True, slots=True)
class ExactRow:
    """The exact conditions of one family, ready to be shown.

    Attributes:
        id: of the family in the table of the analysis.
        name: in words.
        corank, dimension: of the family.
        pinned: joints at fixed values of q; their conditions are the first of `conditions`.
        conditions: for people: "θ4 = 0 or π", "a2 c2 + a3 c23 = 0".
        latex: the same as LaTeX mathematics.
        reality: "" where the family is real whatever the lengths are; else when it is.
    """

    id: str
    name: str
    corank: int
    dimension: int
    pinned: tuple[Pin, ...]
    conditions: tuple[str, ...]
    latex: tuple[str, ...]
    reality: str


@dataclass(frozen=True, slots=True)
class Derivation:
    """The exact derivation of the families of an arm.

    Attributes:
        status: "agrees": derived, and no numerical test contradicts it; "differs": some do; "not derived": the families
            of the analysis are fitted to points.
        asked: "auto" or "on".
        seconds: the time limit; not what was spent, which no file holds.
        reason: why nothing was derived; else "".
        letters: lengths that are symbols, and their values [m].
        shifts: θ = q + shift, per joint: exact conditions speak of θ [rad, m].
        families: the conditions of every derived family, of every corank.
        disagreements: sentences; none where derivation and numerical tests agree.
    """

    status: str
    asked: str
    seconds: float
    reason: str = ""
    letters: Mapping[str, float] | None = None
    shifts: tuple[float, ...] = ()
    families: tuple[ExactRow, ...] = ()
    disagreements: tuple[str, ...] = ()

    @property
    def agrees(self) -> bool:
        """Whether the families were derived, and all tests hold."""
        return self.status == AGREES

    @property
    def derived(self) -> bool:
        """Whether the families are those derived."""
        return self.status != NOT_DERIVED

    @property
    def holds(self) -> bool:
        """Whether nothing contradicts the derivation; under "auto" also where nothing was derived."""
        return self.agrees or (not self.derived and self.asked == "auto")

    @property
    def interrupted(self) -> bool:
        """Whether the user asked to stop (Ctrl-C) before the conditions were derived."""
        return self.reason == INTERRUPTED

    def of_row(self, row: str) -> ExactRow | None:
        """The exact conditions of a family by its id; None for points that no family explains."""
        return next((family for family in self.families if family.id == row), None)
