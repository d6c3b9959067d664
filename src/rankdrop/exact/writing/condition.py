"""One condition, ready to be printed: text, LaTeX, Python, C, and the numeric equation that `analyze` speaks.

First a joint that stands at one of some simple angles (θ4 = 0 or π), then a polynomial.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import atan2, pi, tau
from typing import NamedTuple

import numpy as np

from rankdrop.errors import OptionError
from rankdrop.exact.algebra.polynomial import SIMPLE, Polynomial
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.writing.form import Product, Symbol, Wave, derivative, fourier, total
from rankdrop.exact.writing.notation import Latex, Notation, Python, Text, angle_words, latex_angle
from rankdrop.exact.writing.shortest import parts_of, shortest
from rankdrop.family.equation import Equation, Term, normalised

WORDS = {"0": "0", "pi": "π", "pi/2": "π/2", "-pi/2": "−π/2"}
LATEX = {"0": "0", "pi": r"\pi", "pi/2": r"\frac{\pi}{2}", "-pi/2": r"-\frac{\pi}{2}"}
RADIANS = {"0": 0.0, "pi": pi, "pi/2": pi / 2, "-pi/2": -pi / 2}
QUARTERS = frozenset({"pi/2", "-pi/2"})
HALVES = frozenset({"0", "pi"})


def _checked(values: Sequence[str]) -> tuple[str, ...]:
    unknown = [value for value in values if value not in SIMPLE]
    if unknown or not values:
        got = ", ".join(unknown) or "none"
        raise OptionError("not an angle a joint is pinned at", got=got, allowed=", ".join(SIMPLE))
    return tuple(value for value in SIMPLE if value in values)


class AnglePin(NamedTuple):
    """A joint that stands at one of some simple angles: a condition as `Condition` is one, with the same methods.

    Every method raises an `OptionError` for a value that is not in `SIMPLE`, and where there is none.

    Attributes:
        joint: number.
        values: out of `SIMPLE`.

    Example:
        >>> from rankdrop.exact.writing.notation import C, Python
        >>> pin = AnglePin(4, ("0", "pi"))
        >>> pin.text(), pin.code(Python()), pin.code(C()), pin.gradient(C())
        ('θ4 = 0 or π', 'sin(q4)', 'sin(q[3])', {4: 'cos(q[3])'})
        >>> AnglePin(3, ("pi/2", "-pi/2")).text(), AnglePin(4, ("pi/2",)).code(Python())
        ('θ3 = ±π/2', 'sin((q4 - pi/2)/2)')
    """

    joint: int
    values: tuple[str, ...]

    @property
    def joints(self) -> tuple[int]:
        """The number of the joint."""
        return (self.joint,)

    @property
    def angles(self) -> tuple[float, ...]:
        """The values of θ [rad]."""
        return tuple(RADIANS[value] for value in _checked(self.values))

    def text(self) -> str:
        """For people: "θ4 = 0 or π"."""
        kept = _checked(self.values)
        words = [WORDS[value] for value in kept]
        if set(kept) >= QUARTERS:
            words = [*(WORDS[value] for value in kept if value not in QUARTERS), "±π/2"]
        return f"θ{self.joint} = {' or '.join(words)}"

    def latex(self) -> str:
        r"""LaTeX, without delimiters: \theta_4 \in \{0, \pi\}."""
        kept = _checked(self.values)
        name = rf"\theta_{self.joint}" if self.joint < 10 else rf"\theta_{{{self.joint}}}"
        if len(kept) == 1:
            return f"{name} = {LATEX[kept[0]]}"
        if set(kept) == QUARTERS:
            return rf"{name} = \pm\frac{{\pi}}{{2}}"
        return rf"{name} \in \{{{', '.join(LATEX[value] for value in kept)}\}}"

    def code(self, notation: Python) -> str:
        """An expression in q that vanishes there and nowhere else; no length plays a part."""
        return "*".join(f"{kind}({angle})" for kind, angle, _ in self._factors(notation))

    def gradient(self, notation: Python) -> dict[int, str]:
        """The derivative of `code` by its joint variable."""
        factors = self._factors(notation)
        parts = []
        for place, (kind, angle, whole) in enumerate(factors):
            number = ("" if whole else "0.5*") if kind == "sin" else ("-" if whole else "-0.5*")
            others = [f"{other}({inner})" for k, (other, inner, _) in enumerate(factors) if k != place]
            parts.append(number + "*".join([f"{'cos' if kind == 'sin' else 'sin'}({angle})", *others]))
        return {self.joint: " + ".join(parts).replace("+ -", "- ")}

    def equation(self, letters: Mapping[str, float], n: int, shifts: Sequence[float] | None = None) -> Equation:
        """The numeric equation Π sin((θ_j − value) / 2) = 0 in q; arguments as in `Condition.equation`."""
        size = len(self.angles)
        coefficients = np.array([1.0 + 0.0j])
        for angle in self.angles:  # sin(x) = (exp(ix) − exp(−ix)) / 2i, powers of exp(iθ/2) from −size to size
            turn = np.exp(0.5j * angle)
            coefficients = np.convolve(coefficients, np.array([-turn, 0, 1 / turn]) / 2j)
        shift = 0.0 if shifts is None else float(shifts[self.joint - 1])
        terms = []
        for power in range(size, -1, -1):
            value = coefficients[power + size] * (2 if power else 1)
            harmonics = tuple(power * (i == self.joint - 1) for i in range(n))
            phase = -power * shift / 2 + 0.0
            for kind, part in (("cos", value.real), ("sin", -value.imag)):
                if kind == "cos" or power:
                    terms.append(Term(float(part), kind, harmonics, (0,) * n, phase))
        return normalised(terms)

    def _factors(self, notation: Python) -> list[tuple[str, str, bool]]:
        """(sin or cos, of what, whether of whole angles): the product of these vanishes there and nowhere else."""
        kept = set(_checked(self.values))
        factors = []
        for pair, kind in ((HALVES, "sin"), (QUARTERS, "cos")):
            if kept >= pair:
                factors.append((kind, notation.angle(((self.joint, 2),)), True))
                kept -= pair
        for value in _checked(tuple(kept)) if kept else ():
            kind, rest = ("cos", "0") if value == "pi" else ("sin", value)
            factors.append((kind, notation.angle(((self.joint, 1),), rest), False))
        return factors


@dataclass(frozen=True, eq=False)
class Condition:
    """One condition that is not a pinned joint.

    Attributes:
        ring: of the polynomial.
        polynomial: irreducible, of the half-angle ring; the condition holds where it vanishes.

    Example:
        >>> ring = Ring([3, 4, 5])
        >>> Condition(ring, ring.t[3] + ring.t[5]).text()
        'θ3 + θ5 = 0'
    """

    ring: Ring
    polynomial: Polynomial

    @cached_property
    def form(self) -> Product:
        """The shortest way of writing it that was found; equal to the polynomial (`half_of`)."""
        return shortest(self.polynomial, self.ring)

    @cached_property
    def waves(self) -> tuple[Product, ...]:
        """The terms of the Fourier form: each a number, lengths, slides, and at most one sine or cosine."""
        return tuple(parts_of(fourier(self.ring.form(self.polynomial))))

    @property
    def joints(self) -> tuple[int, ...]:
        """Numbers of the joints that occur."""
        numbers = sorted([*self.ring.revolute, *self.ring.prismatic])
        degrees = dict(zip(self.ring.names, self.polynomial.degrees(), strict=True))
        return tuple(j for j in numbers if degrees.get(f"t{j}", degrees.get(f"q{j}", 0)) > 0)

    def __str__(self) -> str:
        return self.text()

    def text(self) -> str:
        """For people: "a2 c2 + a3 c23 = 0", "θ5 = θ3 + π"; s_i is sin θ_i, c_23 is cos(θ2 + θ3). Angles modulo 2π."""
        relation = self.relation
        if relation is not None:
            return _related(*relation, "θ{}", "−", angle_words)
        return self._slide("q{}", Text(), " m") or _sides(self.form, Text())

    def latex(self) -> str:
        r"""The same in LaTeX, without delimiters: a_2 c_2 + a_3 c_{23} = 0."""
        relation = self.relation
        if relation is not None:
            return _related(*relation, r"\theta_{{{}}}", "-", latex_angle)
        return self._slide("q_{{{}}}", Latex(), r"\,\mathrm{m}") or _sides(self.form, Latex())

    def code(self, notation: Python) -> str:
        """The left-hand side as an expression in q; zero where the condition holds."""
        return notation.zero(self.form)

    def gradient(self, notation: Python) -> dict[int, str]:
        """Derivatives of `code` by the number of the joint; those that vanish are left out."""
        parts = notation.parts(self.form)
        slopes = {joint: total(derivative(part, joint) for part in parts) for joint in self.joints}
        return {joint: notation.value(slope) for joint, slope in slopes.items() if slope.number}

    def equation(self, letters: Mapping[str, float], n: int, shifts: Sequence[float] | None = None) -> Equation:
        """The numeric equation in q, its largest coefficient 1.

        Args:
            letters: value of every length that occurs [m].
            n: number of joints.
            shifts: θ_j = q_j + shifts[j − 1] [rad]; those of slides are 0.
        """
        found: dict[tuple[str, tuple[int, ...], tuple[int, ...]], float] = {}
        largest = self._largest
        for part in self.waves:
            value, kind = float(part.number / largest), "cos"
            harmonics, powers = [0] * n, [0] * n
            for factor, power in part.factors:
                if isinstance(factor, Wave):
                    kind = factor.kind
                    for j, multiple in factor.turns:
                        harmonics[j - 1] = multiple
                elif isinstance(factor, Symbol) and factor.slide:
                    powers[factor.slide - 1] = power
                elif isinstance(factor, Symbol):
                    value *= letters[factor.name] ** power
            key = (kind, tuple(harmonics), tuple(powers))
            found[key] = found.get(key, 0.0) + value
        return normalised(
            Term(value, kind, harmonics, powers, _phase(harmonics, shifts))
            for (kind, harmonics, powers), value in found.items()
        )

    @cached_property
    def _largest(self) -> Fraction:
        """The power of two next to the largest number of the Fourier form: whole numbers of a thousand digits are no
        floats, and with a power of two every ratio keeps its last bit.
        """
        numbers = [part.number for part in self.waves]
        bits = max((abs(one.numerator).bit_length() - one.denominator.bit_length() for one in numbers), default=0)
        return Fraction(2) ** bits

    @cached_property
    def relation(self) -> tuple[tuple[tuple[int, int], ...], float] | None:
        """(turns, value) of Σ turns_j θ_j = value where the condition says just that."""
        cosine = sine = 0.0
        turns: set[tuple[tuple[int, int], ...]] = set()
        for part in self.waves:
            if len(part.factors) != 1 or not isinstance(part.factors[0][0], Wave):
                return None
            one = part.factors[0][0]
            turns.add(one.turns)
            if one.kind == "cos":
                cosine = float(part.number / self._largest)
            else:
                sine = float(part.number / self._largest)
        if len(turns) != 1:
            return None
        kept = turns.pop()
        if all(multiple % 2 == 0 for _, multiple in kept):
            return None
        return kept, 2 * atan2(-cosine, sine) if sine else pi

    def _slide(self, name: str, notation: Notation, unit: str) -> str:
        """q_j = number, where the condition says just that; else ""."""
        if len(self.joints) != 1 or self.joints[0] not in self.ring.prismatic or len(self.polynomial) > 2:
            return ""
        j = self.joints[0]
        numbers = {tuple(factor for factor, _ in part.factors): part.number for part in self.waves}
        slope = numbers.pop((Symbol(f"q{j}", j),), None)
        rest = numbers.pop((), 0)
        if slope is None or numbers:
            return ""
        value = -rest / slope
        sign = notation.minus if value < 0 else ""
        return f"{name.format(j)} = {sign}{notation.number(abs(value))}" + (unit if value else "")


def _phase(harmonics: Sequence[int], shifts: Sequence[float] | None) -> float:
    if shifts is None:
        return 0.0
    return -sum(m * float(s) for m, s in zip(harmonics, shifts, strict=True)) / 2 + 0.0


def _related(
    turns: tuple[tuple[int, int], ...], value: float, name: str, minus: str, words: Callable[[float], str]
) -> str:
    """θ5 = θ3 + π, θ3 + θ5 = 0."""
    value = (value + pi) % tau - pi
    if abs(value + pi) < 1e-12:
        value = pi
    if len(turns) == 2 and turns[0][1] == 1 and turns[1][1] == -1:
        left, right = name.format(turns[1][0]), name.format(turns[0][0])
        other = -value if abs(value - pi) > 1e-12 else pi
        if abs(other) < 1e-12:
            return f"{left} = {right}"
        return f"{left} = {right} {minus if other < 0 else '+'} {words(abs(other))}"
    text = ""
    for j, multiple in turns:
        sign = f" {minus if multiple < 0 else '+'} " if text else ""
        text += sign + ("" if abs(multiple) == 1 else str(abs(multiple))) + name.format(j)
    return f"{text} = {words(value)}"


def _sides(form: Product, notation: Notation) -> str:
    """… = 0, or A = B where half angles make two terms of opposite sign."""
    parts = notation.parts(form)
    if len(parts) == 2 and parts[0].number > 0 > parts[1].number:
        waves = [factor for part in parts for factor, _ in part.factors if isinstance(factor, Wave)]
        if any(wave.halved for wave in waves):
            return f"{notation.product(parts[0])} = {notation.product(parts[1])}"
    return f"{notation.zero(form)} = 0"
