"""What a method of derivation hands over: its conditions, and what it cost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.exact.chain import Chain
from rankdrop.exact.flint import Polynomial
from rankdrop.exact.ring import Atom
from rankdrop.robot.model import Array

ZERO = 1e-6
"""|f| per size of its coefficients at or below this is zero: where sheets cross, σ = 1e-13 leaves 3e-7."""
_ANGLES = {"0": 0.0, "pi": pi, "pi/2": pi / 2, "-pi/2": -pi / 2}


@dataclass(frozen=True)
class Equality:
    """One polynomial that vanishes.

    Attributes:
        atoms: its irreducible factors: it vanishes where one of them does; empty where it was not factored.
        whole: the trigonometric polynomial itself, where it was not factored or is shorter so; else None.
        order: 2 for a sum of squares, which grows with the square of the distance only, else 1.
    """

    atoms: tuple[Atom, ...]
    whole: Polynomial | None = None
    order: int = 1

    @property
    def terms(self) -> int:
        """Number of terms: of `whole`, or of all atoms together."""
        if self.whole is not None:
            return len(self.whole)
        return sum(1 if atom.f is None else len(atom.f) for atom in self.atoms)

    def size(self, chain: Chain, q: ArrayLike) -> Array:
        """How far f is from zero at configurations q (N, n), per size of its coefficients: (N,); zero where it holds.

        Of atoms the smallest counts. Sums of squares are measured by their roots.
        """
        theta = np.atleast_2d(np.asarray(q, dtype=np.float64)) + chain.shifts
        if self.whole is not None:
            found = _trigonometric(chain, self.whole, theta)
        else:
            found = np.min([_atom(chain, atom, theta) for atom in self.atoms], axis=0)
        return np.asarray(found ** (1.0 / self.order))


@dataclass(frozen=True)
class Conjunction:
    """Conditions that hold together.

    Attributes:
        equal: all of them vanish; none at all holds everywhere.
        unequal: of each group at least one does not vanish.
    """

    equal: tuple[Equality, ...]
    unequal: tuple[tuple[Equality, ...], ...] = ()

    def holds(self, chain: Chain, q: ArrayLike, zero: float = ZERO) -> NDArray[np.bool_]:
        """Whether the conjunction holds at configurations q (N, n): (N,).

        Args:
            chain: the arm.
            q: [rad, m].
            zero: `Equality.size` up to this is zero.
        """
        rows = np.atleast_2d(np.asarray(q, dtype=np.float64))
        met = np.ones(len(rows), dtype=np.bool_)
        for equality in self.equal:
            met &= equality.size(chain, rows) <= zero
        for group in self.unequal:
            met &= np.max([equality.size(chain, rows) for equality in group], axis=0) > zero
        return met


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

    def holds(self, q: ArrayLike, zero: float = ZERO) -> NDArray[np.bool_]:
        """Whether one of the conditions holds at configurations q (N, n): (N,)."""
        rows = np.atleast_2d(np.asarray(q, dtype=np.float64))
        met = np.zeros(len(rows), dtype=np.bool_)
        for conjunction in self.conditions:
            met |= conjunction.holds(self.chain, rows, zero)
        return met


def _trigonometric(chain: Chain, p: Polynomial, theta: Array) -> Array:
    """|p| at angles and slides (N, n), per sum of the sizes of its terms' coefficients."""
    columns = []
    for j in chain.ring.revolute:
        columns += [np.sin(theta[:, j - 1]), np.cos(theta[:, j - 1])]
    return _relative(chain, p, columns, theta)


def _atom(chain: Chain, atom: Atom, theta: Array) -> Array:
    """|f| of an atom: t^e of degree D stands for sin^e(θ/2) cos^(D−e)(θ/2), which is finite at θ = π, too."""
    if atom.f is None:
        return np.asarray(np.abs(np.sin((theta[:, atom.joint - 1] - _ANGLES[atom.value]) / 2)))
    halves = [theta[:, j - 1] / 2 for j in chain.ring.revolute]
    homogeneous = np.ones(len(theta))
    for half, degree in zip(halves, atom.f.degrees(), strict=False):
        homogeneous = homogeneous * np.cos(half) ** int(degree)
    return np.asarray(_relative(chain, atom.f, [np.tan(half) for half in halves], theta, homogeneous))


def _relative(
    chain: Chain, f: Polynomial, angles: list[Array], theta: Array, factor: Array | float = 1.0
) -> Array:
    """|factor · f| with the values of its first variables given, per sum of the sizes of its coefficients.

    A slide counts for the coefficients; its size there is at least 1.
    """
    slides = [theta[:, j - 1] for j in chain.ring.prismatic]
    lengths = [np.full(len(theta), chain.numbers[name]) for name in chain.ring.letters]
    values = [*angles, *slides, *lengths]
    sizes = [np.ones(len(theta))] * len(angles) + [np.maximum(np.abs(x), 1.0) for x in slides] + list(map(np.abs, lengths))
    total, scale = np.zeros(len(theta)), np.zeros(len(theta))
    for powers, coefficient in f.terms():
        number = int(coefficient.p) / int(coefficient.q)
        term, size = np.full(len(theta), number), np.full(len(theta), abs(number))
        for value, most, power in zip(values, sizes, powers, strict=True):
            if power:
                term, size = term * value ** int(power), size * most ** int(power)
        total, scale = total + term, scale + size
    return np.asarray(np.abs(total * factor) / scale)
