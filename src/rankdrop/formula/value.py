"""Values as they are written: a polynomial, and one value over another, as an entry of a closed inverse is.

Of a `Value` number, sign and powers are written; a `Quotient` is in factors, with what both share cancelled.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np

from rankdrop.algebra.polynomial import (
    Atom,
    Factors,
    Polynomial,
    leading_number,
    reciprocal,
    reduced_roots,
)
from rankdrop.algebra.ring import Ring
from rankdrop.formula.notation import Latex, Python, Text, in_parts
from rankdrop.formula.shortest import FormSearch, factor_forms, single_angles, times, written_number
from rankdrop.formula.sums import Factor, Product, Sum, Symbol, Wave, half_of, product
from rankdrop.robot.model import Array

FOLDED = 240
"""Characters of one factor above which people are told its size in place of it."""

WHOLE = 12
"""Numbers below the line are whole up to this; others go above as decimals."""


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
        written = factor_forms(self.ring, self.factors.atoms, self.factors.letters)
        return FormSearch(self.ring).scale_to(self.ring.to_half(self.polynomial).f, written)

    def text(self, most: int | None = None) -> str:
        """For people.

        Args:
            most: factors of more characters than that are told by their size; None for none.
        """
        return Text(most, self.ring.parts).value(self.form)

    def latex(self) -> str:
        """LaTeX, without delimiters."""
        return Latex(divisors=self.ring.parts).value(self.form)

    def code(self, notation: Python) -> str:
        """An expression in q and the lengths."""
        return in_parts(notation, self.ring.parts).value(self.form)

    def powers(self) -> tuple[tuple[str, str, int], ...]:
        """(text, LaTeX, multiplicity) of each factor."""
        text, latex = Text(divisors=self.ring.parts), Latex(divisors=self.ring.parts)
        return tuple(
            (text.sum(_open_brackets(factor)), latex.sum(_open_brackets(factor)), int(power))
            for factor, power in self.form.factors
        )


def _open_brackets(factor: Factor) -> tuple[Product, ...]:
    if isinstance(factor, Sum):
        return factor.parts
    return (Product(Fraction(1), ((factor, 1),)),)


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
        top, bottom, ring = self.top, self.bottom, self.top.ring
        if top.polynomial == 0:
            return Product(Fraction(0)), Product(Fraction(1))
        if top.factors is None or bottom.factors is None:
            return _with_numbers(top.form, bottom.form, top.form.number / bottom.form.number)
        powers: dict[Atom, int] = dict(top.factors.atoms)
        for atom, power in bottom.factors.atoms:
            powers[atom] = powers.get(atom, 0) - power
        lengths: dict[str, tuple[Polynomial, int]] = {str(f): (f, power) for f, power in top.factors.letters}
        for f, power in bottom.factors.letters:
            lengths[str(f)] = (f, lengths.get(str(f), (f, 0))[1] - power)
        above, below = (
            _form(ring, [(a, s * p) for a, p in powers.items() if s * p > 0],
                  [(f, s * p) for f, p in lengths.values() if s * p > 0])
            for s in (1, -1)
        )  # fmt: skip
        number = _leading(top) * reciprocal(_leading(bottom)) * below[1] * reciprocal(above[1])
        written = written_number(ring, reduced_roots(number))
        roots = Product(Fraction(1), written.factors)
        return _with_numbers(times(roots, above[0]), below[0], written.number)

    def text(self, most: int | None = None) -> str:
        """For people: "−(a1 + a2 c2) / (a1 a2 s2)".

        Args:
            most: sums of more characters are told by their size; None for none.
        """
        return self.code(Text(most))

    def latex(self) -> str:
        """LaTeX, without delimiters."""
        return self.code(Latex())

    def code(self, notation: Text) -> str:
        """In a notation: with `Python` an expression in q and the lengths."""
        above, below = self.forms
        if below == Product(Fraction(1)):
            return notation.value(above)
        return notation.fraction(above, below)

    def at(self, theta: Array, letters: Mapping[str, float]) -> float:
        """Its value at one configuration θ (n,), with values of the lengths [m]; inf or nan where below is zero."""
        above, below = self.forms
        with np.errstate(divide="ignore", invalid="ignore"):
            return float(np.float64(number_at(above, theta, letters)) / number_at(below, theta, letters))


def number_at(form: Product, theta: Array, letters: Mapping[str, float]) -> float:
    """The value of a form at θ (n,) [rad; slides m], with values of the lengths [m]."""
    value_here = float(form.number)
    for factor, power in form.factors:
        if isinstance(factor, Symbol):
            if factor.slide:
                value = float(theta[factor.slide - 1])
            else:
                value = letters[factor.name]
        elif isinstance(factor, Wave):
            angle = sum(m * float(theta[j - 1]) for j, m in factor.turns) / 2
            value = float(np.sin(angle) if factor.kind == "sin" else np.cos(angle))
        else:
            value = sum(number_at(part, theta, letters) for part in factor.parts)
        value_here *= value**power
    return value_here


def _with_numbers(above: Product, below: Product, number: Fraction) -> tuple[Product, Product]:
    """The forms with a number before both: small whole numbers above and below, any other above."""
    if number.denominator > WHOLE:
        return Product(number, above.factors), Product(Fraction(1), below.factors)
    return Product(Fraction(number.numerator), above.factors), Product(Fraction(number.denominator), below.factors)


def _form(
    ring: Ring, atoms: Sequence[tuple[Atom, int]], lengths: Sequence[tuple[Polynomial, int]]
) -> tuple[Product, Polynomial]:
    """(product of the factors, its number left out; the leading coefficient of that product, of the roots alone)."""
    bare = Product(Fraction(1), product(1, factor_forms(ring, atoms, lengths)).factors)
    return bare, leading_number(half_of(bare, ring).f)


def _leading(value: Value) -> Polynomial:
    """The leading coefficient of a polynomial in half-angle tangents: factors 1 + t² have 1, so that they count not."""
    return leading_number(value.ring.to_half(value.polynomial).f)
