"""What a condition that a person wrote means in the ring of an arm, without rounding and without evaluating text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.exact.algebra.atom import Atom
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.reading.grammar import read
from rankdrop.exact.reading.meaning import Meaning
from rankdrop.robot.model import Array


@dataclass(frozen=True)
class Parsed:
    """A condition as a function on the torus: f · √2^root / Π (1 + t_j²)^(D_j / 2).

    Attributes:
        text: as written.
        ring: of f.
        f: of the half-angle ring; not factored.
        degrees: D_j of each revolute joint; f may have a lower degree in t_j: a zero at θ_j = π.
        root: 0 or 1.
    """

    text: str
    ring: Ring
    f: Polynomial
    degrees: tuple[int, ...]
    root: int = 0

    @cached_property
    def atoms(self) -> tuple[Atom, ...]:
        """The irreducible conditions that it is zero under; none where it is never zero.

        Raises:
            ZeroDivisionError: f is zero everywhere.
        """
        if self.f == 0:
            raise ZeroDivisionError("a condition that always holds has no irreducible parts")
        _, _, found = self.ring.split(self.f)
        own = self.f.degrees()
        missing = [
            self.ring.pin(j, "pi") for k, j in enumerate(self.ring.revolute) if int(own[k]) < self.degrees[k]
        ]
        return (*missing, *(atom for atom, _ in found))

    @cached_property
    def letters(self) -> tuple[Polynomial, ...]:
        """Factors in lengths alone: for special lengths the condition always holds."""
        return () if self.f == 0 else tuple(factor for factor, _ in self.ring.split(self.f)[1])

    def __call__(self, theta: ArrayLike, letters: dict[str, float]) -> Array:
        """The value at angles.

        Args:
            theta: (..., n) angles [rad], variables of slides [m].
            letters: value of each length [m].

        Returns:
            (...,) values.
        """
        theta = np.asarray(theta, dtype=np.float64)
        ring = self.ring
        sines = {k: np.sin(theta[..., j - 1] / 2) for k, j in enumerate(ring.revolute)}
        cosines = {k: np.cos(theta[..., j - 1] / 2) for k, j in enumerate(ring.revolute)}
        rest = [theta[..., j - 1] for j in ring.prismatic] + [np.float64(letters[name]) for name in ring.letters]
        total = np.zeros(theta.shape[:-1])
        for powers, number in self.f.terms():
            value = np.full(theta.shape[:-1], float(Fraction(int(number.p), int(number.q))))
            for k, degree in enumerate(self.degrees):
                value = value * sines[k] ** int(powers[k]) * cosines[k] ** (degree - int(powers[k]))
            for x, power in zip(rest, powers[ring.angles :], strict=True):
                value = value * x ** int(power)
            total = total + value
        return np.asarray(total * 2 ** (self.root / 2))


def parse_conditions(text: str, ring: Ring, *, shifts: Sequence[float] | None = None) -> tuple[Parsed, ...]:
    """The conditions of a text, all of which are to hold: separated by ";", "," or "and".

    Sums, products and whole powers of numbers, lengths, variables of slides, sin and cos of whole and half
    combinations of joint angles plus quarter turns, written as people do: sin(q2 + q3), s23, cos(θ4/2), π/2, 2θ3,
    a2 c2. "left = right" means that the difference is zero. Angles may stand for themselves on both sides, modulo 2π:
    θ4 = 0 or π, θ5 = θ3 + π.

    Args:
        text: as above.
        ring: its joints and lengths may be named.
        shifts: θ_j = q_j + shifts[j − 1] [rad]; None for none.

    Returns:
        One per condition.

    Raises:
        OptionError: a mistake in the text, with its place; or a condition that is no polynomial, or has no sign.

    Example:
        >>> ring = Ring([3, 5])
        >>> [atom.key for atom in parse_conditions("θ5 = θ3 + π; sin(q3) = 0", ring)[1].atoms]
        ['θ3=pi', 'θ3=0']
    """
    meaning = Meaning(text, ring, shifts)
    found = []
    for one in read(text, frozenset(ring.letters)):
        value = meaning.statement(one)
        found.append(Parsed(one.text, ring, value.f, value.degrees, value.root))
    return tuple(found)
