"""A singular configuration proven to exist, in rational numbers: minors that vanish together.

Where a singular set has more dimensions than its equations let it have no interval method can prove a point of it. The
numbers of an arm are doubles, hence rational, and with x = tan(θ/2)/|ω| so is every motion about an axis ω through f:

    Ad(exp) = 1 + 2x/(1 + x²|ω|²) ad + 2x²/(1 + x²|ω|²) ad²        ad of the screw (f × ω; ω), no root of |ω|² in it

All joints but one are put at rational x: at 0 and π exactly, at ±π/2 where |ω| is rational, elsewhere where the double
is. All minors of the Jacobian of as many rows as the rank are polynomials of the x of the one that is left. Where they
are zero, or their greatest common divisor changes its sign next to q, there is a configuration of lower rank. No
number is rounded, and neither rows, dimensions, nor the shape of the Jacobian play a part.
"""

from __future__ import annotations

from itertools import combinations, product
from math import comb, pi
from typing import Any

import numpy as np

from rankdrop.certify.proof.intervals import SCREW, SLIDE, Interval, Link, flint
from rankdrop.certify.proof.reading import Told, Unproven, number, vector

_SNAP = 1e-9  # joints so near to a multiple of a right angle are put there [rad]
_STEPS = (60, 50, 40, 34, 30)  # a change of sign is looked for between −2^−k and 2^−k
_MOST = 20_000  # minors times points, at most: some seconds

Rational = Any
"""A `flint.fmpq`."""
Vector = list[Rational]
Rotation = list[Vector]
Value = tuple[Rational, Rational, Interval]
"""Where a joint stands: what ad and ad² are multiplied by (of a slide the shift and zero), and its angle [rad, m]."""


def verify_in_minors(told: Told) -> str:
    """A configuration whose rank is below that of the certificate within the radius of its q.

    Raises:
        ValueError: the claim is malformed.
        Unproven: it could not be shown.
    """
    q, radius = vector(told.claim["q"], told.variables, "q"), number(told.claim["radius"], 0.0, 1.0, "radius")
    arm = _Exact(told)
    if arm.jacobian([arm.rational(k, value, snap=False) for k, value in enumerate(_ANYWHERE[: told.variables])]).rank(
    ) < told.rank:  # fmt: skip
        raise Unproven(f"the rank is below {told.rank} at a configuration taken at random: that it is so near q is no "
                       "finding")  # fmt: skip
    given = [arm.rational(k, value, snap=True) for k, value in enumerate(q)]
    away = max(arm.distance(one, value) for one, value in zip(given, q, strict=True))
    if away <= radius:
        for moved in range(told.variables):
            step = arm.singular(given, moved, radius - away)
            if step is not None:
                return (f"a configuration of rank below {told.rank} exists within {radius:.3g} of q, joint by joint "
                        "[rad, m]: in rational numbers")  # fmt: skip
    raise Unproven("in rational numbers no single joint, the others standing where they are, at right angles exactly, "
                   "leads to a configuration of lower rank next to q: take one of the same family with its free joints "
                   "elsewhere, or its exact conditions (rankdrop conditions)")  # fmt: skip


_ANYWHERE = tuple(np.random.default_rng(2).uniform(-1.5, 1.5, 32).tolist())


class _Exact:
    """The arm of a certificate in rational numbers; lengths in metres, base coordinates.

    Raises:
        Unproven: joints that follow others or that screw, or a frame that the certificate does not have.
    """

    def __init__(self, told: Told) -> None:
        self._f = flint()
        self._told, self._links = told, told.links
        for place, one in enumerate(told.links):
            if (one.driver, one.multiplier, one.offset) != (place, 1.0, 0.0) or one.kind == SCREW:
                raise Unproven("in rational numbers joints turn or slide, each for itself")
        self._screws = [self._screw(one) for one in told.links]
        self._squares = [_dot(*([s[:3]] * 2 if one.kind == SLIDE else [s[3:]] * 2))
                         for s, one in zip(self._screws, told.links, strict=True)]  # fmt: skip
        self._partial = told.whole_rows != list(told.rows)
        axes, origin, self._local = told.frame
        joints = len(told.links)
        poses = {-1: told.home, joints: told.last, joints + 1: told.home, 0: np.eye(4)}
        decides = [axes, origin] if self._partial else [origin] if told.whole_rows == [0, 1, 2] else []
        if any(one not in poses for one in decides):
            raise Unproven("in rational numbers the frame of a task is that of the base, the last link or the tip")
        self._axes, self._origin = (self._pose(poses.get(one, np.eye(4)), one != 0) for one in (axes, origin))
        self._count = comb(len(told.rows), told.rank) * comb(told.variables, told.rank)

    def _number(self, value: float) -> Rational:
        return self._f.fmpq(*float(value).as_integer_ratio())

    def _pose(self, pose: Any, carried: bool) -> tuple[Rotation, Vector, bool]:
        turn = [[self._number(pose[r, c]) for c in range(3)] for r in range(3)]
        return turn, [self._number(pose[r, 3]) for r in range(3)], carried

    def _screw(self, one: Link) -> Vector:
        """(v; ω): ω as it is, v that of its axis; of a slide its direction."""
        v, w = ([self._number(x) for x in part] for part in (one.screw[:3], one.screw[3:]))
        if one.kind == SLIDE:
            return v + [self._f.fmpq(0)] * 3
        foot = [x / _dot(w, w) for x in _cross(w, v)]
        return _cross(foot, w) + w

    def rational(self, k: int, value: float, *, snap: bool) -> Value:
        """A rational place of a joint next to a value."""
        f, square = self._f, self._squares[k]
        zero, one = f.fmpq(0), f.fmpq(1)
        length = float(square.p) / float(square.q)
        if self._links[k].kind == SLIDE:
            shift = self._number(value / length**0.5)
            return (shift, zero, f.arb(shift) * f.arb(square).sqrt())
        quarter = round(value / (pi / 2))
        if snap and abs(value - quarter * (pi / 2)) <= _SNAP and (quarter % 2 == 0 or square == 1):
            sine, cosine = ((0, 1), (1, 0), (0, -1), (-1, 0))[quarter % 4]
            return (sine * one, (1 - cosine) / square, quarter * f.arb.pi() / 2)
        turns = round(value / (2 * pi))
        x = self._number(np.tan((value - turns * 2 * pi) / 2) / length**0.5)
        angle = 2 * (f.arb(x) * f.arb(square).sqrt()).atan() + 2 * turns * f.arb.pi()
        return self._turned(x, k, angle)

    def _turned(self, x: Rational, k: int, angle: Interval) -> Value:
        below = 1 + x * x * self._squares[k]
        return (2 * x / below, 2 * x * x / below, angle)

    def distance(self, one: Value, value: float) -> float:
        """How far a place is from a value, at most."""
        return float(abs(one[2] - self._f.arb(value)).upper())

    def jacobian(self, given: list[Value], moved: int = -1, by: Value | None = None) -> Any:
        """(m, n) the rows of the task, columns as long as their axes are; `moved` goes on by a second motion."""
        f = self._f
        turn = [[f.fmpq(int(r == c)) for c in range(3)] for r in range(3)]
        shift = [f.fmpq(0)] * 3
        columns = []
        for k, screw in enumerate(self._screws):
            w = _times(turn, screw[3:])
            columns.append([x + y for x, y in zip(_times(turn, screw[:3]), _cross(shift, w), strict=True)] + w)
            for value in [given[k]] if k != moved or by is None else [given[k], by]:
                turn, shift = self._after(turn, shift, k, value)
        (axes, _, carried), (place, point, moves) = self._axes, self._origin
        local = [self._number(x) for x in self._local]
        point = [x + y for x, y in zip(_times(place, local), point, strict=True)]
        if moves:
            point = [x + y for x, y in zip(_times(turn, point), shift, strict=True)]
        axes = [_times(turn, one) for one in _turned_over(axes)] if carried else _turned_over(axes)
        rows = []
        for row in self._told.rows:
            axis = axes[row % 3]
            rows.append([_dot(axis, [x + y for x, y in zip(one[:3], _cross(one[3:], point), strict=True)])
                         if row < 3 else _dot(axis, one[3:]) for one in columns])  # fmt: skip
        return f.fmpq_mat(rows)

    def _after(self, turn: Rotation, shift: Vector, k: int, value: Value) -> tuple[Rotation, Vector]:
        screw = self._screws[k]
        if self._links[k].kind == SLIDE:
            go = _times(turn, [value[0] * x for x in screw[:3]])
            return turn, [x + y for x, y in zip(shift, go, strict=True)]
        w = screw[3:]
        # exp takes p to p + s ω × (p − f) + c ω × (ω × (p − f))
        own = []
        for c in range(3):
            unit = [self._f.fmpq(int(r == c)) for r in range(3)]
            once = _cross(w, unit)
            own.append([p + value[0] * x + value[1] * y
                        for p, x, y in zip(unit, once, _cross(w, once), strict=True)])  # fmt: skip
        foot = [x / self._squares[k] for x in _cross(w, screw[:3])]
        there = [sum((own[c][r] * foot[c] for c in range(3)), self._f.fmpq(0)) for r in range(3)]
        go = _times(turn, [x - y for x, y in zip(foot, there, strict=True)])
        return _turned_over([_times(turn, one) for one in own]), [x + y for x, y in zip(shift, go, strict=True)]

    def singular(self, given: list[Value], moved: int, radius: float) -> float | None:
        """How far a joint goes at most to a configuration of lower rank; None where that is not shown within radius."""
        f, told = self._f, self._told
        slides = self._links[moved].kind == SLIDE
        twice = 2 if self._partial and self._axes[2] else 1  # axes that turn as well
        degree = told.rank * (1 if slides else 2 * twice)
        points = [f.fmpq(k) for k in range(-(degree // 2), degree - degree // 2 + 1)]
        if len(points) * self._count > _MOST:
            raise Unproven(f"in rational numbers there are {self._count:,} minors: too many")
        below = [f.fmpq(1) if slides else 1 + x * x * self._squares[moved] for x in points]
        scale = [one ** (twice * told.rank) for one in below]
        zero = f.arb(0)
        seen = [self.jacobian(given, moved, (x, f.fmpq(0), zero) if slides else self._turned(x, moved, zero))
                for x in points]  # fmt: skip
        entries = [one.tolist() for one in seen]
        inverse = f.fmpq_mat([[x**k for k in range(degree + 1)] for x in points]).inv()
        divisor = None
        for rows, columns in product(*(combinations(range(n), told.rank) for n in (len(told.rows), told.variables))):
            values = [f.fmpq_mat([[table[r][c] for c in columns] for r in rows]).det() * size
                      for table, size in zip(entries, scale, strict=True)]  # fmt: skip
            if not any(values):
                continue
            wave = (inverse * f.fmpq_mat([[one] for one in values])).entries()
            one = f.fmpq_poly(wave).numer()
            divisor = one if divisor is None else divisor.gcd(one)
            if divisor.degree() == 0:
                return None
        if divisor is None or divisor(f.fmpq(0)) == 0:
            return 0.0
        return self._root(divisor, moved, radius)

    def _root(self, divisor: Any, moved: int, radius: float) -> float | None:
        f = self._f
        simple = divisor // divisor.gcd(divisor.derivative())
        for step in _STEPS:
            x = f.fmpq(1, 1 << step)
            far = 2 * float(x.p) / float(x.q) * (1.0 + float(self._squares[moved].p) / float(self._squares[moved].q))
            if far > radius:
                return None
            if simple(x) * simple(-x) <= 0:
                return far
        return None


def _dot(a: Vector, b: Vector) -> Rational:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _turned_over(matrix: Rotation) -> Rotation:
    return [list(one) for one in zip(*matrix, strict=True)]


def _times(matrix: Rotation, vector: Vector) -> Vector:
    return [_dot(row, vector) for row in matrix]
