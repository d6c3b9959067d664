"""The shortest form of a polynomial in sines and cosines of the joint angles.

It is one of several that are all equal to the polynomial: its Fourier form; the polynomial in sines and cosines of
single angles; the factors, where it has several; and, for one joint or length x after another, the sum of its
coefficients times 1, c_x, s_x (or powers of the length), each coefficient written the same way. The last is what people
do by hand: it brings KG eq. 15 at θ4 = 0 from 50 terms to eight.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import chain
from math import prod
from operator import add
from weakref import WeakKeyDictionary

from rankdrop.algebra.polynomial import (
    Atom,
    Polynomial,
    coefficients,
    leading_number,
    primitive,
    reciprocal,
    reduced_roots,
    variables_in,
)
from rankdrop.algebra.ring import Form, Ring
from rankdrop.formula.notation import Text
from rankdrop.formula.sums import (
    Factor,
    Product,
    Sum,
    Symbol,
    Wave,
    factors_of,
    fourier,
    half_of,
    number_of,
    product,
    symbols,
    total,
)

MANY = 600
"""Half-angle polynomials with more terms are not rearranged: nobody reads them."""
FINE, COARSE = 40, 150
"""With more terms than that only the two best variables, or the best one, are tried."""
LOOKS = 240
"""Polynomials looked at for one condition; those after are only multiplied out."""
FEW = 3
"""Terms of a Fourier form that is short enough as it is."""


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
        known[key] = FormSearch(ring).best(ring.form(f))
    return known[key]


def factor_forms(
    ring: Ring, atoms: Sequence[tuple[Atom, int]], lengths: Sequence[tuple[Polynomial, int]]
) -> list[tuple[Factor, int]]:
    """Atoms and factors in lengths alone with their powers as they are written, up to a number before all of them.

    Joints at simple angles become sines and cosines of the whole angle as far as they go.
    """
    bracket = FormSearch(ring).bracket
    written = [(_half(atom.joint, atom.value) if atom.is_pin else bracket(atom.f), int(power)) for atom, power in atoms]
    return _whole_angles([*((bracket(f), int(power)) for f, power in lengths), *written])


def _half(joint: int, value: str) -> Factor:
    """The sine or cosine of half an angle, or their sum or difference, that vanishes at a simple angle."""
    return dict(zip(("0", "pi", "-pi/2", "pi/2"), _halves(((joint, 1),)), strict=True))[value]


def _halves(turns: tuple[tuple[int, int], ...]) -> tuple[Factor, Factor, Factor, Factor]:
    """sin y, cos y, cos y + sin y and cos y − sin y of a combination of angles."""
    sine, cosine = Wave("sin", turns), Wave("cos", turns)
    plus, minus = (total([_product_of(cosine), _product_of(sine, sign)]).factors[0][0] for sign in (1, -1))
    return sine, cosine, plus, minus


def _product_of(factor: Factor, number: int = 1) -> Product:
    return Product(Fraction(number), ((factor, 1),))


def _whole_angles(factors: Iterable[tuple[Factor, int]]) -> list[tuple[Factor, int]]:
    """Functions of half an angle x as functions of x as far as they go, up to a number.

    sin(x/2) cos(x/2) is sin x, (cos(x/2) + sin(x/2)) (cos(x/2) − sin(x/2)) is cos x, and of one joint cos²(x/2) is
    1 + cos x.
    """
    powers = Counter[Factor]()
    for factor, power in factors:
        powers[factor] += power
    for turns in dict.fromkeys(t for factor in powers if (t := _half_angle(factor)) is not None):
        sine, cosine, plus, minus = _halves(turns)
        whole = {kind: Wave(kind, tuple((j, 2 * m) for j, m in turns)) for kind in ("sin", "cos")}
        for kind, pair in (("sin", (sine, cosine)), ("cos", (plus, minus))):
            power = min(powers[factor] for factor in pair)
            powers[whole[kind]] += power
            powers.subtract(dict.fromkeys(pair, power))
        squares = ((cosine, "cos", 1), (sine, "cos", -1), (plus, "sin", 1), (minus, "sin", -1))
        for half, kind, sign in squares if len(turns) == 1 else ():
            square = total([Product(Fraction(1)), _product_of(whole[kind], sign)]).factors[0][0]
            powers[square] += powers[half] // 2
            powers[half] %= 2
    return [(factor, power) for factor, power in powers.items() if power]


def _half_angle(factor: Factor) -> tuple[tuple[int, int], ...] | None:
    """Of sin(x/2), cos(x/2) and cos(x/2) ± sin(x/2) the multiples that x/2 is made of; None of anything else."""
    if isinstance(factor, Wave):
        if all(m % 2 for _, m in factor.turns):
            return factor.turns
        return None
    if isinstance(factor, Sum) and len(factor.parts) == 2:
        waves = [*factors_of(factor.parts)]
        if len(waves) == 2 and all(isinstance(f, Wave) for f in waves):
            return _half_angle(waves[0])
    return None


class FormSearch:
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
        yield factor_out(plain)
        if len(parts_of(plain)) <= FEW:
            return
        yield from self.factors(form)
        if not form.at_pi:
            product = self.sines_and_cosines(f)
            if product is not None:
                yield product
                yield factor_out(product)
        places = [place for place, degree in enumerate(degrees) if 0 < degree <= 2]
        places += [place for place in variables_in(f) if place >= self.ring.angles]
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
        form = single_angles(self.ring, p)
        return times(written_number(self.ring, _ratio(f, self.ring.to_half(p).f)), form)

    def factors(self, form: Form) -> Iterator[Product]:
        """A form as a product: of all its factors, and with those that hold half angles kept in one bracket."""
        ring, f = self.ring, form.f
        _, factors = f.factor()
        if len(factors) + len(form.at_pi) < 2:
            return
        halves = [(_half(joint, "pi"), power) for joint, power in form.at_pi]
        rest: list[tuple[Polynomial, int]] = []
        for factor, power in factors:
            if variables_in(factor)[0] < ring.angles:
                atom = ring.atom(factor)
            else:
                atom = None
            if atom is not None and atom.is_pin:
                halves.append((_half(atom.joint, atom.value), power))
            elif not ring.is_unit(factor):
                rest.append((primitive(factor), power))
        pins = _whole_angles(halves)
        yield self.scale_to(f, [*pins, *((self.bracket(g), power) for g, power in rest)])
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
            bracket = prod((g**power for g, power in odd), start=number_of(Fraction(1), self.ring))
            more = half_of(Product(Fraction(1), tuple(loose)), self.ring)
            counted = tuple(map(add, self.ring.form(bracket).degrees, more.degrees))
            together = self.best(Form(self.ring, bracket * more.f, counted))
            yield self.scale_to(f, [*whole, *even, *together.factors])

    def bracket(self, g: Polynomial) -> Factor:
        """A polynomial as one factor: in brackets, unless it is written as a single factor."""
        written = self.best(self.ring.form(g))
        if len(written.factors) == 1 and written.factors[0][1] == 1:
            return written.factors[0][0]
        return Sum((written,))

    def scale_to(self, f: Polynomial, factors: Sequence[tuple[Factor, int]]) -> Product:
        """Factors times the number that makes their product f."""
        written = product(1, factors)
        return times(written_number(self.ring, _ratio(f, half_of(written, self.ring).f)), written)

    def by_variable(self, form: Form, place: int) -> Product:
        """f = A cos + B sin + C in one joint (half its angle where the degree is 1), or by powers of a symbol."""
        ring, left = self.ring, form.degrees
        powers = coefficients(form.f, place)
        if place < ring.angles:
            turns = ((ring.revolute[place], left[place]),)
            sine, cosine = (list[tuple[Factor, int]]([(Wave(kind, turns), 1)]) for kind in ("sin", "cos"))
            constant, first, second = [*powers, ring.half.constant(0), ring.half.constant(0)][:3]
            # t² stands for (1 − c) / 2, t for s / 2, 1 for (1 + c) / 2
            whole = [((constant - second) / 2, cosine), (first / 2, sine), ((constant + second) / 2, [])]
            if left[place] == 2:
                split = whole
            else:
                split = [(constant, cosine), (first, sine)]
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


def written_number(ring: Ring, number: Polynomial) -> Product:
    """A polynomial in the roots alone as it is written: 3, √2/2, 2 (1 + √3)."""
    return total(
        product(Fraction(int(value.p), int(value.q)), symbols(powers[ring.angles :], ring))
        for powers, value in number.terms()
    )


def times(one: Product, two: Product) -> Product:
    """The product of two forms."""
    return product(one.number * two.number, [*one.factors, *two.factors])


def factor_out(form: Product) -> Product:
    """A sum with common factors put before brackets, the one that saves most first."""
    parts = parts_of(form)
    counts = Counter(factor for factor in factors_of(parts) if not isinstance(factor, Sum))
    common, count = next(iter(counts.most_common(1)), (Symbol(""), 0))
    if count < 2:
        return form
    inside = [part for part in parts if common in dict(part.factors)]
    outside = [part for part in parts if common not in dict(part.factors)]
    lowered = factor_out(total(product(p.number, [(f, e - (f == common)) for f, e in p.factors]) for p in inside))
    taken = product(lowered.number, [*lowered.factors, (common, 1)])
    if outside:
        rest = factor_out(total(outside))
    else:
        rest = Product(Fraction(0))
    if outside:
        return total([taken, *parts_of(rest)])
    return taken


def length(form: Product) -> int:
    """How long a form is to read: its numbers, lengths, sines, angles spelled out, and brackets."""
    return len(re.findall(r"[A-Za-z]\w*|θ\d+|[0-9.]+(?:e-?\d+)?|\(", Text().zero(form)))


def form_of(ring: Ring, p: Polynomial) -> Product:
    """The shortest form of a trigonometric polynomial that is not zero, equal to it."""
    half = ring.to_half(p)
    single, combined = single_angles(ring, p), fourier(half)
    forms = [single, combined, factor_out(single), factor_out(combined)]
    if not half.at_pi:  # else `shortest` would write it without these factors
        forms.append(shortest(half.f, ring))
    return min(forms, key=length)


def single_angles(ring: Ring, p: Polynomial) -> Product:
    """p as it stands, in sines and cosines of single angles."""
    waves = [Wave(kind, ((j, 2),)) for j in ring.revolute for kind in ("sin", "cos")]
    parts = []
    for powers, value in p.terms():
        angles: list[tuple[Factor, int]] = [(wave, int(e)) for wave, e in zip(waves, powers, strict=False) if e]
        number = Fraction(int(value.p), int(value.q))
        parts.append(product(number, angles + symbols(powers[len(waves) :], ring)))
    return total(parts)
