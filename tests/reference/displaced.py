"""Arms whose joints stand a little elsewhere: what a tolerance of the model speaks of."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rankdrop.cover.ball import points_of


def displaced_arm(robot, turns, moves, tool=(0.0, 0.0, 0.0)):
    """An arm of which every joint stands elsewhere in the link before it.

    Args:
        robot: the arm.
        turns: (N, 3) rotation vector of each joint about its point of `points_of`, in base axes at q = 0 [rad].
        moves: (N, 3) and how far it is moved then [m].
        tool: (3,) how far the tip is moved in the last link.
    """
    carried, joints = np.eye(4), []
    for joint, point, turn, move in zip(robot.joints, points_of(robot), turns, moves, strict=True):
        own = np.eye(4)
        own[:3, :3] = _turned(turn)
        own[:3, 3] = point - own[:3, :3] @ point + move
        carried = carried @ own
        v, w = joint.screw[:3], joint.screw[3:]
        if w.any():
            axis = carried[:3, :3] @ w
            foot = carried[:3, :3] @ np.cross(w, v) + carried[:3, 3]
            screw = np.concatenate([np.cross(foot, axis) + (v @ w) * axis, axis])
        else:
            screw = np.concatenate([carried[:3, :3] @ v, w])
        joints.append(replace(joint, screw=screw, frame=carried @ joint.frame))
    home = carried @ robot.home
    home[:3, 3] += np.asarray(tool)
    return replace(robot, joints=tuple(joints), home=home)


def _turned(vector) :
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * skew + (1 - np.cos(angle)) * skew @ skew)
