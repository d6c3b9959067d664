"""Arithmetic modulo a prime: exact ranks at random points, which decide what holds on a whole set.

A polynomial that is not zero on an irreducible set vanishes at a random point of it modulo p with a probability of the
order degree / p (Schwartz and Zippel), here below 1e-15. With p ≡ 3 mod 4, −1 is not a square: 1 + t² has no zero, as
over the reals. The primes up to 43 are squares: √2, √3, √5 … exist, as over the reals. Of other roots some exist modulo
one prime and others modulo the next: a point knows which prime its values are residues of.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from math import prod
from typing import Any

from rankdrop.exact.algebra.polynomial import (
    COS_SIN,
    PRIMES,
    ROOTS,
    TANGENT,
    Atom,
    Number,
    Polynomial,
    Surd,
    flint,
    residues_of_roots,
    roots_of,
)
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.algebra.work import tick

P = PRIMES[0]
"""The one that is taken first."""

_KEPT = 400_000
"""Terms of polynomials of one ring that are remembered modulo primes: twenty megabytes or so. Most derivations have
50,000."""
_RINGS = 4  # for which they are remembered: a derivation has one with letters, one with numbers, seldom a third


class Point(dict[str, int]):
    """Values modulo a prime of the variables of both rings, by name; t_j is absent where θ_j = π.

    Args:
        values: by name.
        prime: out of `PRIMES`.
    """

    def __init__(self, values: Mapping[str, int] | Iterable[tuple[str, int]] = (), prime: int = P) -> None:
        super().__init__(values)
        self.prime = prime

    def changed(self, values: Mapping[str, int]) -> Point:
        """The point with other values of some variables."""
        return Point({**self, **values}, self.prime)


def modulus(point: Mapping[str, int]) -> int:
    """The prime that values are residues of; `P` where they do not tell."""
    return point.prime if isinstance(point, Point) else P


def modulo(value: Any, prime: int = P) -> int:
    """A rational number (`flint.fmpq`) modulo a prime."""
    bottom = int(value.q)
    top = int(value.p) % prime
    return top if bottom == 1 else top * pow(bottom, -1, prime) % prime


def residue(value: Number, prime: int = P) -> int:
    """An exact number modulo a prime."""
    if isinstance(value, Surd):
        roots = residues_of_roots(tuple(roots_of([value])), prime) or {}
        return sum(residue(part, prime) * prod(roots[name] for name in names) for names, part in value.terms) % prime
    return value.numerator % prime * pow(value.denominator, -1, prime) % prime


def roots_at(ring: Ring, prime: int) -> dict[str, int]:
    """Values of the roots of a ring modulo one of its primes."""
    found = residues_of_roots(tuple(name for name in ring.letters if name in ROOTS), prime)
    if found is None:
        raise AssertionError("a ring takes its points modulo primes with its roots")
    return found


def reduced(f: Polynomial, prime: int = P) -> Polynomial:
    """A polynomial over the rationals modulo a prime (`flint.nmod_mpoly` in the same variables)."""
    module = flint()
    context = module.nmod_mpoly_ctx.get(list(f.context().names()), prime, module.Ordering.lex)
    return context.from_dict({tuple(map(int, powers)): modulo(value, prime) for powers, value in f.terms()})


Remembered = dict[tuple[int, int], tuple[Polynomial, Polynomial, tuple[str, ...]]]
"""(id of a polynomial, prime) -> the polynomial, so that its id is no other one's, `reduced`, names of variables."""


@lru_cache(maxsize=_RINGS)
def residues_of(_ring: Ring) -> tuple[list[int], Remembered]:
    """The number of remembered terms and what is remembered for a ring; of rings not used for long nothing is."""
    return [0], {}


def _residues(ring: Ring, f: Polynomial, prime: int) -> tuple[Polynomial, tuple[str, ...]]:
    """`reduced`, and the names of the variables."""
    terms, kept = residues_of(ring)
    known = kept.get((id(f), prime))
    if known is None:
        terms[0] += 1 + len(f)
        if terms[0] > _KEPT:
            kept.clear()
            terms[0] = 1 + len(f)
        known = kept[id(f), prime] = (f, reduced(f, prime), tuple(f.context().names()))
    return known[1:]


def value_at(ring: Ring, f: Polynomial, point: Mapping[str, int]) -> int:
    """A polynomial of either ring modulo the prime of a point; variables that have no value there are not in it."""
    tick(3 + 0.12 * len(f))
    residues, names = _residues(ring, f, modulus(point))
    return int(residues(*(point.get(name, 0) for name in names)))


def residues(
    ring: Ring, columns: Sequence[Sequence[Polynomial]], points: Sequence[Point]
) -> list[tuple[list[list[int]], int]]:
    """A matrix at each of the points, and the prime that its entries are modulo."""
    return [
        ([[value_at(ring, x, point) if x != 0 else 0 for x in column] for column in columns], point.prime)
        for point in points
    ]


def univariate(ring: Ring, f: Polynomial, name: str, point: Mapping[str, int]) -> list[int]:
    """f as a polynomial in one variable, the others at a point: coefficients from power 0 up, modulo its prime."""
    put, names = _put(ring, f, (name,), point)
    return dense(put, names.index(name))


def bivariate(ring: Ring, f: Polynomial, one: str, two: str, point: Mapping[str, int]) -> Polynomial:
    """f as a polynomial in two variables modulo the prime of a point (`flint.nmod_mpoly` in x, y)."""
    put, names = _put(ring, f, (one, two), point)
    a, b = names.index(one), names.index(two)
    module = flint()
    context = module.nmod_mpoly_ctx.get(["x", "y"], modulus(point), module.Ordering.lex)
    return context.from_dict({(int(e[a]), int(e[b])): int(value) for e, value in put.to_dict().items()})


def _put(
    ring: Ring, f: Polynomial, left: Sequence[str], point: Mapping[str, int]
) -> tuple[Polynomial, tuple[str, ...]]:
    """f modulo the prime with every variable but those left at a point, and the names of its variables."""
    tick(10 + len(f))
    residues, names = _residues(ring, f, modulus(point))
    return residues.subs({name: point[name] for name in names if name not in left and name in point}), names


def half_angle_value(ring: Ring, f: Polynomial, point: Point) -> int:
    """A half-angle polynomial at a point; of joints at π, which have no t_j there, its highest coefficient."""
    degrees = f.degrees()
    far = {j: "pi" for place, j in enumerate(ring.revolute) if degrees[place] and f"t{j}" not in point}
    return value_at(ring, ring.form(f).at(far).f if far else f, point)


def stands(point: Point, joint: int, value: str) -> bool:
    """Whether a revolute joint is at a simple angle (out of `atom.SIMPLE`) at a point."""
    cosine, sine = COS_SIN[value]
    prime = modulus(point)
    return (point[f"c{joint}"], point[f"s{joint}"]) == (cosine % prime, sine % prime)


def holds(ring: Ring, f: Polynomial | Atom, point: Point) -> bool:
    """Whether an atom, or a trigonometric polynomial = 0, holds at a point."""
    if not isinstance(f, Atom):
        return value_at(ring, f, point) == 0
    return stands(point, f.joint, f.value) if f.pinned else half_angle_value(ring, f.f, point) == 0


def roots(values: Sequence[int], prime: int = P) -> list[int]:
    """Zeros modulo a prime of a polynomial in one variable, coefficients from power 0 up; none where it is zero."""
    kept = list(values)
    while kept and kept[-1] % prime == 0:
        kept.pop()
    if len(kept) < 2:
        return []
    if len(kept) == 2:
        return [-kept[0] * pow(kept[1], -1, prime) % prime]
    tick(20 * len(kept))
    return [int(root) for root, _ in flint().nmod_poly(kept, prime).roots()]


def common_zeros(f: Polynomial, g: Polynomial) -> Iterator[tuple[int, int]]:
    """All common zeros (x, y) of two polynomials from `bivariate`; none where they have a common factor."""
    if f == 0 or g == 0:
        return
    eliminated = f.resultant(g, "x")
    tick(100 + 3 * len(f) * len(g))
    if eliminated == 0:
        return
    module, prime = flint(), int(f.context().modulus())
    for y in roots(dense(eliminated, 1), prime):
        one, two = (module.nmod_poly(dense(h.subs({"y": y}), 0), prime) for h in (f, g))
        for x in roots([int(value) for value in one.gcd(two).coeffs()], prime):
            yield x, y


def dense(f: Polynomial, place: int) -> list[int]:
    """Coefficients from power 0 up of a polynomial modulo a prime (`flint.nmod_mpoly`) in one variable."""
    parts = {int(e[place]): int(value) for e, value in f.to_dict().items()}
    return [parts.get(k, 0) for k in range(max(parts, default=0) + 1)]


def rank(rows: Sequence[Sequence[int]], prime: int = P) -> int:
    """Rank modulo a prime of a matrix of residues."""
    if not rows or not rows[0]:
        return 0
    tick(15)
    return int(flint().nmod_mat(len(rows), len(rows[0]), [x for row in rows for x in row], prime).rank())


def complete(ring: Ring, tangents: Mapping[str, int], pins: Mapping[int, str]) -> Point | None:
    """Add sines and cosines to values of t_j, q_j and lengths, modulo their prime; None where 1 + t_j² = 0, which does
    not happen.

    Args:
        ring: of the variables.
        tangents: value of every variable of the half-angle ring that is not pinned.
        pins: joints at simple angles.
    """
    prime = modulus(tangents)
    point = Point(tangents, prime)
    point.update(roots_at(ring, prime))
    for j in ring.revolute:
        if j in pins:
            cosine, sine = COS_SIN[pins[j]]
            if pins[j] != "pi":
                point[f"t{j}"] = TANGENT[pins[j]] % prime
            else:
                point.pop(f"t{j}", None)
        else:
            t = point[f"t{j}"]
            if (1 + t * t) % prime == 0:
                return None
            inverse = pow(1 + t * t, -1, prime)
            cosine, sine = (1 - t * t) * inverse, 2 * t * inverse
        point[f"c{j}"], point[f"s{j}"] = cosine % prime, sine % prime
    return point


def random_point(ring: Ring, rng: random.Random) -> Point:
    """A random point of the whole joint space modulo P, lengths random too."""
    point = complete(ring, {name: rng.randrange(1, P) for name in ring.names}, {})
    assert point is not None  # −1 is not a square modulo P
    return point
