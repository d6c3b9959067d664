r"""Formulas: sums of products of lengths, slides, sines and cosines, and of sums in brackets; how they are written.

One tree serves every output and the reader of what a user wrote: text and LaTeX for people, Python and C in the joint
variables q = θ − shift for machines. `half_of` takes it back to the half-angle ring without rounding, so that every way
of writing a condition can be held against the polynomial. `fourier` makes it of a half-angle polynomial: a sum of sines
and cosines of half-integer combinations of the angles. t^k of degree D stands for sin^k(θ/2) cos^(D−k)(θ/2). With
z = exp(iθ/2) that is

    (−i)^k 2^(−D) (z − 1/z)^k (z + 1/z)^(D−k),

so that the whole polynomial is multiplied out joint by joint. A combination comes out whole wherever it can: a2 c2 +
a3 c23 has two terms here and three in sines and cosines of single angles.

`typeset` makes MathML of LaTeX: results hold conditions as LaTeX alone. Only what is written here is understood:
letters with subscripts and powers, \frac, \sin, \cos, \theta, \pi, \pm, \in, sets in \{ \}, numbers. A long one is
cut before signs, so that lines can break.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from fractions import Fraction
from html import escape
from math import comb, gcd, lcm, pi
from types import MappingProxyType
from typing import Any, TypeAlias

from rankdrop.algebra.polynomial import Polynomial, flint, reduced_roots
from rankdrop.algebra.ring import Form, Ring
from rankdrop.algebra.roots import ROOTS, WRITTEN, approximation, rational_square
from rankdrop.formula.equation import pretty_angle, share_of_pi


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
            others = [(one, p) for k, (one, p) in enumerate(form.factors) if k != place]
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
        one = _half_of_factor(factor, ring)
        f = f * one.f**power
        degrees = tuple(d + power * m for d, m in zip(degrees, one.degrees, strict=True))
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
    return added([half_of(part, ring) for part in factor.parts])


def added(parts: Sequence[Form]) -> Form:
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


Pair = tuple[int, int]
"""Real and imaginary part, times a number that all have in common: whole numbers are faster than fractions."""


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
            state = _expanded(state, k, int(degrees[k]))
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
            sign, one = wave(kind, dict(zip(ring.revolute, turns, strict=True)))
            if value and sign:
                if one is None:
                    factors = monomial
                else:
                    factors = [*monomial, (one, 1)]
                parts.append(product(Fraction(value * sign, bottom), factors))
    return total(parts)


def symbols(powers: Sequence[int], ring: Ring) -> list[tuple[Factor, int]]:
    """The monomial in slides and lengths with these powers."""
    names = [Symbol(f"q{j}", j) for j in ring.prismatic] + [Symbol(name) for name in ring.letters]
    return [(symbol, int(power)) for symbol, power in zip(names, powers, strict=True) if power]


def _expanded(state: dict[tuple[int, ...], Pair], k: int, degree: int) -> dict[tuple[int, ...], Pair]:
    """The power of t_k in every key replaced by the power of z_k, all times 2^degree."""
    tables = {power: _table(power, degree) for power in {key[k] for key in state}}
    found: dict[tuple[int, ...], Pair] = {}
    for key, (real, imaginary) in state.items():
        power = key[k]
        for _ in range(power % 4):  # times −i
            real, imaginary = imaginary, -real
        for z, value in tables[power].items():
            new = (*key[:k], z, *key[k + 1 :])
            one, two = found.get(new, (0, 0))
            found[new] = (one + value * real, two + value * imaginary)
    return {key: pair for key, pair in found.items() if any(pair)}


def _table(power: int, degree: int) -> dict[int, int]:
    found: dict[int, int] = {}
    for i in range(power + 1):
        for j in range(degree - power + 1):
            z = degree - 2 * i - 2 * j
            found[z] = found.get(z, 0) + (-1) ** i * comb(power, i) * comb(degree - power, j)
    return {z: value for z, value in found.items() if value}


SUPERSCRIPT = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
LONG = 10**5
"""Whole numbers above this are not read any more; people get `DIGITS` digits of them, the largest of a sum being 1."""
DIGITS = 6
EXACT = 2**53  # whole numbers up to this are exact as floats


def _long(form: Product) -> bool:
    sums = [factor.parts for factor, _ in form.factors if isinstance(factor, Sum)]
    return any(_too_long(part.number) or _long(part) for parts in sums for part in parts)


def _too_long(value: Fraction) -> bool:
    return max(abs(value.numerator), value.denominator) > LONG


def _are_doubles(parts: Iterable[Product]) -> bool:
    """Whether the number of every product is what its double prints."""
    return all(Fraction(repr(float(part.number))) == part.number for part in parts)


def _rescaled(form: Product, exact: bool, every: bool) -> Product:
    """Sums divided by their largest number: those with long numbers, or every one."""
    number = form.number
    factors: list[tuple[Factor, int]] = []
    for factor, power in form.factors:
        if isinstance(factor, Sum):
            parts = [_rescaled(part, exact, every) for part in factor.parts]
            most = max(abs(part.number) for part in parts)
            if every or any(_too_long(part.number) for part in parts):
                divided = [Product(part.number / most, part.factors) for part in parts]
                if not exact or most > EXACT or _are_doubles(divided):
                    parts, number = divided, number * most**power
            factors.append((Sum(tuple(parts)), power))
        else:
            factors.append((factor, power))
    return Product(number, tuple(factors))


def _readable(value: Fraction) -> str:
    if value.denominator == 1 and value.numerator <= LONG:
        return str(value.numerator)
    short = f"{Decimal(value.numerator) / Decimal(value.denominator):.{DIGITS}g}".replace("e+", "e")
    if "e" not in short:
        short = f"{float(value):.{DIGITS}g}"  # without zeros at the end
    if value.denominator > 1 and Fraction(short) != value and value.denominator <= 12:
        return f"{value.numerator}/{value.denominator}"
    return short


class Text:
    """Unicode: a2 c2 + a3 c23 − d4 s23. Other notations write numbers, symbols, waves and powers their own way.

    Args:
        most: sums of more characters are told by what they hold; None for none.
        divisors: of joints that a form has a part of the angle of, how many make the whole (`Ring.parts`).
    """

    times = " "
    minus = "−"
    exact = False  # whether numbers are written to the last digit
    angle, slide = "θ{}", "q{}"
    metre = " m"
    between = ""  # a number and an angle
    most: int | None = None
    divisors: Mapping[int, int] = MappingProxyType({})

    def __init__(self, most: int | None = None, divisors: Mapping[int, int] | None = None) -> None:
        self.most = most
        self.divisors = divisors or {}

    def number(self, value: Fraction) -> str:
        """A positive number: whole, or six digits."""
        return _readable(value)

    def angle_value(self, value: float) -> str:
        """An angle for people: parts of π as such, others in radians with degrees beside."""
        text = pretty_angle(value)
        if share_of_pi(value) is not None:
            return text
        return f"{text} rad ({value * 180 / pi:.4g}°)".replace("-", "−")

    def symbol(self, symbol: Symbol) -> str:
        """A length, the variable of a slide, or a root: its name; √2."""
        return WRITTEN.get(symbol.name, symbol.name)

    def wave(self, wave: Wave) -> str:
        """sin or cos of a combination of angles: c23, s(θ1 − θ2), cos(θ4/2)."""
        short = self.short(wave)
        if short:
            return short
        full = wave.halved or self.divided(wave)
        return f"{wave.kind if full else wave.kind[0]}({self.combination(wave)})"

    def short(self, wave: Wave) -> str:
        """c23 of a plain sum of whole angles up to θ9; "" of another combination."""
        if all(j < 10 and m == 2 * self.divisors.get(j, 1) for j, m in wave.turns):
            return wave.kind[0] + "".join(str(j) for j, _ in wave.turns)
        return ""

    def divided(self, wave: Wave) -> bool:
        """Whether an angle of a wave is a part of its joint's own."""
        return any(j in self.divisors for j, _ in wave.turns)

    def combination(self, wave: Wave) -> str:
        """The angle of a wave: θ3 − θ5, (θ3 + θ5)/2, 3θ2/2 + θ4."""
        if self.divided(wave):
            return self.sum_of_shares(wave)
        halved = all(m % 2 for _, m in wave.turns)
        parts = []
        for j, m in wave.turns:
            size = abs(m) if halved or m % 2 else abs(m) // 2
            one = ("" if size == 1 else f"{self.number(Fraction(size))}{self.between}") + self.theta(j)
            parts.append((m < 0, one if halved or m % 2 == 0 else self.half(one)))
        text = self.signed(parts) + self.offset(wave)
        return self.half(text) if halved else text

    def sum_of_shares(self, wave: Wave) -> str:
        """The angle of a wave in shares of the joints' own angles: 3θ2/2 + θ4."""
        return self.signed([(m < 0, self.share(j, abs(m))) for j, m in wave.turns]) + self.offset(wave)

    def share(self, joint: int, halves: int) -> str:
        """So many halves of a joint's angle in a form, as a share of the joint's own: 3θ2/4."""
        share = Fraction(halves, 2 * self.divisors.get(joint, 1))
        return self.fraction_of(share, self.theta(joint))

    def fraction_of(self, share: Fraction, angle: str) -> str:
        """A share of an angle: θ2/2, 3θ2/2."""
        text = angle
        if share.numerator != 1:
            text = f"{self.number(Fraction(share.numerator))}{self.between}{angle}"
        if share.denominator == 1:
            return text
        return f"{text}/{self.number(Fraction(share.denominator))}"

    def theta(self, joint: int) -> str:
        """The angle of one joint."""
        return self.angle.format(joint)

    def offset(self, wave: Wave) -> str:
        """What is added to the angle of a wave."""
        if wave.less == "0":
            return ""
        return f" − {wave.less}{'/2' * self.divided(wave)}"

    def half(self, text: str) -> str:
        """Half an angle."""
        two = self.number(Fraction(2))
        if " " in text:
            return f"({text})/{two}"
        return f"{text}/{two}"

    def signed(self, parts: Sequence[tuple[bool, str]]) -> str:
        """Summands, each with whether it is negative, joined by signs."""
        text = " ".join(f"{self.minus if negative else '+'} {one}" for negative, one in parts)
        if text[:1] == "+":
            return text[2:]
        return text.replace(" ", "", 1)

    def power(self, text: str, factor: Factor, power: int) -> str:
        """A factor to a power from 2 up: a raised number, before an angle in brackets."""
        if isinstance(factor, Wave) and text[-1] == ")":
            name, rest = text.split("(", 1)
            return f"{name}{str(power).translate(SUPERSCRIPT)}({rest}"
        return text + str(power).translate(SUPERSCRIPT)

    def zero(self, form: Product) -> str:
        """What vanishes with the form: the form less its number, a power, and a bracket round all of it."""
        return self.sum(self.parts(form))

    def parts(self, form: Product) -> tuple[Product, ...]:
        """What vanishes with the form, as products to be added, without numbers before it and its powers."""
        kept = [factor for factor, _ in form.factors if not is_number(factor)] or [factor for factor, _ in form.factors]
        form = self.readable(Product(Fraction(1), tuple((factor, 1) for factor in kept)))
        if len(form.factors) == 1 and isinstance(form.factors[0][0], Sum):
            return form.factors[0][0].parts
        return (Product(Fraction(1), form.factors),)

    def value(self, form: Product) -> str:
        """The form itself, with its number and its powers."""
        form = self.readable(form)
        if len(form.factors) == 1 and isinstance(form.factors[0][0], Sum) and form.factors[0][1] == 1:
            whole = form.factors[0][0]
            text = self.sum([replace(part, number=form.number * part.number) for part in whole.parts])
            if self.most is None or len(text) <= self.most:
                return text
            return f"[{describe_sum(whole)}]"
        return self.sum([form])

    def fraction(self, above: Product, below: Product) -> str:
        """One form over another one, which is not the number 1 and holds no sum alone."""
        upper, lower = self.sum([self.readable(above)]), self.product(self.readable(below))
        line = "/" if self.exact else " / "
        if len(below.factors) + (below.number != 1) > 1:
            return f"{upper}{line}({lower})"
        return f"{upper}{line}{lower}"

    def readable(self, form: Product) -> Product:
        """The form, equal to it, with sums of long numbers divided by the largest one."""
        return _rescaled(form, self.exact, not self.exact and _long(form))

    def sum(self, parts: Sequence[Product]) -> str:
        """Products joined by signs."""
        return self.signed([(part.number < 0, self.product(part)) for part in parts])

    def product(self, part: Product) -> str:
        """One product without its sign."""
        number = abs(part.number)
        if number != 1 or not part.factors:
            factors = [self.number(number)]
        else:
            factors = []
        return self.times.join(factors + [self.factor(factor, power) for factor, power in part.factors])

    def factor(self, factor: Factor, power: int) -> str:
        """A factor to its power; a long sum as "[120 sines and cosines of θ2, θ3, θ5]"."""
        if isinstance(factor, Sum):
            text = f"({self.sum(factor.parts)})"
            if self.most is not None and len(text if power == 1 else self.power(text, factor, power)) > self.most:
                text = f"[{describe_sum(factor)}]"
        else:
            if isinstance(factor, Symbol):
                text = self.symbol(factor)
            else:
                text = self.wave(factor)
        if power == 1:
            return text
        return self.power(text, factor, power)


def describe_sum(factor: Factor) -> str:
    """What a sum in brackets holds: "120 sines and cosines of θ2, θ3, θ5"."""
    inside = [*_leaves(factor)]
    waves = [one for one in inside if isinstance(one, Wave)]
    joints = {f"q{one.slide}" for one in inside if isinstance(one, Symbol) and one.slide}
    for one in waves:
        joints |= {f"θ{j}" for j, _ in one.turns}
    return f"{len(waves)} sines and cosines, of {', '.join(sorted(joints, key=lambda name: int(name[1:])))}"


def joints_of(form: Product) -> set[int]:
    """Numbers of the joints in a form."""
    joints: set[int] = set()
    for one in _leaves_of(form):
        if isinstance(one, Wave):
            joints.update(j for j, _ in one.turns)
        elif one.slide:
            joints.add(one.slide)
    return joints


def functions_of(forms: Iterable[Product]) -> list[str]:
    """The functions and constants that forms need in Python: out of "cos", "pi" and "sin", in this order."""
    names: set[str] = set()
    for form in forms:
        waves = [one for one in _leaves_of(form) if isinstance(one, Wave)]
        names.update(one.kind for one in waves)
        if any(one.less != "0" for one in waves):
            names.add("pi")
    return sorted(names)


def _leaves_of(form: Product) -> Iterator[Wave | Symbol]:
    """The lengths, slides and waves of a form, those in sums as well."""
    for factor, _ in form.factors:
        yield from _leaves(factor)


def _leaves(factor: Factor) -> Iterator[Wave | Symbol]:
    if isinstance(factor, Sum):
        for part in factor.parts:
            yield from _leaves_of(part)
    else:
        yield factor


class Latex(Text):
    r"""LaTeX: a_2 c_2 + a_3 c_{23}; names in full where the angles are no plain sum: \cos(\theta_3 - \theta_5)."""

    minus = "-"
    angle, slide = r"\theta_{{{}}}", "q_{{{}}}"
    metre = r"\,\mathrm{m}"

    def number(self, value: Fraction) -> str:
        """As in text, powers of ten spelled out."""
        text = _readable(value)
        if "/" in text:
            top, bottom = text.split("/")
            return rf"\tfrac{{{top}}}{{{bottom}}}"
        if "e" in text:
            digits, power = text.split("e")
            return rf"{digits} \cdot 10^{{{int(power)}}}"
        return text

    def angle_value(self, value: float) -> str:
        """Parts of π as fractions, others in radians."""
        share = share_of_pi(value)
        if share is None:
            return rf"{pretty_angle(value)}\,\mathrm{{rad}}".replace("−", self.minus)
        if share == 0:
            return "0"
        sign, multiple = self.minus * (share < 0), abs(share.numerator)
        top = r"\pi"
        if multiple > 1:
            top = rf"{multiple}\pi"
        if share.denominator == 1:
            return sign + top
        return rf"{sign}\frac{{{top}}}{{{share.denominator}}}"

    def symbol(self, symbol: Symbol) -> str:
        """With a subscript."""
        return latex_name(symbol.name)

    def theta(self, joint: int) -> str:
        """With a subscript, in braces where it has two digits."""
        if joint < 10:
            return rf"\theta_{joint}"
        return self.angle.format(joint)

    def fraction_of(self, share: Fraction, angle: str) -> str:
        """A small fraction, its number above the line."""
        if share.numerator == 1:
            top = angle
        else:
            top = f"{share.numerator} {angle}"
        if share.denominator == 1:
            return top
        return rf"\tfrac{{{top}}}{{{share.denominator}}}"

    def half(self, text: str) -> str:
        """A small fraction."""
        return rf"\tfrac{{{text}}}{{2}}"

    def wave(self, wave: Wave) -> str:
        """c_{23}, or the name in full."""
        short = self.short(wave)
        if short:
            return latex_name(short)
        return rf"\{wave.kind}({self.combination(wave)})"

    def power(self, text: str, factor: Factor, power: int) -> str:
        """A superscript, before an angle in brackets."""
        if isinstance(factor, Wave):
            name, bracket, rest = text.partition("(")
        else:
            name, bracket, rest = (text, "", "")
        return f"{name}^{{{power}}}{bracket}{rest}"

    def fraction(self, above: Product, below: Product) -> str:
        """One line over another."""
        upper = self.value(Product(abs(above.number), above.factors))
        return rf"{'-' if above.number < 0 else ''}\frac{{{upper}}}{{{self.value(below)}}}"


def latex_name(name: str) -> str:
    r"""a2 → a_2, c23 → c_{23}, upper → \mathrm{upper}."""
    if name in WRITTEN:
        return re.sub("√(.*)", r"\\sqrt{\1}", WRITTEN[name]).replace("cos", r"\cos").replace("°", r"^\circ")
    head, tail = re.fullmatch(r"([A-Za-z]*)_?(.*)", name, re.DOTALL).groups()  # type: ignore[union-attr] # matches all
    if len(head) == 1:
        head = head
    else:
        head = rf"\mathrm{{{head}}}"
    tail = tail.replace("_", r"\_")
    if not tail:
        return head
    if len(tail) == 1:
        return f"{head}_{tail}"
    return f"{head}_{{{tail}}}"


@dataclass(frozen=True)
class Python(Text):
    """Python: a2*cos(q2) + a3*cos(q2 + q3), in the joint variables q = θ − shift.

    Attributes:
        shifts: of each joint [rad], slides have none; empty for none.
        variable: pattern of a joint variable, with {0} for its number and {1} for its place from 0.
        names: what lengths are called there, where it is something else.
        divisors: as of `Text`; such a joint's angle is q / part + shift.
    """

    shifts: Sequence[float] = ()
    variable: str = "q{0}"
    names: Mapping[str, str] = field(default_factory=dict)
    divisors: Mapping[int, int] = field(default_factory=dict)

    times, minus, between = "*", "-", "*"
    exact = True

    def number(self, value: Fraction) -> str:
        """Whole numbers as such, others as floats."""
        if value.denominator == 1 and value <= EXACT:
            return str(value.numerator)
        return repr(float(value))

    def symbol(self, symbol: Symbol) -> str:
        """Its name, or the name given for it; the value of a root."""
        if symbol.slide:
            return self.theta(symbol.slide)
        if symbol.name in WRITTEN:
            return repr(float(approximation(symbol.name)))
        return self.names.get(symbol.name, symbol.name)

    def wave(self, wave: Wave) -> str:
        """A call."""
        return f"{wave.kind}({self.combination(wave)})"

    def offset(self, wave: Wave) -> str:
        """Σ m_j shift_j / 2, twice that where the whole angle is halved, less what the wave says."""
        less, halved, divided = wave.less, all(m % 2 for _, m in wave.turns), self.divided(wave)
        if less == "0":
            text = ""
        else:
            text = f" {'+' if less[0] == '-' else '-'} {self.simple(less.lstrip('-'))}{'/2' * divided}"
        shifts = (
            m * float(self.shifts[j - 1]) / self.divisors.get(j, 1) for j, m in wave.turns if len(self.shifts)
        )
        constant = sum(shifts) * (1.0 if halved and not divided else 0.5)
        return text + f" {'+' if constant > 0 else '-'} {abs(constant)!r}" * bool(constant)

    def theta(self, joint: int) -> str:
        """A joint variable."""
        return self.variable.format(joint, joint - 1)

    def simple(self, value: str) -> str:
        """π or π/2."""
        return value

    def power(self, text: str, factor: Factor, power: int) -> str:
        """With **."""
        return f"{text}**{power}"


@dataclass(frozen=True)
class C(Python):
    """C99, with <math.h>: a2*cos(q[1]) + a3*cos(q[1] + q[2])."""

    variable: str = "q[{1}]"

    def number(self, value: Fraction) -> str:
        """A double."""
        return repr(float(value))

    def simple(self, value: str) -> str:
        """To the last digit: <math.h> need not know π."""
        return repr(pi if value == "pi" else pi / 2)

    def power(self, text: str, factor: Factor, power: int) -> str:
        """A call of pow."""
        return f"pow({text}, {power}.0)"


@dataclass(frozen=True, slots=True)
class Step:
    """One step of a derivation done by hand.

    Attributes:
        title: heading.
        lines: under it; long polynomials are told by their number of terms, and of many conditions the first ones.
        whole: the same with everything written out; empty where `lines` leave nothing out.
    """

    title: str
    lines: tuple[str, ...]
    whole: tuple[str, ...] = ()


_TOKEN = re.compile(r"\\mathrm\{[^}]*\}|\\[A-Za-z]+|\\.|\d+(?:\.\d+)?|[A-Za-z]|[{}_^()=+\-,/]|[^\s\\]")
_LEAVES = {
    r"\theta": "<mi>θ</mi>", r"\pi": "<mi>π</mi>", r"\alpha": "<mi>α</mi>", r"\beta": "<mi>β</mi>",
    **{rf"\{name}": f"<mi>{name}</mi><mspace width='0.15em'></mspace>" for name in ("sin", "cos", "tan")},
    r"\,": "<mspace width='0.17em'></mspace>",
}  # fmt: skip
_OPERATORS = {r"\in": "∈", r"\pm": "±", r"\cdot": "·", r"\{": "{", r"\}": "}", "-": "−", r"\ne": "≠", r"\quad": " "}
_BREAKS = {"+", "-", "="}
_LEADING = {"(", ",", "{", r"\{", "=", r"\in"}  # a sign after one of these stands before its term
_SCRIPTS = {"": "{0}", "_": "<msub>{0}{1}</msub>", "^": "<msup>{0}{1}</msup>", "_^": "<msubsup>{0}{1}{2}</msubsup>"}
_SHORT = 60  # characters; a condition no longer than this stays in one piece


def typeset(latex: str) -> str:
    """One condition as HTML: MathML in pieces between which a line may break.

    Example:
        >>> typeset("a_2 = 0")
        '<math><msub><mi>a</mi><mn>2</mn></msub><mo stretchy="false" form="infix">=</mo><mn>0</mn></math>'
    """
    pieces: list[list[str]] = [[]]
    depth, before = 0, ""
    for token in _TOKEN.findall(latex):
        depth += {"{": 1, "}": -1}.get(token, 0)
        if token in _BREAKS and len(latex) > _SHORT and depth == 0 and before not in {"", "(", "=", ","}:
            pieces.append([])
            before = ""
        pieces[-1].append(_leaf(token, before))
        before = token
    return " ".join(f"<math>{_row(piece[::-1])}</math>" for piece in pieces if piece)


def _leaf(token: str, before: str) -> str:
    """The MathML of a letter, a number or a sign; braces, scripts and fractions as they are."""
    if token in _LEAVES or token in {"{", "}", "_", "^", r"\frac", r"\tfrac"}:
        return _LEAVES.get(token, token)
    if token.startswith(r"\mathrm{"):
        plain = "".join(token[8:-1].replace("\\", "").split())
        return f"<mtext>{escape(plain)}</mtext>"
    if token.isalpha() or token[0].isdigit():
        if token.isalpha():
            return f"<mi>{token}</mi>"
        return f"<mn>{token}</mn>"
    if token in _BREAKS and before not in _LEADING:
        form = ' form="infix"'
    else:
        form = ""
    return f'<mo stretchy="false"{form}>{escape(_OPERATORS.get(token, token))}</mo>'


def _row(waiting: list[str]) -> str:
    """MathML of what waits, last first, up to a closing brace, each part with what is written below and above it."""
    parts = ""
    while waiting and waiting[-1] != "}":
        base, scripts = _part(waiting), dict[str, str]()
        while waiting and waiting[-1] in {"_", "^"}:
            mark = waiting.pop()
            scripts[mark] = _part(waiting)
        marks = sorted(scripts, reverse=True)
        parts += _SCRIPTS["".join(marks)].format(base, *(scripts[mark] for mark in marks))
    return parts


def _part(waiting: list[str]) -> str:
    """A group, a fraction, or a leaf."""
    token = waiting.pop() if waiting else "{"
    if token in {r"\frac", r"\tfrac"}:
        return f"<mfrac>{_part(waiting)}{_part(waiting)}</mfrac>"
    if token != "{":
        return token
    inside = _row(waiting)
    if waiting:
        waiting.pop()
    return f"<mrow>{inside}</mrow>"


def in_parts(notation: Python, parts: Mapping[int, int]) -> Python:
    """A notation for forms in which the angles of some joints are parts of their own."""
    if parts:
        return replace(notation, divisors=parts)
    return notation
