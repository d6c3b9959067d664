"""The axes of a chain at q = 0 as lines, and the common normals between consecutive ones.

Between axis i and axis i+1 runs a common normal x_i. Parallel axes have many: there it starts where the frame of the
joint stands, or where the normal before ended; but where the arm is, if these are far off. (The feet of normals between
axes that are nearly parallel are: tables of calibrated arms have offsets of 300 m.) Where the joints carry frames that
follow either convention of Denavit and Hartenberg, the normals are directed as theirs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop.robot.model import Array, JointKind, Robot

FAR = 2.0
"""Frames farther from their axis's place in the arm than this times its size are no part of it."""
_NOTHING = 1e-12  # share of the coordinates at which a length is rounding


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


def anchors(robot: Robot) -> Array:
    """(N, 3) a point of every axis near the arm [m]: from the tip on, the one nearest to the next.

    It depends on frames where slides are: their lines go through their frames.
    """
    point = np.array(robot.home[:3, 3])
    found = np.zeros((len(robot.joints), 3))
    for i, joint in reversed(list(enumerate(robot.joints))):
        slides = joint.kind is JointKind.PRISMATIC
        point = _nearest(Line(joint.screw[:3], joint.frame[:3, 3]) if slides else _turning_line(joint.screw), point)
        found[i] = point
    return found


def extent(robot: Robot) -> float:
    """Length of the way along `anchors` to the tip [m]; 1 where it is nothing."""
    points = np.vstack([anchors(robot), robot.home[:3, 3]])
    total = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    return total if total > _NOTHING * float(np.abs(points).max()) else 1.0


def astray(robot: Robot) -> list[bool]:
    """Which frames stand so far from the anchor of their axis that they are not on the arm."""
    far = FAR * extent(robot)
    pairs = zip(robot.joints, anchors(robot), strict=True)
    return [float(np.linalg.norm(joint.frame[:3, 3] - anchor)) > far for joint, anchor in pairs]


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
    far = FAR * extent(robot)
    near = anchors(robot)
    for i in range(len(lines) - 1):
        before = between[-1] if between else None
        place = (robot.joints[i].frame, near[i], far)
        between.append(_normal(lines[i], lines[i + 1], place, before, angle, length))
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


def _normal(
    one: Line, two: Line, place: tuple[Array, Array, float], before: Normal | None, angle: float, length: float
) -> Normal:
    """Common normal of two axes; `place`: frame of the joint between, where the arm is, and what is far from there.

    `before` is the normal before.
    """
    hint, anchor, far_off = place
    cross = np.cross(one.direction, two.direction)
    if np.linalg.norm(cross) > angle:
        x = cross / np.linalg.norm(cross)
        near, far = _feet(one, two)
        if abs(float((far - near) @ x)) > length:
            x = x * np.sign(float((far - near) @ x))
    else:
        start = before.far if before is not None else one.point
        on_axis = min(_distance(hint[:3, 3], one), _distance(hint[:3, 3], two)) < length
        near = _nearest(one, hint[:3, 3] if on_axis else start)
        if np.linalg.norm(near - anchor) > far_off:
            near = _nearest(one, anchor)
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


def _nearest(line: Line, point: Array) -> Array:
    """The point of a line that is nearest to a point."""
    return line.point + line.direction * float((point - line.point) @ line.direction)


def _distance(point: Array, line: Line) -> float:
    return float(np.linalg.norm(np.cross(point - line.point, line.direction)))


def _perpendicular(z: Array) -> Array:
    x = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    return np.asarray(x / np.linalg.norm(x))
