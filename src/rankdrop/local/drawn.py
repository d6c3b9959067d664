"""Where to draw an arm: one point on each axis, from the numbers of the joints alone, and these points at q."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop._handles import check_robot
from rankdrop.kinematics import link_poses, pose
from rankdrop.robot import Array, JointKind, Robot

_ALONG = 1e-9  # a point this near an axis, per length of the way, is on it


@dataclass(frozen=True, eq=False)
class Drawn:
    """An arm at one configuration, ready to be drawn, in the base frame.

    Attributes:
        links: (P, 3) points from the base to the tip, joined by the links [m].
        middles: (N, 3) where the joints are drawn, on their axes [m].
        axes: (N, 3) unit directions of the axes.
        slides: (N,) whether a joint is prismatic.
        numbers: (N,) number of the variable that drives a joint, from 1; a mimic joint has that of its leader.
    """

    links: Array
    middles: Array
    axes: Array
    slides: tuple[bool, ...]
    numbers: tuple[int, ...]


def drawn_at(robot: Robot, q: Array) -> Drawn:
    """Where the arm is drawn at q, joint by joint on the points of `skeleton`.

    Args:
        robot: the arm.
        q: (n,) configuration [rad, m].
    """
    check_robot(robot)
    at_home, drawn = skeleton(robot)
    poses = link_poses(robot, q)
    frames = [np.eye(4), *(joint.frame for joint in robot.joints)]
    moved = [poses[i] @ np.linalg.inv(frames[i]) for i in range(len(robot.joints) + 1)]
    links, middles, axes = [np.zeros(3)], [], []
    for i, joint in enumerate(robot.joints):
        held, carried = moved[i], moved[i + 1]
        links += [_apply(held, at_home[i]), _apply(carried, at_home[i])]
        middles.append(_apply(held, drawn[i]))
        axis = joint.screw[:3] if joint.kind is JointKind.PRISMATIC else joint.screw[3:]
        axes.append(held[:3, :3] @ axis)
    links.append(pose(robot, q)[:3, 3])
    names = [joint.name for joint in robot.variables]
    return Drawn(
        np.array(links), np.array(middles), np.array(axes),
        tuple(joint.kind is JointKind.PRISMATIC for joint in robot.joints),
        tuple(names.index(joint.mimic.leader if joint.mimic else joint.name) + 1 for joint in robot.joints),
    )  # fmt: skip


def _apply(moved: Array, point: Array) -> Array:
    return np.asarray(moved[:3, :3] @ point + moved[:3, 3])


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
