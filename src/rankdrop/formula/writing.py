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
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import chain
from math import atan2, pi, prod, tau
from operator import add
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from rankdrop.algebra.polynomial import (
    SIMPLE,
    Atom,
    Factors,
    Polynomial,
    coefficients,
    leading_number,
    primitive,
    reciprocal,
    reduced_roots,
    used,
)
from rankdrop.algebra.ring import Form, Ring, polynomial_of
from rankdrop.algebra.roots import ROOTS, sums_over_roots
from rankdrop.errors import OptionError
from rankdrop.formula.equation import Equation, Term, normalised
from rankdrop.formula.notation import (
    Factor,
    Latex,
    Product,
    Python,
    Sum,
    Symbol,
    Text,
    Wave,
    derivative,
    factors_of,
    fourier,
    half_of,
    number_of,
    product,
    symbols,
    total,
)
from rankdrop.robot.model import Array

MANY = 600
"""Half-angle polynomials with more terms are not rearranged: nobody reads them."""
FINE, COARSE = 40, 150
"""With more terms than that only the two best variables, or the best one, are tried."""
LOOKS = 240
"""Polynomials looked at for one condition; those after are only multiplied out."""
FEW = 3
"""Terms of a Fourier form that is short enough as it is."""

_SAME = 1e-12  # angles closer than this are the same [rad]
_KNOWN: WeakKeyDictionary[Ring, dict[str, Product]] = WeakKeyDictionary()
"""Forms found, by polynomial: sets at θ = 0 and θ = π share their conditions."""
_TEXTS: WeakKeyDictionary[Ring, dict[str, str]] = WeakKeyDictionary()
"""Texts of trigonometric polynomials: the same ones come back in every case of a derivation."""


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


def factor_forms(
    ring: Ring, atoms: Sequence[tuple[Atom, int]], lengths: Sequence[tuple[Polynomial, int]]
) -> list[tuple[Factor, int]]:
    """Atoms and factors in lengths alone with their powers as they are written, up to a number before all of them.

    Joints at simple angles become sines and cosines of the whole angle as far as they go.
    """
    bracket = _Search(ring).bracket
    written = [(_half(atom.joint, atom.value) if atom.pinned else bracket(atom.f), int(power)) for atom, power in atoms]
    return _whole_angles([*((bracket(f), int(power)) for f, power in lengths), *written])


def _half(joint: int, value: str) -> Factor:
    """The sine or cosine of half an angle, or their sum or difference, that vanishes at a simple angle."""
    return dict(zip(("0", "pi", "-pi/2", "pi/2"), _halves(((joint, 1),)), strict=True))[value]


def _halves(turns: tuple[tuple[int, int], ...]) -> tuple[Factor, Factor, Factor, Factor]:
    """sin y, cos y, cos y + sin y and cos y − sin y of a combination of angles."""
    sine, cosine = Wave("sin", turns), Wave("cos", turns)
    plus, minus = (total([_of(cosine), _of(sine, sign)]).factors[0][0] for sign in (1, -1))
    return sine, cosine, plus, minus


def _of(factor: Factor, number: int = 1) -> Product:
    return Product(Fraction(number), ((factor, 1),))


def _whole_angles(factors: Iterable[tuple[Factor, int]]) -> list[tuple[Factor, int]]:
    """Functions of half an angle x as functions of x as far as they go, up to a number.

    sin(x/2) cos(x/2) is sin x, (cos(x/2) + sin(x/2)) (cos(x/2) − sin(x/2)) is cos x, and of one joint cos²(x/2) is
    1 + cos x.
    """
    powers = Counter[Factor]()
    for factor, power in factors:
        powers[factor] += power
    for turns in dict.fromkeys(t for factor in powers if (t := _halved(factor)) is not None):
        sine, cosine, plus, minus = _halves(turns)
        whole = {kind: Wave(kind, tuple((j, 2 * m) for j, m in turns)) for kind in ("sin", "cos")}
        for kind, pair in (("sin", (sine, cosine)), ("cos", (plus, minus))):
            power = min(powers[one] for one in pair)
            powers[whole[kind]] += power
            powers.subtract(dict.fromkeys(pair, power))
        squares = ((cosine, "cos", 1), (sine, "cos", -1), (plus, "sin", 1), (minus, "sin", -1))
        for half, kind, sign in squares if len(turns) == 1 else ():
            square = total([Product(Fraction(1)), _of(whole[kind], sign)]).factors[0][0]
            powers[square] += powers[half] // 2
            powers[half] %= 2
    return [(factor, power) for factor, power in powers.items() if power]


def _halved(factor: Factor) -> tuple[tuple[int, int], ...] | None:
    """Of sin(x/2), cos(x/2) and cos(x/2) ± sin(x/2) the multiples that x/2 is made of; None of anything else."""
    if isinstance(factor, Wave):
        if all(m % 2 for _, m in factor.turns):
            return factor.turns
        return None
    if isinstance(factor, Sum) and len(factor.parts) == 2:
        waves = [*factors_of(factor.parts)]
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
            yield self.by_variable(form, place)

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
        return _times(_written_number(self.ring, _ratio(f, self.ring.to_half(p).f)), found)

    def factors(self, form: Form) -> Iterator[Product]:
        """A form as a product: of all its factors, and with those that hold half angles kept in one bracket."""
        ring, f = self.ring, form.f
        _, found = f.factor()
        if len(found) + len(form.at_pi) < 2:
            return
        halves = [(_half(joint, "pi"), power) for joint, power in form.at_pi]
        rest: list[tuple[Polynomial, int]] = []
        for factor, power in found:
            if used(factor)[0] < ring.angles:
                atom = ring.atom(factor)
            else:
                atom = None
            if atom is not None and atom.pinned:
                halves.append((_half(atom.joint, atom.value), power))
            elif not ring.is_unit(factor):
                rest.append((primitive(factor), power))
        pins = _whole_angles(halves)
        yield self.scaled(f, [*pins, *((self.bracket(g), power) for g, power in rest)])
        yield from self.with_one_bracket(f, pins, rest)

    def with_one_bracket(
        self, f: Polynomial, pins: list[tuple[Factor, int]], rest: list[tuple[Polynomial, int]]
    ) -> Iterator[Product]:
        """The product of all factors with those that hold half angles in one bracket, where others are left."""
        whole, odd, even = list[tuple[Factor, int]](), list[tuple[Polynomial, int]](), list[tuple[Factor, int]]()
        loose: list[tuple[Factor, int]] = []
        for pin, power in pins:
            (whole if isinstance(pin, Wave) and not pin.halved else loose).append((pin, power))
        for g, power in rest:
            if any(degree % 2 for degree in g.degrees()[: self.ring.angles]):
                odd.append((g, power))
            else:
                even.append((self.bracket(g), power))
        if odd and (whole or even) and len(odd) + len(loose) > 1:
            one = prod((g**power for g, power in odd), start=number_of(Fraction(1), self.ring))
            more = half_of(Product(Fraction(1), tuple(loose)), self.ring)
            counted = tuple(map(add, self.ring.form(one).degrees, more.degrees))
            together = self.best(Form(self.ring, one * more.f, counted))
            yield self.scaled(f, [*whole, *even, *together.factors])

    def bracket(self, g: Polynomial) -> Factor:
        written = self.best(self.ring.form(g))
        if len(written.factors) == 1 and written.factors[0][1] == 1:
            return written.factors[0][0]
        return Sum((written,))

    def scaled(self, f: Polynomial, factors: Sequence[tuple[Factor, int]]) -> Product:
        written = product(1, factors)
        return _times(_written_number(self.ring, _ratio(f, half_of(written, self.ring).f)), written)

    def by_variable(self, form: Form, place: int) -> Product:
        """f = A cos + B sin + C in one joint (half its angle where the degree is 1), or by powers of a symbol."""
        ring, left = self.ring, form.degrees
        powers = coefficients(form.f, place)
        if place < ring.angles:
            turns = ((ring.revolute[place], left[place]),)
            sine, cosine = (list[tuple[Factor, int]]([(Wave(kind, turns), 1)]) for kind in ("sin", "cos"))
            zero, one, two = [*powers, ring.half.constant(0), ring.half.constant(0)][:3]
            # t² stands for (1 − c) / 2, t for s / 2, 1 for (1 + c) / 2
            whole = [((zero - two) / 2, cosine), (one / 2, sine), ((zero + two) / 2, [])]
            if left[place] == 2:
                split = whole
            else:
                split = [(zero, cosine), (one, sine)]
            left = (*left[:place], 0, *left[place + 1 :])
        else:
            rest = range(ring.angles, len(ring.names))
            split = [(f, symbols([power * (k == place) for k in rest], ring)) for power, f in enumerate(powers)]
        parts = (_spread(self.best(Form(ring, f, left)), own) for f, own in split if f != 0)
        return total(chain.from_iterable(parts))


def _spread(form: Product, own: list[tuple[Factor, int]]) -> list[Product]:
    """The parts that a coefficient adds to a sum: its own parts where nothing stands before it."""
    if not own:
        return parts_of(form)
    return [product(form.number, [*form.factors, *own])]


def parts_of(form: Product) -> list[Product]:
    """A form as products to be added: several where it is a number times a sum."""
    if len(form.factors) == 1 and isinstance(form.factors[0][0], Sum) and form.factors[0][1] == 1:
        return [product(form.number * part.number, part.factors) for part in form.factors[0][0].parts]
    return [form]


def ratio(ring: Ring, p: Polynomial, f: Polynomial) -> Polynomial:
    """The number c, a polynomial in the roots alone, where a trigonometric polynomial is c times what a half-angle one
    stands for, up to factors 1 + t².
    """
    return _ratio(ring.to_half(p).f, f)


def _ratio(one: Polynomial, two: Polynomial) -> Polynomial:
    """One half-angle polynomial over another that it is equal to up to a number and factors 1 + t²: that number, of the
    field of the roots, as a polynomial in them alone.
    """
    above, below = (leading_number(reduced_roots(f)) for f in (one, two))
    return reduced_roots(above * reciprocal(below))


def _written_number(ring: Ring, number: Polynomial) -> Product:
    """A polynomial in the roots alone as it is written: 3, √2/2, 2 (1 + √3)."""
    return total(
        product(Fraction(int(value.p), int(value.q)), symbols(powers[ring.angles :], ring))
        for powers, value in number.terms()
    )


def _times(one: Product, two: Product) -> Product:
    """The product of two forms."""
    return product(one.number * two.number, [*one.factors, *two.factors])


def gathered(form: Product) -> Product:
    """A sum with common factors put before brackets, the one that saves most first."""
    parts = parts_of(form)
    counts = Counter(factor for factor in factors_of(parts) if not isinstance(factor, Sum))
    common, count = next(iter(counts.most_common(1)), (Symbol(""), 0))
    if count < 2:
        return form
    inside = [part for part in parts if common in dict(part.factors)]
    outside = [part for part in parts if common not in dict(part.factors)]
    lowered = gathered(total(product(p.number, [(f, e - (f == common)) for f, e in p.factors]) for p in inside))
    taken = product(lowered.number, [*lowered.factors, (common, 1)])
    if outside:
        rest = gathered(total(outside))
    else:
        rest = Product(Fraction(0))
    if outside:
        return total([taken, *parts_of(rest)])
    return taken


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
        return tuple(RADIANS[value] for value in _checked(self.values))

    @property
    def words(self) -> tuple[str, ...]:
        """The values for people, π/2 and −π/2 as one: ("0", "±π/2")."""
        kept = _checked(self.values)
        if set(kept) >= QUARTERS:
            return (*(WORDS[value] for value in kept if value not in QUARTERS), "±π/2")
        return tuple(WORDS[value] for value in kept)

    def text(self, sign: str = "=") -> str:
        """For people: "θ4 = 0 or π"; with "≠" of one value: "θ4 ≠ 0"."""
        return f"{self._angle(Text())} {sign} {' or '.join(self.words)}"

    def latex(self) -> str:
        r"""LaTeX, without delimiters: \theta_4 \in \{0, \pi\}."""
        kept = _checked(self.values)
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
        kept = set(_checked(self.values))
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
        return _of_parts(notation, self.parts).product(self.form)

    def gradient(self, notation: Python) -> dict[int, str]:
        """The derivative of `code` by its joint variable."""
        slope = _divided(derivative(self.form, self.joint), self.part)
        return {self.joint: _of_parts(notation, self.parts).value(slope)}

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
        return normalised(terms)


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
        return self._written(Text(divisors=self.ring.parts), sign)

    def latex(self) -> str:
        r"""The same in LaTeX, without delimiters: a_2 c_2 + a_3 c_{23} = 0."""
        return self._written(Latex(divisors=self.ring.parts))

    def _written(self, notation: Text, sign: str = "=") -> str:
        relation = self.relation
        if relation is not None:
            return _related(*relation, notation, sign)
        return self._slide(notation, sign) or _sides(self.form, notation, sign)

    def code(self, notation: Python) -> str:
        """The left-hand side as an expression in q; zero where the condition holds."""
        return _of_parts(notation, self.ring.parts).zero(self.form)

    def gradient(self, notation: Python) -> dict[int, str]:
        """Derivatives of `code` by the number of the joint; those that vanish are left out."""
        notation = _of_parts(notation, self.ring.parts)
        parts = notation.parts(self.form)
        slopes = {joint: total(derivative(part, joint) for part in parts) for joint in self.joints}
        return {
            joint: notation.value(_divided(slope, self.ring.parts.get(joint, 1)))
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

    def _slide(self, notation: Text, sign: str) -> str:
        """q_j = number, where the condition says just that; else ""."""
        ring, f, places = self.ring, self.polynomial, used(self.polynomial)
        if len(places) != 1 or not ring.angles <= places[0] < ring.moving or f.total_degree() > 1:
            return ""
        numbers = {int(powers[places[0]]): Fraction(int(c.p), int(c.q)) for powers, c in f.terms()}
        value = -numbers.get(0, Fraction(0)) / numbers[1]
        minus, unit = notation.minus * (value < 0), notation.metre * bool(value)
        return f"{notation.slide.format(self.joints[0])} {sign} {minus}{notation.number(abs(value))}{unit}"


def _of_parts(notation: Python, parts: Mapping[int, int]) -> Python:
    """A notation for forms in which the angles of some joints are parts of their own."""
    if parts:
        return replace(notation, divisors=parts)
    return notation


def _divided(slope: Product, part: int) -> Product:
    """The derivative by a joint variable of which the angle of a form is one of so many parts."""
    return Product(slope.number / part, slope.factors)


def _equation(
    waves: Sequence[Product], letters: Mapping[str, float], n: int, shifts: Sequence[float] | None
) -> Equation:
    """The numeric equation of terms of a Fourier form; arguments as in `Condition.equation`."""
    found: dict[tuple[str, tuple[int, ...], tuple[int, ...]], float] = {}
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
        found[key] = found.get(key, 0.0) + value
    if shifts is None:
        half = np.zeros(n)
    else:
        half = np.asarray(shifts, dtype=np.float64) / 2
    terms = []
    for (kind, multiples, exponents), value in found.items():
        phase = float(sum(m * x for m, x in zip(multiples, half, strict=True)))
        terms.append(Term(value, kind, multiples, exponents, 0.0 - phase))
    return normalised(terms)


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
    bits = max((abs(one.numerator).bit_length() - one.denominator.bit_length() for one in numbers), default=0)
    return Fraction(2) ** bits


def _related(turns: tuple[tuple[int, int], ...], value: float, notation: Text, sign: str) -> str:
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
    return " or ".join([*texts, *(written(atom.f) for atom in atoms if not atom.pinned)])


def pin_of(ring: Ring, joint: int, values: Sequence[str]) -> AnglePin:
    """A joint of a ring at simple angles, or a part of its angle."""
    return AnglePin(joint, tuple(values), ring.parts.get(joint, 1))


def count_alternatives(atoms: Sequence[Atom]) -> int:
    """How many alternatives `atoms_text` joins with "or": a joint at ±π/2 is one, a joint at 0 or π two."""
    pins = (AnglePin(joint, tuple(values)) for joint, values in _simple_angles(atoms).items())
    return sum(len(pin.words) for pin in pins) + sum(not atom.pinned for atom in atoms)


def _pins(ring: Ring, atoms: Sequence[Atom]) -> list[AnglePin]:
    """The joints at simple angles among atoms, in order, each with all of its values."""
    return [pin_of(ring, joint, chosen) for joint, chosen in sorted(_simple_angles(atoms).items())]


def _simple_angles(atoms: Sequence[Atom]) -> dict[int, list[str]]:
    values: dict[int, list[str]] = {}
    for atom in atoms:
        if atom.pinned:
            values.setdefault(atom.joint, []).append(atom.value)
    return values


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
        written = factor_forms(self.ring, self.factors.atoms, self.factors.letters)
        return _Search(self.ring).scaled(self.ring.to_half(self.polynomial).f, written)

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
        return _of_parts(notation, self.ring.parts).value(self.form)

    def powers(self) -> tuple[tuple[str, str, int], ...]:
        """(text, LaTeX, multiplicity) of each factor."""
        text, latex = Text(divisors=self.ring.parts), Latex(divisors=self.ring.parts)
        return tuple(
            (text.sum(_opened(factor)), latex.sum(_opened(factor)), int(power)) for factor, power in self.form.factors
        )


def _opened(factor: Factor) -> tuple[Product, ...]:
    if isinstance(factor, Sum):
        return factor.parts
    return (Product(Fraction(1), ((factor, 1),)),)


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
        number = _leading(one) * reciprocal(_leading(two)) * below[1] * reciprocal(above[1])
        written = _written_number(ring, reduced_roots(number))
        roots = Product(Fraction(1), written.factors)
        return _with_numbers(_times(roots, above[0]), below[0], written.number)

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
    found = float(form.number)
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
        found *= value**power
    return found


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
