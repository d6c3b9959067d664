"""Trigonometric polynomials written out: as text, as values, as quotients.

As a value, not as a condition, its number, its sign and its powers are written, too. A quotient is one
polynomial over another, in factors, with what they share cancelled: an entry of a closed inverse.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache

import numpy as np

from rankdrop.exact.algebra.polynomial import SIMPLE, Atom, Factors, Polynomial, primitive
from rankdrop.exact.algebra.ring import Ring, polynomial_of
from rankdrop.exact.writing.condition import WORDS
from rankdrop.exact.writing.form import Factor, Product, Sum, Symbol, Wave, fourier, half_of, product, symbols, total
from rankdrop.exact.writing.notation import Latex, Notation, Python, Text
from rankdrop.exact.writing.shortest import factor_forms, gathered, length, multiplied, parts_of, shortest
from rankdrop.robot.model import Array


def text_of(ring: Ring, p: Polynomial) -> str:
    """A trigonometric polynomial, equal to it: s_j is sin θ_j, c_34 is cos(θ3 + θ4).

    Example:
        >>> ring = Ring([1, 2])
        >>> text_of(ring, ring.s[1] * ring.c[2] + ring.c[1] * ring.s[2])
        's12'
    """
    known, key = _known(ring), str(p)
    if key not in known:
        known[key] = _written(ring, p)
    return known[key]


@lru_cache(maxsize=8)
def _known(ring: Ring) -> dict[str, str]:
    """Texts found before, by polynomial: the same ones come back in every case."""
    return {}


def _written(ring: Ring, p: Polynomial) -> str:
    return "0" if p == 0 else Text().sum(parts_of(form_of(ring, p)))


def form_of(ring: Ring, p: Polynomial) -> Product:
    """The shortest form of a trigonometric polynomial that is not zero, equal to it."""
    half = ring.to_half(p)
    single, combined = single_angles(ring, p), fourier(half)
    forms = [single, combined, gathered(single), gathered(combined)]
    if not half.at_pi:  # else `shortest` would write it without these factors
        forms.append(shortest(half.f, ring))
    return min(forms, key=length)


def single_angles(ring: Ring, p: Polynomial) -> Product:
    """p as it stands, in sines and cosines of single angles."""
    waves = [Wave(kind, ((j, 2),)) for j in ring.revolute for kind in ("sin", "cos")]
    parts = []
    for powers, value in p.terms():
        angles: list[tuple[Factor, int]] = [(one, int(e)) for one, e in zip(waves, powers, strict=False) if e]
        number = Fraction(int(value.p), int(value.q))
        parts.append(product(number, angles + symbols(powers[len(waves) :], ring)))
    return total(parts)


def condition_text(ring: Ring, p: Polynomial, sign: str = "=") -> str:
    """The condition p = 0 (or ≠ 0): "s4 = 0", "θ4 = π", "a6 + d3 s6 + d5 s6 ≠ 0"."""
    wanted = primitive(p)
    for j in ring.revolute:
        for value in SIMPLE:
            if wanted == primitive(polynomial_of(ring, ring.pin(j, value))):
                return f"θ{j} {sign} {WORDS[value]}"
    text = text_of(ring, wanted)
    return f"{text_of(ring, -wanted) if text.startswith('−') else text} {sign} 0"


FOLDED = 240
"""Characters of one factor above which people are told its size in place of it."""


@dataclass(frozen=True, eq=False)
class Value:
    """A polynomial taken apart.

    Attributes:
        ring: of the polynomial.
        polynomial: of the trigonometric ring.
        factors: its factors; None where they were not found: then it is written term by term.

    Example:
        >>> ring = Ring([1, 2], letters=["a1", "a2"])
        >>> p = -3 * ring.letter["a1"] * ring.letter["a2"] ** 2 * ring.s[2]
        >>> value = Value(ring, p, ring.factor(p))
        >>> value.text(), value.latex(), value.code(Python())
        ('−3 a1 a2² s2', '-3 a_1 a_2^{2} s_2', '-3*a1*a2**2*sin(q2)')
    """

    ring: Ring
    polynomial: Polynomial
    factors: Factors | None

    @cached_property
    def form(self) -> Product:
        """number · Π factor^power, equal to the polynomial everywhere."""
        if self.polynomial == 0:
            return Product(Fraction(0))
        if self.factors is None:
            return single_angles(self.ring, self.polynomial)
        return multiplied(self.ring, self.polynomial, self.factors)

    @property
    def sign(self) -> int:
        """Of the number before the factors: 1, −1, or 0 for a polynomial that is zero."""
        return (self.form.number > 0) - (self.form.number < 0)

    @property
    def terms(self) -> int:
        """Of the polynomial in sines and cosines."""
        return len(self.polynomial)

    def text(self, most: int | None = None) -> str:
        """For people.

        Args:
            most: factors of more characters than that are told by their size; None for none.
        """
        return (Text() if most is None else Folded(most)).value(self.form)

    def latex(self) -> str:
        """LaTeX, without delimiters."""
        return Latex().value(self.form)

    def code(self, notation: Python) -> str:
        """An expression in q and the lengths."""
        return notation.value(self.form)

    def powers(self) -> tuple[tuple[str, str, int], ...]:
        """(text, LaTeX, multiplicity) of each factor."""
        text, latex = Text(), Latex()
        return tuple(
            (text.sum(_opened(factor)), latex.sum(_opened(factor)), int(power)) for factor, power in self.form.factors
        )


def _opened(factor: Factor) -> tuple[Product, ...]:
    return factor.parts if isinstance(factor, Sum) else (Product(Fraction(1), ((factor, 1),)),)


class Folded(Text):
    """Text in which long sums in brackets are told by what they hold."""

    def __init__(self, most: int) -> None:
        self.most = most

    def value(self, form: Product) -> str:
        """As `Notation.value`; a long sum that is all of it is told in the same way."""
        text = super().value(form)
        alone = len(form.factors) == 1 and isinstance(form.factors[0][0], Sum)
        return f"[{_held(form.factors[0][0])}]" if alone and len(text) > self.most else text

    def factor(self, factor: Factor, power: int) -> str:
        """As `Notation.factor`, or "[120 terms in θ2, θ3, θ5]"."""
        text = super().factor(factor, power)
        if isinstance(factor, Sum) and len(text) > self.most:
            text = f"[{_held(factor)}]"
            return text if power == 1 else self.power(text, factor, power)
        return text


def _held(factor: Factor) -> str:
    """What a sum in brackets holds: "120 sines and cosines of θ2, θ3, θ5"."""
    joints: set[str] = set()
    count = _gather(factor, joints)
    return f"{count} sines and cosines, of {', '.join(sorted(joints, key=lambda name: int(name[1:])))}"


def _gather(factor: Factor, joints: set[str]) -> int:
    if isinstance(factor, Wave):
        joints.update(f"θ{j}" for j, _ in factor.turns)
        return 1
    if isinstance(factor, Symbol):
        if factor.slide:
            joints.add(f"q{factor.slide}")
        return 0
    return sum(_gather(inner, joints) for part in factor.parts for inner, _ in part.factors)


WHOLE = 12
"""Numbers below the line are whole up to this; others go above as decimals."""


@dataclass(frozen=True, eq=False)
class Quotient:
    """top / bottom.

    Attributes:
        top, bottom: polynomials with their factors; bottom is not zero. Where the factors of one are not known, nothing
            is cancelled.

    Example:
        >>> ring = Ring([1, 2], letters=["a1", "a2"])
        >>> a1, a2 = ring.letter["a1"], ring.letter["a2"]
        >>> top, bottom = a2 * ring.c[2], a1 * a2 * ring.s[2]
        >>> found = Quotient(Value(ring, top, ring.factor(top)), Value(ring, bottom, ring.factor(bottom)))
        >>> found.text(), found.latex()
        ('c2 / (a1 s2)', '\\\\frac{c_2}{a_1 s_2}')
    """

    top: Value
    bottom: Value

    @cached_property
    def forms(self) -> tuple[Product, Product]:
        """(above, below) the line, equal to top / bottom wherever that is defined; below has the number 1 or a whole
        one.
        """
        one, two, ring = self.top, self.bottom, self.top.ring
        if one.polynomial == 0:
            return Product(Fraction(0)), Product(Fraction(1))
        if one.factors is None or two.factors is None:
            return _with_numbers(one.form, two.form, one.form.number / two.form.number)
        powers: dict[Atom, int] = dict(one.factors.atoms)
        for atom, power in two.factors.atoms:
            powers[atom] = powers.get(atom, 0) - power
        lengths: dict[str, tuple[Polynomial, int]] = {str(f): (f, power) for f, power in one.factors.letters}
        for f, power in two.factors.letters:
            lengths[str(f)] = (f, lengths.get(str(f), (f, 0))[1] - power)
        above, below = (
            _form(ring, [(a, s * p) for a, p in powers.items() if s * p > 0],
                  [(f, s * p) for f, p in lengths.values() if s * p > 0])
            for s in (1, -1)
        )  # fmt: skip
        number = _leading(one) / _leading(two)
        return _with_numbers(above[0], below[0], number * below[1] / above[1])

    def text(self, most: int | None = None) -> str:
        """For people: "−(a1 + a2 c2) / (a1 a2 s2)".

        Args:
            most: sums of more characters are told by their size; None for none.
        """
        above, below = self.forms
        notation = Text() if most is None else Folded(most)
        return _joined(notation, above, below, " / ")

    def latex(self) -> str:
        """LaTeX, without delimiters."""
        above, below = self.forms
        notation = Latex()
        if below == Product(Fraction(1)):
            return notation.value(above)
        sign = "-" if above.number < 0 else ""
        upper, lower = Product(abs(above.number), above.factors), below
        return rf"{sign}\frac{{{notation.value(upper)}}}{{{notation.value(lower)}}}"

    def code(self, notation: Python) -> str:
        """An expression in q and the lengths."""
        return _joined(notation, *self.forms, "/")

    def at(self, theta: Array, letters: Mapping[str, float]) -> float:
        """Its value at one configuration θ (n,), with values of the lengths [m]; inf or nan where below is zero."""
        above, below = self.forms
        with np.errstate(divide="ignore", invalid="ignore"):
            return float(np.float64(number_at(above, theta, letters)) / number_at(below, theta, letters))


def number_at(form: Product, theta: Array, letters: Mapping[str, float]) -> float:
    """The value of a form at θ (n,) [rad; slides m], with values of the lengths [m]."""
    found = float(form.number)
    for factor, power in form.factors:
        if isinstance(factor, Symbol):
            value = float(theta[factor.slide - 1]) if factor.slide else letters[factor.name]
        elif isinstance(factor, Wave):
            angle = sum(m * float(theta[j - 1]) for j, m in factor.turns) / 2
            value = float(np.sin(angle) if factor.kind == "sin" else np.cos(angle))
        else:
            value = sum(number_at(part, theta, letters) for part in factor.parts)
        found *= value**power
    return found


def _joined(notation: Notation, above: Product, below: Product, line: str) -> str:
    if below == Product(Fraction(1)):
        return notation.value(above)
    upper, lower = _above(notation, above), notation.product(notation.readable(below))
    bracketed = len(below.factors) + (below.number != 1) > 1
    return f"{upper}{line}({lower})" if bracketed else f"{upper}{line}{lower}"


def _above(notation: Notation, above: Product) -> str:
    """A product, a sum in brackets; its sign before it."""
    return notation.sum([notation.readable(above)])


def _with_numbers(above: Product, below: Product, number: Fraction) -> tuple[Product, Product]:
    """The forms with a number before both: small whole numbers above and below, any other above."""
    if number.denominator > WHOLE:
        return Product(number, above.factors), Product(Fraction(1), below.factors)
    return Product(Fraction(number.numerator), above.factors), Product(Fraction(number.denominator), below.factors)


def _form(
    ring: Ring, atoms: Sequence[tuple[Atom, int]], lengths: Sequence[tuple[Polynomial, int]]
) -> tuple[Product, Fraction]:
    """(product of the factors, its number left out; the leading coefficient of that product)."""
    made = product(1, factor_forms(ring, atoms, lengths))
    bare = Product(Fraction(1), made.factors)
    value = half_of(bare, ring).f.coeffs()[0]
    return bare, Fraction(int(value.p), int(value.q))


def _leading(value: Value) -> Fraction:
    """The leading coefficient of a polynomial in half-angle tangents: factors 1 + t² have 1, so that they count not."""
    found = value.ring.to_half(value.polynomial).f.coeffs()[0]
    return Fraction(int(found.p), int(found.q))
