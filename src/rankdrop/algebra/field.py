"""Arithmetic modulo a prime: exact ranks at random points, which decide what holds on a whole set.

A polynomial that is not zero on an irreducible set vanishes at a random point of it modulo p with a probability of the
order degree / p (Schwartz and Zippel), here below 1e-15. With p ≡ 3 mod 4, −1 is not a square: 1 + t² has no zero, as
over the reals. The primes up to 43 are squares: √2, √3, √5 … exist, as over the reals. Of other roots some exist modulo
one prime and others modulo the next: a point knows which prime its values are residues of.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import combinations
from math import lcm, prod
from typing import Any, NamedTuple

from rankdrop.algebra.matrix import entries
from rankdrop.algebra.polynomial import COS_SIN, TANGENT, Atom, Polynomial, flint, used_by, variables_in
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.roots import PRIMES, ROOTS, Number, Surd, residues_of_roots, roots_of
from rankdrop.algebra.work import tick

P = PRIMES[0]
"""The one that is taken first."""

_SHORT = 24  # terms up to which a polynomial is evaluated term by term: a call of the library costs as much

_SEEN = 3  # evaluations modulo one prime without an image modulo it

Terms = list[tuple[int, list[tuple[str, int]]]]
"""Coefficient modulo a prime, and (variable, power) of each variable that occurs, of each term."""
Image = tuple[Polynomial, Polynomial, tuple[str, ...], Terms]
"""A polynomial, so that its id is no other one's, `modulo_prime`, names of the variables, the terms of a short one."""

_LARGEST = 400  # terms that a resultant of three conditions on the way to their zeros may have


class ModularPoint(dict[str, int]):
    """Values modulo a prime of the variables of both rings, by name; t_j is absent where θ_j = π.

    Args:
        values: by name.
        prime: out of `PRIMES`.
    """

    def __init__(self, values: Mapping[str, int] | Iterable[tuple[str, int]] = (), prime: int = P) -> None:
        super().__init__(values)
        self.prime = prime

    def replace_values(self, values: Mapping[str, int]) -> ModularPoint:
        """The point with other values of some variables."""
        return ModularPoint({**self, **values}, self.prime)


def modulo(value: Any, prime: int = P) -> int:
    """A rational number (`flint.fmpq`) modulo a prime."""
    bottom = int(value.q)
    top = int(value.p) % prime
    if bottom == 1:
        return top
    return top * pow(bottom, -1, prime) % prime


def residue(value: Number, prime: int = P) -> int:
    """An exact number modulo a prime."""
    if isinstance(value, Surd):
        roots = residues_of_roots(tuple(roots_of([value])), prime) or {}
        return sum(residue(part, prime) * prod(roots[name] for name in names) for names, part in value.terms) % prime
    return value.numerator % prime * pow(value.denominator, -1, prime) % prime


def roots_at(ring: Ring, prime: int) -> dict[str, int]:
    """Values of the roots of a ring modulo one of its primes."""
    residues = residues_of_roots(tuple(name for name in ring.letters if name in ROOTS), prime)
    if residues is None:
        raise AssertionError("a ring takes its points modulo primes with its roots")
    return residues


def modulo_prime(f: Polynomial, prime: int = P) -> Polynomial:
    """A polynomial over the rationals modulo a prime (`flint.nmod_mpoly` in the same variables)."""
    module = flint()
    context = module.nmod_mpoly_ctx.get(list(f.context().names()), prime, module.Ordering.lex)
    values = (modulo(value, prime) for value in f.coeffs())
    return context.from_dict(dict(zip(f.monoms(), values, strict=True)))


class Uses(NamedTuple):
    """How often a polynomial was evaluated modulo a prime before its image was made."""

    f: Polynomial
    times: int


def _image(ring: Ring, f: Polynomial, prime: int) -> Image:
    key = (id(f), prime)
    known: Image | Uses | None = ring.images.get(key)
    if known is None or isinstance(known, Uses):
        tick(8 * len(f))
        image, names = modulo_prime(f, prime), tuple(f.context().names())
        short: Terms = []
        if len(f) <= _SHORT:
            short = [
                (int(value), [(name, int(power)) for name, power in zip(names, powers, strict=True) if power])
                for powers, value in image.to_dict().items()
            ]
        known = (f, image, names, short)
        ring.images.keep(key, known, len(f))
    return known


def value_at(ring: Ring, f: Polynomial, point: ModularPoint) -> int:
    """A polynomial of either ring modulo the prime of a point; variables that have no value there are not in it."""
    prime = point.prime
    if len(f) > _SHORT:
        known: Image | Uses | None = ring.images.get((id(f), prime))
        if known is None:
            return _early_value(ring, f, point, 0)
        if isinstance(known, Uses) and known.times < _SEEN:
            return _early_value(ring, f, point, known.times)
    tick(5 + 0.12 * len(f))
    _, image, names, short = _image(ring, f, prime)
    if not short:
        return int(image(*[point.get(name, 0) for name in names]))
    total = 0
    for value, powers in short:
        for name, power in powers:
            x = point.get(name, 0)
            value = value * (x if power == 1 else pow(x, power, prime)) % prime
        total += value
    return total % prime


def _early_value(ring: Ring, f: Polynomial, point: ModularPoint, uses: int) -> int:
    """`value_at` of a polynomial that has been evaluated modulo this prime a few times at most: term by term.

    An image modulo the prime costs as much as three of these; it is made where the polynomial is evaluated often.
    """
    prime = point.prime
    known = ring.images.get(id(f))
    if known is None:
        tick(3 * len(f))
        known = ring.images.keep(id(f), (f, *_integer_terms(f)), len(f))
    _, bottom, terms = known
    ring.images.keep((id(f), prime), Uses(f, uses + 1), 0)
    tick(10 + 2 * len(f))
    names = f.context().names()
    tables = [_powers(point.get(name, 0), int(degree), prime) for name, degree in zip(names, f.degrees(), strict=True)]
    total = 0
    for value, powers in terms:
        for place, power in powers:
            value = value * tables[place][power] % prime
        total += value
    if bottom == 1:
        return int(total % prime)
    return int(total * pow(bottom, -1, prime) % prime)


def _integer_terms(f: Polynomial) -> tuple[int, list[tuple[int, list[tuple[int, int]]]]]:
    """A common denominator, and for each term its whole numerator and (place, power) of the variables in it."""
    values, places = f.coeffs(), variables_in(f)
    bottom = lcm(*(int(value.q) for value in values))
    return bottom, [
        (int(value.p) * (bottom // int(value.q)), [(place, int(powers[place])) for place in places if powers[place]])
        for powers, value in zip(f.monoms(), values, strict=True)
    ]


def _powers(x: int, degree: int, prime: int) -> list[int]:
    """1, x, x², … modulo a prime."""
    powers = [1]
    for _ in range(degree):
        powers.append(powers[-1] * x % prime)
    return powers


def residues(
    ring: Ring, columns: Sequence[Sequence[Polynomial]], points: Sequence[ModularPoint]
) -> list[tuple[list[list[int]], int]]:
    """A matrix at each of the points, and the prime that its entries are modulo."""
    return [
        ([[0 if x.is_zero() else value_at(ring, x, point) for x in column] for column in columns], point.prime)
        for point in points
    ]


def univariate(ring: Ring, f: Polynomial, name: str, point: ModularPoint) -> list[int]:
    """f as a polynomial in one variable, the others at a point: coefficients from power 0 up, modulo its prime."""
    put, names = _evaluate_but(ring, f, (name,), point)
    return dense(put, names.index(name))


def bivariate(ring: Ring, f: Polynomial, one: str, two: str, point: ModularPoint) -> Polynomial:
    """f as a polynomial in two variables modulo the prime of a point (`flint.nmod_mpoly` in x, y)."""
    return slice_at(ring, f, (one, two), point)


def slice_at(ring: Ring, f: Polynomial, moving: Sequence[str], point: ModularPoint) -> Polynomial:
    """f as a polynomial in two or three variables modulo the prime of a point (`flint.nmod_mpoly` in x, y, z)."""
    put, names = _evaluate_but(ring, f, moving, point)
    places = [names.index(name) for name in moving]
    module = flint()
    context = module.nmod_mpoly_ctx.get(list("xyz"[: len(moving)]), point.prime, module.Ordering.lex)
    return context.from_dict({tuple(int(e[k]) for k in places): int(value) for e, value in put.to_dict().items()})


def _evaluate_but(
    ring: Ring, f: Polynomial, left: Sequence[str], point: ModularPoint
) -> tuple[Polynomial, tuple[str, ...]]:
    """f modulo the prime with every variable but those left at a point, and the names of its variables."""
    tick(60 + 2 * len(f))
    _, image, names, _ = _image(ring, f, point.prime)
    return image.subs({name: point[name] for name in names if name not in left and name in point}), names


def half_angle_value(ring: Ring, f: Polynomial, point: ModularPoint) -> int:
    """A half-angle polynomial at a point; of joints at π, which have no t_j there, its highest coefficient."""
    degrees = f.degrees()
    far = tuple(j for place, j in enumerate(ring.revolute) if degrees[place] and f"t{j}" not in point)
    if not far:
        return value_at(ring, f, point)
    return value_at(ring, _highest(ring, f, far), point)


def _highest(ring: Ring, f: Polynomial, far: tuple[int, ...]) -> Polynomial:
    """The highest coefficient of f in the tangents of joints at π, made once: points of a set are at the same ones."""
    key = (id(f), "pi", far)
    known: tuple[Polynomial, Polynomial] | None = ring.images.get(key)
    if known is None:
        tick(3 * len(f))
        there = ring.form(f).at(dict.fromkeys(far, "pi")).f
        known = ring.images.keep(key, (f, there), len(f) + len(there))
    return known[1]


def stands(point: ModularPoint, joint: int, value: str) -> bool:
    """Whether a revolute joint is at a simple angle (out of `atom.SIMPLE`) at a point."""
    cosine, sine = COS_SIN[value]
    prime = point.prime
    return (point[f"c{joint}"], point[f"s{joint}"]) == (cosine % prime, sine % prime)


def holds(ring: Ring, f: Polynomial | Atom, point: ModularPoint) -> bool:
    """Whether an atom, or a trigonometric polynomial = 0, holds at a point."""
    if not isinstance(f, Atom):
        return value_at(ring, f, point) == 0
    if f.is_pin:
        return stands(point, f.joint, f.value)
    return half_angle_value(ring, f.f, point) == 0


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
        f_at_y, g_at_y = (module.nmod_poly(dense(h.subs({"y": y}), 0), prime) for h in (f, g))
        for x in roots([int(value) for value in f_at_y.gcd(g_at_y).coeffs()], prime):
            yield x, y


def plane_size(f: Polynomial, g: Polynomial, place: int) -> int:
    """Number of terms that the resultant of two polynomials in one of three variables may have."""
    degrees_f, degrees_g = (list(map(int, h.degrees())) for h in (f, g))
    others = [k for k in range(len(degrees_f)) if k != place]
    return prod(1 + degrees_f[k] * degrees_g[place] + degrees_g[k] * degrees_f[place] for k in others)


def solvable_in_space(conditions: Sequence[Polynomial], moving: int) -> bool:
    """Whether three conditions have zeros that `zeros_in_space` finds in short time, whichever three of the first so
    many variables they are solved for.
    """
    places = sorted(place for place in used_by(conditions) if place < moving)
    degrees = [list(map(int, f.degrees())) for f in conditions]
    for chosen in combinations(places, 3):
        here = [[d[k] for k in chosen] for d in degrees]
        best = min(_work_in_space(here, place) for place in range(3))
        if best > _LARGEST:
            return False
    return True


def _work_in_space(degrees: Sequence[Sequence[int]], place: int) -> int:
    """Terms of the longest resultant where three polynomials of these degrees are solved after one variable is
    eliminated.
    """
    inside = sorted((d for d in degrees if d[place]), key=lambda d: d[place])
    return max((prod(1 + inside[0][k] * d[place] + d[k] * inside[0][place] for k in range(3) if k != place)
                for d in inside[1:]), default=0)  # fmt: skip


def zeros_in_space(conditions: Sequence[Polynomial]) -> list[tuple[int, ...]] | None:
    """All common zeros (x, y, z) of three polynomials modulo a prime (`flint.nmod_mpoly` in x, y, z).

    Returns:
        None where they are not isolated as far as is seen, or would take too long.
    """
    if any(f == 0 for f in conditions):
        return None
    degrees = [list(map(int, f.degrees())) for f in conditions]
    for place in sorted(range(3), key=lambda k: (sum(d[k] > 0 for d in degrees), max(d[k] for d in degrees))):
        inside = sorted((f for f in conditions if f.degrees()[place]), key=lambda f: (int(f.degrees()[place]), len(f)))
        outside = [f for f in conditions if not f.degrees()[place]]
        if not inside:
            continue
        if any(plane_size(inside[0], f, place) > _LARGEST for f in inside[1:]):
            continue
        for f in inside[1:]:
            tick(200 + 5 * plane_size(inside[0], f, place))
        name = "xyz"[place]
        outside += [inside[0].resultant(f, name) for f in inside[1:]]
        zeros = _zeros_in_plane(outside, place)
        if zeros is None:
            lines = None
        else:
            lines = _lines_through(conditions, inside, zeros, place)
        if lines is not None:
            return lines
    return None


def _zeros_in_plane(pair: Sequence[Polynomial], without: int) -> list[tuple[int, int]] | None:
    """The common zeros of two polynomials in two of x, y, z; None where they have a common factor."""
    first, second = pair
    if first == 0 or second == 0:
        return None
    module, prime = flint(), int(first.context().modulus())
    context = module.nmod_mpoly_ctx.get(["x", "y"], prime, module.Ordering.lex)
    f, g = (
        context.from_dict({tuple(int(x) for k, x in enumerate(e) if k != without): int(c)
                           for e, c in h.to_dict().items()})
        for h in (first, second)
    )  # fmt: skip
    if not f.gcd(g).is_constant():
        return None
    return list(common_zeros(f, g))


def _lines_through(
    conditions: Sequence[Polynomial], inside: Sequence[Polynomial], zeros: Sequence[tuple[int, int]], place: int
) -> list[tuple[int, ...]] | None:
    """Zeros in space above zeros in the plane; None where a whole line is one."""
    module, solutions = flint(), list[tuple[int, ...]]()
    for a, b in zeros:
        values = iter((a, b))
        there = {"xyz"[k]: next(values) for k in range(3) if k != place}
        prime = int(inside[0].context().modulus())
        lines = [module.nmod_poly(dense(f.subs(there), place), prime) for f in inside]
        lines = [line for line in lines if line.degree() >= 0]
        if not lines:
            return None
        common = lines[0]
        for line in lines[1:]:
            common = common.gcd(line)
        for x in roots([int(value) for value in common.coeffs()], prime):
            point = {**there, "xyz"[place]: x}
            if all(int(f(*(point[name] for name in "xyz"))) == 0 for f in conditions):
                solutions.append((point["x"], point["y"], point["z"]))
    return solutions


def dense(f: Polynomial, place: int) -> list[int]:
    """Coefficients from power 0 up of a polynomial modulo a prime (`flint.nmod_mpoly`) in one variable."""
    parts = {int(e[place]): int(value) for e, value in f.to_dict().items()}
    return [parts.get(k, 0) for k in range(max(parts, default=0) + 1)]


def rank(rows: Sequence[Sequence[int]], prime: int = P) -> int:
    """Rank modulo a prime of a matrix of residues."""
    if not rows or not rows[0]:
        return 0
    tick(15)
    return int(flint().nmod_mat(len(rows), len(rows[0]), entries(rows), prime).rank())


def complete(ring: Ring, tangents: ModularPoint, pins: Mapping[int, str]) -> ModularPoint | None:
    """Add sines and cosines to values of t_j, q_j and lengths, modulo their prime; None where 1 + t_j² = 0, which does
    not happen.

    Args:
        ring: of the variables.
        tangents: value of every variable of the half-angle ring that is not pinned.
        pins: joints at simple angles.
    """
    prime = tangents.prime
    point = ModularPoint(tangents, prime)
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


def random_point(ring: Ring, rng: random.Random) -> ModularPoint:
    """A random point of the whole joint space modulo P, lengths random too."""
    point = complete(ring, ModularPoint({name: rng.randrange(1, P) for name in ring.names}), {})
    assert point is not None  # −1 is not a square modulo P
    return point
