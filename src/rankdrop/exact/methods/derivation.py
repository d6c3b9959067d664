"""What a method of derivation hands over: its conditions, in polynomials and in words, and what it cost.

At configurations they say how far off they vanish. In words factors are joined by "or", polynomials by "and", and
exceptions stand at the end.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.exact.algebra.field import Point, holds
from rankdrop.exact.algebra.polynomial import Atom, Equality, Polynomial
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.writing.condition import RADIANS, AnglePin, Condition
from rankdrop.exact.writing.form import fourier
from rankdrop.exact.writing.notation import Text
from rankdrop.exact.writing.value import condition_text, single_angles
from rankdrop.robot.model import Array
from rankdrop.units import into_units

STEP = 1e-5
"""Of central differences [rad, m]: rounding leaves 1e-11 of the gradient, the third derivative 1e-10."""


NOISE = 1e-10
"""Slopes below it, relative to the coefficients, may be rounding: ten times what `STEP` leaves of it."""


class Distances:
    """Distances of configurations from the zeros of polynomials, to first order: |f|/|∇f|, half the distance from the
    zeros of a sum of squares; where the slope may be rounding, the smaller of that and √|f|.

    What was asked for once is kept: the cases of a derivation speak of few different polynomials.

    Args:
        chain: the arm.
        q: (N, n) configurations [rad, m].
    """

    def __init__(self, chain: Chain, q: ArrayLike) -> None:
        self._chain = chain
        self._theta = into_units(chain.robot, np.atleast_2d(np.asarray(q, dtype=np.float64))) + chain.shifts
        self._known: dict[str, Array] = {}

    def __len__(self) -> int:
        return len(self._theta)

    def of(self, f: Polynomial | Atom) -> Array:
        """(N,) [rad; slides in the arm's own unit] of a trigonometric polynomial or an atom; f is divided by the size
        of its coefficients.
        """
        key = f.key if isinstance(f, Atom) else str(f)
        if key not in self._known:
            self._known[key] = self._computed(f)
        return self._known[key]

    def _computed(self, f: Polynomial | Atom) -> Array:
        """|f|/|∇f| by central differences, or the smaller of that and √|f| where the slope may be rounding."""
        chain, theta = self._chain, self._theta
        if isinstance(f, Atom) and f.f is None:
            return np.asarray(2 * np.abs(np.sin((theta[:, f.joint - 1] - RADIANS[f.value]) / 2)))
        value, scale = values_of(chain, f, theta)
        slope = np.zeros_like(theta)
        for j in range(chain.n):
            step = STEP * np.eye(chain.n)[j]
            slope[:, j] = (values_of(chain, f, theta + step)[0] - values_of(chain, f, theta - step)[0]) / (2 * STEP)
        size, steep = np.abs(value) / scale, np.linalg.norm(slope, axis=1) / scale
        ratio = size / np.maximum(steep, 1e-300)
        return np.asarray(np.where(steep > NOISE, ratio, np.minimum(ratio, np.sqrt(size))))


def values_of(chain: Chain, f: Polynomial | Atom, theta: Array) -> tuple[Array, Array]:
    """(value, size of the coefficients), both (N,), lengths in the arm's own unit, at θ (N, n); of an atom the
    homogeneous value, which is finite at θ = π, too: t^e of degree D stands for sin^e(θ/2) cos^(D−e)(θ/2).
    """
    ring = chain.ring
    angles = [theta[:, j - 1] for j in ring.revolute]
    if isinstance(f, Atom):
        factors = [
            (np.sin(angle / 2), np.cos(angle / 2), int(degree))
            for angle, degree in zip(angles, f.f.degrees(), strict=False)
        ]
        powers = [[s**e * c ** (d - e) for e in range(d + 1)] for s, c, d in factors]
        return _sum(chain, chain.own_polynomial(f.f), theta, powers)
    tables = []
    for angle, j in zip(angles, ring.revolute, strict=True):
        place = 2 * ring.revolute.index(j)
        for wave, degree in zip((np.sin(angle), np.cos(angle)), f.degrees()[place : place + 2], strict=True):
            tables.append([wave**e for e in range(int(degree) + 1)])
    return _sum(chain, chain.own_polynomial(f), theta, tables)


def _sum(chain: Chain, f: Polynomial, theta: Array, angles: list[list[Array]]) -> tuple[Array, Array]:
    """Σ of the terms with the powers of the first variables given in tables, and of their sizes.

    Angles enter sizes as 1, slides as 1 at least.
    """
    slides = [theta[:, j - 1] for j in chain.ring.prismatic]
    lengths = [chain.own_numbers[name] for name in chain.ring.letters]
    one = np.ones(len(theta))
    total, scale = 0 * one, 0 * one
    for powers, coefficient in f.terms():
        number = int(coefficient.p) / int(coefficient.q)
        for length, power in zip(lengths, powers[len(angles) + len(slides) :], strict=True):
            number *= length ** int(power)
        term, size = number * one, abs(number) * one
        for table, power in zip(angles, powers, strict=False):
            term = term * table[int(power)]
        for slide, power in zip(slides, powers[len(angles) :], strict=False):
            term, size = term * slide ** int(power), size * np.maximum(np.abs(slide), 1.0) ** int(power)
        total, scale = total + term, scale + size
    return total, scale


ZERO = 1e-5
"""A condition holds within this distance of its zeros [rad]: where sheets cross, σ = 1e-13 leaves 3e-7."""
CLEAR = 1e-8
"""… and what must not vanish does not where this far off; less than `ZERO`, so that cases overlap and leave no gap."""


def _distance(equality: Equality, distances: Distances) -> Array:
    """First-order distance of configurations from where it holds: (N,) [rad, m]; of atoms the nearest."""
    parts = equality.atoms if equality.whole is None else (equality.whole,)
    return np.asarray(np.min([distances.of(part) for part in parts], axis=0, initial=np.inf))


def _vanishes(equality: Equality, ring: Ring, point: Point) -> bool:
    """Whether it holds at a point modulo a prime, exactly."""
    parts = equality.atoms if equality.whole is None else (equality.whole,)
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
            met &= _distance(equality, distances) <= ZERO
            if not met.any():
                return met
        for group in self.unequal:
            met &= np.max([_distance(equality, distances) for equality in group], axis=0) > CLEAR
        return met

    def holds_modulo(self, ring: Ring, point: Point) -> bool:
        """Whether it holds at a point modulo P, exactly."""
        return all(_vanishes(equality, ring, point) for equality in self.equal) and all(
            any(not _vanishes(equality, ring, point) for equality in group) for group in self.unequal
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


READABLE = 30
"""Polynomials of more terms are told by their number of terms: nobody reads them."""


class Words:
    """Conditions of one ring in words; the shortest form of a polynomial is looked for once.

    Args:
        ring: of the chain.
        whole: write every polynomial out; long ones as they are, without a search for their shortest form.

    Example:
        >>> ring = Ring([1, 2])
        >>> atoms = tuple(atom for atom, _ in ring.factor(ring.s[1] * (ring.c[2] - ring.s[2])).atoms)
        >>> Words(ring).conjunction(Conjunction((Equality(atoms),), ((Equality((ring.pin(2, "pi"),)),),)))
        'θ1 = 0 or π or c2 − s2 = 0, where θ2 ≠ π'
    """

    def __init__(self, ring: Ring, *, whole: bool = False) -> None:
        self._ring, self._whole = ring, whole
        self._known: dict[Atom, str] = {}

    def conjunction(self, conjunction: Conjunction) -> str:
        """Everything that has to hold: "θ4 = 0 and (s2 = 0 or …), where θ6 ≠ 0"."""
        equal = [self.equality(equality) for equality in conjunction.equal]
        text = " and ".join(_bracketed(part) if len(equal) > 1 else part for part in equal) or "everywhere"
        unequal = [self._unequal(group) for group in conjunction.unequal]
        return f"{text}, where {' and '.join(unequal)}" if unequal else text

    def equality(self, equality: Equality) -> str:
        """One polynomial that vanishes: its factors, joined by "or"; joints at simple angles together."""
        if equality.whole is not None:
            count = len(equality.whole)
            if count <= READABLE:
                return condition_text(self._ring, equality.whole)
            if not self._whole:
                return _long(count, "")
            return f"{Text().zero(single_angles(self._ring, equality.whole))} = 0"
        pins: dict[int, list[str]] = {}
        for atom in equality.atoms:
            if atom.pinned:
                pins.setdefault(atom.joint, []).append(atom.value)
        texts = [AnglePin(joint, tuple(values)).text() for joint, values in sorted(pins.items())]
        return " or ".join([*texts, *(self._polynomial(atom) for atom in equality.atoms if not atom.pinned)])

    def _polynomial(self, atom: Atom) -> str:
        if atom not in self._known:
            if len(atom.f) <= READABLE:
                self._known[atom] = Condition(self._ring, atom.f).text()
            else:
                self._known[atom] = self._written(atom.f) if self._whole else _long(len(atom.f), "half-angle ")
        return self._known[atom]

    def _written(self, f: Polynomial) -> str:
        """A long half-angle polynomial: in sines and cosines where it has whole angles, else multiplied out."""
        p = self._ring.to_trig(f)
        if p is not None:
            return f"{Text().zero(single_angles(self._ring, p))} = 0"
        return f"{Text().zero(fourier(self._ring.form(f)))} = 0"

    def _unequal(self, group: Sequence[Equality]) -> str:
        texts = [self.equality(equality) for equality in group]
        if len(texts) > 1:
            return "not all of these hold: " + "; ".join(texts)
        if texts[0].count(" = ") == 1 and " or " not in texts[0]:
            return texts[0].replace(" = ", " ≠ ")
        return f"not ({texts[0]})"


def _long(count: int, kind: str) -> str:
    return f"a polynomial of {count} {kind}terms = 0"


def _bracketed(text: str) -> str:
    return f"({text})" if " or " in text else text
