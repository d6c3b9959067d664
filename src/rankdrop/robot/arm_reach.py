"""How long an arm is: its reach, the sum of its links, whatever its pose and whatever its frames.

Each axis has one point near the arm: from the tip on, the point nearest to that of the next axis. The way along these
points has the same length in every pose. Where a frame stands far away from it, the frame is no part of the arm.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rankdrop.robot.model import Array, Joint, Robot, once
from rankdrop.robot.transform import dot, norm

FAR = 2.0
"""Frames farther from their axis's place in the arm than this times its size are no part of it."""
_NOTHING = 1e-12  # share of the coordinates that a length is made of at which it is rounding
Line = tuple[Array, Array]
"""An axis: (3,) its direction, of length 1; (3,) a point on it [m]."""
FAR_SLIDE = 10.0
"""Limits of a slide that lie farther apart than this times the reach of the links say nothing of the arm: ±1e6 m of a
mobile base, a rail of 20 m under an arm of one. The Stanford arm has 6."""


def anchors(robot: Robot) -> Array:
    """(N, 3) a point of every axis near the arm [m]: from the tip on, the one nearest to the next.

    It depends on frames where slides are: their lines go through their frames.
    """
    return _walk(robot, robot.joints)[:-1]


def _walk(robot: Robot, joints: Sequence[Joint]) -> Array:
    """(N + 1, 3) the tip last, and before it the point of each axis nearest to the next."""
    points = [robot.home[:3, 3]]
    for joint in reversed(joints):
        points.append(nearest((joint.axis, joint.foot), points[-1]))
    return np.array(points[::-1])


def extent(robot: Robot) -> float:
    """Length of the way along `anchors` to the tip [m]; 1 where it is nothing."""
    return float(_steps(_walk(robot, robot.joints)).sum()) or 1.0


def _steps(points: Array) -> Array:
    """(N,) lengths of a way from point to point; all 0 where no more than rounding is there."""
    lengths = np.array([norm(step) for step in np.diff(points, axis=0)])
    if lengths.sum() > _NOTHING * float(np.abs(points).max()):
        return lengths
    return np.zeros(len(lengths))


def astray(robot: Robot) -> list[bool]:
    """Which frames stand so far from the anchor of their axis that they are not on the arm."""
    far = FAR * extent(robot)
    pairs = zip(robot.joints, anchors(robot), strict=True)
    return [norm(joint.frame[:3, 3] - anchor) > far for joint, anchor in pairs]


def nearest(line: Line, point: Array) -> Array:
    """(3,) point of an axis nearest to a point [m]."""
    direction, start = line
    return start + direction * dot(point - start, direction)


def link_lengths(robot: Robot) -> Array:
    """Lengths ‖p_{i+1} − p_i‖ of the polygon tip → axis N → … → axis 1, p_i the point of axis i nearest to p_{i+1}.

    Each length is fixed in one link, so the result depends neither on q nor on the frames of the source. A prismatic
    joint adds its longest travel where `travel_limits` has any.

    Returns:
        (N,) length from joint i to the next one [m].
    """
    lengths = np.zeros(len(robot.joints))
    lengths[[not joint.slides for joint in robot.joints]] = _polygon(robot)
    for i, joint in enumerate(robot.joints):
        if joint.slides:
            travel = max(abs(end) for end in travel_limits(robot, joint))
            if np.isfinite(travel):
                lengths[i] = travel
            else:
                lengths[i] = 0.0
    return lengths


def travel_limits(robot: Robot, joint: Joint) -> tuple[float, float]:
    """Limits of a slide as far as they say something of the arm [m]; ±inf where there are none or too far."""
    links = float(_polygon(robot).sum())
    if links and joint.upper - joint.lower > FAR_SLIDE * links:
        if abs(joint.lower) <= FAR_SLIDE * links:
            lower = joint.lower
        else:
            lower = -np.inf
        return lower, joint.upper if abs(joint.upper) <= FAR_SLIDE * links else np.inf
    return joint.lower, joint.upper


@once
def reach(robot: Robot) -> float:
    """Sum of the link lengths from the first axis to the tip [m]; 1 for an arm without length (a bare wrist)."""
    return float(link_lengths(robot).sum()) or 1.0


@once
def _polygon(robot: Robot) -> Array:
    """`link_lengths` of the joints that turn."""
    return _steps(_walk(robot, [joint for joint in robot.joints if not joint.slides]))
