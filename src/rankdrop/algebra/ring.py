"""Two rings for one set of joints: trigonometric polynomials, and polynomials in half-angle tangents.

Kinematics is done with s_j = sin θ_j and c_j = cos θ_j, reduced by s_j² = 1 − c_j². Factoring is not: in that ring
factors are not unique. With t_j = tan(θ_j / 2),

    s_j = 2 t_j / (1 + t_j²),    c_j = (1 − t_j²) / (1 + t_j²),

a trigonometric polynomial of degree m_j in joint j becomes a polynomial of degree at most 2 m_j in t_j once it is
multiplied by (1 + t_j²)^m_j, which has no real zero. Factors of that polynomial are unique. θ_j = π is the point at
infinity of t_j: such a polynomial is a `Form` on a product of projective lines, one for each revolute joint.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property, reduce
from math import prod
from operator import add
from typing import Any

import numpy as np

from rankdrop.algebra.factoring import factor
from rankdrop.algebra.halt import Halt, HaltKind, TooLong
from rankdrop.algebra.polynomial import (
    COS_SIN,
    TANGENT,
    Atom,
    Factors,
    Polynomial,
    coefficient,
    coefficients,
    flint,
    order,
    primitive,
    reduced_roots,
    roots_in,
    variables_in,
)
from rankdrop.algebra.roots import Number, Surd, primes_with, sums_over_roots, with_inner
from rankdrop.algebra.work import tick
from rankdrop.robot.model import Array

_BITS = 500  # of a coefficient: twice as many take four times as long to factor
MANY = 20_000
"""Polynomials of more terms than this take minutes and gigabytes to factor."""

KEPT = 400_000
"""Terms of polynomials that a ring remembers: twenty megabytes or so. Most derivations have 50,000."""
_SHORT, _LASTING = 1_000, 15_000  # terms up to which factoring takes milliseconds, and seconds
_OVER_ROOTS = 3  # times as much work as factoring over the rationals
_FAMILIAR = 4_000  # terms up to which the factors of a polynomial are remembered: minors return on many sets

_LONGEST = 2_000_000  # products of terms in one multiplication: half a second, and some hundred megabytes at worst


Terms = Sequence[tuple[tuple[int, ...], Any]]
"""Powers of all variables and the number before them."""


def replace_angles(
    items: Terms,
    angles: int,
    key: Callable[[tuple[int, ...], int], Any],
    value: Callable[[int, Any], Polynomial],
    rest: Callable[[Terms], Polynomial],
    place: int = 0,
) -> Polynomial:
    """Terms with the powers of every angle replaced; terms with the same ones are gathered, and multiplied at once.

    Args:
        items: the terms.
        angles: how many there are.
        key: of the powers of a term those of one angle, by its place.
        value: what stands for these powers of an angle.
        rest: terms without their angles, as a polynomial.
        place: of the angle to begin with.
    """
    if place == angles or not items:
        return rest(items)
    groups: dict[Any, list[tuple[tuple[int, ...], Any]]] = {}
    for item in items:
        groups.setdefault(key(item[0], place), []).append(item)
    inner = ((power, replace_angles(group, angles, key, value, rest, place + 1)) for power, group in groups.items())
    return reduce(add, (value(place, power) * part for power, part in inner))


class Memory(dict[Any, Any]):
    """What was computed of polynomials of a ring, emptied when these have more than `KEPT` terms; it ends with its
    ring.

    Attributes:
        terms: of the polynomials, and one for each.
    """

    def __init__(self) -> None:
        super().__init__()
        self.terms = 0

    def keep(self, key: Any, value: Any, terms: int) -> Any:
        """Remember what was computed of a polynomial of so many terms, and return it."""
        self.terms += 1 + terms
        if self.terms > KEPT:
            self.clear()
            self.terms = 1 + terms
        self[key] = value
        return value


class Ring:
    """Both rings over the rationals, for named joints and lengths.

    Args:
        revolute: numbers of the revolute joints.
        prismatic: numbers of the prismatic joints; their variables are q_j [m].
        letters: names of the lengths that stay symbols [m], and of the roots that numbers contain (`ROOTS`).
        parts: the b of θ_j = b φ_j, for revolute joints j of which s_j, c_j, t_j are those of φ_j; only words need it.

    Attributes:
        trig: context of s_j, c_j (every revolute joint), then q_j, then the lengths.
        half: context of t_j, then q_j, then the lengths.
        s, c, q, letter: generators of `trig`, by joint number or name.
        t, q_half, letter_half: generators of `half`.
        names: names of the variables of `half`, in order.
        primes: modulo which points of it are taken: those with its roots.
        images: of polynomials modulo primes.
        known: half-angle forms of trigonometric polynomials, and factors of forms.

    Example:
        >>> ring = Ring([1, 2])
        >>> found = ring.factor(ring.s[2] * (ring.c[1] * ring.c[2] - ring.s[1] * ring.s[2] + 1))
        >>> [atom.key for atom, _ in found.atoms]
        ['θ2=0', 'θ2=pi', 't1*t2 - 1']
    """

    def __init__(
        self,
        revolute: Sequence[int],
        prismatic: Sequence[int] = (),
        letters: Sequence[str] = (),
        parts: Mapping[int, int] | None = None,
    ) -> None:
        module = flint()
        self.parts = dict(parts or {})
        self.revolute, self.prismatic = tuple(revolute), tuple(prismatic)
        roots = tuple(with_inner(letters))  # the last variables: see `roots.monic`
        self.letters = (*(name for name in letters if name not in roots), *roots)
        self.primes = primes_with(roots)
        tail = [f"q{j}" for j in self.prismatic] + list(self.letters)
        # s before c in lexicographic order: division by s² + c² − 1 leaves s at most once
        names = [f"{x}{j}" for j in self.revolute for x in "sc"] + tail
        self.trig = module.fmpq_mpoly_ctx.get(names, module.Ordering.lex)
        generators = dict(zip(names, self.trig.gens(), strict=True))
        self.s = {j: generators[f"s{j}"] for j in self.revolute}
        self.c = {j: generators[f"c{j}"] for j in self.revolute}
        self.q = {j: generators[f"q{j}"] for j in self.prismatic}
        self.letter = {name: generators[name] for name in self.letters}
        self.names = tuple([f"t{j}" for j in self.revolute] + tail)
        self.half = module.fmpq_mpoly_ctx.get(self.names, module.Ordering.lex)
        generators = dict(zip(self.names, self.half.gens(), strict=True))
        self.t = {j: generators[f"t{j}"] for j in self.revolute}
        self.q_half = {j: generators[f"q{j}"] for j in self.prismatic}
        self.letter_half = {name: generators[name] for name in self.letters}
        self.images, self.known = Memory(), Memory()
        self.zero, self.one = self.trig.constant(0), self.trig.constant(1)
        self._circle = [self.s[j] ** 2 + self.c[j] ** 2 - 1 for j in self.revolute]

    @property
    def angles(self) -> int:
        """Number of revolute joints: the first so many variables of `half` are half-angle tangents."""
        return len(self.revolute)

    @property
    def moving(self) -> int:
        """Number of joints: the first so many variables of `half` depend on the configuration."""
        return len(self.revolute) + len(self.prismatic)

    @cached_property
    def index(self) -> dict[str, int]:
        """Place of each variable of `half`."""
        return {name: place for place, name in enumerate(self.names)}

    def constant(self, value: Number | int) -> Polynomial:
        """A number as an element of `trig`."""
        if isinstance(value, Surd):
            return sum(
                (self.constant(part) * prod(self.letter[name] for name in names) for names, part in value.terms),
                self.zero,
            )
        value = Fraction(value)
        return self.trig.constant(flint().fmpq(value.numerator, value.denominator))

    def reduce(self, p: Polynomial) -> Polynomial:
        """Normal form: every s_j at most once.

        There is no other identity between them: p vanishes on the torus when its normal form is 0.
        """
        degrees = p.degrees()
        for place, circle in enumerate(self._circle):
            if degrees[2 * place] > 1:
                p = p % circle
        return reduced_roots(p)

    def to_half(self, p: Polynomial) -> Form:
        """p · Π (1 + t_j²)^m_j in half-angle tangents, which counts for the degrees 2 m_j; m_j is the degree of p."""
        p = self.reduce(p)
        if len(p) > _FAMILIAR:
            return self._in_half_angles(p)
        key = str(p)
        known: Form = self.known.get(key) or self.known.keep(key, self._in_half_angles(p), len(p))
        return known

    def _in_half_angles(self, p: Polynomial) -> Form:
        terms = list(p.terms())
        tick(20 + 20 * len(terms))
        n = self.angles
        degree = tuple(int(max((e[2 * k] + e[2 * k + 1] for e, _ in terms), default=0)) for k in range(n))

        @cache
        def value(k: int, powers: tuple[int, int]) -> Polynomial:
            (sines, cosines), t = powers, self.t[self.revolute[k]]
            return (2 * t) ** sines * (1 - t**2) ** cosines * (1 + t**2) ** (degree[k] - sines - cosines)

        def rest(items: Terms) -> Polynomial:
            return self.half.from_dict({(0,) * n + tuple(e[2 * n :]): number for e, number in items})

        f = replace_angles(terms, n, lambda e, k: e[2 * k : 2 * k + 2], value, rest)
        return Form(self, f, tuple(2 * m for m in degree))

    def form(self, f: Polynomial) -> Form:
        """A half-angle polynomial that counts for its own degrees: without a zero at θ = π for that."""
        return Form(self, f, tuple(int(d) for d in f.degrees()[: self.angles]))

    def factor(self, p: Polynomial) -> Factors:
        """The conditions under which a trigonometric polynomial vanishes, pinned joints first, short ones first.

        Args:
            p: not zero, of `trig`.

        Returns:
            Factors; p vanishes where one of the atoms holds, or, for special lengths, one of the letters' factors.
        """
        letters, atoms = self.to_half(p).factors()
        return Factors(letters, tuple(sorted(atoms, key=lambda pair: order(pair[0]))))

    def factors_within(self, p: Polynomial, seconds: float) -> Factors | None:
        """`factor`; None where the polynomial is long and would take more work than that [s], or cannot be stopped."""
        try:
            form = self.to_half(p)
        except TooLong:
            return None
        if len(form.f) > _SHORT and (len(form.f) > _LASTING or form.cost * 1e-6 > seconds):
            return None
        return self.factor(p)

    def is_unit(self, f: Polynomial) -> bool:
        """Whether f is 1 + t_j² up to a number: without a real zero."""
        places = variables_in(f)
        if len(places) != 1 or places[0] >= self.angles or len(f) != 2:
            return False
        t = self.half.gens()[places[0]]
        return bool(primitive(f) == 1 + t**2)

    def atom(self, f: Polynomial) -> Atom:
        """The atom of an irreducible half-angle polynomial."""
        f = primitive(f)
        places = variables_in(f)
        if len(places) == 1 and places[0] < self.angles and f.total_degree() == 1:
            j = self.revolute[places[0]]
            for value, root in TANGENT.items():
                if f == self.t[j] - root:
                    return self.pin(j, value)
        return Atom(0, "", f, str(f))

    def pin(self, joint: int, value: str) -> Atom:
        """The atom θ_joint = value, a value out of `SIMPLE`."""
        return Atom(joint, value, None, f"θ{joint}={value}")

    def half_of(self, atom: Atom) -> Polynomial:
        """The half-angle polynomial that vanishes where an atom other than θ = π holds."""
        if atom.is_pin:
            return self.t[atom.joint] - TANGENT[atom.value]
        return atom.f

    def at(self, p: Polynomial, pins: Mapping[int, str]) -> Polynomial:
        """A trigonometric polynomial with some joints at simple angles, reduced."""
        if p == 0:
            return p
        values: dict[str, int] = {}
        for joint, value in pins.items():
            cosine, sine = COS_SIN[value]
            values[f"c{joint}"], values[f"s{joint}"] = cosine, sine
        if values:
            return self.reduce(p.subs(values))
        return self.reduce(p)

    def to_trig(self, f: Polynomial, degrees: Sequence[int] = ()) -> Polynomial | None:
        """The primitive trigonometric polynomial with the zeros of f; None where some t_j has odd degree.

        t^e of degree D stands for sin^e(θ/2) cos^(D−e)(θ/2), which is trigonometric in θ when D is even. D is the
        degree of f in t, or that in `degrees`.

        Raises:
            TooLong: f has more than `MANY` terms; this cannot be interrupted.
        """
        degrees = degrees or [int(degree) for degree in f.degrees()]
        n = self.angles
        if any(degrees[k] % 2 for k in range(n)):
            return None
        if len(f) > MANY:
            raise TooLong(Halt(HaltKind.SINES, terms=len(f)))
        tick(20 + 20 * len(f))

        @cache
        def value(k: int, e: int) -> Polynomial:
            s, c, odd = self.s[self.revolute[k]], self.c[self.revolute[k]], e % 2
            expanded = (1 + c) ** ((degrees[k] - e - odd) // 2) * (1 - c) ** ((e - odd) // 2)
            return self.reduce(expanded * s if odd else expanded)

        def rest(items: Terms) -> Polynomial:
            return self.trig.from_dict({(0,) * (2 * n) + tuple(e[n:]): number for e, number in items})

        reduced = self.reduce(replace_angles(list(f.terms()), n, lambda e, k: e[k], value, rest))
        tick(4 * len(reduced))
        return primitive(reduced)

    def trig_zero_set(self, f: Polynomial) -> Polynomial:
        """A trigonometric polynomial with the zeros of f: `to_trig`, of f² where f itself has half angles."""
        trig_form = self.to_trig(f)
        if trig_form is not None:
            return trig_form
        return self.to_trig(self.product(f, f))

    def powers_at(self, f: Polynomial, theta: Array, degrees: Sequence[int] = ()) -> list[list[Array]]:
        """The powers that f contains of each variable that moves, at θ (..., n); f is of either ring.

        A power of a half-angle tangent stands for sin^e(θ/2) cos^(D−e)(θ/2), with D its degree in f or in `degrees`.
        """
        top = [int(degree) for degree in f.degrees()]
        first = len(top) - len(self.letters) - len(self.prismatic)
        slides = [[theta[..., j - 1] ** e for e in range(top[k] + 1)] for k, j in enumerate(self.prismatic, first)]
        if first > self.angles:
            waves = [wave(theta[..., j - 1]) for j in self.revolute for wave in (np.sin, np.cos)]
            return [*([x**e for e in range(d + 1)] for x, d in zip(waves, top, strict=False)), *slides]
        halves = zip(self.revolute, degrees or top, strict=False)
        angles = ((np.sin(theta[..., j - 1] / 2), np.cos(theta[..., j - 1] / 2), d) for j, d in halves)
        return [*([s**e * c ** (d - e) for e in range(d + 1)] for s, c, d in angles), *slides]

    def product(self, one: Polynomial, two: Polynomial) -> Polynomial:
        """Of two polynomials, not reduced.

        Raises:
            TooLong: it would have millions of terms; it cannot be interrupted, and takes gigabytes.
        """
        if len(one) * len(two) > _LONGEST or max(len(one), len(two)) > 5 * MANY:
            raise TooLong(Halt(HaltKind.PRODUCT, terms=len(one), others=len(two)))
        return one * two

    def determinant(self, rows: Sequence[Sequence[Polynomial]]) -> Polynomial:
        """Determinant of a square matrix over `trig`, reduced: Laplace along sparse rows, minors kept."""
        n = len(rows)
        order = sorted(range(n), key=lambda r: sum(1 for x in rows[r] if x != 0))
        swaps = sum(1 for i in range(n) for j in range(i) if order[j] > order[i])
        minors: dict[tuple[int, ...], Polynomial] = {}

        def minor(columns: tuple[int, ...]) -> Polynomial:
            if not columns:
                return self.one
            if columns not in minors:
                row = rows[order[n - len(columns)]]
                total = self.zero
                for place, column in enumerate(columns):
                    if row[column] != 0:
                        below = minor(columns[:place] + columns[place + 1 :])
                        tick(2 + 0.3 * len(row[column]) * len(below))
                        part = self.product(row[column], below)
                        if place % 2:
                            total = total - part
                        else:
                            total = total + part
                minors[columns] = self.reduce(total)
            return minors[columns]

        value = minor(tuple(range(n)))
        return -value if swaps % 2 else value


@dataclass(frozen=True, slots=True, eq=False)
class Form:
    """A polynomial on a product of projective lines, homogeneous of degree D_j in sin(θ_j/2) and cos(θ_j/2).

    t_j^e stands for sin^e(θ_j/2) cos^(D_j − e)(θ_j/2). So θ_j = π is a point like any other, and cos(θ_j/2) a factor
    like any other: it is one as often as f is of a lower degree in t_j than the D_j it counts for. Nothing else in the
    package compares degrees to find zeros at π.

    Attributes:
        ring: of f.
        f: of `ring.half`; where it is 0 the condition f = 0 holds everywhere.
        degrees: D_j of each revolute joint, at least the degree of f in t_j.

    Example:
        >>> ring = Ring([1, 2])
        >>> form = ring.to_half(1 + ring.c[2])
        >>> form.f, form.degrees, form.at_pi
        (2, (0, 2), ((2, 2),))
    """

    ring: Ring
    f: Polynomial
    degrees: tuple[int, ...]

    @property
    def at_pi(self) -> tuple[tuple[int, int], ...]:
        """(joint, multiplicity) of the factors cos(θ_j/2)."""
        of_joints = zip(self.ring.revolute, self.degrees, self.f.degrees(), strict=False)
        return tuple((j, most - int(degree)) for j, most, degree in of_joints if most > degree)

    def at(self, pins: Mapping[int, str]) -> Form:
        """The form with some joints at simple angles; at π that is the coefficient of t^D."""
        f, degrees = self.f, list(self.degrees)
        for joint, value in pins.items():
            place = self.ring.index[f"t{joint}"]
            if value == "pi":
                f = coefficient(f, place, degrees[place])
            else:
                f = f.subs({f"t{joint}": TANGENT[value]})
            degrees[place] = 0
        return Form(self.ring, f, tuple(degrees))

    def coefficients(self, place: int) -> list[Form]:
        """Those by one variable that are not 0: where all vanish the form does, whatever that variable is."""
        left = tuple(0 if k == place else degree for k, degree in enumerate(self.degrees))
        return [Form(self.ring, part, left) for part in coefficients(self.f, place) if part != 0]

    def factors(self) -> Factors:
        """Factors in lengths alone, and atoms, those at π first; f has every root at most once and is not 0.

        Raises:
            TooLong: f has more than `MANY` terms; factoring cannot be interrupted.
        """
        ring, f = self.ring, self.f
        if len(f) > MANY:
            raise TooLong(Halt(HaltKind.FACTORING, terms=len(f)))
        if len(f) > _FAMILIAR:
            return self._factors_found()
        key = (str(f), self.degrees)
        known: Factors = ring.known.get(key) or ring.known.keep(key, self._factors_found(), len(f))
        return known

    @property
    def cost(self) -> float:
        """Work of factoring it [µs]."""
        if self.f != 0:
            digits = int(self.f.coeffs()[0].p).bit_length()
        else:
            digits = 0
        cost = 100 + 15 * len(self.f) * (1 + (digits / _BITS) ** 2)
        if roots_in(self.f):
            return _OVER_ROOTS * cost
        return cost

    def _factors_found(self) -> Factors:
        ring, f = self.ring, self.f
        tick(self.cost)
        factors = factor(f)
        letters = list[tuple[Polynomial, int]]()
        atoms = [(ring.pin(joint, "pi"), multiplicity) for joint, multiplicity in self.at_pi]
        for irreducible, multiplicity in factors:
            if all(place >= ring.moving for place in variables_in(irreducible)):
                letters.append((primitive(irreducible), multiplicity))
            elif not ring.is_unit(irreducible):
                atoms.append((ring.atom(irreducible), multiplicity))
        return Factors(tuple(letters), tuple(atoms))


def polynomial_of(ring: Ring, atom: Atom) -> Polynomial:
    """A trigonometric polynomial that vanishes where an atom holds, and nowhere else."""
    if not atom.is_pin:
        return ring.trig_zero_set(atom.f)
    c, s = ring.c[atom.joint], ring.s[atom.joint]
    return {"0": 1 - c, "pi": 1 + c, "pi/2": 1 - s, "-pi/2": 1 + s}[atom.value]


def letters_polynomial(ring: Ring, f: Polynomial) -> Polynomial:
    """A half-angle polynomial in lengths alone as an element of the trigonometric ring."""
    skipped = (0,) * (2 * ring.angles + len(ring.prismatic))
    return ring.trig.from_dict({(*skipped, *powers[ring.moving :]): value for powers, value in f.terms()})


def numeric_terms(
    f: Polynomial, numbers: Mapping[str, float], power: int = 0, unit: Any = None
) -> Iterator[tuple[float, tuple[int, ...]]]:
    """(coefficient with numbers for the lengths, powers) of each term of a polynomial of either ring.

    Args:
        f: not zero.
        numbers: values of its lengths and roots.
        power: slides are in units of 10 to this power.
        unit: what coefficients are divided by; None for the largest: those of calibrated arms have a hundred digits.
    """
    names = f.context().names()
    lengths = {name for name in names if name[0] not in "tscq" or not name[1:].isdecimal()}
    terms = _with_numbers_for_roots(f)
    unit = unit or max(abs(value) for _, value in terms)
    for powers, value in terms:
        share = value / unit
        number = int(share.p) / int(share.q)
        for name, e in zip(names, powers, strict=True):
            if name in lengths:
                number *= numbers[name] ** e
            else:
                number *= 10.0 ** (power * e * (name[0] == "q"))
        yield number, powers


def _with_numbers_for_roots(f: Polynomial) -> list[tuple[tuple[int, ...], Any]]:
    """(powers, coefficient) of each term, the values of roots in the coefficients and their powers 0."""
    whole = [(tuple(map(int, powers)), value) for powers, value in f.terms()]
    names = list(map(str, f.context().names()))
    places = [names.index(root) for root in roots_in(f)]
    if not places:
        return whole
    terms = []
    for powers, value in whole:
        rest = list(powers)
        root_powers: list[tuple[str, int]] = []
        for place in places:
            rest[place] = 0
            root_powers.append((names[place], powers[place]))
        terms.append((tuple(rest), Fraction(int(value.p), int(value.q)), root_powers))
    sums = sums_over_roots(terms)
    return [(powers, flint().fmpq(x.numerator, x.denominator)) for powers, x in sums.items() if x]


def add_terms(terms: Iterable[tuple[float, tuple[int, ...]]], powers: Sequence[Sequence[Array]]) -> Array:
    """Σ coefficient · Π powers of variables, from `numeric_terms` and `Ring.powers_at`."""
    return np.asarray(sum(number * prod(x[e] for x, e in zip(powers, es, strict=False)) for number, es in terms))
