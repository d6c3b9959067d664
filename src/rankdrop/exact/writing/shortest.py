"""The shortest way to write a half-angle polynomial, among forms that are all equal to it.

Candidates: the Fourier form; the polynomial in sines and cosines of single angles; the factors, where it has several;
and, for one joint or length x after another, the sum of its coefficients times 1, c_x, s_x (or powers of the length),
each coefficient written the same way. The last is what people do by hand: it brings KG eq. 15 at θ4 = 0
from 50 terms to eight.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from fractions import Fraction
from weakref import WeakKeyDictionary

from rankdrop.exact.algebra.polynomial import Atom, Factors, Polynomial, coefficients, primitive, used
from rankdrop.exact.algebra.ring import Form, Ring
from rankdrop.exact.writing.form import Factor, Product, Sum, Wave, fourier, half_of, number_of, product, symbols, total
from rankdrop.exact.writing.notation import Text

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
        count = 0
        for coefficient in coefficients(f, place):
            if coefficient != 0:
                count += sum(len(factor) for factor, _ in coefficient.factor()[1])
        return count

    def sines_and_cosines(self, f: Polynomial) -> Product | None:
        """f in sines and cosines of single angles, where it has whole ones."""
        ring = self.ring
        p = ring.to_trig(f)
        if p is None:
            return None
        waves: list[Factor] = [Wave(kind, ((j, 2),)) for j in ring.revolute for kind in ("sin", "cos")]
        parts = []
        for powers, value in p.terms():
            angles = [(one, int(e)) for one, e in zip(waves, powers, strict=False) if e]
            number = Fraction(int(value.p), int(value.q))
            parts.append(product(number, angles + symbols(powers[len(waves) :], ring)))
        found = total(parts)
        return Product(found.number * _ratio(f, ring.to_half(p).f), found.factors)

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
            one = number_of(Fraction(1), ring)
            for g, p in odd:
                one = one * g**p
            more = half_of(Product(Fraction(1), tuple(loose)), ring)
            counted = tuple(a + b for a, b in zip(ring.form(one).degrees, more.degrees, strict=True))
            together = self.best(Form(ring, one * more.f, counted))
            even = [(self.bracket(g), p) for g, p in rest if not any(d % 2 for d in g.degrees()[: ring.angles])]
            yield self.scaled(f, kept + even + list(together.factors))

    def bracket(self, g: Polynomial) -> Factor:
        """A polynomial as one factor."""
        written = self.best(self.ring.form(g))
        return written.factors[0][0] if len(written.factors) == 1 and written.factors[0][1] == 1 else Sum((written,))

    def scaled(self, f: Polynomial, factors: Sequence[tuple[Factor, int]]) -> Product:
        """The product with the number that makes it equal to f."""
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
        """f by powers of a length or a slide's variable."""
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
