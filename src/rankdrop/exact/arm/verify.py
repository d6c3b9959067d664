"""Ranks modulo a prime: a check of exact conditions that knows nothing of how they were derived.

They come from modular forward kinematics of the exact twists and lengths, never from the polynomials that conditions
are made of.
"""

from __future__ import annotations

import random
from collections.abc import Iterable
from dataclasses import dataclass

from rankdrop.algebra.field import ModularPoint, random_point, rank, residue
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.geometry import JointAndLink
from rankdrop.families.record import Check
from rankdrop.robot.model import JointKind


def random_points(chain: Chain, count: int, seed: int = 0) -> list[ModularPoint]:
    """Points of the whole joint space modulo P, lengths random too: what almost every arm of this kind does.

    Args:
        chain: the arm.
        count: how many.
        seed: of the points.
    """
    rng = random.Random(seed)
    return [random_point(chain.ring, rng) for _ in range(count)]


def rank_modulo(chain: Chain, point: ModularPoint) -> int:
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


def rank_check(chain: Chain, points: Iterable[ModularPoint]) -> tuple[int, ...]:
    """`rank_modulo` at each of the points."""
    return tuple(rank_modulo(chain, point) for point in points)


def rank_agreement(chain: Chain, points: Iterable[ModularPoint], claimed: int) -> Check:
    """At how many of the points, one or more of every piece of a family, the rank is exactly as claimed."""
    ranks = rank_check(chain, points)
    return Check(len(ranks), sum(rank == claimed for rank in ranks))


def _twists(chain: Chain, point: ModularPoint) -> list[list[int]]:
    """Columns (v; ω) in the frame before joint 1, as residues: of a joint v = p × z for a point p of the axis z, summed
    up over the joints that a variable moves; then one for each row that the task leaves out.
    """
    prime = point.prime
    frame = _ChainFrame([[int(i == j) for j in range(3)] for i in range(3)], [0, 0, 0])
    twists = [[0] * 6 for _ in range(chain.n)]
    for number, section in enumerate(chain.sections):
        screw = _screw(frame, section, prime)
        variable, m = section.variable - 1, residue(section.multiplier, prime)
        twists[variable] = [(x + m * y) % prime for x, y in zip(twists[variable], screw, strict=True)]
        frame = _next_frame(chain, frame, number, section, point)
    left_out = sorted({*range(6)} - {*chain.task.rows})
    if left_out:
        tip = _tip(chain, frame, point)
        twists += [_screw_of_row(chain, frame, tip, row, prime) for row in left_out]
    return twists


@dataclass(frozen=True)
class _ChainFrame:
    """A frame of the chain, in the frame before joint 1.

    Attributes:
        turn: (3, 3) its axes as columns, residues.
        origin: (3,) residues.
    """

    turn: list[list[int]]
    origin: list[int]


def _screw(frame: _ChainFrame, section: JointAndLink, prime: int) -> list[int]:
    """(v; ω) of a joint that moves by one unit about or along the z axis of its frame."""
    z = [row[2] for row in frame.turn]
    if section.kind is JointKind.PRISMATIC:
        return [*z, 0, 0, 0]
    return [*_moment(frame.origin, z, prime), *z]


def _next_frame(
    chain: Chain, frame: _ChainFrame, number: int, section: JointAndLink, point: ModularPoint
) -> _ChainFrame:
    """The frame behind a section (from 0): turned and moved along z, then moved and turned along the new x axis."""
    prime = point.prime
    z = [row[2] for row in frame.turn]
    d = _length(chain, number, "d", point)
    if section.kind is JointKind.PRISMATIC:
        d += residue(section.multiplier, prime) * point[f"q{section.variable}"]
    cosine, sine = _angle(section, point)
    turn = _times(frame.turn, [[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]], prime)
    a = _length(chain, number, "a", point)
    origin = [(frame.origin[i] + d * z[i] + a * turn[i][0]) % prime for i in range(3)]
    cosine, sine = residue(section.twist.cos, prime), residue(section.twist.sin, prime)
    return _ChainFrame(_times(turn, [[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]], prime), origin)


def _angle(section: JointAndLink, point: ModularPoint) -> tuple[int, int]:
    """(cos, sin) of the angle about z: the phase, and of a turning joint a whole multiple of its variable."""
    prime = point.prime
    cosine, sine = residue(section.phase.cos, prime), residue(section.phase.sin, prime)
    if section.kind is JointKind.PRISMATIC:
        return cosine, sine
    c, s = point[f"c{section.variable}"], point[f"s{section.variable}"]
    if section.multiplier < 0:
        s = -s
    for _ in range(abs(int(section.multiplier))):
        cosine, sine = (c * cosine - s * sine) % prime, (s * cosine + c * sine) % prime
    return cosine, sine


def _tip(chain: Chain, frame: _ChainFrame, point: ModularPoint) -> list[int]:
    """(3,) the tip, given the frame behind the last section."""
    prime, last = point.prime, chain.links
    offset = [_length(chain, last, "a", point), residue(chain.tip[1], prime), _length(chain, last, "d", point)]
    moved = _rotate_modulo(frame.turn, offset, prime)
    return [(x + y) % prime for x, y in zip(frame.origin, moved, strict=True)]


def _screw_of_row(chain: Chain, frame: _ChainFrame, tip: list[int], row: int, prime: int) -> list[int]:
    """(v; ω) of the motion that a row of the task would measure: along an axis, or about it through the tip."""
    axis = [residue(x, prime) for x in chain.task_axes[row % 3]]
    if chain.in_body:
        axis = _rotate_modulo(frame.turn, axis, prime)
    if row > 2:
        return [*_moment(tip, axis, prime), *axis]
    return [*axis, 0, 0, 0]


def _rotate_modulo(turn: list[list[int]], vector: list[int], prime: int) -> list[int]:
    """A vector turned."""
    return [sum(x * y for x, y in zip(row, vector, strict=True)) % prime for row in turn]


def _moment(point: list[int], axis: list[int], prime: int) -> list[int]:
    return [(point[i - 2] * axis[i - 1] - point[i - 1] * axis[i - 2]) % prime for i in range(3)]


def _length(chain: Chain, place: int, which: str, point: ModularPoint) -> int:
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
