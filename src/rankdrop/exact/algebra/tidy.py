"""Irreducible sets in shorter words: sums of angles that are constant on them, found at random points.

θ5 = θ3 + π is seen at once; among resultants it is not. With such a relation the other conditions have a joint less.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, product

from rankdrop.exact.algebra.decompose import decompose
from rankdrop.exact.algebra.field import Point
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.polynomial import primitive, used
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.algebra.solving import form
from rankdrop.exact.algebra.variety import Variety
from rankdrop.exact.algebra.work import Work

_MOST = 4  # joints in a sum
_SIMPLE = {(1, 0): "0", (-1, 0): "pi", (0, 1): "pi/2", (0, -1): "-pi/2"}  # by cosine and sine


def tidy(piece: Variety, work: Work) -> Variety:
    """The same set with its constant sums of angles among the conditions, and the other conditions shortened by them.

    Raises:
        OutOfTime: the deadline has passed.
    """
    if len(piece.equations) < 2 or piece.also or not piece.samples:
        return piece
    ring = piece.ring
    found = list(_relations(piece))
    if not found or all(str(f) in {str(primitive(g)) for g in piece.equations} for f in found):
        return piece
    most = piece.codimension - len(piece.pins)
    system = [form(f, ring) for f in (*found, *piece.equations)]
    for other in decompose(ring, piece.pins, system, most, work):
        if other.codimension == piece.codimension and other.inside(piece) and piece.inside(other):
            return other
    return piece


def _relations(piece: Variety) -> Iterator[Polynomial]:
    """Polynomials of Σ ± θ_j = 0, π or ±π/2 that hold on a set, for its joints that are bound together."""
    ring = piece.ring
    bound = {place for f in piece.equations for place in used(f) if place < ring.angles}
    joints = [j for j in ring.revolute if ring.index[f"t{j}"] in bound]
    covered: list[set[int]] = []
    for size in range(2, _MOST + 1):
        for chosen in combinations(joints, size):
            if any(known <= set(chosen) for known in covered):
                continue
            for signs in product((1, -1), repeat=size - 1):
                turns = tuple(zip(chosen, (1, *signs), strict=True))
                f = _constant(ring, turns, piece.samples)
                if f is not None:
                    covered.append(set(chosen))
                    yield f
                    break


def _constant(ring: Ring, turns: tuple[tuple[int, int], ...], points: list[Point]) -> Polynomial | None:
    """The polynomial of Σ turns_j θ_j = value where that holds at all points for a simple value."""
    met = {_sum(turns, point) for point in points}
    value = _SIMPLE.get(met.pop()) if len(met) == 1 else None
    if value is None:
        return None
    real, imaginary = ring.half.constant(1), ring.half.constant(0)
    for joint, sign in turns:  # Π (1 + i sign t): its argument is half the sum
        t = ring.t[joint] * sign
        real, imaginary = real - imaginary * t, imaginary + real * t
    return primitive({"0": imaginary, "pi": real, "pi/2": imaginary - real, "-pi/2": imaginary + real}[value])


def _sum(turns: tuple[tuple[int, int], ...], point: Point) -> tuple[int, int]:
    """(cos, sin) of a sum of angles modulo the prime of a point, between −p/2 and p/2."""
    cosine, sine, prime = 1, 0, point.prime
    for joint, sign in turns:
        c, s = point[f"c{joint}"], sign * point[f"s{joint}"]
        cosine, sine = (cosine * c - sine * s) % prime, (sine * c + cosine * s) % prime
    return cosine - prime * (2 * cosine > prime), sine - prime * (2 * sine > prime)
