"""A condition as it is written: sums of products of lengths, slides, sines and cosines, and of sums in brackets.

One tree serves every output (text, LaTeX, Python, C) and the reader of what a user wrote. `half_of` takes it back to
the half-angle ring without rounding, so that every way of writing a condition can be held against the polynomial.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm
from typing import Any, TypeAlias

from rankdrop.exact.algebra.flint import Polynomial, flint
from rankdrop.exact.algebra.ring import Ring


@dataclass(frozen=True, slots=True)
class Wave:
    """sin or cos of a combination of joint angles.

    Attributes:
        kind: "sin" or "cos".
        turns: (joint, twice its multiple), joints ascending, no zeros, the first multiple positive.
    """

    kind: str
    turns: tuple[tuple[int, int], ...]

    @property
    def halved(self) -> bool:
        """Whether half an angle occurs."""
        return any(multiple % 2 for _, multiple in self.turns)


@dataclass(frozen=True, slots=True)
class Symbol:
    """A length, or the variable q_j of a slide.

    Attributes:
        name: as in the ring.
        slide: number of the prismatic joint; 0 for a length.
    """

    name: str
    slide: int = 0


@dataclass(frozen=True, slots=True)
class Product:
    """number · Π factor^power.

    Attributes:
        number: exact.
        factors: (factor, power ≥ 1), lengths first, then slides, waves, and sums.
    """

    number: Fraction
    factors: tuple[tuple[Factor, int], ...] = ()


@dataclass(frozen=True, slots=True)
class Sum:
    """Products added up, in the order they are written.

    Attributes:
        parts: at least one.
    """

    parts: tuple[Product, ...]


Factor: TypeAlias = Wave | Symbol | Sum


def wave(kind: str, turns: Mapping[int, int]) -> tuple[int, Wave | None]:
    """(sign, wave) of sin or cos of Σ turns_j θ_j / 2; the wave is None for sin 0 (sign 0) and cos 0 (sign 1)."""
    kept = tuple(sorted((j, m) for j, m in turns.items() if m))
    if not kept:
        return (1 if kind == "cos" else 0), None
    if kept[0][1] > 0:
        return 1, Wave(kind, kept)
    return (1 if kind == "cos" else -1), Wave(kind, tuple((j, -m) for j, m in kept))


def product(number: Fraction | int, factors: Iterable[tuple[Factor, int]]) -> Product:
    """number · Π factor^power with equal factors gathered, sums of one part opened, factors in order."""
    number = Fraction(number)
    powers: dict[Factor, int] = {}
    waiting = list(factors)
    while waiting:
        factor, power = waiting.pop()
        if isinstance(factor, Sum) and len(factor.parts) == 1:
            number *= factor.parts[0].number ** power
            waiting += [(inner, p * power) for inner, p in factor.parts[0].factors]
        elif power:
            powers[factor] = powers.get(factor, 0) + power
    return Product(number, tuple(sorted(powers.items(), key=lambda item: _rank(item[0]))))


def total(parts: Iterable[Product]) -> Product:
    """The sum of products as number · (sum with whole coprime numbers, the first one positive), parts in order."""
    kept: dict[tuple[tuple[Factor, int], ...], Fraction] = {}
    for part in parts:
        kept[part.factors] = kept.get(part.factors, Fraction(0)) + part.number
    ordered = sorted((Product(n, factors) for factors, n in kept.items() if n), key=_place)
    if not ordered:
        return Product(Fraction(0))
    if len(ordered) == 1:
        return ordered[0]
    content = Fraction(gcd(*(p.number.numerator for p in ordered)), lcm(*(p.number.denominator for p in ordered)))
    if ordered[0].number < 0:
        content = -content
    return Product(content, ((Sum(tuple(Product(p.number / content, p.factors) for p in ordered)), 1),))


def _rank(factor: Factor) -> tuple[Any, ...]:
    if isinstance(factor, Symbol):
        return (factor.slide > 0, factor.slide, factor.name, ())
    if isinstance(factor, Wave):
        return (2, len(factor.turns) > 1, factor.kind, factor.turns)
    return (3, len(factor.parts), "", tuple(_place(part) for part in factor.parts))


def _place(part: Product) -> tuple[Any, ...]:
    """Where a product stands in a sum: by its lengths, then slides, then angles; pure numbers come last."""
    lengths = [f.name for f, power in part.factors for _ in range(power) if isinstance(f, Symbol) and not f.slide]
    slides = [f.slide for f, power in part.factors for _ in range(power) if isinstance(f, Symbol) and f.slide]
    waves = [(f.turns, f.kind) for f, power in part.factors for _ in range(power) if isinstance(f, Wave)]
    sums = [_rank(f) for f, _ in part.factors if isinstance(f, Sum)]
    return (not lengths, lengths, not slides, [-j for j in slides], not waves and not sums, waves, sums)


def half_of(form: Product, ring: Ring) -> tuple[Polynomial, tuple[int, ...]]:
    """A form in half-angle tangents: (f, D) with form = f / Π (1 + t_j²)^(D_j / 2), exactly.

    Args:
        form: of the ring's joints and lengths.
        ring: of the result.

    Returns:
        f of `ring.half` and one D_j per revolute joint.

    Raises:
        ValueError: parts of a sum differ in the parity of a half angle: the form has no sign on the torus.

    Example:
        >>> ring = Ring([1, 2])
        >>> half_of(Product(Fraction(2), ((Wave("cos", ((1, 1), (2, 1))), 1),)), ring)
        (-2*t1*t2 + 2, (1, 1))
    """
    f, degrees = number_of(form.number, ring), (0,) * ring.angles
    for factor, power in form.factors:
        one, more = _half_of_factor(factor, ring)
        f = f * one**power
        degrees = tuple(d + power * m for d, m in zip(degrees, more, strict=True))
    return f, degrees


def number_of(value: Fraction, ring: Ring) -> Polynomial:
    """A number as an element of the half-angle ring."""
    return ring.half.constant(flint().fmpq(value.numerator, value.denominator))


def _half_of_factor(factor: Factor, ring: Ring) -> tuple[Polynomial, tuple[int, ...]]:
    none = (0,) * ring.angles
    if isinstance(factor, Symbol):
        return (ring.q_half[factor.slide] if factor.slide else ring.letter_half[factor.name]), none
    if isinstance(factor, Wave):
        turns = dict(factor.turns)
        real, imaginary = ring.half.constant(1), ring.half.constant(0)
        for j, multiple in factor.turns:  # exp(i m θ / 2) = ((1 + i t) / √(1 + t²))^m
            t = ring.t[j] if multiple > 0 else -ring.t[j]
            for _ in range(abs(multiple)):
                real, imaginary = real - t * imaginary, imaginary + t * real
        return (real if factor.kind == "cos" else imaginary), tuple(abs(turns.get(j, 0)) for j in ring.revolute)
    return added([half_of(part, ring) for part in factor.parts], ring)


def added(
    parts: Sequence[tuple[Polynomial, tuple[int, ...]]], ring: Ring
) -> tuple[Polynomial, tuple[int, ...]]:
    """The sum of forms that are given as polynomials with degrees, over their common degrees.

    Raises:
        ValueError: parts differ in the parity of a half angle.
    """
    degrees = tuple(max(column) for column in zip(*(d for _, d in parts), strict=True)) if ring.angles else ()
    f = ring.half.constant(0)
    for one, own in parts:
        for j, most, d in zip(ring.revolute, degrees, own, strict=True):
            if (most - d) % 2:
                raise ValueError(f"terms with θ{j}/2 and terms without it do not add up")
            if most > d:
                one = one * (1 + ring.t[j] ** 2) ** ((most - d) // 2)
        f = f + one
    return f, degrees
