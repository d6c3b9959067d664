"""A trigonometric polynomial as a value, not as a condition: its number, its sign and its powers are written, too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from rankdrop.exact.algebra.atom import Factors
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.writing.form import Factor, Product, Sum, Symbol, Wave
from rankdrop.exact.writing.notation import Latex, Text
from rankdrop.exact.writing.programs import C, Python
from rankdrop.exact.writing.shortest import multiplied
from rankdrop.exact.writing.text_of import single_angles

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
        >>> value.text(), value.latex(), value.expression()
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

    def expression(self, *, shifts: Sequence[float] | None = None, names: Mapping[str, str] | None = None) -> str:
        """A Python expression in q1 …, sin, cos and the lengths.

        Args:
            shifts: θ_j = q_j + shifts[j − 1] [rad]; None for none.
            names: what lengths are called there, where it is something else.
        """
        return Python({}, () if shifts is None else shifts, names=names or {}).value(self.form)

    def c_code(self, *, shifts: Sequence[float] | None = None, names: Mapping[str, str] | None = None) -> str:
        """A C expression in q[0] …, with <math.h>; arguments as of `expression`."""
        return C(shifts=() if shifts is None else shifts, variable="q[{1}]", names=names or {}).value(self.form)

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
