"""What dependent-screw suppression goes through and ends in: cases and families."""

from __future__ import annotations

from dataclasses import dataclass

from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.suppression.basic_screws import Basic
from rankdrop.exact.suppression.dependence import Dependence
from rankdrop.exact.suppression.stratum import Stratum


@dataclass(frozen=True)
class Case:
    """One node of the hand calculation.

    Attributes:
        number: "1", "1.2", …; "" for the start.
        stratum: where it holds.
        joints: numbers of the screws that are left.
        dependence: of the screw suppressed in it; None where none is.
        basic: the six screws whose determinant is taken next; None where there is none to take.
        cases: what it falls into.
        split: whether the cases are there because no screw is dependent everywhere, not for a determinant's factors.
        family: number (from 1) of the family that the case is; 0 where it is none.
    """

    number: str
    stratum: Stratum
    joints: tuple[int, ...]
    dependence: Dependence | None = None
    basic: Basic | None = None
    cases: tuple[Case, ...] = ()
    split: bool = False
    family: int = 0


@dataclass(frozen=True)
class SuppressedFamily:
    """One family of singular configurations.

    Attributes:
        number: from 1.
        stratum: its conditions = 0 and ≠ 0.
        chain: the cases on the way to it, from the start to itself.
        ranks: every rank of all screws found at random points of it modulo p, ascending.
    """

    number: int
    stratum: Stratum
    chain: tuple[Case, ...]
    ranks: tuple[int, ...]

    @property
    def equalities(self) -> tuple[Polynomial, ...]:
        """Trigonometric polynomials that vanish, as they read with pinned joints at their angles."""
        return self.stratum.closed

    @property
    def inequalities(self) -> tuple[Polynomial, ...]:
        """Trigonometric polynomials that do not vanish."""
        return self.stratum.open
