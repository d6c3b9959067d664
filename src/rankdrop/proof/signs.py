"""An arm that cannot change its posture without a singularity: each solution of a pose has signs of its own.

A function A + ρ cos(θ − φ) takes a value at two places at most, and its derivative has opposite signs at the two. In
the structures below the pose of the tip, or the place p of a point, leaves one joint after another two values in this
way, and the derivatives are, up to a constant, the factors of det J. Along a path without singularity no factor changes
its sign: of two solutions at its ends each joint is the same one, whole turns left out. With u_i(x) = ω_i × (x − o_i),
the velocity of x for a unit of joint i (unit vectors ω, o on the axis):

    axes 1, 2 meet in O      |p − O|² leaves θ3, then ω1·p leaves θ2         (p − O)·u3(p)   ω1·u2(p)
    axes 1, 2 parallel       ω1·p leaves θ3, then |p − o1|² ⟂ ω1 leaves θ2   ω1·u3(p)        (p − o1)·u2(p)
    axes 2, 3 parallel       ω2·p leaves θ1, then the elbow leaves θ3        ω2·u1(p)        ω2·(u2(p) × u3(p))
    axes 2, 3 meet in O      |p − O|² leaves θ1, then ω2·(p − O) leaves θ3   (p − O)·u1(p)   (p − O)·(ω2 × ω3)
    orientation              ω1·ω3 leaves θ2                                 ω1·(ω2 × ω3)
    planar                   |p − o_i|² ⟂ ω leaves θ_j, then θ_i follows     ω·(u_i(p) × u_j(p))

The joint that is left is determined: where p is on its axis the arm is singular. Six joints with axes 4, 5, 6 that meet
in p have one factor more, ω4·(ω5 × ω6): ω4·ω6 leaves θ5. And with O where axes 5 and 6 meet

    axes 2, 3, 4 parallel, 5, 6 meet    ω2·O leaves θ1, ω4·ω6 leaves θ5, the sum of θ2, θ3, θ4 and θ6 follow, and with
                                        axis 4 the elbow leaves θ3      ω2·u1(O)   ω4·(ω5 × ω6)   ω2·(u2(o4) × u3(o4))

In the last structure all axes are parallel to one axis of the base, at most one of them a slide, which the height
leaves one place. Joints i and j are the first two that turn. Where the task has the angle, a third one turns: the tool
leaves its axis one place, which takes the part of p, and θ_k follows from the sum of the angles.

That axes meet or are parallel is decided in rational numbers: those of the file, exactly, as axes of neighbours stay as
they are. Where joint 3 slides, |p − O|² is quadratic in it, with derivatives of opposite signs at its two zeros, and
ω1·p leaves one place of it: the first two structures are known then too. That the factors multiply to ± det J is
compared besides, in intervals at some configurations.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import prod
from typing import Any

import numpy as np

from rankdrop.proof.arm import Arm, Interval, cross, dot, flint
from rankdrop.proof.record import (
    MEET_12,
    MEET_23,
    ORIENTATION,
    PARALLEL_12,
    PARALLEL_23,
    PLANAR,
    SLIDE,
    THREE_PARALLEL,
    TURN,
    Claim,
    Link,
    Unproven,
)
from rankdrop.proof.tip import tip_motion, velocity

_POSE, _PLACE, _TURN = [0, 1, 2, 3, 4, 5], [0, 1, 2], [3, 4, 5]  # rows of a task
_TRIED = 4  # configurations at which the factors are multiplied out
_WORDS = {
    THREE_PARALLEL: "axes 2, 3, 4 parallel; 5, 6 meet", ORIENTATION: "two values of θ2",
    PLANAR: "all axes parallel",
}  # fmt: skip

Vector = list[Any]
"""Three intervals, or three rational numbers (`flint.fmpq`)."""
Line = tuple[Vector, Vector]
"""Direction ω and moment o × ω of an axis, rational; of a slide, which has none, 0 and its direction."""


def verify_signs(claim: Claim) -> str:
    """Each solution of a pose has signs of its own.

    Returns:
        Why, in words.

    Raises:
        Unproven: the arm has not the structure that is claimed, or its determinant not the factors.
    """
    if claim.tolerance is not None:
        raise Unproven("axes meet and are parallel for the numbers of the arm, not for arms near it")
    structure = claim.entries["structure"]
    if structure == PLANAR:
        _check_plane(claim)
    else:
        _check_turning(claim, structure)
    _DeterminantFactors(claim, structure).check()
    words = _WORDS.get(structure, str(structure))
    if len(claim.links) == 6 and structure != THREE_PARALLEL:
        return f"{words}; axes 4, 5, 6 meet"
    return words


def _check_turning(claim: Claim, structure: str) -> None:
    """Joints turn, or joint 3 slides where that is known, and there are as many as rows of the task.

    Raises:
        Unproven: it is not so.
    """
    count = len(claim.links)
    kinds = [link.kind for link in claim.links]
    if structure in (MEET_12, PARALLEL_12) and kinds[2:3] == [SLIDE]:
        kinds[2] = TURN
    if claim.variables != count or set(kinds) != {TURN}:
        raise Unproven("signs of each solution are known of turning joints, or joint 3 sliding where axes 1 and 2 meet "
                       "or are parallel, and of arms in which none follows another")  # fmt: skip
    fits = {THREE_PARALLEL: (_POSE,), ORIENTATION: (_TURN,)}.get(structure, (_PLACE, _POSE))
    if list(claim.rows) not in fits or not claim.rank == count == len(claim.rows):
        raise Unproven(f"the structure {structure!r} needs as many joints as rows, and rows "
                       f"{' or '.join(map(str, fits))}")  # fmt: skip


def _check_plane(claim: Claim) -> None:
    """All axes have the direction of one axis of the base, and the task has the rows of that plane.

    Raises:
        Unproven: it is not so.
    """
    kinds, count = [link.kind for link in claim.links], len(claim.links)
    turning, sliding = kinds.count(TURN), kinds.count(SLIDE)
    few = turning in (2, 3) and sliding <= 1 and turning + sliding == count
    if not few or claim.variables != count:
        raise Unproven("an arm of parallel axes has two or three turning joints and at most one slide, none of which "
                       "follows another")  # fmt: skip
    along = _normal(claim.links)
    rows = sorted({0, 1, 2} - {along}) + [along] * sliding + [3 + along] * (turning - 2)
    if list(claim.rows) != sorted(rows) or claim.rank != count:
        raise Unproven(f"parallel axes need as many joints as rows, here rows {sorted(rows)}")
    _check_frame_of_plane(claim, along)


def _check_frame_of_plane(claim: Claim, along: int) -> None:
    """The rows of the task are those of the plane, for a point of the tool.

    Raises:
        Unproven: they are not.
    """
    axes, origin, _ = claim.frame
    tips = {-1, len(claim.links), len(claim.links) + 1}
    if axes not in tips | {0} or origin not in tips:
        raise Unproven("the point of the task is one of the last link or the tip, its axes are theirs or those of the "
                       "base")  # fmt: skip
    direction = claim.poses[axes][:3, along].tolist()
    if [abs(x) for x in direction] != [float(k == along) for k in range(3)]:
        raise Unproven(f"the axes of the task are not along those of the arm: {direction}")


def _normal(links: list[Link]) -> int:
    """The axis of the base (from 0) that all axes are parallel to, exactly.

    Raises:
        Unproven: there is none.
    """
    across = set()
    for link in links:
        direction, moment = _line(link)
        if link.kind == SLIDE:
            direction = moment
        across.add(tuple(k for k in range(3) if direction[k] != 0))
    if len(across) == 1:
        only = across.pop()
        if len(only) == 1:
            return only[0]
    raise Unproven("the axes are not all parallel to one axis of the base")


class _DeterminantFactors:
    """The factors of the determinant of an arm of this structure.

    Raises:
        Unproven: its axes are not so.
    """

    def __init__(self, claim: Claim, structure: str) -> None:
        self._f, self._claim, self._structure = flint(), claim, structure
        lines = [_line(link) for link in claim.links]
        self._meeting: Vector | None = None  # where the two axes that are claimed to meet do so, at q = 0
        if structure in (PARALLEL_12, PARALLEL_23, THREE_PARALLEL):
            for i in {PARALLEL_12: (0,), PARALLEL_23: (1,), THREE_PARALLEL: (1, 2)}[structure]:
                _check_parallel(lines, i)
        if structure in (MEET_12, MEET_23, THREE_PARALLEL):
            self._meeting = _meeting(lines, {MEET_12: 0, MEET_23: 1, THREE_PARALLEL: 4}[structure])
        self._wrist = len(lines) == 6 and structure != THREE_PARALLEL
        if self._wrist:
            self._point = _meeting(lines, 3)
            if _off(self._point, lines[5]) != [0, 0, 0]:
                raise Unproven(f"axes 4, 5 and 6 do not meet in one point: axis 6 misses that of 4 and 5 by "
                               f"{_size(_off(self._point, lines[5])):.2g} m")  # fmt: skip
        else:
            self._point = self._of_task()

    def _of_task(self) -> Vector:
        """The point of the task at q = 0."""
        _, origin, local = self._claim.frame
        home = self._claim.poses.get(origin, self._claim.home)
        number, point = [_rational(row) for row in home[:3].tolist()], _rational(local)
        return [dot(row[:3], point) + row[3] for row in number]

    def check(self) -> None:
        """They multiply to ± det J, of one sign, at some configurations.

        Raises:
            Unproven: they do not.
        """
        f, claim = self._f, self._claim
        n, one = claim.variables, f.arb(1)
        base = Arm(claim.links, n, 0, [f.arb(0)] * 3, one)
        if list(claim.rows) == [0, 1, 2] or self._structure == PLANAR:
            seen = Arm(claim.links, n, n, [f.arb(x) for x in self._point], one)
        else:
            seen = base
        signs = set()
        for angles in np.random.default_rng(3).uniform(-np.pi, np.pi, (_TRIED, n)).tolist():
            q = [f.arb(x) for x in angles]
            value, product = seen.determinant(q, list(claim.rows)), prod(self.values(base, q))
            ratio = product / value
            if not (ratio.overlaps(one) or ratio.overlaps(-one)) or not ratio.rad() < 1e-9:
                raise Unproven("the factors of this structure do not multiply to the determinant of the arm")
            signs.add(bool(ratio > 0))
        if len(signs) > 1:
            raise Unproven("the factors of this structure multiply to the determinant with two signs")

    def values(self, arm: Arm, q: list[Interval]) -> list[Interval]:
        """The factors at a configuration; `arm` is seen from the base."""
        columns = [screw.entries() for screw in arm.screws_over(q, [self._f.arb(0)] * arm.variables)[0]]
        w = [column[3:] for column in columns]
        if self._structure == ORIENTATION:
            return [dot(w[0], cross(w[1], w[2]))]
        if self._structure == PLANAR:
            return [self._of_plane(columns, q)]
        if self._structure == THREE_PARALLEL:
            first = self._of_three_parallel(columns, w, q)
        else:
            first = self._of_a_point(columns, w, q)
        if len(w) == 6:
            first.append(dot(w[3], cross(w[4], w[5])))
        return first

    def _of_plane(self, columns: list[Vector], q: list[Interval]) -> Interval:
        kinds = [link.kind for link in self._claim.links]
        first, second, *third = [columns[i] for i, kind in enumerate(kinds) if kind == TURN]
        if third:
            p = _foot(third[0])
        else:
            p = self._place_point(self._point, len(columns), q)
        return dot(first[3:], cross(velocity(first, p), velocity(second, p)))

    def _of_three_parallel(self, columns: list[Vector], w: list[Vector], q: list[Interval]) -> list[Interval]:
        o, foot = self._place_point(self._meeting, 4, q), _foot(columns[3])
        elbow = cross(velocity(columns[1], foot), velocity(columns[2], foot))
        return [dot(w[1], velocity(columns[0], o)), dot(w[1], elbow)]

    def _of_a_point(self, columns: list[Vector], w: list[Vector], q: list[Interval]) -> list[Interval]:
        p = self._place_point(self._point, 3, q)
        u = [velocity(column, p) for column in columns[:3]]
        if self._structure == MEET_12:
            return [dot(_minus(p, self._place_point(self._meeting, 0, q)), u[2]), dot(w[0], u[1])]
        if self._structure == PARALLEL_12:
            return [dot(w[0], u[2]), dot(_minus(p, _foot(columns[0])), u[1])]
        if self._structure == PARALLEL_23:
            return [dot(w[1], u[0]), dot(w[1], cross(u[1], u[2]))]
        away = _minus(p, self._place_point(self._meeting, 1, q))
        return [dot(away, u[0]), dot(away, cross(w[1], w[2]))]

    def _place_point(self, point: Vector | None, joints: int, q: list[Interval]) -> Vector:
        """Where so many joints carry a point."""
        assert point is not None
        turn, shift = tip_motion(self._claim.links[:joints], q)
        return list((turn * self._f.arb_mat([[self._f.arb(x)] for x in point]) + shift).entries())


def _foot(column: Vector) -> Vector:
    """A point of the axis of a unit twist."""
    return cross(column[3:], column[:3])


def _rational(values: Iterable[float]) -> Vector:
    return [flint().fmpq(*float(value).as_integer_ratio()) for value in values]


def _line(link: Link) -> Line:
    """The axis at q = 0: the part of v along ω is no part of it."""
    v, w = _rational(link.screw[:3]), _rational(link.screw[3:])
    if link.kind == SLIDE:
        return w, v
    pitch = dot(v, w) / dot(w, w)
    return w, [a - pitch * b for a, b in zip(v, w, strict=True)]


def _minus(a: Vector, b: Vector) -> Vector:
    return [x - y for x, y in zip(a, b, strict=True)]


def _off(point: Vector, line: Line) -> Vector:
    """Zero where a point is on a line: its moment about a point of the line."""
    return _minus(cross(point, line[0]), line[1])


def _size(vector: Vector) -> float:
    return float(np.linalg.norm([float(flint().arb(x)) for x in vector]))


def _check_parallel(lines: list[Line], i: int) -> None:
    """Axes i and i + 1 (from 0) are parallel.

    Raises:
        Unproven: they are not.
    """
    normal = cross(lines[i][0], lines[i + 1][0])
    if normal != [0, 0, 0]:
        raise Unproven(f"axes {i + 1} and {i + 2} are not parallel: {_size(normal):.2g} rad off")


def _meeting(lines: list[Line], i: int) -> Vector:
    """Where axes i and i + 1 (from 0) meet.

    Raises:
        Unproven: they are parallel, or miss one another.
    """
    (w, moment), other = lines[i], lines[i + 1]
    normal = cross(w, other[0])
    if normal == [0, 0, 0]:
        raise Unproven(f"axes {i + 1} and {i + 2} are parallel: they do not meet")
    foot = [x / dot(w, w) for x in cross(w, moment)]
    share = -dot(_off(foot, other), normal) / dot(normal, normal)
    point = [a + share * b for a, b in zip(foot, w, strict=True)]
    if _off(point, other) != [0, 0, 0]:
        raise Unproven(f"axes {i + 1} and {i + 2} do not meet: {_size(_off(point, other)):.2g} m between them")
    return point
