"""Writing a form for machines: Python and C, in the joint variables q = θ − shift."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import pi

from rankdrop.exact.writing.form import Factor, Symbol, Wave
from rankdrop.exact.writing.notation import EXACT, Notation


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
    """C99, with <math.h>."""

    def number(self, value: Fraction) -> str:
        """A double."""
        return repr(float(value))

    def simple(self, value: str) -> str:
        """To the last digit: <math.h> need not know π."""
        return repr(pi if value == "pi" else pi / 2)

    def power(self, text: str, factor: Factor, power: int) -> str:
        """A call of pow."""
        return f"pow({text}, {power}.0)"
