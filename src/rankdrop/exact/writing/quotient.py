"""One polynomial over another, in factors, with what they share cancelled: an entry of a closed inverse."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np

from rankdrop.exact.algebra.atom import Atom
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.writing.form import Product, Symbol, Wave, half_of, product
from rankdrop.exact.writing.notation import Latex, Notation, Text
from rankdrop.exact.writing.programs import Python
from rankdrop.exact.writing.shortest import factor_forms
from rankdrop.exact.writing.value import Folded, Value
from rankdrop.robot.model import Array

WHOLE = 12
"""Numbers below the line are whole up to this; others go above as decimals."""
_ONE = Product(Fraction(1))


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
            return Product(Fraction(0)), _ONE
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
        if below == _ONE:
            return notation.value(above)
        sign = "-" if above.number < 0 else ""
        upper, lower = Product(abs(above.number), above.factors), below
        return rf"{sign}\frac{{{notation.value(upper)}}}{{{notation.value(lower)}}}"

    def expression(self, *, shifts: Sequence[float] | None = None) -> str:
        """A Python expression in q1 …, sin, cos and the lengths.

        Args:
            shifts: θ_j = q_j + shifts[j − 1] [rad]; None for none.
        """
        above, below = self.forms
        return _joined(Python({}, () if shifts is None else shifts), above, below, "/")

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
    if below == _ONE:
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
    back, _ = half_of(bare, ring)
    value = back.coeffs()[0]
    return bare, Fraction(int(value.p), int(value.q))


def _leading(value: Value) -> Fraction:
    """The leading coefficient of a polynomial in half-angle tangents: factors 1 + t² have 1, so that they count not."""
    f, _ = value.ring.to_half(value.polynomial)
    found = f.coeffs()[0]
    return Fraction(int(found.p), int(found.q))
