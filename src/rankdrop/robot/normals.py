"""The axes of a chain at q = 0 as lines, and the common normals between consecutive ones.

Between axis i and axis i+1 runs a common normal x_i. Parallel axes have many: there it starts where the frame of the
joint stands, or where the normal before ended. Where the joints carry frames that follow either convention of Denavit
and Hartenberg, the normals are directed as theirs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop.robot.model import Array, JointKind, Robot


@dataclass(frozen=True, slots=True)
class Line:
    """An axis.

    Attributes:
        direction: (3,) of length 1.
        point: (3,) on it [m].
    """

    direction: Array
    point: Array


@dataclass(frozen=True, slots=True)
class Normal:
    """A common normal of two axes.

    Attributes:
        direction: (3,) of length 1.
        near: (3,) its foot on the axis before [m].
        far: (3,) its foot on the axis after [m].
    """

    direction: Array
    near: Array
    far: Array


def axis_lines(robot: Robot, *, length: float) -> list[Line]:
    """The axes of all joints at q = 0, in the base frame.

    A slide has a direction only; its line goes where its frame stands, or the frame before, where frames stand on the
    axis after their joint.

    Args:
        robot: joints of any kind.
        length: frames this near to an axis stand on it [m].
    """
    joints = robot.joints
    turning = [joint for joint in joints if joint.kind is not JointKind.PRISMATIC]
    on_own = all(_distance(joint.frame[:3, 3], _turning_line(joint.screw)) <= length for joint in turning)
    lines = []
    for i, joint in enumerate(joints):
        if joint.kind is not JointKind.PRISMATIC:
            lines.append(_turning_line(joint.screw))
        else:
            frame = joint.frame if on_own or i == 0 else joints[i - 1].frame
            lines.append(Line(joint.screw[:3], frame[:3, 3]))
    return lines


def common_normals(robot: Robot, lines: list[Line], *, angle: float, length: float) -> list[Normal]:
    """The n + 1 normals of n axes: before the first axis, n − 1 between consecutive ones, after the last.

    The first has no length and stands where the next one starts; the last where the one before ends.

    Args:
        robot, lines: from `axis_lines`.
        angle: axes that are parallel to this are parallel [rad].
        length: axes this near meet; frames this near to an axis stand on it [m].
    """
    between: list[Normal] = []
    for i in range(len(lines) - 1):
        before = between[-1] if between else None
        between.append(_normal(lines[i], lines[i + 1], robot.joints[i].frame, before, angle, length))
    if not between:  # one joint alone
        x = _perpendicular(lines[0].direction)
        return [Normal(x, lines[0].point, lines[0].point)] * 2
    start, last = between[0], between[-1]
    return [Normal(start.direction, start.near, start.near), *between, Normal(last.direction, last.far, last.far)]


def frame_at(x: Array, z: Array, origin: Array) -> Array:
    """(4, 4) a frame with its z axis along `z`, its x axis along the part of `x` that is perpendicular to z."""
    across = x - z * float(x @ z)
    across = across / np.linalg.norm(across)
    frame = np.eye(4)
    frame[:3, 0], frame[:3, 1], frame[:3, 2], frame[:3, 3] = across, np.cross(z, across), z, origin
    return frame


def _turning_line(screw: Array) -> Line:
    omega = screw[3:]
    return Line(omega, np.cross(omega, screw[:3]))


def _normal(one: Line, two: Line, hint: Array, before: Normal | None, angle: float, length: float) -> Normal:
    """Common normal of two axes; `hint` is the frame of the joint between, `before` the normal before."""
    cross = np.cross(one.direction, two.direction)
    if np.linalg.norm(cross) > angle:
        x = cross / np.linalg.norm(cross)
        near, far = _feet(one, two)
        if abs(float((far - near) @ x)) > length:
            x = x * np.sign(float((far - near) @ x))
    else:
        start = before.far if before is not None else one.point
        on_axis = min(_distance(hint[:3, 3], one), _distance(hint[:3, 3], two)) < length
        origin = hint[:3, 3] if on_axis else start
        near = one.point + one.direction * float((origin - one.point) @ one.direction)
        # where axis two crosses the plane: the axes are parallel to `angle` only, and part far away
        way = float((near - two.point) @ one.direction) / float(two.direction @ one.direction)
        far = two.point + two.direction * way
        across = far - near
        if np.linalg.norm(across) > length:
            x = across / np.linalg.norm(across)
        else:
            x = hint[:3, 0] - one.direction * float(hint[:3, 0] @ one.direction)
            if np.linalg.norm(x) < 0.5:
                x = before.direction if before is not None else _perpendicular(one.direction)
            x = x / np.linalg.norm(x)
    if float(hint[:3, 0] @ x) < -1 + max(angle, 1e-6):  # along the frame's, but for the way
        x = -x
    return Normal(x, near, far)


def _feet(one: Line, two: Line) -> tuple[Array, Array]:
    """Points of the two lines that are closest to each other."""
    a, b, gap = one.direction, two.direction, two.point - one.point
    dot = float(a @ b)
    s, t = np.linalg.solve([[1.0, -dot], [dot, -1.0]], [float(a @ gap), float(b @ gap)])
    return one.point + s * a, two.point + t * b


def _distance(point: Array, line: Line) -> float:
    return float(np.linalg.norm(np.cross(point - line.point, line.direction)))


def _perpendicular(z: Array) -> Array:
    x = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    return np.asarray(x / np.linalg.norm(x))
