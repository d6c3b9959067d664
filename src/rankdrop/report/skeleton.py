"""The arm drawn as capsules: one point on each axis, from the numbers of the joints alone."""

from __future__ import annotations

import numpy as np

from rankdrop.robot import Array, JointKind, Robot

_ALONG = 1e-9  # a point this near an axis, per length of the way, is on it


def skeleton(robot: Robot) -> tuple[Array, Array]:
    """Points to draw the arm through, at q = 0 in the base frame.

    Point i lies on axis i, nearest to point i + 1 (the last one to the tip), so that the links are the common normals
    and the pieces of the axes between them. A slide has its point where the next one is.

    Returns:
        (N, 3) points p_i, fixed on axis i; and (N, 3) where the joint itself is drawn: half way between p_{i−1} and p_i
        where that way runs along axis i, else at p_i. Both ride on link i − 1 [m].
    """
    count = len(robot.joints)
    points = np.zeros((count, 3))
    following = robot.home[:3, 3]
    for i in range(count - 1, -1, -1):
        points[i] = following = _foot(robot, i, following)
    before = np.vstack([np.zeros(3), points[:-1]])
    drawn = points.copy()
    for i, joint in enumerate(robot.joints):
        way = float(np.linalg.norm(points[i] - before[i]))
        if (
            joint.kind is not JointKind.PRISMATIC
            and np.linalg.norm(_foot(robot, i, before[i]) - before[i]) <= _ALONG + 1e-6 * way
        ):
            drawn[i] = (points[i] + before[i]) / 2
    return points, drawn


def _foot(robot: Robot, i: int, point: Array) -> Array:
    joint = robot.joints[i]
    if joint.kind is JointKind.PRISMATIC:
        return np.array(point)
    axis = joint.screw[3:]
    origin = np.cross(axis, joint.screw[:3])
    return np.asarray(origin + axis * (axis @ (point - origin)))
