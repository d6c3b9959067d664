"""The records of the atlas: one family (a row of the table), one corank's summary, and their parts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from rankdrop.family.equation import Equation
from rankdrop.robot.model import Array


@dataclass(frozen=True, slots=True)
class Pinned:
    """A joint that stands at one of a few values on the whole family.

    Attributes:
        joint: name.
        number: counted from 1.
        values: in (−π, π] [rad], or [m] for a prismatic joint; every combination of the values of a family's pinned
            joints belongs to the family.
    """

    joint: str
    number: int
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Soundness:
    """Solutions of a family's equations from random starts: `singular` of `tested` have the corank or more."""

    tested: int
    singular: int

    @property
    def holds(self) -> bool:
        """Every solution was singular, and there was at least one."""
        return 0 < self.tested == self.singular


@dataclass(frozen=True, slots=True)
class Share:
    """`explained` of `tested` independent singular configurations."""

    tested: int
    explained: int


@dataclass(frozen=True, slots=True)
class Unseen:
    """Share of the search's convergence mass that lies on sets that no point has met.

    Attributes:
        estimate: Good–Turing.
        upper: upper bound at 95 % confidence.
        how: the estimator in words, with the counts it used.
    """

    estimate: float
    upper: float
    how: str


@dataclass(frozen=True, eq=False)
class Family:
    """One family of singular configurations: a piece of the singular set with conditions of one form.

    Attributes:
        id: "k1.f1": corank 1, first row.
        name: "elbow", "wrist" …, or what the joints do.
        corank: rank lost on the family.
        dimension: of the family in joint space; for a family that is not named an upper bound (dim ker D).
        pinned: joints at fixed values.
        free: numbers of the joints that the family does not depend on.
        coupled: numbers of the joints bound together by the remaining equations.
        equations: every condition, those of the pinned joints included; the family is their common zero set.
            Empty where no condition was found (`named` is False then).
        witness: a configuration on the family, of exactly this corank.
        lost_directions: (k, 6) rows (v; ω), orthonormal, at the witness.
        lost_words: one sentence per lost direction.
        soundness: the equations solved from random starts, and the rank there.
        explained: share of the fresh points of this corank that lie on this family.
        evidence: how the conditions were obtained.
        named: False for a family whose points were found but whose conditions were not.
    """

    id: str
    name: str
    corank: int
    dimension: int
    pinned: tuple[Pinned, ...]
    free: tuple[int, ...]
    coupled: tuple[int, ...]
    equations: tuple[Equation, ...]
    witness: tuple[float, ...]
    lost_directions: Array  # (k, 6)
    lost_words: tuple[str, ...]
    soundness: Soundness
    explained: Share
    evidence: str
    named: bool = True

    def __post_init__(self) -> None:
        directions = np.array(self.lost_directions, dtype=np.float64)
        directions.flags.writeable = False
        object.__setattr__(self, "lost_directions", directions)


@dataclass(frozen=True, slots=True)
class CorankSummary:
    """What the search met at one corank.

    Attributes:
        corank, rank: corank k and the rank kept.
        starts, converged, near_misses, slow: of the cloud the families were made from.
        smallest_near_miss: smallest σ of a nonzero local minimum; None when there was none.
        completeness: fresh points of exactly this corank, and how many of them some named row explains.
        higher: fresh points whose corank is higher; they belong to the table of that corank and are not counted above.
        unseen: what sampling may have missed.
    """

    corank: int
    rank: int
    starts: int
    converged: int
    near_misses: int
    slow: int
    smallest_near_miss: float | None
    completeness: Share
    higher: int
    unseen: Unseen


@dataclass(frozen=True, slots=True, eq=False)
class CorankFamilies:
    """All rows of one corank with their summary.

    Attributes:
        summary: what the search met.
        families: in their order.
        fresh: (N, n) the points that completeness was counted on.
    """

    summary: CorankSummary
    families: tuple[Family, ...]
    fresh: Array = field(default_factory=lambda: np.zeros((0, 0)))


Order = tuple[int, tuple[int, ...], tuple[int, ...], tuple[tuple[float, ...], ...], tuple[str, ...]]


def place_of(dimension: int, pinned: Iterable[Pinned], coupled: Iterable[int], texts: Iterable[str]) -> Order:
    """What decides the place of a family among those of its corank, hence its id: the set, not how it was found.

    Large families first; then by joints that are pinned, joints that are coupled, values, and the conditions in words.

    Args:
        dimension: of the family.
        pinned: joints at fixed values of q.
        coupled: numbers of the joints bound together.
        texts: its conditions for people.
    """
    pins = sorted(pinned, key=lambda one: one.number)
    values = tuple(tuple(sorted(round(value, 6) + 0.0 for value in one.values)) for one in pins)
    return -dimension, tuple(one.number for one in pins), tuple(sorted(coupled)), values, tuple(texts)


def numbered(rows: Sequence[Family], corank: int, after: int = 0) -> tuple[Family, ...]:
    """Rows in their places with the ids that go with them; those without conditions come last.

    Args:
        rows: of one corank.
        corank: of all of them.
        after: the number of the family before the first.
    """

    def place(row: Family) -> tuple[bool, Order]:
        texts = (str(equation) for equation in row.equations)
        return not row.named, place_of(row.dimension, row.pinned, row.coupled, texts)

    ordered = sorted(rows, key=place)
    return tuple(replace(row, id=f"k{corank}.f{number}") for number, row in enumerate(ordered, after + 1))
