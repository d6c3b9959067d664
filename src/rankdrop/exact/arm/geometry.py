"""A chain as twists, lengths and offsets between consecutive axes, read off the joint screws, then made exact.

Between axis i and axis i+1 runs a common normal x_i. Along it the axes are a_i apart and twisted by α_i; along axis i
the feet of x_{i−1} and x_i are d_i apart, and the angle between these normals is θ_i = q_i + φ_i (a slide: a constant
angle, and distance d_i + q_i). These are Denavit and Hartenberg's numbers. Where the joints carry frames that follow
either of the two conventions, the normals are directed as theirs, so that the numbers are those of the table.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from math import atan2, cos, pi, sin, tan

import numpy as np

from rankdrop.errors import RobotError
from rankdrop.reach import reach
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.tolerances import ALIGNED
from rankdrop.units import UnitRobot, shifted

DIGITS = 12
"""Lengths are read as decimals of so many places of the arm's own unit: far below any drawing, far above rounding."""


@dataclass(frozen=True, slots=True)
class Turn:
    """An angle by its rational cosine and sine.

    Attributes:
        cos, sin: exact, cos² + sin² = 1.
        error: the given angle less this one [rad].
    """

    cos: Fraction
    sin: Fraction
    error: float

    @property
    def quarters(self) -> int | None:
        """0, 1, 2 or 3 quarter turns; None for another angle."""
        found = {(1, 0): 0, (0, 1): 1, (-1, 0): 2, (0, -1): 3}
        return found.get((int(self.cos), int(self.sin))) if self.cos.denominator == self.sin.denominator == 1 else None


@dataclass(frozen=True, slots=True)
class Section:
    """Joint i and the link after it.

    Attributes:
        kind: of the joint.
        phase: θ_i at q = 0 (for a slide its constant angle).
        shift: θ_i = q_i + shift [rad]: 0 where the phase is a whole number of quarter turns, which `phase` then holds;
            else the phase itself, and θ_i is what conditions speak of.
        d: distance along axis i between the two normals [m], at q = 0 for a slide.
        a: distance between axes i and i+1 along the normal [m].
        twist: from axis i to axis i+1 about the normal.
    """

    kind: JointKind
    phase: Turn
    shift: float
    d: Fraction
    a: Fraction
    twist: Turn


@dataclass(frozen=True, slots=True)
class _Line:
    direction: Array  # (3,)
    point: Array  # (3,)


@dataclass(frozen=True, slots=True)
class _Normal:
    direction: Array  # (3,)
    near: Array  # (3,) foot on the axis before
    far: Array  # (3,) foot on the axis after


def sections(robot: Robot, *, snap: float = 0.0) -> tuple[tuple[Section, ...], tuple[str, ...]]:
    """The n sections of a chain, the last one up to the tip's foot on the last axis, and what was rounded.

    Args:
        robot: revolute and prismatic joints, each a variable of its own.
        snap: lengths up to this are taken for zero [m].

    Returns:
        (sections, remarks): a remark for each twist, phase or length that had to be changed by more than rounding.

    Raises:
        RobotError: a helical or a mimic joint.
    """
    _check(robot)
    power = robot.exponent if isinstance(robot, UnitRobot) else 0
    lines = _lines(robot)
    normals = _normals(robot, lines)
    remarks: list[str] = []
    found = []
    for i, joint in enumerate(robot.joints):
        before, after = normals[i], normals[i + 1]
        z = lines[i].direction
        angle = atan2(float(np.cross(before.direction, after.direction) @ z), float(before.direction @ after.direction))
        phase = turn(angle)
        shift = 0.0
        if joint.kind is JointKind.REVOLUTE and phase.quarters is None:
            phase, shift = turn(0.0), angle
        twist = turn(0.0)
        a = Fraction(0)
        if i + 1 < len(robot.joints):
            next_z = lines[i + 1].direction
            twist = turn(atan2(float(np.cross(z, next_z) @ after.direction), float(z @ next_z)))
            a = _length(float((after.far - after.near) @ after.direction), snap, f"a{i + 1}", remarks, power)
        d = _length(float((after.near - before.far) @ z), snap, f"d{i + 1}", remarks, power)
        remarks += _rounded(phase, f"angle of slide {joint.name}") + _rounded(twist, f"twist after {joint.name}")
        found.append(Section(joint.kind, phase, shift, d, a, twist))
    return tuple(found), tuple(remarks)


def turn(angle: float) -> Turn:
    """The angle as whole quarter turns where it is that to `ALIGNED`, else by a rational tangent of its half.

    The rational differs from tan(angle / 2) by less than 1e-12.
    """
    quarters = round(angle * 2 / pi)
    error = angle - quarters * pi / 2
    if abs(error) <= ALIGNED:
        cosine, sine = ((1, 0), (0, 1), (-1, 0), (0, -1))[quarters % 4]
        return Turn(Fraction(cosine), Fraction(sine), error)
    t = Fraction(tan(angle / 2)).limit_denominator(10**6)
    c, s = (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)
    return Turn(c, s, atan2(sin(angle - _angle(c, s)), cos(angle - _angle(c, s))))


def _angle(cosine: Fraction, sine: Fraction) -> float:
    return atan2(float(sine), float(cosine))


def _rounded(given: Turn, what: str) -> list[str]:
    if abs(given.error) <= 1e-12:
        return []
    degrees = np.degrees(_angle(given.cos, given.sin))
    return [f"{what} taken as {degrees:.10g}°, {abs(given.error):.1e} rad from the one given"]


def _length(value: float, snap: float, what: str, remarks: list[str], power: int) -> Fraction:
    if 10.0**-DIGITS < abs(value) <= snap:
        remarks.append(f"length {what} = {shifted(value, power):.6g} m taken as 0")
        return Fraction(0)
    return Fraction(f"{round(value, DIGITS):.{DIGITS}f}")


def _check(robot: Robot) -> None:
    for joint in robot.joints:
        where = f"robot {robot.name!r}, joint {joint.name!r}"
        if joint.kind is JointKind.HELICAL:
            raise RobotError(
                "the conditions of a helical joint are not algebraic",
                where=where,
                allowed="revolute, prismatic",
                mend="rankdrop analyze finds its singularities numerically",
            )
        if joint.mimic is not None:
            raise RobotError(
                "exact conditions are not derived for joints that follow others",
                where=where,
                got=f"mimic of {joint.mimic.leader!r}",
                mend="rankdrop analyze finds its singularities numerically",
            )


def _lines(robot: Robot) -> list[_Line]:
    """The axes at q = 0. A slide has a direction only; its line goes where its frame stands."""
    joints = robot.joints
    on_own = all(_on(joint.frame[:3, 3], joint.screw, robot) for joint in joints if joint.kind is JointKind.REVOLUTE)
    lines = []
    for i, joint in enumerate(joints):
        if joint.kind is JointKind.REVOLUTE:
            v, w = joint.screw[:3], joint.screw[3:]
            lines.append(_Line(w, np.cross(w, v)))
        else:
            frame = joint.frame if on_own or i == 0 else joints[i - 1].frame
            lines.append(_Line(joint.screw[:3], frame[:3, 3]))
    return lines


def _on(point: Array, screw: Array, robot: Robot) -> bool:
    moment = screw[:3] - np.cross(point, screw[3:])
    return bool(np.abs(moment).max() <= ALIGNED * reach(robot))


def _normals(robot: Robot, lines: list[_Line]) -> list[_Normal]:
    """n + 1 normals: before the first axis, between consecutive ones, and after the last."""
    size = reach(robot)
    between: list[_Normal | None] = []
    for i in range(len(lines) - 1):
        between.append(_normal(lines[i], lines[i + 1], robot.joints[i].frame, between[-1] if between else None, size))
    start = between[0] if between else None
    if start is None:  # one joint alone
        z = lines[0].direction
        x = _perpendicular(z)
        end = _Normal(x, lines[0].point, lines[0].point)
        return [end, end]
    last = between[-1]
    assert last is not None
    first = _Normal(start.direction, start.near, start.near)
    final = _Normal(last.direction, last.far, last.far)
    return [first, *(one for one in between if one is not None), final]


def _normal(one: _Line, two: _Line, hint: Array, before: _Normal | None, size: float) -> _Normal:
    """Common normal of two axes; `hint` is the frame of the joint between, `before` the normal before."""
    cross = np.cross(one.direction, two.direction)
    gap = two.point - one.point
    if np.linalg.norm(cross) > ALIGNED:
        x = cross / np.linalg.norm(cross)
        near, far = _feet(one, two)
        if abs(float(gap @ x)) > ALIGNED * size:
            x = x * np.sign(float(gap @ x))
    else:
        across = gap - one.direction * float(gap @ one.direction)
        start = before.far if before is not None else one.point
        on_axis = min(_distance(hint[:3, 3], one), _distance(hint[:3, 3], two)) < ALIGNED * size
        origin = hint[:3, 3] if on_axis else start
        near = one.point + one.direction * float((origin - one.point) @ one.direction)
        far = near + across
        if np.linalg.norm(across) > ALIGNED * size:
            x = across / np.linalg.norm(across)
        else:
            x = hint[:3, 0] - one.direction * float(hint[:3, 0] @ one.direction)
            if np.linalg.norm(x) < 0.5:
                x = before.direction if before is not None else _perpendicular(one.direction)
            x = x / np.linalg.norm(x)
    if float(hint[:3, 0] @ x) < -1 + ALIGNED:
        x = -x
    return _Normal(x, near, far)


def _feet(one: _Line, two: _Line) -> tuple[Array, Array]:
    """Points of the two lines that are closest to each other."""
    a, b, gap = one.direction, two.direction, two.point - one.point
    dot = float(a @ b)
    s, t = np.linalg.solve([[1.0, -dot], [dot, -1.0]], [float(a @ gap), float(b @ gap)])
    return one.point + s * a, two.point + t * b


def _distance(point: Array, line: _Line) -> float:
    return float(np.linalg.norm(np.cross(point - line.point, line.direction)))


def _perpendicular(z: Array) -> Array:
    x = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    return np.asarray(x / np.linalg.norm(x))


def first_and_last(robot: Robot) -> tuple[Array, Array]:
    """Frames (4, 4) at q = 0, in the base: before joint 1 (z its axis, x the first normal), and at the last normal's
    foot on axis n (z that axis, x as the last normal).
    """
    lines = _lines(robot)
    normals = _normals(robot, lines)
    return _frame(normals[0].direction, lines[0], normals[0].far), _frame(
        normals[-1].direction, lines[-1], normals[-1].near
    )


def _frame(x: Array, line: _Line, origin: Array) -> Array:
    frame = np.eye(4)
    frame[:3, 0], frame[:3, 1], frame[:3, 2] = x, np.cross(line.direction, x), line.direction
    frame[:3, 3] = origin
    return frame


def decimals(values: Iterable[float]) -> list[Fraction]:
    """Numbers as rationals of `DIGITS` decimals."""
    return [Fraction(f"{x:.{DIGITS}f}") for x in values]
