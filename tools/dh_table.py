"""A chain of revolute joints as a standard DH table, or any chain as screws, written the way a person would.

The table is read off the joint screws at q = 0: the common normal of each pair of consecutive axes is an x axis. Where
axes are parallel the normal runs through the frame before, so that the distance along them stands in one row.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, pi

import numpy as np

from rankdrop.robot.model import Array, Robot

_PARALLEL = 1e-9  # sine of the angle between axes below which they are parallel: rounding of the product of transforms
_NOTHING = 1e-9  # lengths [m] and angles [rad] below this are rounding too
_PARTS = 12  # angles are looked for among the multiples of π/12

Row = tuple[float, float, float, float]
"""(a, alpha, d, theta) [m, rad]."""


def dh_table(robot: Robot) -> tuple[Array, list[Row], Array]:
    """(base, rows, tool) of a chain of revolute joints: `from_dh(rows, convention="standard", base=…, tool=…)` is it.

    Args:
        robot: revolute joints only.

    Returns:
        (4, 4) pose of frame 0, one row per joint, (4, 4) pose of the tip in frame n.
    """
    directions = [joint.screw[3:] for joint in robot.joints]
    points = [np.cross(joint.screw[3:], joint.screw[:3]) for joint in robot.joints]
    z = directions[0]
    base = _first_frame(z, points[0])
    x, origin = base[:3, 0], base[:3, 3]
    rows: list[Row] = []
    for i in range(len(directions) - 1):
        direction, near, far = _normal(z, origin, x, directions[i + 1], points[i + 1])
        theta = _angle(x, direction, z)
        if abs(theta) > pi / 2 + _NOTHING:  # the normal has two directions: the one that turns less
            direction, theta = -direction, _angle(x, -direction, z)
        alpha = _angle(z, directions[i + 1], direction)
        rows.append((float((far - near) @ direction), alpha, float((near - origin) @ z), theta))
        x, z, origin = direction, directions[i + 1], far
    foot = origin + ((robot.home[:3, 3] - origin) @ z) * z
    tip_x = robot.home[:3, 0]
    straight = np.linalg.norm(robot.home[:3, 3] - foot) < _NOTHING and abs(abs(robot.home[:3, 2] @ z) - 1) < _PARALLEL
    theta, alpha = 0.0, 0.0
    if straight:
        theta, alpha = _angle(x, tip_x, z), (0.0 if robot.home[:3, 2] @ z > 0 else pi)
        x = tip_x
    rows.append((0.0, alpha, float((foot - origin) @ z), theta))
    last = np.eye(4)
    z_n = z if alpha == 0.0 else -z
    last[:3, 0], last[:3, 1], last[:3, 2], last[:3, 3] = x, np.cross(z_n, x), z_n, foot
    return base, rows, np.asarray(np.linalg.inv(last) @ robot.home)


def _first_frame(z: Array, point: Array) -> Array:
    """Frame 0: the base frame itself where its z axis is the first axis, else as near to it as may be."""
    foot = point - (point @ z) * z
    for x in (*np.eye(3), None):
        assert x is not None
        if abs(x @ z) < 0.9:
            break
    x = x - (x @ z) * z
    x = x / np.linalg.norm(x)
    frame = np.eye(4)
    frame[:3, 0], frame[:3, 1], frame[:3, 2], frame[:3, 3] = x, np.cross(z, x), z, foot
    return frame


def _normal(z: Array, origin: Array, x: Array, other: Array, point: Array) -> tuple[Array, Array, Array]:
    """(direction, foot on this axis, foot on the next one) of the common normal; through `origin` for parallel axes."""
    cross = np.cross(z, other)
    between = point - origin
    if np.linalg.norm(cross) < _PARALLEL:
        across = between - (between @ z) * z
        size = float(np.linalg.norm(across))
        if size < _NOTHING:  # one axis
            return x, origin, origin
        return across / size, origin, origin + across
    direction = cross / np.linalg.norm(cross)
    along, along_other, _ = np.linalg.solve(np.stack([z, -other, direction], axis=1), between)
    near, far = origin + along * z, point + along_other * other
    across = far - near
    if np.linalg.norm(across) > _NOTHING and across @ direction < 0:
        direction = -direction
    return direction, near, far


def _angle(start: Array, end: Array, about: Array) -> float:
    """The turn about a unit vector that takes one unit vector to another [rad]."""
    angle = atan2(float(np.cross(start, end) @ about), float(start @ end))
    return pi if angle < -pi + _NOTHING else angle


def angle_text(angle: float, *, degrees: bool = False) -> str:
    """A TOML value: a multiple of π/12 exactly, else with all digits that mean something.

    Example:
        >>> angle_text(1.5707963267948966), angle_text(0.3), angle_text(-2.6179938779914944)
        ('"pi/2"', '0.3', '"-5*pi/6"')
    """
    parts = round(angle * _PARTS / pi)
    if parts and abs(angle - parts * pi / _PARTS) < _NOTHING:
        factor = int(np.gcd(parts, _PARTS))
        top, bottom = parts // factor, _PARTS // factor
        word = "pi" if abs(top) == 1 else f"{abs(top)}*pi"
        return f'"{"-" if top < 0 else ""}{word}{f"/{bottom}" if bottom > 1 else ""}"'
    if degrees:
        turned = np.degrees(angle)
        if abs(turned - round(turned)) < np.degrees(_NOTHING):
            return f'"{round(turned)} deg"'
    return number_text(angle)


def number_text(value: float) -> str:
    """A number with as few decimals as say it to 1e-10, and never −0.

    Example:
        >>> number_text(0.16250000000000003), number_text(-0.0), number_text(0.1234567)
        ('0.1625', '0', '0.1234567')
    """
    for places in range(13):
        if abs(value - round(value, places)) < 1e-10:
            short = round(value, places) + 0.0
            return str(int(short)) if places == 0 else f"{short:.{places}f}"
    return f"{value:.12f}"


def pose_lines(title: str, pose: Array) -> list[str]:
    """A table [base], [tool] or [home] in TOML; no line where the pose is none."""
    xyz, (roll, pitch, yaw) = pose[:3, 3], rpy_of(pose[:3, :3])
    lines = []
    if np.abs(xyz).max() > _NOTHING:
        lines.append(f"xyz = [{', '.join(number_text(float(x)) for x in xyz)}]")
    if max(map(abs, (roll, pitch, yaw))) > _NOTHING:
        lines.append(f"rpy = [{', '.join(angle_text(x) if abs(x) > _NOTHING else '0' for x in (roll, pitch, yaw))}]")
    return [f"[{title}]", *lines, ""] if lines else []


def rpy_of(turn: Array) -> tuple[float, float, float]:
    """Roll, pitch and yaw of R = Rz(yaw) Ry(pitch) Rx(roll) [rad]; yaw 0 where only a sum of two is told."""
    across = float(np.hypot(turn[0, 0], turn[1, 0]))
    pitch = atan2(-float(turn[2, 0]), across)
    if across < _PARALLEL:
        return atan2(-float(turn[1, 2]), float(turn[1, 1])), pitch, 0.0
    return atan2(float(turn[2, 1]), float(turn[2, 2])), pitch, atan2(float(turn[1, 0]), float(turn[0, 0]))


def joint_tables(robot: Robot, keys: Sequence[Sequence[str]], limits: Sequence[Sequence[str]]) -> list[str]:
    """The [[joints]] tables: name, what places the joint, limits."""
    lines = []
    for joint, own, ends in zip(robot.joints, keys, limits, strict=True):
        lines += ["[[joints]]", f'name = "{joint.name}"', *own, *ends, ""]
    return lines
