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

from collections.abc import Sequence
from itertools import combinations, product
from math import comb, pi
from typing import Any

import numpy as np

from rankdrop.proof.arm import Arm, Interval, cross, dot, flint
from rankdrop.proof.record import SCREW, SLIDE, Array, Claim, Link, Unproven

_SNAP = 1e-9  # joints so near to a multiple of a right angle are put there [rad]
_STEPS = (60, 50, 40, 34, 30)  # a change of sign is looked for between −2^−k and 2^−k
_MOST = 20_000  # minors times points, at most: some seconds

Rational = Any
"""A `flint.fmpq`."""
Value = tuple[Rational, Rational, Interval]
"""Where a joint stands: what ad and ad² are multiplied by (of a slide the shift and zero), and its angle [rad, m]."""
_ANYWHERE = tuple(np.random.default_rng(2).uniform(-1.5, 1.5, 32).tolist())


def verify_in_minors(claim: Claim) -> None:
    """A configuration whose rank is below that of the certificate exists within the radius of its q.

    Raises:
        Unproven: it could not be shown.
    """
    q, radius = claim.entries["q"], claim.entries["radius"]
    arm = _Exact(claim)
    anywhere = [arm.rational(k, value, snap=False) for k, value in enumerate(_ANYWHERE[: claim.variables])]
    if arm.task_rows(anywhere).rank() < claim.rank:
        raise Unproven(f"the rank is below {claim.rank} at a configuration taken at random: that it is so near q is no "
                       "finding")  # fmt: skip
    given = [arm.rational(k, value, snap=True) for k, value in enumerate(q)]
    away = max(arm.distance(pose, value) for pose, value in zip(given, q, strict=True))
    if away <= radius and any(
        arm.singular(given, moved, radius - away) is not None for moved in range(claim.variables)
    ):
        return
    raise Unproven("in rational numbers no single joint, the others standing where they are, at right angles exactly, "
                   "leads to a configuration of lower rank next to q: take one of the same family with its free joints "
                   "elsewhere, or its exact conditions (rankdrop conditions)")  # fmt: skip


class _Exact(Arm):
    """The arm and the task of a certificate in rational numbers; axes as long as they are in the file, lengths in m.

    Raises:
        Unproven: joints that follow others or that screw, or a frame that the certificate does not have.
    """

    def __init__(self, claim: Claim) -> None:
        self._claim = claim
        self._partial = claim.blocks != list(claim.rows)
        _refuse_unsuited(claim, partial=self._partial)
        axes, origin, local = claim.frame
        pose = claim.poses.get(origin, np.eye(4))
        point = self._rotated_point(pose, local)
        link = 0 if origin == 0 else len(claim.links)
        super().__init__(claim.links, claim.variables, link, point, self._number(1))
        turn = claim.poses.get(axes, np.eye(4))[:3, :3].T
        self._axes = self._matrix([self._numbers(row) for row in turn])
        if (axes == 0) == (link == 0):  # how the axes of the task are turned from the link's
            self._turned = 0
        elif axes == 0:
            self._turned = 1
        else:
            self._turned = -1
        self._count = comb(len(claim.rows), claim.rank) * comb(claim.variables, claim.rank)

    def matrices(self) -> Any:
        """The type of its matrices."""
        return flint().fmpq_mat

    def _number(self, value: float) -> Rational:
        return flint().fmpq(*float(value).as_integer_ratio())

    def _rotated_point(self, pose: Array, local: Sequence[float]) -> list[Rational]:
        """A point in the axes of a pose, in those in which the pose is given."""
        point = self._numbers(local)
        moved = []
        for row in pose[:3]:
            *turn, shift = self._numbers(row)
            moved.append(dot(turn, point) + shift)
        return moved

    def _screw(self, one: Link) -> list[Rational]:
        v, w = self._numbers(one.screw[:3]), self._numbers(one.screw[3:])
        if one.kind == SLIDE:
            return v + [self._number(0)] * 3
        foot = [x / dot(w, w) - y for x, y in zip(cross(w, v), self._point, strict=True)]
        return cross(foot, w) + w

    def _square(self, k: int) -> Rational:
        """Square of the length of an axis."""
        if self.links[k].kind == SLIDE:
            axis = self._screws[k][:3]
        else:
            axis = self._screws[k][3:]
        return dot(axis, axis)

    def rational(self, k: int, value: float, *, snap: bool) -> Value:
        """A rational place of a joint next to a value."""
        f, square = self._f, self._square(k)
        zero, one = f.fmpq(0), f.fmpq(1)
        length = float(square.p) / float(square.q)
        if self.links[k].kind == SLIDE:
            shift = self._number(value / length**0.5)
            return (shift, zero, f.arb(shift) * f.arb(square).sqrt())
        quarter = round(value / (pi / 2))
        if snap and abs(value - quarter * (pi / 2)) <= _SNAP and (quarter % 2 == 0 or square == 1):
            sine, cosine = ((0, 1), (1, 0), (0, -1), (-1, 0))[quarter % 4]
            return (sine * one, (1 - cosine) / square, quarter * f.arb.pi() / 2)
        turns = round(value / (2 * pi))
        x = self._number(np.tan((value - turns * 2 * pi) / 2) / length**0.5)
        return self._place(x, k, 2 * (f.arb(x) * f.arb(square).sqrt()).atan() + 2 * turns * f.arb.pi())

    def _place(self, x: Rational, k: int, angle: Interval) -> Value:
        below = 1 + x * x * self._square(k)
        return (2 * x / below, 2 * x * x / below, angle)

    def distance(self, one: Value, value: float) -> float:
        """How far a place is from a value, at most."""
        return float(abs(one[2] - self._f.arb(value)).upper())

    def task_rows(self, given: list[Value], *, turned: bool = True) -> Any:
        """(m, n) the rows of the task, columns as long as their axes are; in the axes of the task if `turned`."""
        seen = self.carry_screws(lambda i, sign: self.exponential(i, sign * given[i][0], given[i][1]))
        columns = self._matrix([screw.entries() for screw in seen[0]])
        six = columns.transpose().tolist()
        linear, angular = self._matrix(six[:3]), self._matrix(six[3:])
        if turned and self._turned:
            total = self.unit()
            for i, (once, twice, _) in enumerate(given):
                total = total * self.exponential(i, once, twice)
            turn = self._matrix([row[:3] for row in total.tolist()[:3]])
            if self._turned < 0:
                turn = turn.transpose()
            linear, angular = turn * linear, turn * angular
        rows = (self._axes * linear).tolist() + (self._axes * angular).tolist()
        return self._matrix([rows[row] for row in self._claim.rows])

    def _after(self, one: Value, k: int, x: Rational) -> Value:
        """The place of a joint that goes on from another one by x."""
        if self.links[k].kind == SLIDE:
            return (one[0] + x, one[1], one[2])
        # the motions 1 + s ad + c ad² about one axis, ad³ = −|ω|² ad, multiplied out
        s, c, square = one[0], one[1], self._square(k)
        sine, shift, _ = self._place(x, k, one[2])
        return (s + sine - square * (s * shift + c * sine), c + shift + s * sine - square * c * shift, one[2])

    def singular(self, given: list[Value], moved: int, radius: float) -> float | None:
        """How far a joint goes at most to a configuration of lower rank; None where that is not shown within radius."""
        f, rank, square = self._f, self._claim.rank, self._square(moved)
        slides = self.links[moved].kind == SLIDE
        twice = 2 if self._partial and self._turned else 1  # axes that turn as well
        degree = rank * (1 if slides else 2 * twice)
        points = [f.fmpq(k) for k in range(-(degree // 2), degree - degree // 2 + 1)]
        if len(points) * self._count > _MOST:
            raise Unproven(f"in rational numbers there are {self._count:,} minors: too many")
        scale = [f.fmpq(1) if slides else (1 + x * x * square) ** (twice * rank) for x in points]
        tables = []
        for x in points:
            there = [*given[:moved], self._after(given[moved], moved, x), *given[moved + 1 :]]
            tables.append(self.task_rows(there, turned=self._partial).tolist())
        inverse = f.fmpq_mat([_powers(x, degree) for x in points]).inv()
        divisor = f.fmpz_poly([0])
        choices = product(combinations(range(len(self._claim.rows)), rank), combinations(range(len(given)), rank))
        for rows, columns in choices:
            values = f.fmpq_mat(len(points), 1)  # of the minor, at each point
            for place, (table, size) in enumerate(zip(tables, scale, strict=True)):
                values[place, 0] = self._minor(table, rows, columns) * size
            minor = f.fmpq_poly((inverse * values).entries())
            divisor = divisor.gcd(minor.numer())
            if divisor.degree() == 0:
                return None
        if divisor(f.fmpq(0)) == 0:
            return 0.0
        return self._root(divisor, float(square.p) / float(square.q), radius)

    def _minor(self, table: Sequence[Sequence[Rational]], rows: Sequence[int], columns: Sequence[int]) -> Rational:
        """A determinant of some rows and columns."""
        part = []
        for row in rows:
            part.append([table[row][column] for column in columns])
        return self._matrix(part).det()

    def _root(self, divisor: Any, square: float, radius: float) -> float | None:
        simple = divisor // divisor.gcd(divisor.derivative())
        for step in _STEPS:
            x = self._f.fmpq(1, 1 << step)
            far = 2 * float(x.p) / float(x.q) * (1.0 + square)
            if far > radius:
                return None
            if simple(x) * simple(-x) <= 0:
                return far
        return None


def _refuse_unsuited(claim: Claim, *, partial: bool) -> None:
    """Refuse joints and frames for which rational numbers do not do; see `_Exact`."""
    for place, link in enumerate(claim.links):
        if (link.driver, link.multiplier, link.offset) != (place, 1.0, 0.0) or link.kind == SCREW:
            raise Unproven("in rational numbers joints turn or slide, each for itself")
    axes, origin, _ = claim.frame
    if partial:
        decides = [axes, origin]
    elif claim.blocks == [0, 1, 2]:
        decides = [origin]
    else:
        decides = []
    if any(link not in claim.poses for link in decides):
        raise Unproven("in rational numbers the frame of a task is that of the base, the last link or the tip")


def _powers(x: Rational, degree: int) -> list[Rational]:
    """1, x, …, x to the degree."""
    return [x**k for k in range(degree + 1)]
