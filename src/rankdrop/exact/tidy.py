"""A set's conditions shortened by the sums of angles that are constant on it.

The sums are found at random points: θ5 = θ3 + π is seen at once there, among resultants it is not.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, product

from rankdrop.algebra.decompose import decompose
from rankdrop.algebra.field import ModularPoint
from rankdrop.algebra.polynomial import Polynomial, primitive, used_by
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.work import Work
from rankdrop.algebra.zeroset import ZeroSet

_MOST = 4  # joints in a sum
_SIMPLE = {(1, 0): "0", (-1, 0): "pi", (0, 1): "pi/2", (0, -1): "-pi/2"}  # by cosine and sine


def tidy(piece: ZeroSet, work: Work) -> ZeroSet:
    """The same set with its constant sums of angles among the conditions, and the other conditions shortened by them.

    Raises:
        OutOfTime: the deadline has passed.
    """
    if len(piece.equations) < 2 or piece.zero or not piece.samples:
        return piece
    ring = piece.ring
    relations = list(_relations(piece))
    if not relations or all(str(f) in {str(primitive(g)) for g in piece.equations} for f in relations):
        return piece
    most = piece.codimension - len(piece.pins)
    system = [ring.form(f) for f in (*relations, *piece.equations)]
    for other in decompose(ring, piece.pins, system, most, work):
        if other.codimension == piece.codimension and other.lies_inside(piece) and piece.lies_inside(other):
            return other
    return piece


def _relations(piece: ZeroSet) -> Iterator[Polynomial]:
    """Polynomials of Σ ± θ_j = 0, π or ±π/2 that hold on a set, for its joints that are bound together."""
    ring = piece.ring
    bound = {place for place in used_by(piece.equations) if place < ring.angles}
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


def _constant(ring: Ring, turns: tuple[tuple[int, int], ...], points: list[ModularPoint]) -> Polynomial | None:
    """The polynomial of Σ turns_j θ_j = value where that holds at all points for a simple value."""
    met = {_sum(turns, point) for point in points}
    if len(met) == 1:
        value = _SIMPLE.get(met.pop())
    else:
        value = None
    if value is None:
        return None
    real, imaginary = ring.half.constant(1), ring.half.constant(0)
    for joint, sign in turns:  # Π (1 + i sign t): its argument is half the sum
        t = ring.t[joint] * sign
        real, imaginary = real - imaginary * t, imaginary + real * t
    return primitive({"0": imaginary, "pi": real, "pi/2": imaginary - real, "-pi/2": imaginary + real}[value])


def _sum(turns: tuple[tuple[int, int], ...], point: ModularPoint) -> tuple[int, int]:
    """(cos, sin) of a sum of angles modulo the prime of a point, between −p/2 and p/2."""
    cosine, sine, prime = 1, 0, point.prime
    for joint, sign in turns:
        c, s = point[f"c{joint}"], sign * point[f"s{joint}"]
        cosine, sine = (cosine * c - sine * s) % prime, (sine * c + cosine * s) % prime
    return cosine - prime * (2 * cosine > prime), sine - prime * (2 * sine > prime)
