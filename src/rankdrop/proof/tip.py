"""Where the last link of a chain is, in intervals: the joints' motions multiplied out, link after link."""

from __future__ import annotations

from rankdrop.proof.arm import Interval, Matrix, cross, dot, flint
from rankdrop.proof.record import SCREW, SLIDE, Link


def tip_motion(links: list[Link], q: list[Interval]) -> tuple[Matrix, Matrix]:
    """(3, 3) rotation R and (3, 1) shift p of the motion of the last link from q = 0: a point x goes to R x + p.

    R is a product of exact rotations, whatever the doubles of the certificate are.
    """
    f = flint()
    turn = unit(3)
    place = f.arb_mat(3, 1, [0, 0, 0])
    for link in links:
        own_turn, own_place = _motion(link, f.arb(link.multiplier) * q[link.driver] + f.arb(link.offset))
        place = turn * own_place + place
        turn = turn * own_turn
    return turn, place


def _motion(link: Link, value: Interval) -> tuple[Matrix, Matrix]:
    """(3, 3) rotation and (3, 1) shift of one joint, in base coordinates at q = 0."""
    f = flint()
    v, w = ([f.arb(x) for x in part] for part in (link.screw[:3], link.screw[3:]))
    if link.kind == SLIDE:
        size = dot(v, v).sqrt()
        return unit(3), f.arb_mat([[x / size * value] for x in v])
    square = dot(w, w)
    axis = [x / square.sqrt() for x in w]
    foot = f.arb_mat([[x / square] for x in cross(w, v)])
    turn = turn_about(axis, value)
    shift = foot - turn * foot
    if link.kind == SCREW:
        pitch = dot(w, v) / square
        shift = shift + f.arb_mat([[pitch * value * x] for x in axis])
    return turn, shift


def turn_about(axis: list[Interval], angle: Interval) -> Matrix:
    """(3, 3) rotation about a unit vector by an angle."""
    f = flint()
    x, y, z = axis
    sine, cosine = angle.sin_cos()
    hat = f.arb_mat([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return unit(3) + hat * sine + hat * hat * (1 - cosine)


def velocity(twist: list[Interval], x: list[Interval]) -> list[Interval]:
    """v + ω × x, of a point x and a twist (v; ω) in base coordinates."""
    return [a + b for a, b in zip(twist[:3], cross(twist[3:], x), strict=True)]


def unit(n: int) -> Matrix:
    """(n, n) identity."""
    return flint().arb_mat(n, n, [int(r == c) for r in range(n) for c in range(n)])
