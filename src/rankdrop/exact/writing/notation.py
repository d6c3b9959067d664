"""Writing a form: text and LaTeX for people, Python and C in the joint variables q = θ − shift for machines.

And a step of a derivation as it is written down.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from fractions import Fraction
from math import pi

from rankdrop.exact.algebra.polynomial import WRITTEN, approximation
from rankdrop.exact.writing.form import Factor, Product, Sum, Symbol, Wave
from rankdrop.family.equation import pretty_angle

SUPERSCRIPT = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
LONG = 10**5
"""Whole numbers above this are not read any more; people get `DIGITS` digits of them, the largest of a sum being 1."""
DIGITS = 6
EXACT = 2**53  # whole numbers up to this are exact as floats


class Notation(ABC):
    """How numbers, symbols, waves, powers and brackets are written; sums and products follow from these."""

    times = " "
    minus = "-"
    exact = False  # whether numbers are written to the last digit

    @abstractmethod
    def number(self, value: Fraction) -> str:
        """A positive number."""

    @abstractmethod
    def symbol(self, symbol: Symbol) -> str:
        """A length, a root, or the variable of a slide."""

    @abstractmethod
    def wave(self, wave: Wave) -> str:
        """sin or cos of a combination of angles."""

    @abstractmethod
    def power(self, text: str, factor: Factor, power: int) -> str:
        """A factor to a power from 2 up."""

    def bracket(self, text: str) -> str:
        """A sum inside a product."""
        return f"({text})"

    def zero(self, form: Product) -> str:
        """What vanishes with the form: the form less its number, a power, and a bracket round all of it."""
        return self.sum(self.parts(form))

    def parts(self, form: Product) -> tuple[Product, ...]:
        """What vanishes with the form, as products to be added."""
        return bare(Product(Fraction(1), tuple((factor, 1) for factor, _ in form.factors)), self.exact)

    def value(self, form: Product) -> str:
        """The form itself, with its number and its powers."""
        form = self.readable(form)
        if len(form.factors) == 1 and isinstance(form.factors[0][0], Sum) and form.factors[0][1] == 1:
            return self.sum([replace(part, number=form.number * part.number) for part in form.factors[0][0].parts])
        return self.sum([form])

    def readable(self, form: Product) -> Product:
        """The form, equal to it, with sums of long numbers divided by the largest one."""
        return _rescaled(form, self.exact, not self.exact and _long(form))

    def sum(self, parts: Sequence[Product]) -> str:
        """Products joined by signs."""
        text = ""
        for place, part in enumerate(parts):
            sign = self.minus if part.number < 0 else "+"
            text += f" {sign} " if place else (sign if sign != "+" else "")
            text += self.product(part)
        return text

    def product(self, part: Product) -> str:
        """One product without its sign."""
        number = abs(part.number)
        factors = [self.number(number)] if number != 1 or not part.factors else []
        return self.times.join(factors + [self.factor(factor, power) for factor, power in part.factors])

    def factor(self, factor: Factor, power: int) -> str:
        """A factor to its power."""
        if isinstance(factor, Sum):
            text = self.bracket(self.sum(factor.parts))
        else:
            text = self.symbol(factor) if isinstance(factor, Symbol) else self.wave(factor)
        return text if power == 1 else self.power(text, factor, power)


def bare(form: Product, exact: bool) -> tuple[Product, ...]:
    """The parts of a form without its number; sums with long numbers are divided by the largest one.

    Args:
        form: any.
        exact: only where that leaves decimals that a float holds, or where the numbers are longer than a float.
    """
    rescaled = _rescaled(form, exact, not exact and _long(form))
    if len(rescaled.factors) == 1 and isinstance(rescaled.factors[0][0], Sum):
        return rescaled.factors[0][0].parts
    return (Product(Fraction(1), rescaled.factors),)


def _long(form: Product) -> bool:
    """Whether a number anywhere in the form is too long to be read."""
    sums = [factor.parts for factor, _ in form.factors if isinstance(factor, Sum)]
    return any(_too_long(part.number) or _long(part) for parts in sums for part in parts)


def _too_long(value: Fraction) -> bool:
    return max(abs(value.numerator), value.denominator) > LONG


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
                if not exact or most > EXACT or all(Fraction(repr(float(p.number))) == p.number for p in divided):
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


def _spelled(turns: Sequence[tuple[int, int]], name: str, minus: str, half: str) -> str:
    """θ3 − θ5 and (θ3 + θ5)/2: a combination of angles; `name` and `half` are patterns."""
    halved = all(m % 2 for _, m in turns)
    text = ""
    for j, m in turns:
        size = abs(m) if halved or m % 2 else abs(m) // 2
        one = ("" if size == 1 else str(size)) + name.format(j)
        one = one if halved or m % 2 == 0 else half.format(one)
        text += (f" {minus if m < 0 else '+'} " if text else minus if m < 0 else "") + one
    if halved:
        return half.format(f"({text})" if len(turns) > 1 else text)
    return text


def _joined(turns: Sequence[tuple[int, int]]) -> bool:
    """Whether the combination is written by its joints' digits alone."""
    return all(m == 2 and j < 10 for j, m in turns)


class Text(Notation):
    """Unicode: a2 c2 + a3 c23 − d4 s23."""

    minus = "−"

    def number(self, value: Fraction) -> str:
        """Whole, or six digits."""
        return _readable(value)

    def symbol(self, symbol: Symbol) -> str:
        """Its name; √2 for a root."""
        return WRITTEN.get(symbol.name, symbol.name)

    def wave(self, wave: Wave) -> str:
        """c23, s(θ1 − θ2), cos(θ4/2)."""
        if _joined(wave.turns):
            return wave.kind[0] + "".join(str(j) for j, _ in wave.turns)
        name = wave.kind if wave.halved else wave.kind[0]
        text = _spelled(wave.turns, "θ{}", self.minus, "{}/2")
        return f"{name}({text})"

    def power(self, text: str, factor: Factor, power: int) -> str:
        """A raised number, before an angle in brackets."""
        if isinstance(factor, Wave) and text[-1] == ")":
            name, rest = text.split("(", 1)
            return f"{name}{str(power).translate(SUPERSCRIPT)}({rest}"
        return text + str(power).translate(SUPERSCRIPT)


class Latex(Notation):
    r"""LaTeX: a_2 c_2 + a_3 c_{23}; names in full where the angles are no plain sum: \cos(\theta_3 - \theta_5)."""

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

    def symbol(self, symbol: Symbol) -> str:
        """With a subscript."""
        return latex_name(symbol.name)

    def wave(self, wave: Wave) -> str:
        """c_{23}, or the name in full."""
        if _joined(wave.turns):
            return latex_name(wave.kind[0] + "".join(str(j) for j, _ in wave.turns))
        text = latex_subscripts(_spelled(wave.turns, r"\theta_{}", self.minus, r"\tfrac{{{}}}{{2}}"))
        text = re.sub(r"\\tfrac\{\((.*)\)\}", r"\\tfrac{\1}", text)
        return rf"\{wave.kind}({text})"

    def power(self, text: str, factor: Factor, power: int) -> str:
        """A superscript, before an angle in brackets."""
        if isinstance(factor, Wave):
            head = re.match(r"\\?[a-z]+", text)
            assert head is not None
            name, rest = head.group(), text[head.end() :]
            return f"{name}{rest}^{{{power}}}" if rest.startswith("_") else f"{name}^{{{power}}}{rest}"
        return f"{text}^{{{power}}}"


def latex_name(name: str) -> str:
    r"""a2 → a_2, c23 → c_{23}, upper → \mathrm{upper}."""
    if name in WRITTEN:
        return re.sub("√(.*)", r"\\sqrt{\1}", WRITTEN[name]).replace("cos", r"\cos").replace("°", r"^\circ")
    head, tail = re.fullmatch(r"([A-Za-z]*)_?(.*)", name, re.DOTALL).groups()  # type: ignore[union-attr] # matches all
    head = head if len(head) == 1 else rf"\mathrm{{{head}}}"
    tail = tail.replace("_", r"\_")
    return head if not tail else f"{head}_{tail}" if len(tail) == 1 else f"{head}_{{{tail}}}"


def latex_subscripts(text: str) -> str:
    r"""\theta_12 → \theta_{12}."""
    return re.sub(r"_(\d\d+)", r"_{\1}", text)


def angle_words(value: float) -> str:
    """An angle for people: parts of π as such, others in radians with degrees beside."""
    text = pretty_angle(value)
    return text if "π" in text or text == "0" else f"{text} rad ({value * 180 / pi:.4g}°)".replace("-", "−")


def latex_angle(value: float) -> str:
    """The same in LaTeX."""
    text = pretty_angle(value).replace("−", "-").replace("π", r"\pi")
    if r"\pi" not in text and text != "0":
        return rf"{text}\,\mathrm{{rad}}"
    match = re.fullmatch(r"(-?)(.*)/(\d+)", text)
    return rf"{match[1]}\frac{{{match[2]}}}{{{match[3]}}}" if match else text


@dataclass(frozen=True)
class Python(Notation):
    """Python: a2*cos(q2) + a3*cos(q2 + q3), in the joint variables q = θ − shift.

    Attributes:
        letters: numbers that replace lengths [m].
        shifts: of each joint [rad], slides have none; empty for none.
        variable: pattern of a joint variable, with {0} for its number and {1} for its place from 0.
        names: what lengths are called there, where it is something else.
    """

    letters: Mapping[str, float] = field(default_factory=dict)
    shifts: Sequence[float] = ()
    variable: str = "q{0}"
    names: Mapping[str, str] = field(default_factory=dict)

    times = "*"
    exact = True

    def number(self, value: Fraction) -> str:
        """Whole numbers as such, others as floats."""
        return str(value.numerator) if value.denominator == 1 and value <= EXACT else repr(float(value))

    def symbol(self, symbol: Symbol) -> str:
        """Its name, the name given for it, or its value."""
        if symbol.slide:
            return self.joint(symbol.slide)
        if symbol.name in WRITTEN:
            return repr(float(approximation(symbol.name)))
        if symbol.name in self.letters:
            value = float(self.letters[symbol.name])
            return repr(value) if value >= 0 else f"({value!r})"
        return self.names.get(symbol.name, symbol.name)

    def wave(self, wave: Wave) -> str:
        """A call."""
        return f"{wave.kind}({self.angle(wave.turns)})"

    def angle(self, turns: Sequence[tuple[int, int]], value: str = "0") -> str:
        """Σ m_j (q_j + shift_j) / 2 − value / 2, a combination of angles less half of an angle out of `SIMPLE`."""
        halved = all(m % 2 for _, m in turns)
        constant = sum(m * self.shift(j) for j, m in turns) * (1.0 if halved else 0.5)
        text = ""
        for j, m in turns:
            size = abs(m) if halved or m % 2 else abs(m) // 2
            one = ("" if size == 1 else f"{self.number(Fraction(size))}*") + self.joint(j)
            one = one if halved or m % 2 == 0 else f"{one}/{self.number(Fraction(2))}"
            text += (f" {'-' if m < 0 else '+'} " if text else "-" if m < 0 else "") + one
        if value != "0":
            text += f" {'+' if value[0] == '-' else '-'} {self.simple(value.lstrip('-'))}"
        if constant:
            text += f" {'+' if constant > 0 else '-'} {abs(constant)!r}"
        two = self.number(Fraction(2))
        return text if not halved else f"({text})/{two}" if " " in text else f"{text}/{two}"

    def joint(self, number: int) -> str:
        """A joint variable."""
        return self.variable.format(number, number - 1)

    def shift(self, number: int) -> float:
        """What is added to a joint variable [rad]."""
        return float(self.shifts[number - 1]) if len(self.shifts) else 0.0

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
