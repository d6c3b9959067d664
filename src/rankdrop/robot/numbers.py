"""What lies between the axes of a chain: lines, common normals, Denavit and Hartenberg's numbers, whatever its frames.

Between axis i and axis i+1 runs a common normal x_i. Parallel axes have many: there it starts where the frame of the
joint stands, or where the normal before ended; but where the arm is, if these are far off. (The feet of normals between
axes that are nearly parallel are: tables of calibrated arms have offsets of 300 m.) Where the joints carry frames that
follow either convention of Denavit and Hartenberg, the normals are directed as theirs. From the normals follow the
numbers, in floating point.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import asin, atan2, pi

import numpy as np

from rankdrop.robot.arm_reach import FAR, Line, anchors, extent, nearest
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.transform import dot, norm
from rankdrop.tolerances import NOTHING

Normal = tuple[Array, Array, Array]
"""A common normal of two axes: (3,) its direction, of length 1; (3,) its feet on the axis before and after [m]."""


def axis_lines(robot: Robot, *, length: float) -> list[Line]:
    """The axes of all joints at q = 0, in the base frame.

    A slide has a direction only; its line goes where its frame stands, or the frame before, where frames stand on the
    axis after their joint.

    Args:
        robot: joints of any kind.
        length: frames this near to an axis stand on it [m].
    """
    joints = robot.joints
    on_own = all(_distance(joint.frame[:3, 3], (joint.axis, joint.foot)) <= length for joint in joints)
    return [
        (joint.axis, joint.foot if on_own or i == 0 or not joint.slides else joints[i - 1].frame[:3, 3])
        for i, joint in enumerate(joints)
    ]


def common_normals(robot: Robot, lines: list[Line], *, angle: float, length: float) -> list[Normal]:
    """The n + 1 normals of n axes: before the first axis, n − 1 between consecutive ones, after the last.

    The first has no length and stands where the next one starts; the last where the one before ends.

    Args:
        robot, lines: from `axis_lines`.
        angle: axes that are parallel to this are parallel [rad].
        length: axes this near meet; frames this near to an axis stand on it [m].
    """
    between: list[Normal] = []
    far = FAR * extent(robot)
    near = anchors(robot)
    for i in range(len(lines) - 1):
        before = between[-1] if between else None
        place = (robot.joints[i].frame, near[i], far)
        between.append(_normal(lines[i], lines[i + 1], place, before, angle, length))
    if not between:  # one joint alone
        axis, point = lines[0]
        return [(_perpendicular(axis), point, point)] * 2
    (first, start, _), (last, _, end) = between[0], between[-1]
    return [(first, start, start), *between, (last, end, end)]


def frame_at(x: Array, z: Array, origin: Array) -> Array:
    """(4, 4) a frame with its z axis along `z`, its x axis along the part of `x` that is perpendicular to z."""
    across = x - z * dot(x, z)
    across = across / norm(across)
    frame = np.eye(4)
    frame[:3, 0], frame[:3, 1], frame[:3, 2], frame[:3, 3] = across, np.cross(z, across), z, origin
    return frame


def _normal(
    one: Line, two: Line, place: tuple[Array, Array, float], before: Normal | None, angle: float, length: float
) -> Normal:
    """Common normal of two axes; `place`: frame of the joint between, where the arm is, and what is far from there.

    `before` is the normal before.
    """
    hint, anchor, far_off = place
    (axis, point), (other, beyond) = one, two
    cross = np.cross(axis, other)
    if norm(cross) > angle:
        x = cross / norm(cross)
        near, far = feet(one, two)
        if abs(dot(far - near, x)) > length:
            x = x * np.sign(dot(far - near, x))
    else:
        if before is not None:
            start = before[2]
        else:
            start = point
        on_axis = min(_distance(hint[:3, 3], one), _distance(hint[:3, 3], two)) < length
        near = nearest(one, hint[:3, 3] if on_axis else start)
        if norm(near - anchor) > far_off:
            near = nearest(one, anchor)
        # where axis two crosses the plane: the axes are parallel to `angle` only, and part far away
        far = beyond + other * (dot(near - beyond, axis) / dot(other, axis))
        across = far - near
        if norm(across) > length:
            x = across / norm(across)
        else:
            x = hint[:3, 0] - axis * dot(hint[:3, 0], axis)
            if norm(x) < 0.5:
                if before is not None:
                    x = before[0]
                else:
                    x = _perpendicular(axis)
            x = x / norm(x)
    if dot(hint[:3, 0], x) < -1 + max(angle, 1e-6):  # along the frame's, but for the way
        x = -x
    return x, near, far


def feet(one: Line, two: Line) -> tuple[Array, Array]:
    """(3,) feet on two axes, which are not parallel, of their common normal [m]."""
    (a, start), (b, end) = one, two
    gap = end - start
    lean, along_a, along_b = dot(a, b), dot(a, gap), dot(b, gap)  # s − lean t = along_a, lean s − t = along_b
    across = np.cross(a, b)
    less = dot(across, across)  # 1 − lean², without cancelling
    s, t = (along_a - lean * along_b) / less, (lean * along_a - along_b) / less
    return start + s * a, end + t * b


def _distance(point: Array, line: Line) -> float:
    direction, start = line
    return norm(np.cross(point - start, direction))


def _perpendicular(z: Array) -> Array:
    x = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    return np.asarray(x / norm(x))


@dataclass(frozen=True, slots=True)
class LinkNumbers:
    """One joint and the link after it.

    Attributes:
        phase: angle about the axis from the normal before to the one after, at q = 0 [rad].
        d: offset along the axis between these normals, at q = 0 [m].
        a: distance from this axis to the next one along their normal [m].
        twist: angle from this axis to the next one about their normal [rad].
        tilt: where the two count as parallel, how far the next one leans along the normal [rad]; else 0.
    """

    phase: float
    d: float
    a: float
    twist: float
    tilt: float = 0.0


def numbers_of(robot: Robot, *, angle: float, length: float) -> list[LinkNumbers]:
    """The numbers of all joints of a robot, mimic joints too; the link after the last has no length and no twist.

    Args:
        robot: joints of any kind.
        angle: axes that are parallel to this have a normal where their frames stand [rad].
        length: axes this near meet [m].
    """
    lines = axis_lines(robot, length=length)
    return section_numbers(lines, common_normals(robot, lines, angle=angle, length=length))


def section_numbers(lines: Sequence[Line], normals: Sequence[Normal]) -> list[LinkNumbers]:
    """The numbers of n axes with their n + 1 normals."""
    numbers = []
    for i, line in enumerate(lines):
        (before, _, start), (after, near, far), z = normals[i], normals[i + 1], line[0]
        phase, d = _turn(before, after, z), dot(near - start, z)
        a = twist = tilt = 0.0
        if i + 1 < len(lines):
            next_z = lines[i + 1][0]
            twist, a = _turn(z, next_z, after), dot(far - near, after)
            tilt = asin(max(-1.0, min(1.0, dot(next_z, after))))
        numbers.append(LinkNumbers(phase, d, a, twist, tilt))
    return numbers


def parallel_runs(numbers: Sequence[LinkNumbers]) -> list[list[int]]:
    """Indices of axes, from 0, parted where two that follow each other are not exactly parallel."""
    runs = [[0]]
    for i, number in enumerate(numbers[:-1]):
        if parallel(number.twist):
            runs[-1].append(i + 1)
        else:
            runs.append([i + 1])
    return runs


def offsets_along(numbers: Sequence[LinkNumbers], run: Sequence[int]) -> list[float]:
    """The offsets of axes that are parallel, all in the direction of the first [m]; only their sum moves axes."""
    sign, values = 1.0, []
    for k in run:
        values.append(sign * numbers[k].d)
        if abs(numbers[k].twist) < 1.0:
            sign *= 1.0
        else:
            sign *= -1.0
    return values


def parallel(twist: float) -> bool:
    """Whether a twist is that of parallel axes, whichever way they point."""
    return abs(twist - round(twist / pi) * pi) < NOTHING


def wrap_angle(angle: float) -> float:
    """The same angle in −π … π."""
    return (angle + pi) % (2 * pi) - pi


def _turn(one: Array, two: Array, about: Array) -> float:
    return atan2(dot(np.cross(one, two), about), dot(one, two))
