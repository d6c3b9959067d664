"""The exact conditions beside an analysis: what was derived, and whether it is what was found. A record for JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rankdrop.compare.match import Match, Wider
from rankdrop.exact.check import Check
from rankdrop.family.record import Pinned

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
