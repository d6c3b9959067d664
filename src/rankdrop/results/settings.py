"""What an analysis was asked, and how a witness of it holds when it is evaluated again."""

from __future__ import annotations

from dataclasses import dataclass

from rankdrop.tolerances import Tolerances


@dataclass(frozen=True, slots=True)
class Settings:
    """What the analysis was asked to do; together with the robot and the version it determines the result.

    Attributes:
        seed: every random choice comes from it.
        starts: random starts for each corank.
        limits: starts and fresh points within the joint limits only.
        length_scale: translation rows were divided by it [m].
        tolerances: every threshold used.
        version: of rankdrop.
    """

    seed: int
    starts: int
    limits: bool
    length_scale: float
    tolerances: Tolerances
    version: str


@dataclass(frozen=True, slots=True)
class Residual:
    """A witness, or the worst of several, evaluated again.

    Attributes:
        equation: largest |equation| at the witness (0 where the family has none).
        sigma: largest of the singular values that have to vanish.
        kept: smallest of those that must not.
    """

    equation: float
    sigma: float
    kept: float

    def holds(self, tolerances: Tolerances) -> bool:
        """Whether the witness satisfies its equations and has exactly the corank of its family."""
        return self.equation <= tolerances.explained and self.sigma <= tolerances.singular < self.kept
