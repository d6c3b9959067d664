"""How formulas are written: as text and LaTeX for people, as Python and C in the joint variables q = θ − shift for
machines.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from fractions import Fraction
from math import pi
from types import MappingProxyType

from rankdrop.algebra.roots import WRITTEN, approximation
from rankdrop.formula.equation import pretty_angle, share_of_pi
from rankdrop.formula.sums import Factor, Product, Sum, Symbol, Wave, is_number, leaves

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


def _divide_long_sums(form: Product, exact: bool, every: bool) -> Product:
    """Sums divided by their largest number: those with long numbers, or every one."""
    number = form.number
    factors: list[tuple[Factor, int]] = []
    for factor, power in form.factors:
        if isinstance(factor, Sum):
            parts = [_divide_long_sums(part, exact, every) for part in factor.parts]
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
            whole = ("" if size == 1 else f"{self.number(Fraction(size))}{self.between}") + self.theta(j)
            parts.append((m < 0, whole if halved or m % 2 == 0 else self.half(whole)))
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
        text = " ".join(f"{self.minus if negative else '+'} {summand}" for negative, summand in parts)
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
        return _divide_long_sums(form, self.exact, not self.exact and _long(form))

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
    inside = [*leaves(factor)]
    waves = [symbol for symbol in inside if isinstance(symbol, Wave)]
    joints = {f"q{symbol.slide}" for symbol in inside if isinstance(symbol, Symbol) and symbol.slide}
    for symbol in waves:
        joints |= {f"θ{j}" for j, _ in symbol.turns}
    return f"{len(waves)} sines and cosines, of {', '.join(sorted(joints, key=lambda name: int(name[1:])))}"


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


def in_parts(notation: Python, parts: Mapping[int, int]) -> Python:
    """A notation for forms in which the angles of some joints are parts of their own."""
    if parts:
        return replace(notation, divisors=parts)
    return notation
