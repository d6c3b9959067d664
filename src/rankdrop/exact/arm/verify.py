"""Ranks modulo a prime: a check of exact conditions that knows nothing of how they were derived.

They come from modular forward kinematics of the exact twists and lengths, never from the polynomials that conditions
are made of.
"""

from __future__ import annotations

import random
from collections.abc import Iterable

from rankdrop.algebra.field import Point, random_point, rank, residue
from rankdrop.exact.arm.chain import Chain
from rankdrop.families.record import Check
from rankdrop.robot.model import JointKind


def random_points(chain: Chain, count: int, seed: int = 0) -> list[Point]:
    """Points of the whole joint space modulo P, lengths random too: what almost every arm of this kind does.

    Args:
        chain: the arm.
        count: how many.
        seed: of the points.
    """
    rng = random.Random(seed)
    return [random_point(chain.ring, rng) for _ in range(count)]


def rank_modulo(chain: Chain, point: Point) -> int:
    """Rank of the task Jacobian at a point modulo P.

    By forward kinematics of residues along the chain, from the first axis on; the symbolic screws are not used. For a
    task that leaves rows out a screw is added for each of these: see `Chain.augmented`.

    Args:
        chain: the arm.
        point: sines, cosines, slides and letters modulo P, as from `ZeroSet.point` or `random_points`.

    Example:
        >>> from rankdrop.exact.arm.chain import exact_chain
        >>> from rankdrop.robot.open import open_robot
        >>> chain = exact_chain(open_robot("pa10"))
        >>> rank_modulo(chain, random_points(chain, 1)[0])
        6
    """
    return rank(_twists(chain, point), point.prime) - (6 - chain.task.m)


def rank_check(chain: Chain, points: Iterable[Point]) -> tuple[int, ...]:
    """`rank_modulo` at each of the points."""
    return tuple(rank_modulo(chain, point) for point in points)


def rank_agreement(chain: Chain, points: Iterable[Point], claimed: int) -> Check:
    """At how many of the points, one or more of every piece of a family, the rank is exactly as claimed."""
    ranks = rank_check(chain, points)
    return Check(len(ranks), sum(found == claimed for found in ranks))


def _twists(chain: Chain, point: Point) -> list[list[int]]:
    """Columns (v; ω) in the frame before joint 1, as residues: of a joint v = p × z for a point p of the axis z, summed
    up over the joints that a variable moves; then one for each row that the task leaves out.
    """
    prime = point.prime
    turned = [[int(i == j) for j in range(3)] for i in range(3)]
    place = [0, 0, 0]
    found = [[0] * 6 for _ in range(chain.n)]
    for number, section in enumerate(chain.sections, 1):
        z = [row[2] for row in turned]
        cosine, sine = residue(section.phase.cos, prime), residue(section.phase.sin, prime)
        d = _length(chain, number - 1, "d", point)
        variable, m = section.variable, residue(section.multiplier, prime)
        if section.kind is JointKind.PRISMATIC:
            d += m * point[f"q{variable}"]
            screw = [*z, 0, 0, 0]
        else:
            screw = [*_moment(place, z, prime), *z]
            c, s = point[f"c{variable}"], point[f"s{variable}"]
            for _ in range(abs(int(section.multiplier))):
                cosine, sine = _turned(cosine, sine, c, s if section.multiplier > 0 else -s, prime)
        found[variable - 1] = [(x + m * y) % prime for x, y in zip(found[variable - 1], screw, strict=True)]
        turned = _times(turned, [[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]], prime)
        a = _length(chain, number - 1, "a", point)
        place = [(place[i] + d * z[i] + a * turned[i][0]) % prime for i in range(3)]
        cosine, sine = residue(section.twist.cos, prime), residue(section.twist.sin, prime)
        turned = _times(turned, [[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]], prime)
    left_out = sorted({*range(6)} - {*chain.task.rows})
    if left_out:
        last = chain.links
        tip = [_length(chain, last, "a", point), residue(chain.tip[1], prime), _length(chain, last, "d", point)]
        place = [(place[i] + sum(turned[i][k] * tip[k] for k in range(3))) % prime for i in range(3)]
    for row in left_out:
        along = [residue(x, prime) for x in chain.task_axes[row % 3]]
        if chain.in_body:
            axis = [sum(turned[i][k] * along[k] for k in range(3)) % prime for i in range(3)]
        else:
            axis = along
        found.append([*_moment(place, axis, prime), *axis] if row > 2 else [*axis, 0, 0, 0])
    return found


def _turned(cosine: int, sine: int, c: int, s: int, prime: int) -> tuple[int, int]:
    """(cos, sin) of the sum of two angles."""
    return (c * cosine - s * sine) % prime, (s * cosine + c * sine) % prime


def _moment(point: list[int], axis: list[int], prime: int) -> list[int]:
    return [(point[i - 2] * axis[i - 1] - point[i - 1] * axis[i - 2]) % prime for i in range(3)]


def _length(chain: Chain, place: int, which: str, point: Point) -> int:
    """Length "a" or "d" of a section as a residue: its letter's value at the point, or its own."""
    if (place, which) in chain.written:
        sign, letter = chain.written[place, which]
        return sign * point[letter]
    if place == chain.links:
        value = chain.tip["aid".index(which)]
    else:
        value = getattr(chain.sections[place], which)
    return residue(value, point.prime)


def _times(one: list[list[int]], two: list[list[int]], prime: int) -> list[list[int]]:
    return [[sum(one[i][k] * two[k][j] for k in range(3)) % prime for j in range(3)] for i in range(3)]
