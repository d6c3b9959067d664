"""Conditions as they are written: as text, LaTeX, Python and C, and as the numeric equation that `analyze` uses.

`AnglePin` and `Condition` are conditions: a joint at one of some simple angles (θ4 = 0 or π), and a polynomial.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import atan2, pi, tau
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from rankdrop.algebra.polynomial import (
    SIMPLE,
    Atom,
    Polynomial,
    primitive,
    variables_in,
)
from rankdrop.algebra.ring import Ring, polynomial_of
from rankdrop.algebra.roots import ROOTS, sums_over_roots
from rankdrop.errors import OptionError
from rankdrop.formula.equation import Equation, Term, normalised_equation
from rankdrop.formula.notation import Latex, Python, Text, in_parts
from rankdrop.formula.shortest import form_of, parts_of, shortest
from rankdrop.formula.sums import Factor, Product, Symbol, Wave, derivative, factors_of, fourier, total

_SAME = 1e-12  # angles closer than this are the same [rad]


_TEXTS: WeakKeyDictionary[Ring, dict[str, str]] = WeakKeyDictionary()
"""Texts of trigonometric polynomials: the same ones come back in every case of a derivation."""


WORDS = {"0": "0", "pi": "π", "pi/2": "π/2", "-pi/2": "−π/2"}
LATEX = {"0": "0", "pi": r"\pi", "pi/2": r"\frac{\pi}{2}", "-pi/2": r"-\frac{\pi}{2}"}
RADIANS = {"0": 0.0, "pi": pi, "pi/2": pi / 2, "-pi/2": -pi / 2}
QUARTERS = frozenset({"pi/2", "-pi/2"})
HALVES = frozenset({"0", "pi"})


def _checked_names(values: Sequence[str]) -> tuple[str, ...]:
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
        part: b where the angle at these values is θ_j / b: θ_j is at b times the values, modulo 2πb.

    Example:
        >>> from rankdrop.formula.notation import C, Python
        >>> pin = AnglePin(4, ("0", "pi"))
        >>> pin.text(), pin.code(Python()), pin.code(C()), pin.gradient(C())
        ('θ4 = 0 or π', 'sin(q4)', 'sin(q[3])', {4: 'cos(q[3])'})
        >>> AnglePin(3, ("pi/2", "-pi/2")).text(), AnglePin(4, ("pi/2",)).code(Python())
        ('θ3 = ±π/2', 'sin((q4 - pi/2)/2)')
    """

    joint: int
    values: tuple[str, ...]
    part: int = 1

    @property
    def joints(self) -> tuple[int]:
        """The number of the joint."""
        return (self.joint,)

    @property
    def angles(self) -> tuple[float, ...]:
        """The values of θ [rad]."""
        return tuple(RADIANS[value] for value in _checked_names(self.values))

    @property
    def words(self) -> tuple[str, ...]:
        """The values for people, π/2 and −π/2 as one: ("0", "±π/2")."""
        kept = _checked_names(self.values)
        if set(kept) >= QUARTERS:
            return (*(WORDS[value] for value in kept if value not in QUARTERS), "±π/2")
        return tuple(WORDS[value] for value in kept)

    def text(self, sign: str = "=") -> str:
        """For people: "θ4 = 0 or π"; with "≠" of one value: "θ4 ≠ 0"."""
        return f"{self._angle(Text())} {sign} {' or '.join(self.words)}"

    def latex(self) -> str:
        r"""LaTeX, without delimiters: \theta_4 \in \{0, \pi\}."""
        kept = _checked_names(self.values)
        name = self._angle(Latex())
        if len(kept) == 1:
            return f"{name} = {LATEX[kept[0]]}"
        if set(kept) == QUARTERS:
            return rf"{name} = \pm\frac{{\pi}}{{2}}"
        return rf"{name} \in \{{{', '.join(LATEX[value] for value in kept)}\}}"

    def _angle(self, notation: Text) -> str:
        return notation.fraction_of(Fraction(1, self.part), notation.theta(self.joint))

    @property
    def parts(self) -> dict[int, int]:
        """The joint with its part, as notations take it; empty for a whole angle."""
        return {self.joint: self.part} if self.part > 1 else {}

    @property
    def form(self) -> Product:
        """What vanishes there and nowhere else; no length plays a part."""
        kept = set(_checked_names(self.values))
        factors = []
        for pair, kind in ((HALVES, "sin"), (QUARTERS, "cos")):
            if kept >= pair:
                factors.append(Wave(kind, ((self.joint, 2),)))
                kept -= pair
        for value in sorted(kept, key=SIMPLE.index):
            half = ((self.joint, 1),)
            factors.append(Wave("cos", half) if value == "pi" else Wave("sin", half, value))
        return Product(Fraction(1), tuple((factor, 1) for factor in factors))

    def code(self, notation: Python) -> str:
        """`form` as an expression in q."""
        return in_parts(notation, self.parts).product(self.form)

    def gradient(self, notation: Python) -> dict[int, str]:
        """The derivative of `code` by its joint variable."""
        slope = _derivative_by_part(derivative(self.form, self.joint), self.part)
        return {self.joint: in_parts(notation, self.parts).value(slope)}

    def equation(self, letters: Mapping[str, float], n: int, shifts: Sequence[float] | None = None) -> Equation:
        """The numeric equation Π sin((θ_j − value) / 2) = 0 in q, of a part of θ_j in q_j / part; arguments as in
        `Condition.equation`.
        """
        size = len(self.angles)
        coefficients = np.array([1.0 + 0.0j])
        for angle in self.angles:  # sin(x) = (exp(ix) − exp(−ix)) / 2i, powers of exp(iθ/2) from −size to size
            turn = np.exp(0.5j * angle)
            coefficients = np.convolve(coefficients, np.array([-turn, 0, 1 / turn]) / 2j)
        if shifts is None:
            shift = 0.0
        else:
            shift = float(shifts[self.joint - 1]) / self.part
        terms = []
        for power in range(size, -1, -1):
            value = coefficients[power + size] * (2 if power else 1)
            harmonics = tuple(power * (i == self.joint - 1) for i in range(n))
            phase = -power * shift / 2 + 0.0
            for kind, part in (("cos", value.real), ("sin", -value.imag)):
                if kind == "cos" or power:
                    terms.append(Term(float(part), kind, harmonics, (0,) * n, phase))
        return normalised_equation(terms)


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
        known, key = self.ring.known, ("waves", str(self.polynomial))
        parts: tuple[Product, ...] = known.get(key) or known.keep(
            key, tuple(parts_of(fourier(self.ring.form(self.polynomial)))), len(self.polynomial)
        )
        return parts

    @property
    def joints(self) -> tuple[int, ...]:
        """Numbers of the joints that occur."""
        numbers = sorted([*self.ring.revolute, *self.ring.prismatic])
        degrees = dict(zip(self.ring.names, self.polynomial.degrees(), strict=True))
        return tuple(j for j in numbers if degrees.get(f"t{j}", degrees.get(f"q{j}", 0)) > 0)

    def text(self, sign: str = "=") -> str:
        """For people: "a2 c2 + a3 c23 = 0", "θ5 = θ3 + π"; s_i is sin θ_i, c_23 is cos(θ2 + θ3). Angles modulo 2π.

        Args:
            sign: "=", or "≠" for the negation.
        """
        return self._with_sign(Text(divisors=self.ring.parts), sign)

    def latex(self) -> str:
        r"""The same in LaTeX, without delimiters: a_2 c_2 + a_3 c_{23} = 0."""
        return self._with_sign(Latex(divisors=self.ring.parts))

    def _with_sign(self, notation: Text, sign: str = "=") -> str:
        relation = self.relation
        if relation is not None:
            return _angle_relation(*relation, notation, sign)
        return self._slide(notation, sign) or _sides(self.form, notation, sign)

    def code(self, notation: Python) -> str:
        """The left-hand side as an expression in q; zero where the condition holds."""
        return in_parts(notation, self.ring.parts).zero(self.form)

    def gradient(self, notation: Python) -> dict[int, str]:
        """Derivatives of `code` by the number of the joint; those that vanish are left out."""
        notation = in_parts(notation, self.ring.parts)
        parts = notation.parts(self.form)
        slopes = {joint: total(derivative(part, joint) for part in parts) for joint in self.joints}
        return {
            joint: notation.value(_derivative_by_part(slope, self.ring.parts.get(joint, 1)))
            for joint, slope in slopes.items()
            if slope.number
        }

    def equation(self, letters: Mapping[str, float], n: int, shifts: Sequence[float] | None = None) -> Equation:
        """The numeric equation in q (of a joint in `Ring.parts` in q_j / part), its largest coefficient 1.

        Args:
            letters: value of every length that occurs [m].
            n: number of joints.
            shifts: θ_j = q_j + shifts[j − 1] [rad]; those of slides are 0.
        """
        if shifts is not None:
            shifts = [float(shift) / self.ring.parts.get(j, 1) for j, shift in enumerate(shifts, 1)]
        return _equation(self.waves, letters, n, shifts)

    @cached_property
    def relation(self) -> tuple[tuple[tuple[int, int], ...], float] | None:
        """(turns, value) of Σ turns_j θ_j = value where the condition says just that."""
        cosine = sine = 0.0
        turns: set[tuple[tuple[int, int], ...]] = set()
        for part in self.waves:
            if len(part.factors) != 1 or not isinstance(part.factors[0][0], Wave):
                return None
            wave = part.factors[0][0]
            turns.add(wave.turns)
            if wave.kind == "cos":
                cosine = float(part.number / _largest(self.waves))
            else:
                sine = float(part.number / _largest(self.waves))
        if len(turns) != 1:
            return None
        kept = turns.pop()
        if all(multiple % 2 == 0 for _, multiple in kept):
            return None
        return kept, 2 * atan2(-cosine, sine) if sine else pi

    def _slide(self, notation: Text, sign: str) -> str:
        """q_j = number, where the condition says just that; else ""."""
        ring, f, places = self.ring, self.polynomial, variables_in(self.polynomial)
        if len(places) != 1 or not ring.angles <= places[0] < ring.moving or f.total_degree() > 1:
            return ""
        numbers = {int(powers[places[0]]): Fraction(int(c.p), int(c.q)) for powers, c in f.terms()}
        value = -numbers.get(0, Fraction(0)) / numbers[1]
        minus, unit = notation.minus * (value < 0), notation.metre * bool(value)
        return f"{notation.slide.format(self.joints[0])} {sign} {minus}{notation.number(abs(value))}{unit}"


def _derivative_by_part(slope: Product, part: int) -> Product:
    """The derivative by a joint variable of which the angle of a form is one of so many parts."""
    return Product(slope.number / part, slope.factors)


def _equation(
    waves: Sequence[Product], letters: Mapping[str, float], n: int, shifts: Sequence[float] | None
) -> Equation:
    """The numeric equation of terms of a Fourier form; arguments as in `Condition.equation`."""
    amplitudes: dict[tuple[str, tuple[int, ...], tuple[int, ...]], float] = {}
    waves = _with_numbers_for_roots(waves)
    largest = _largest(waves)
    for part in waves:
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
        amplitudes[key] = amplitudes.get(key, 0.0) + value
    if shifts is None:
        half = np.zeros(n)
    else:
        half = np.asarray(shifts, dtype=np.float64) / 2
    terms = []
    for (kind, multiples, exponents), value in amplitudes.items():
        phase = float(sum(m * x for m, x in zip(multiples, half, strict=True)))
        terms.append(Term(value, kind, multiples, exponents, 0.0 - phase))
    return normalised_equation(terms)


def _with_numbers_for_roots(waves: Sequence[Product]) -> Sequence[Product]:
    """The terms with the values of √2 and its like in their numbers, those with the same factors added up."""
    terms, met = [], False
    for part in waves:
        roots: list[tuple[str, int]] = []
        others: list[tuple[Factor, int]] = []
        for factor, power in part.factors:
            if isinstance(factor, Symbol) and factor.name in ROOTS:
                roots.append((factor.name, power))
                met = True
            else:
                others.append((factor, power))
        terms.append((tuple(others), part.number, tuple(roots)))
    if not met:
        return waves
    return [Product(number, factors) for factors, number in sums_over_roots(terms).items() if number]


def _largest(waves: Sequence[Product]) -> Fraction:
    """The power of two next to the largest number of a Fourier form: whole numbers of a thousand digits are no floats,
    and with a power of two every ratio keeps its last bit.
    """
    numbers = [part.number for part in waves]
    bits = max((abs(x.numerator).bit_length() - x.denominator.bit_length() for x in numbers), default=0)
    return Fraction(2) ** bits


def _angle_relation(turns: tuple[tuple[int, int], ...], value: float, notation: Text, sign: str) -> str:
    """θ5 = θ3 + π, θ3 + θ5 = 0."""
    value = (value + pi) % tau - pi
    value = pi if abs(value + pi) < _SAME else value
    if [multiple for _, multiple in turns] != [1, -1]:
        parts = [(m < 0, notation.share(j, 2 * abs(m))) for j, m in turns]
        return f"{notation.signed(parts)} {sign} {notation.angle_value(value)}"
    right, left = (notation.share(j, 2) for j, _ in turns)
    if abs(value - pi) < _SAME:
        other = value
    else:
        other = -value
    if abs(other) < _SAME:
        return f"{left} {sign} {right}"
    return f"{left} {sign} {right} {notation.minus if other < 0 else '+'} {notation.angle_value(abs(other))}"


def _sides(form: Product, notation: Text, sign: str) -> str:
    """… = 0, or A = B where half angles make two terms of opposite sign."""
    parts = notation.parts(form)
    if len(parts) == 2 and parts[0].number > 0 > parts[1].number:
        waves = [factor for factor in factors_of(parts) if isinstance(factor, Wave)]
        if any(wave.halved for wave in waves):
            return f"{notation.product(parts[0])} {sign} {notation.product(parts[1])}"
    return f"{notation.zero(form)} {sign} 0"


def text_of(ring: Ring, p: Polynomial) -> str:
    """A trigonometric polynomial, equal to it: s_j is sin θ_j, c_34 is cos(θ3 + θ4).

    Example:
        >>> ring = Ring([1, 2])
        >>> text_of(ring, ring.s[1] * ring.c[2] + ring.c[1] * ring.s[2])
        's12'
    """
    known, key = _TEXTS.setdefault(ring, {}), str(p)
    if key not in known:
        if p == 0:
            known[key] = "0"
        else:
            known[key] = Text(divisors=ring.parts).sum(parts_of(form_of(ring, p)))
    return known[key]


def condition_text(ring: Ring, p: Polynomial, sign: str = "=") -> str:
    """The condition p = 0 (or ≠ 0): "s4 = 0", "θ4 = π", "a6 + d3 s6 + d5 s6 ≠ 0"."""
    wanted = primitive(p)
    for j in ring.revolute:
        for value in SIMPLE:
            if wanted == primitive(polynomial_of(ring, ring.pin(j, value))):
                return pin_of(ring, j, (value,)).text(sign)
    text = text_of(ring, wanted)
    return f"{text_of(ring, -wanted) if text.startswith('−') else text} {sign} 0"


def atoms_text(
    ring: Ring, atoms: Sequence[Atom], written: Callable[[Polynomial], str] | None = None, sign: str = "="
) -> str:
    """When one of some atoms holds: "θ3 = 0 or π or a2 c2 + a3 c23 = 0"; joints at simple angles first.

    Args:
        ring: of the polynomials.
        atoms: at least one.
        written: how a polynomial that vanishes is written; None for the shortest form.
        sign: of joints at simple angles.
    """
    texts = [pin.text(sign) for pin in _pins(ring, atoms)]
    written = written or (lambda f: Condition(ring, f).text(sign))
    return " or ".join([*texts, *(written(atom.f) for atom in atoms if not atom.is_pin)])


def pin_of(ring: Ring, joint: int, values: Sequence[str]) -> AnglePin:
    """A joint of a ring at simple angles, or a part of its angle."""
    return AnglePin(joint, tuple(values), ring.parts.get(joint, 1))


def count_alternatives(atoms: Sequence[Atom]) -> int:
    """How many alternatives `atoms_text` joins with "or": a joint at ±π/2 is one, a joint at 0 or π two."""
    pins = (AnglePin(joint, tuple(values)) for joint, values in _simple_angles(atoms).items())
    return sum(len(pin.words) for pin in pins) + sum(not atom.is_pin for atom in atoms)


def _pins(ring: Ring, atoms: Sequence[Atom]) -> list[AnglePin]:
    """The joints at simple angles among atoms, in order, each with all of its values."""
    return [pin_of(ring, joint, chosen) for joint, chosen in sorted(_simple_angles(atoms).items())]


def _simple_angles(atoms: Sequence[Atom]) -> dict[int, list[str]]:
    values: dict[int, list[str]] = {}
    for atom in atoms:
        if atom.is_pin:
            values.setdefault(atom.joint, []).append(atom.value)
    return values
