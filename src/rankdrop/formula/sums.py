"""Formulas: sums of products of lengths, slides, sines and cosines, and of sums in brackets.

One tree serves every output and the reader of what a user wrote. `half_of` takes it back to the half-angle ring
without rounding, so that every way of writing a condition can be held against the polynomial. `fourier` makes it of a
half-angle polynomial: a sum of sines and cosines of half-integer combinations of the angles. t^k of degree D stands for
sin^k(θ/2) cos^(D−k)(θ/2). With z = exp(iθ/2) that is

    (−i)^k 2^(−D) (z − 1/z)^k (z + 1/z)^(D−k),

so that the whole polynomial is multiplied out joint by joint. A combination comes out whole wherever it can: a2 c2 +
a3 c23 has two terms here and three in sines and cosines of single angles.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import comb, gcd, lcm
from typing import Any, TypeAlias

from rankdrop.algebra.polynomial import Polynomial, flint, reduced_roots
from rankdrop.algebra.ring import Form, Ring
from rankdrop.algebra.roots import ROOTS, rational_square

Pair = tuple[int, int]
"""Real and imaginary part, times a number that all have in common: whole numbers are faster than fractions."""


@dataclass(frozen=True, slots=True)
class Wave:
    """sin or cos of a combination of joint angles.

    Attributes:
        kind: "sin" or "cos".
        turns: (joint, twice its multiple), joints ascending, no zeros, the first multiple positive.
        less: simple angle that is taken from Σ turns_j θ_j, and half of it from the argument.
    """

    kind: str
    turns: tuple[tuple[int, int], ...]
    less: str = "0"

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
    """number · Π factor^power with equal factors gathered, sums of one part opened, √2² as 2, factors in order."""
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
    for root in [factor for factor in powers if isinstance(factor, Symbol) and powers[factor] > 1]:
        square = rational_square(root.name)
        if square is not None:
            number *= square ** (powers[root] // 2)
            powers[root] %= 2
    powers = {factor: power for factor, power in powers.items() if power}
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


def derivative(form: Product, joint: int) -> Product:
    """The derivative of a form by the variable of one joint, equal to it; number 0 where it does not depend on it."""
    parts = []
    for place, (factor, power) in enumerate(form.factors):
        inner = _slope(factor, joint)
        if inner.number:
            others = [(left, p) for k, (left, p) in enumerate(form.factors) if k != place]
            outer = [*others, *inner.factors, (factor, power - 1)]
            parts.append(product(form.number * power * inner.number, outer))
    return total(parts)


def _slope(factor: Factor, joint: int) -> Product:
    if isinstance(factor, Symbol):
        return Product(Fraction(int(factor.slide == joint)))
    if isinstance(factor, Sum):
        return total(derivative(part, joint) for part in factor.parts)
    half = Fraction(dict(factor.turns).get(joint, 0), 2)
    if factor.kind == "sin":
        return Product(half, ((replace(factor, kind="cos"), 1),))
    return Product(-half, ((replace(factor, kind="sin"), 1),))


def _rank(factor: Factor) -> tuple[Any, ...]:
    """Sort key of factors in a product: lengths, slides, single waves, combined ones, sums."""
    if isinstance(factor, Symbol):
        return (factor.slide > 0, factor.slide, factor.name, ())
    if isinstance(factor, Wave):
        return (2, len(factor.turns) > 1, factor.kind, factor.turns)
    return (3, len(factor.parts), "", tuple(_place(part) for part in factor.parts))


def _place(part: Product) -> tuple[Any, ...]:
    """Where a product stands in a sum: by its lengths, then slides, then angles; pure numbers come last."""
    lengths: list[str] = []
    slides: list[int] = []
    waves: list[Any] = []
    sums: list[Any] = []
    for factor, power in part.factors:
        if isinstance(factor, Symbol) and factor.slide:
            slides += [-factor.slide] * power
        elif isinstance(factor, Symbol):
            lengths += [factor.name] * power
        elif isinstance(factor, Wave):
            waves += [(factor.turns, factor.kind)] * power
        else:
            sums.append(_rank(factor))
    return (not lengths, lengths, not slides, slides, not waves and not sums, waves, sums)


def is_number(factor: Factor) -> bool:
    """Whether a factor is a number: a root, or a sum of products of roots."""
    if isinstance(factor, Sum):
        return all(map(is_number, factors_of(factor.parts)))
    return isinstance(factor, Symbol) and factor.name in ROOTS and not factor.slide


def factors_of(parts: Iterable[Product]) -> Iterator[Factor]:
    """The factors of each of several products, without their powers."""
    for part in parts:
        for factor, _ in part.factors:
            yield factor


def half_of(form: Product, ring: Ring) -> Form:
    """A form in half-angle tangents: (f, D) with form = f / Π (1 + t_j²)^(D_j / 2), exactly.

    Args:
        form: of the ring's joints and lengths.
        ring: of the result.

    Raises:
        ValueError: parts of a sum differ in the parity of a half angle: the form has no sign on the torus.

    Example:
        >>> ring = Ring([1, 2])
        >>> found = half_of(Product(Fraction(2), ((Wave("cos", ((1, 1), (2, 1))), 1),)), ring)
        >>> found.f, found.degrees
        (-2*t1*t2 + 2, (1, 1))
    """
    f, degrees = number_of(form.number, ring), (0,) * ring.angles
    for factor, power in form.factors:
        half = _half_of_factor(factor, ring)
        f = f * half.f**power
        degrees = tuple(d + power * m for d, m in zip(degrees, half.degrees, strict=True))
    return Form(ring, reduced_roots(f), degrees)


def number_of(value: Fraction, ring: Ring) -> Polynomial:
    """A number as an element of the half-angle ring."""
    return ring.half.constant(flint().fmpq(value.numerator, value.denominator))


def _half_of_factor(factor: Factor, ring: Ring) -> Form:
    """`half_of` for a length, a slide, a sine or cosine, or a sum."""
    if isinstance(factor, Symbol):
        if factor.slide:
            f = ring.q_half[factor.slide]
        else:
            f = ring.letter_half[factor.name]
        return Form(ring, f, (0,) * ring.angles)
    if isinstance(factor, Wave):
        turns = dict(factor.turns)
        real, imaginary = ring.half.constant(1), ring.half.constant(0)
        for j, multiple in factor.turns:  # exp(i m θ / 2) = ((1 + i t) / √(1 + t²))^m
            t = ring.t[j] if multiple > 0 else -ring.t[j]
            for _ in range(abs(multiple)):
                real, imaginary = real - t * imaginary, imaginary + t * real
        f = real if factor.kind == "cos" else imaginary
        return Form(ring, f, tuple(abs(turns.get(j, 0)) for j in ring.revolute))
    return add_forms([half_of(part, ring) for part in factor.parts])


def add_forms(parts: Sequence[Form]) -> Form:
    """The sum of forms, at least one, over their common degrees.

    Raises:
        ValueError: parts differ in the parity of a half angle.
    """
    ring = parts[0].ring
    degrees = tuple(max(column) for column in zip(*(part.degrees for part in parts), strict=True))
    total = ring.half.constant(0)
    for part in parts:
        f = part.f
        for j, most, d in zip(ring.revolute, degrees, part.degrees, strict=True):
            if (most - d) % 2:
                raise ValueError(f"terms with θ{j}/2 and terms without it do not add up")
            if most > d:
                f = f * (1 + ring.t[j] ** 2) ** ((most - d) // 2)
        total = total + f
    return Form(ring, total, degrees)


def fourier(form: Form) -> Product:
    """f / Π (1 + t_j²)^(D_j / 2) as a sum of waves times monomials in lengths and slides.

    Returns:
        number · (sum of terms), equal to it exactly.
    """
    ring, f, degrees = form.ring, form.f, form.degrees
    n = ring.angles
    terms = [(tuple(int(e) for e in powers), int(value.p), int(value.q)) for powers, value in f.terms()]
    bottom = lcm(*(q for _, _, q in terms))
    state: dict[tuple[int, ...], Pair] = {powers: (p * (bottom // q), 0) for powers, p, q in terms}
    for k in range(n):
        if degrees[k]:
            state = _expand_power(state, k, int(degrees[k]))
            bottom <<= int(degrees[k])
    parts = []
    for key, (real, imaginary) in state.items():
        turns = key[:n]
        first = next((m for m in turns if m), 0)
        if first < 0:
            continue
        twice = 2 if first else 1
        monomial = symbols(key[n:], ring)
        for kind, value in (("cos", twice * real), ("sin", -twice * imaginary)):
            sign, wave_of_turns = wave(kind, dict(zip(ring.revolute, turns, strict=True)))
            if value and sign:
                if wave_of_turns is None:
                    factors = monomial
                else:
                    factors = [*monomial, (wave_of_turns, 1)]
                parts.append(product(Fraction(value * sign, bottom), factors))
    return total(parts)


def symbols(powers: Sequence[int], ring: Ring) -> list[tuple[Factor, int]]:
    """The monomial in slides and lengths with these powers."""
    names = [Symbol(f"q{j}", j) for j in ring.prismatic] + [Symbol(name) for name in ring.letters]
    return [(symbol, int(power)) for symbol, power in zip(names, powers, strict=True) if power]


def _expand_power(state: dict[tuple[int, ...], Pair], k: int, degree: int) -> dict[tuple[int, ...], Pair]:
    """The power of t_k in every key replaced by the power of z_k, all times 2^degree."""
    tables = {power: _table(power, degree) for power in {key[k] for key in state}}
    expansion: dict[tuple[int, ...], Pair] = {}
    for key, (real, imaginary) in state.items():
        power = key[k]
        for _ in range(power % 4):  # times −i
            real, imaginary = imaginary, -real
        for z, value in tables[power].items():
            new = (*key[:k], z, *key[k + 1 :])
            re, im = expansion.get(new, (0, 0))
            expansion[new] = (re + value * real, im + value * imaginary)
    return {key: pair for key, pair in expansion.items() if any(pair)}


def _table(power: int, degree: int) -> dict[int, int]:
    degrees: dict[int, int] = {}
    for i in range(power + 1):
        for j in range(degree - power + 1):
            z = degree - 2 * i - 2 * j
            degrees[z] = degrees.get(z, 0) + (-1) ** i * comb(power, i) * comb(degree - power, j)
    return {z: value for z, value in degrees.items() if value}


def joints_of(form: Product) -> set[int]:
    """Numbers of the joints in a form."""
    joints: set[int] = set()
    for leaf in leaves_of(form):
        if isinstance(leaf, Wave):
            joints.update(j for j, _ in leaf.turns)
        elif leaf.slide:
            joints.add(leaf.slide)
    return joints


def functions_of(forms: Iterable[Product]) -> list[str]:
    """The functions and constants that forms need in Python: out of "cos", "pi" and "sin", in this order."""
    names: set[str] = set()
    for form in forms:
        waves = [leaf for leaf in leaves_of(form) if isinstance(leaf, Wave)]
        names.update(leaf.kind for leaf in waves)
        if any(leaf.less != "0" for leaf in waves):
            names.add("pi")
    return sorted(names)


def leaves_of(form: Product) -> Iterator[Wave | Symbol]:
    """The lengths, slides and waves of a form, those in sums as well."""
    for factor, _ in form.factors:
        yield from leaves(factor)


def leaves(factor: Factor) -> Iterator[Wave | Symbol]:
    """The lengths, slides and waves of a factor, those in sums as well."""
    if isinstance(factor, Sum):
        for part in factor.parts:
            yield from leaves_of(part)
    else:
        yield factor
