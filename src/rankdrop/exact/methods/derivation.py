"""What a method of derivation hands over: its conditions, and what it cost."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.exact.algebra.atom import Atom
from rankdrop.exact.algebra.field import Point, holds
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.methods.evaluate import Distances
from rankdrop.robot.model import Array

ZERO = 1e-5
"""A condition holds within this distance of its zeros [rad]: where sheets cross, σ = 1e-13 leaves 3e-7."""
CLEAR = 1e-8
"""… and what must not vanish does not where this far off; less than `ZERO`, so that cases overlap and leave no gap."""


@dataclass(frozen=True)
class Equality:
    """One polynomial that vanishes.

    Attributes:
        atoms: its irreducible factors: it vanishes where one of them does; empty where it was not factored.
        whole: the trigonometric polynomial itself, where it was not factored or is shorter so; else None.
    """

    atoms: tuple[Atom, ...]
    whole: Polynomial | None = None

    @property
    def terms(self) -> int:
        """Number of terms: of `whole`, or of all atoms together."""
        if self.whole is not None:
            return len(self.whole)
        return sum(1 if atom.f is None else len(atom.f) for atom in self.atoms)

    def distance(self, distances: Distances) -> Array:
        """First-order distance of configurations from where it holds: (N,) [rad, m]; of atoms the nearest."""
        parts = self.atoms if self.whole is None else (self.whole,)
        return np.asarray(np.min([distances.of(part) for part in parts], axis=0, initial=np.inf))

    def vanishes(self, ring: Ring, point: Point) -> bool:
        """Whether it holds at a point modulo P, exactly."""
        parts = self.atoms if self.whole is None else (self.whole,)
        return any(holds(ring, part, point) for part in parts)


@dataclass(frozen=True)
class Conjunction:
    """Conditions that hold together.

    Attributes:
        equal: all of them vanish; none at all holds everywhere.
        unequal: of each group at least one does not vanish.
    """

    equal: tuple[Equality, ...]
    unequal: tuple[tuple[Equality, ...], ...] = ()

    def holds(self, distances: Distances) -> NDArray[np.bool_]:
        """Whether it holds at configurations, within `ZERO`: (N,)."""
        met = np.ones(len(distances), dtype=np.bool_)
        for equality in self.equal:
            met &= equality.distance(distances) <= ZERO
            if not met.any():
                return met
        for group in self.unequal:
            met &= np.max([equality.distance(distances) for equality in group], axis=0) > CLEAR
        return met

    def holds_modulo(self, ring: Ring, point: Point) -> bool:
        """Whether it holds at a point modulo P, exactly."""
        return all(equality.vanishes(ring, point) for equality in self.equal) and all(
            any(not equality.vanishes(ring, point) for equality in group) for group in self.unequal
        )


@dataclass(frozen=True)
class Derivation:
    """A singular set as one method finds it.

    Attributes:
        chain: the arm and its task.
        method: one of `METHODS`.
        conditions: a configuration is singular where one of these holds.
        generic: whether configurations were left out that `notes` tell of: the conditions are necessary off them only.
        assumptions: polynomials in lengths, of the half-angle ring, taken not to vanish.
        notes: what is to be said of the answer, in words.
        sizes: figures of what was met on the way ("minors", "terms", …).
        left: what was not finished within the time; empty where everything was.
        seconds: spent.
    """

    chain: Chain
    method: str
    conditions: tuple[Conjunction, ...]
    generic: bool
    assumptions: tuple[Polynomial, ...]
    notes: tuple[str, ...]
    sizes: Mapping[str, int] = field(default_factory=dict)
    left: tuple[str, ...] = ()
    seconds: float = 0.0

    @property
    def complete(self) -> bool:
        """Whether every case was finished."""
        return not self.left

    def holds(self, q: ArrayLike) -> NDArray[np.bool_]:
        """Whether one of the conditions holds at configurations q (N, n), within `ZERO`: (N,)."""
        distances = Distances(self.chain, q)
        met = np.zeros(len(distances), dtype=np.bool_)
        for conjunction in self.conditions:
            met |= conjunction.holds(distances)
        return met

    def holds_modulo(self, points: Iterable[Point]) -> tuple[bool, ...]:
        """Whether one of the conditions holds at each of the points modulo P, exactly."""
        return tuple(any(c.holds_modulo(self.chain.ring, point) for c in self.conditions) for point in points)
