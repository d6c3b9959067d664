"""Were the families of an analysis derived exactly, and do the numerical tests agree with the derivation?

The printed form is made in `text/derivation.py`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from rankdrop.families.contradiction import Contradiction
from rankdrop.families.not_derived import NotDerived, NotDerivedKind

AGREES, DIFFERS, NOT_DERIVED = "agrees", "differs", "not derived"
ASKED = ("auto", "on", "off")


@dataclass(frozen=True, slots=True)
class Derivation:
    """The exact derivation of the families of an arm; what it gives for each of them is `Family.exact`.

    Attributes:
        status: "agrees": derived, and no numerical test contradicts it; "differs": some do; "not derived": the families
            of the analysis are fitted to points.
        asked: "auto" or "on".
        seconds: the time limit; not what was spent, which no file holds.
        reason: why nothing was derived, `str` gives the words; None where the families were derived.
        letters: lengths that are symbols, and their values [m].
        shifts: θ = q + shift, per joint: exact conditions speak of θ [rad, m].
        disagreements: none where derivation and numerical tests agree; `str` gives a sentence.
        first_derived: of an analysis that is "not derived": its families of corank 1 are derived all the same, from
            det J.
    """

    status: str
    asked: str
    seconds: float
    reason: NotDerived | None = None
    letters: Mapping[str, float] | None = None
    shifts: tuple[float, ...] = ()
    disagreements: tuple[Contradiction, ...] = ()
    first_derived: bool = False

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
        return self.reason is not None and self.reason.kind is NotDerivedKind.INTERRUPTED
