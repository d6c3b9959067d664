"""Conditions and values as they are written: the shortest form of a polynomial, as text, LaTeX, Python and C.

The shortest form is one of several that are all equal to the polynomial: its Fourier form; the polynomial in sines and
cosines of single angles; the factors, where it has several; and, for one joint or length x after another, the sum of
its coefficients times 1, c_x, s_x (or powers of the length), each coefficient written the same way. The last is what
people do by hand: it brings KG eq. 15 at θ4 = 0 from 50 terms to eight.

`AnglePin` and `Condition` are conditions: a joint at one of some simple angles (θ4 = 0 or π), and a polynomial; both
give the numeric equation that `analyze` uses, too. `Value` is a polynomial as a value: its number, its sign and its
powers are written. `Quotient` is one value over another, in factors, with what they share cancelled: an entry of a
closed inverse.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from math import atan2, pi, prod, tau
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from rankdrop.errors import OptionError
from rankdrop.exact.algebra.polynomial import SIMPLE, Atom, Factors, Polynomial, coefficients, primitive, used
from rankdrop.exact.algebra.ring import Form, Ring, polynomial_of
from rankdrop.exact.notation import (
    Factor,
    Latex,
    Product,
    Python,
    Sum,
    Symbol,
    Text,
    Wave,
    angle_words,
    derivative,
    fourier,
    half_of,
    latex_angle,
    number_of,
    product,
    symbols,
    total,
)
from rankdrop.family.equation import Equation, Term, normalised
from rankdrop.robot.model import Array

MANY = 600
"""Half-angle polynomials with more terms are not rearranged: nobody reads them."""
FINE, COARSE = 40, 150
"""With more terms than that only the two best variables, or the best one, are tried."""
LOOKS = 240
"""Polynomials looked at for one condition; those after are only multiplied out."""
FEW = 3
"""Terms of a Fourier form that is short enough as it is."""

_PINNED = ("pi", "0", "pi/2", "-pi/2")
"""Order in which `_pins` counts simple angles."""
_KNOWN: WeakKeyDictionary[Ring, dict[str, Product]] = WeakKeyDictionary()
"""Forms found, by polynomial: sets at θ = 0 and θ = π share their conditions."""


def shortest(f: Polynomial, ring: Ring) -> Product:
    """A short form of a half-angle polynomial, equal to f / Π (1 + t_j²)^(D_j / 2) with D_j its degree in t_j.

    Example:
        >>> ring = Ring([2, 3], letters=["a2", "a3"])
        >>> c23 = ring.c[2] * ring.c[3] - ring.s[2] * ring.s[3]
        >>> form = ring.to_half(ring.letter["a2"] * ring.c[2] + ring.letter["a3"] * c23)
        >>> Text().zero(shortest(form.f, ring))
        'a2 c2 + a3 c23'
    """
    known = _KNOWN.setdefault(ring, {})
    key = str(f)
    if key not in known:
        known[key] = _Search(ring).best(ring.form(f))
    return known[key]


def multiplied(ring: Ring, p: Polynomial, factors: Factors) -> Product:
    """A trigonometric polynomial as the product of its factors, number and sign included: equal to it everywhere.

    Half angles of one joint are put together as far as they go: 2 sin(θ/2) cos(θ/2) is sin θ.

    Args:
        ring: of p.
        p: not zero.
        factors: of p, from `Ring.factor`.

    Example:
        >>> ring = Ring([1, 2], letters=["a1"])
        >>> p = -2 * ring.letter["a1"] * ring.s[2] * (ring.c[1] + ring.c[2])
        >>> Text().value(multiplied(ring, p, ring.factor(p)))
        '−4 a1 s2 cos((θ1 − θ2)/2) cos((θ1 + θ2)/2)'
    """
    return _Search(ring).scaled(ring.to_half(p).f, factor_forms(ring, factors.atoms, factors.letters))


def factor_forms(
    ring: Ring, atoms: Sequence[tuple[Atom, int]], lengths: Sequence[tuple[Polynomial, int]]
) -> list[tuple[Factor, int]]:
    """Atoms and factors in lengths alone with their powers as they are written, up to a number before all of them.

    Joints at simple angles become sines and cosines of the whole angle as far as they go.
    """
    search = _Search(ring)
    counts: dict[int, list[int]] = {}
    rest = []
    for atom, power in atoms:
        if atom.pinned:
            counts.setdefault(atom.joint, [0, 0, 0, 0])[_PINNED.index(atom.value)] += int(power)
        else:
            rest.append((search.bracket(atom.f), int(power)))
    pins = [pair for j in sorted(counts) for pair in _pins(j, counts[j])]
    return _whole_angles([*((search.bracket(f), int(power)) for f, power in lengths), *pins, *rest])


def _whole_angles(factors: Sequence[tuple[Factor, int]]) -> list[tuple[Factor, int]]:
    """sin(x/2) cos(x/2) as sin x, (cos(x/2) + sin(x/2)) (cos(x/2) − sin(x/2)) as cos x, up to a number."""
    powers: dict[Factor, int] = {}
    for factor, power in factors:
        powers[factor] = powers.get(factor, 0) + power
    for turns in dict.fromkeys(t for factor in powers if (t := _halved(factor)) is not None):
        sine, cosine = Wave("sin", turns), Wave("cos", turns)
        plus, minus = (
            total([Product(Fraction(1), ((cosine, 1),)), Product(Fraction(sign), ((sine, 1),))]).factors[0][0]
            for sign in (1, -1)
        )
        whole = tuple((j, 2 * m) for j, m in turns)
        for kind, pair in (("sin", (sine, cosine)), ("cos", (plus, minus))):
            power = min(powers.get(one, 0) for one in pair)
            if power:
                powers[Wave(kind, whole)] = powers.get(Wave(kind, whole), 0) + power
                for one in pair:
                    powers[one] -= power
    return [(factor, power) for factor, power in powers.items() if power]


def _halved(factor: Factor) -> tuple[tuple[int, int], ...] | None:
    """Of sin(x/2), cos(x/2) and cos(x/2) ± sin(x/2) the multiples that x/2 is made of; None of anything else."""
    if isinstance(factor, Wave):
        return factor.turns if all(m % 2 for _, m in factor.turns) else None
    if isinstance(factor, Sum) and len(factor.parts) == 2:
        waves = [f for part in factor.parts for f, _ in part.factors]
        if len(waves) == 2 and all(isinstance(f, Wave) for f in waves):
            return _halved(waves[0])
    return None


class _Search:
    """Forms found so far, by polynomial."""

    def __init__(self, ring: Ring) -> None:
        self.ring = ring
        self.known: dict[tuple[str, tuple[int, ...]], Product] = {}

    def best(self, form: Form) -> Product:
        """The shortest form found of f over Π (1 + t_j²)^(D_j / 2)."""
        key = (str(form.f), form.degrees)
        if key not in self.known:
            plain = fourier(form)
            self.known[key] = plain  # for those who come back here while candidates are made
            if len(form.f) > 1 or any(form.degrees):
                self.known[key] = min(self.candidates(form, plain), key=length)
        return self.known[key]

    def candidates(self, form: Form, plain: Product) -> Iterator[Product]:
        """Ways to write a form, the first ones being preferred among equally long ones."""
        f, degrees = form.f, form.degrees
        yield plain
        if len(f) > MANY or len(self.known) > LOOKS:
            return
        yield gathered(plain)
        if len(parts_of(plain)) <= FEW:
            return
        yield from self.factors(form)
        if not form.at_pi:
            found = self.sines_and_cosines(f)
            if found is not None:
                yield found
                yield gathered(found)
        places = [place for place, degree in enumerate(degrees) if 0 < degree <= 2]
        places += [place for place in used(f) if place >= self.ring.angles]
        if len(f) > FINE:
            places = sorted(places, key=lambda place: self.spread(f, place))[: 2 if len(f) <= COARSE else 1]
        for place in places:
            yield self.by_joint(form, place) if place < self.ring.angles else self.by_symbol(form, place)

    def spread(self, f: Polynomial, place: int) -> int:
        """Terms of the factors of all coefficients of f in one variable: what is left to be written."""
        parts = (coefficient for coefficient in coefficients(f, place) if coefficient != 0)
        return sum(len(factor) for coefficient in parts for factor, _ in coefficient.factor()[1])

    def sines_and_cosines(self, f: Polynomial) -> Product | None:
        """f in sines and cosines of single angles, where it has whole ones."""
        p = self.ring.to_trig(f)
        if p is None:
            return None
        found = single_angles(self.ring, p)
        return Product(found.number * _ratio(f, self.ring.to_half(p).f), found.factors)

    def factors(self, form: Form) -> Iterator[Product]:
        """A form as a product: of all its factors, and with those that hold half angles kept in one bracket."""
        ring, f, at_pi = self.ring, form.f, dict(form.at_pi)
        _, found = f.factor()
        if len(found) + len(at_pi) < 2:
            return
        powers = {j: [at_pi.get(j, 0), 0, 0, 0] for j in ring.revolute}  # π, 0, π/2, −π/2
        rest: list[tuple[Polynomial, int]] = []
        for factor, power in found:
            place = used(factor)[0]
            atom = ring.atom(factor) if place < ring.angles else None
            if atom is not None and atom.pinned:
                powers[atom.joint][_PINNED.index(atom.value)] += power
            elif not ring.is_unit(factor):
                rest.append((primitive(factor), power))
        pins = [pair for j, counts in powers.items() for pair in _pins(j, counts)]
        yield self.scaled(f, pins + [(self.bracket(g), power) for g, power in rest])
        odd = [(g, p) for g, p in rest if any(d % 2 for d in g.degrees()[: ring.angles])]
        loose = [(factor, p) for factor, p in pins if not (isinstance(factor, Wave) and not factor.halved)]
        if odd and (len(odd) + len(loose)) > 1 and len(odd) + len(loose) < len(rest) + len(pins):
            kept = [(factor, p) for factor, p in pins if isinstance(factor, Wave) and not factor.halved]
            one = prod((g**p for g, p in odd), start=number_of(Fraction(1), ring))
            more = half_of(Product(Fraction(1), tuple(loose)), ring)
            counted = tuple(a + b for a, b in zip(ring.form(one).degrees, more.degrees, strict=True))
            together = self.best(Form(ring, one * more.f, counted))
            even = [(self.bracket(g), p) for g, p in rest if not any(d % 2 for d in g.degrees()[: ring.angles])]
            yield self.scaled(f, kept + even + list(together.factors))

    def bracket(self, g: Polynomial) -> Factor:
        written = self.best(self.ring.form(g))
        return written.factors[0][0] if len(written.factors) == 1 and written.factors[0][1] == 1 else Sum((written,))

    def scaled(self, f: Polynomial, factors: Sequence[tuple[Factor, int]]) -> Product:
        written = product(1, factors)
        return Product(_ratio(f, half_of(written, self.ring).f) * written.number, written.factors)

    def by_joint(self, form: Form, place: int) -> Product:
        """f = A cos + B sin + C in one joint (half its angle where the degree is 1)."""
        degrees = form.degrees
        j, degree = self.ring.revolute[place], degrees[place]
        powers = coefficients(form.f, place) + [self.ring.half.constant(0)] * 2
        if degree == 2:
            # t² stands for (1 − c) / 2, t for s / 2, 1 for (1 + c) / 2
            whole = {"cos": (powers[0] - powers[2]) / 2, "sin": powers[1] / 2, "": (powers[0] + powers[2]) / 2}
        else:
            whole = {"cos": powers[0], "sin": powers[1]}
        left = (*degrees[:place], 0, *degrees[place + 1 :])
        parts = []
        for kind, coefficient in whole.items():
            if coefficient != 0:
                own: list[tuple[Factor, int]] = [(Wave(kind, ((j, degree),)), 1)] if kind else []
                parts += _spread(self.best(Form(self.ring, coefficient, left)), own)
        return total(parts)

    def by_symbol(self, form: Form, place: int) -> Product:
        ring = self.ring
        parts = []
        for power, coefficient in enumerate(coefficients(form.f, place)):
            if coefficient != 0:
                exponents = [0] * (len(ring.names) - ring.angles)
                exponents[place - ring.angles] = power
                parts += _spread(self.best(Form(ring, coefficient, form.degrees)), symbols(exponents, ring))
        return total(parts)


def _spread(form: Product, own: list[tuple[Factor, int]]) -> list[Product]:
    """The parts that a coefficient adds to a sum: its own parts where nothing stands before it."""
    return parts_of(form) if not own else [product(form.number, [*form.factors, *own])]


def parts_of(form: Product) -> list[Product]:
    """A form as products to be added: several where it is a number times a sum."""
    if len(form.factors) == 1 and isinstance(form.factors[0][0], Sum) and form.factors[0][1] == 1:
        return [product(form.number * part.number, part.factors) for part in form.factors[0][0].parts]
    return [form]


def _pins(joint: int, counts: list[int]) -> list[tuple[Factor, int]]:
    """cos^π(θ/2) sin^0(θ/2) … as sines and cosines of the whole angle as far as they go."""
    at_pi, at_zero, up, down = counts
    found: list[tuple[Factor, int]] = [
        (Wave("sin", ((joint, 2),)), min(at_pi, at_zero)),
        (Wave("cos", ((joint, 2),)), min(up, down)),
    ]
    one = Product(Fraction(1))
    for kind, sign, count in (
        ("cos", 1, at_pi - at_zero), ("cos", -1, at_zero - at_pi), ("sin", -1, up - down), ("sin", 1, down - up)
    ):  # fmt: skip
        if count > 0:
            square = total([one, Product(Fraction(sign), ((Wave(kind, ((joint, 2),)), 1),))])
            half: tuple[Factor, int]
            if kind == "cos":
                half = (Wave("cos" if sign > 0 else "sin", ((joint, 1),)), 1)
            else:
                lower = Product(Fraction(sign), ((Wave("cos", ((joint, 1),)), 1),))
                half = (total([Product(Fraction(1), ((Wave("sin", ((joint, 1),)), 1),)), lower]).factors[0][0], 1)
            found += [(square.factors[0][0], count // 2), (half[0], count % 2)]
    return [(factor, power) for factor, power in found if power]


def _ratio(f: Polynomial, back: Polynomial) -> Fraction:
    """f / back where they are equal up to a number and factors 1 + t², whose first coefficient is 1."""
    one, two = f.coeffs()[0], back.coeffs()[0]
    value = one / two
    return Fraction(int(value.p), int(value.q))


def gathered(form: Product) -> Product:
    """A sum with common factors put before brackets, the one that saves most first."""
    parts = parts_of(form)
    counts: dict[Factor, int] = {}
    for part in parts:
        for factor, _ in part.factors:
            if not isinstance(factor, Sum):
                counts[factor] = counts.get(factor, 0) + 1
    common = max(counts, key=lambda factor: counts[factor], default=None)
    if common is None or counts[common] < 2:
        return form
    inside = [part for part in parts if common in dict(part.factors)]
    outside = [part for part in parts if common not in dict(part.factors)]
    lowered = gathered(total(product(p.number, [(f, e - (f == common)) for f, e in p.factors]) for p in inside))
    taken = product(lowered.number, [*lowered.factors, (common, 1)])
    rest = gathered(total(outside)) if outside else Product(Fraction(0))
    return total([taken, *parts_of(rest)]) if outside else taken


def length(form: Product) -> int:
    """How long a form is to read: its numbers, lengths, sines, angles spelled out, and brackets."""
    return len(re.findall(r"[A-Za-z]\w*|θ\d+|[0-9.]+(?:e-?\d+)?|\(", Text().zero(form)))


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
        >>> from rankdrop.exact.notation import C, Python
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
        return _equation(self.waves, letters, n, shifts)

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
                cosine = float(part.number / _largest(self.waves))
            else:
                sine = float(part.number / _largest(self.waves))
        if len(turns) != 1:
            return None
        kept = turns.pop()
        if all(multiple % 2 == 0 for _, multiple in kept):
            return None
        return kept, 2 * atan2(-cosine, sine) if sine else pi

    def _slide(self, name: str, notation: Text, unit: str) -> str:
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


def _equation(
    waves: Sequence[Product], letters: Mapping[str, float], n: int, shifts: Sequence[float] | None
) -> Equation:
    """The numeric equation of terms of a Fourier form; arguments as in `Condition.equation`."""
    found: dict[tuple[str, tuple[int, ...], tuple[int, ...]], float] = {}
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
        found[key] = found.get(key, 0.0) + value
    half = np.zeros(n) if shifts is None else np.asarray(shifts, dtype=np.float64) / 2
    return normalised(
        Term(value, kind, harmonics, powers, 0.0 - float(sum(m * x for m, x in zip(harmonics, half, strict=True))))
        for (kind, harmonics, powers), value in found.items()
    )


def _largest(waves: Sequence[Product]) -> Fraction:
    """The power of two next to the largest number of a Fourier form: whole numbers of a thousand digits are no floats,
    and with a power of two every ratio keeps its last bit.
    """
    numbers = [part.number for part in waves]
    bits = max((abs(one.numerator).bit_length() - one.denominator.bit_length() for one in numbers), default=0)
    return Fraction(2) ** bits


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


def _sides(form: Product, notation: Text) -> str:
    """… = 0, or A = B where half angles make two terms of opposite sign."""
    parts = notation.parts(form)
    if len(parts) == 2 and parts[0].number > 0 > parts[1].number:
        waves = [factor for part in parts for factor, _ in part.factors if isinstance(factor, Wave)]
        if any(wave.halved for wave in waves):
            return f"{notation.product(parts[0])} = {notation.product(parts[1])}"
    return f"{notation.zero(form)} = 0"


def text_of(ring: Ring, p: Polynomial) -> str:
    """A trigonometric polynomial, equal to it: s_j is sin θ_j, c_34 is cos(θ3 + θ4).

    Example:
        >>> ring = Ring([1, 2])
        >>> text_of(ring, ring.s[1] * ring.c[2] + ring.c[1] * ring.s[2])
        's12'
    """
    known, key = _known(ring), str(p)
    if key not in known:
        known[key] = "0" if p == 0 else Text().sum(parts_of(form_of(ring, p)))
    return known[key]


@lru_cache(maxsize=8)
def _known(ring: Ring) -> dict[str, str]:
    """Texts found before, by polynomial: the same ones come back in every case."""
    return {}


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
        return Text.folding(most).value(self.form)

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
        return _join_fraction(Text.folding(most), above, below, " / ")

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
        return _join_fraction(notation, *self.forms, "/")

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


def _join_fraction(notation: Text, above: Product, below: Product, line: str) -> str:
    if below == Product(Fraction(1)):
        return notation.value(above)
    upper, lower = notation.sum([notation.readable(above)]), notation.product(notation.readable(below))
    bracketed = len(below.factors) + (below.number != 1) > 1
    return f"{upper}{line}({lower})" if bracketed else f"{upper}{line}{lower}"


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
