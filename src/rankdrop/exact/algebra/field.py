"""Arithmetic modulo a prime: exact ranks at random points, which decide what holds on a whole set.

A polynomial that is not zero on an irreducible set vanishes at a random point of it modulo p with a probability of the
order degree / p (Schwartz and Zippel), here below 1e-15. With p ≡ 3 mod 4, −1 is not a square: 1 + t² has no zero, as
over the reals. The primes up to 43 are squares: √2, √3, √5 … exist, as over the reals.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any

from rankdrop.exact.algebra.atom import COS_SIN, TANGENT, Atom
from rankdrop.exact.algebra.effort import tick
from rankdrop.exact.algebra.flint import Polynomial, flint
from rankdrop.exact.algebra.ring import Ring

P = (1 << 61) - 11_913
"""A prime ≡ 119 mod 120, the largest below 2^61 of which all primes up to 43 are squares and −1 is not."""

_KEPT = 50_000  # polynomials whose residues are remembered

Point = dict[str, int]
"""Values modulo P of the variables of both rings, by name; t_j is absent where θ_j = π."""


def modulo(value: Any) -> int:
    """A rational number (`flint.fmpq`) modulo P."""
    bottom = int(value.q)
    top = int(value.p) % P
    return top if bottom == 1 else top * pow(bottom, -1, P) % P


def residue(value: Fraction) -> int:
    """A rational number modulo P."""
    return value.numerator % P * pow(value.denominator, -1, P) % P


_reduced: dict[int, tuple[Polynomial, Polynomial]] = {}  # by id; the first one keeps the id from being used again


def reduced(f: Polynomial) -> Polynomial:
    """A polynomial over the rationals modulo P (`flint.nmod_mpoly` in the same variables); kept."""
    kept = _reduced.get(id(f))
    if kept is None or kept[0] is not f:
        if len(_reduced) > _KEPT:
            _reduced.clear()
        module = flint()
        context = module.nmod_mpoly_ctx.get(list(f.context().names()), P, module.Ordering.lex)
        terms = {tuple(map(int, powers)): modulo(value) for powers, value in f.terms()}
        kept = _reduced[id(f)] = (f, context.from_dict(terms))
    return kept[1]


class Evaluator:
    """Evaluates polynomials of one context modulo P.

    Args:
        names: of the context's variables, in order.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self._names = tuple(names)
        module = flint()
        self._two = module.nmod_mpoly_ctx.get(["x", "y"], P, module.Ordering.lex)

    def __call__(self, f: Polynomial, point: Mapping[str, int]) -> int:
        """f at a point; variables that the point gives no value to are not in f."""
        tick(3 + 0.12 * len(f))
        return int(reduced(f)(*(point.get(name, 0) for name in self._names)))

    def _put(self, f: Polynomial, left: Sequence[str], point: Mapping[str, int]) -> Polynomial:
        """f modulo P with every variable but those left at a point."""
        tick(10 + len(f))
        return reduced(f).subs({name: point[name] for name in self._names if name not in left and name in point})

    def in_one(self, f: Polynomial, name: str, point: Mapping[str, int]) -> list[int]:
        """f as a polynomial in one variable, the others at a point: coefficients from power 0 up."""
        return dense(self._put(f, (name,), point), self._names.index(name))

    def in_two(self, f: Polynomial, one: str, two: str, point: Mapping[str, int]) -> Polynomial:
        """f as a polynomial in two variables modulo P (`flint.nmod_mpoly` in x, y)."""
        a, b = self._names.index(one), self._names.index(two)
        put = self._put(f, (one, two), point)
        return self._two.from_dict({(int(e[a]), int(e[b])): int(value) for e, value in put.to_dict().items()})


@lru_cache(maxsize=32)
def half_evaluator(ring: Ring) -> Evaluator:
    """Evaluates half-angle polynomials of a ring."""
    return Evaluator(ring.names)


@lru_cache(maxsize=32)
def trig_evaluator(ring: Ring) -> Evaluator:
    """Evaluates trigonometric polynomials of a ring."""
    return Evaluator([f"{x}{j}" for j in ring.revolute for x in "sc"] + list(ring.names[ring.angles :]))


def half_value(ring: Ring, f: Polynomial, point: Point) -> int:
    """A half-angle polynomial at a point; of joints at π, which have no t_j there, its highest coefficient."""
    degrees = f.degrees()
    far = {j: "pi" for place, j in enumerate(ring.revolute) if degrees[place] and f"t{j}" not in point}
    return half_evaluator(ring)(ring.half_at(f, far) if far else f, point)


def stands(point: Point, joint: int, value: str) -> bool:
    """Whether a revolute joint is at a simple angle (out of `atom.SIMPLE`) at a point."""
    cosine, sine = COS_SIN[value]
    return (point[f"c{joint}"], point[f"s{joint}"]) == (cosine % P, sine % P)


def holds(ring: Ring, f: Polynomial | Atom, point: Point) -> bool:
    """Whether an atom, or a trigonometric polynomial = 0, holds at a point."""
    if not isinstance(f, Atom):
        return trig_evaluator(ring)(f, point) == 0
    return stands(point, f.joint, f.value) if f.pinned else half_value(ring, f.f, point) == 0


def roots(values: Sequence[int]) -> list[int]:
    """Zeros modulo P of a polynomial in one variable, coefficients from power 0 up; none of the zero polynomial."""
    kept = list(values)
    while kept and kept[-1] % P == 0:
        kept.pop()
    if len(kept) < 2:
        return []
    if len(kept) == 2:
        return [-kept[0] * pow(kept[1], -1, P) % P]
    tick(20 * len(kept))
    return [int(root) for root, _ in flint().nmod_poly(kept, P).roots()]


def common_zeros(f: Polynomial, g: Polynomial) -> Iterator[tuple[int, int]]:
    """All common zeros (x, y) of two polynomials from `Evaluator.in_two`; none where they have a common factor."""
    if f == 0 or g == 0:
        return
    eliminated = f.resultant(g, "x")
    tick(100 + 3 * len(f) * len(g))
    if eliminated == 0:
        return
    module = flint()
    for y in roots(dense(eliminated, 1)):
        one, two = (module.nmod_poly(dense(h.subs({"y": y}), 0), P) for h in (f, g))
        for x in roots([int(value) for value in one.gcd(two).coeffs()]):
            yield x, y


def put_common_zero(
    evaluate: Evaluator,
    f: Polynomial,
    g: Polynomial,
    names: tuple[str, str],
    values: dict[str, int],
    rng: random.Random,
) -> bool:
    """Change the values of two variables so that two polynomials vanish; whether there is such a zero."""
    zeros = list(common_zeros(evaluate.in_two(f, *names, values), evaluate.in_two(g, *names, values)))
    if zeros:
        values.update(zip(names, rng.choice(zeros), strict=True))
    return bool(zeros)


def dense(f: Polynomial, place: int) -> list[int]:
    """Coefficients from power 0 up of a polynomial modulo P (`flint.nmod_mpoly`) that contains one variable alone."""
    parts = {int(e[place]): int(value) for e, value in f.to_dict().items()}
    return [parts.get(k, 0) for k in range(max(parts, default=0) + 1)]


def rank(rows: Sequence[Sequence[int]]) -> int:
    """Rank modulo P of a matrix of residues."""
    if not rows or not rows[0]:
        return 0
    tick(15)
    return int(flint().nmod_mat(len(rows), len(rows[0]), [x for row in rows for x in row], P).rank())


def complete(ring: Ring, tangents: Mapping[str, int], pins: Mapping[int, str]) -> Point | None:
    """Add sines and cosines to values of t_j, q_j and lengths; None where 1 + t_j² = 0, which does not happen.

    Args:
        ring: of the variables.
        tangents: value of every variable of the half-angle ring that is not pinned.
        pins: joints at simple angles.
    """
    point = dict(tangents)
    for j in ring.revolute:
        if j in pins:
            cosine, sine = COS_SIN[pins[j]]
            if pins[j] != "pi":
                point[f"t{j}"] = TANGENT[pins[j]] % P
            else:
                point.pop(f"t{j}", None)
        else:
            t = point[f"t{j}"]
            if (1 + t * t) % P == 0:
                return None
            inverse = pow(1 + t * t, -1, P)
            cosine, sine = (1 - t * t) * inverse, 2 * t * inverse
        point[f"c{j}"], point[f"s{j}"] = cosine % P, sine % P
    return point
