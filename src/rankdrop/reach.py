"""Reach: the sum of the link lengths, the characteristic length of an arm."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np

from rankdrop.robot.model import Array, Joint, JointKind, Robot
from rankdrop.robot.transform import dot, norm

FAR = 10.0
"""Limits of a slide that lie farther apart than this times the reach of the links say nothing of the arm: ±1e6 m of a
mobile base, a rail of 20 m under an arm of one. The Stanford arm has 6."""
_NOTHING = 1e-12  # share of the coordinates that a length is made of at which it is rounding

_reaches: WeakKeyDictionary[Robot, float] = WeakKeyDictionary()  # a robot never changes, and every view asks
_links: WeakKeyDictionary[Robot, float] = WeakKeyDictionary()


def link_lengths(robot: Robot) -> Array:
    """Lengths ‖p_{i+1} − p_i‖ of the polygon tip → axis N → … → axis 1, p_i the point of axis i nearest to p_{i+1}.

    Each length is fixed in one link, so the result depends neither on q nor on the frames of the source. A prismatic
    joint adds its longest travel where `travel_limits` has any.

    Returns:
        (N,) length from joint i to the next one [m].
    """
    lengths = _polygon(robot)
    for i, joint in enumerate(robot.joints):
        if joint.kind is JointKind.PRISMATIC:
            travel = max(abs(end) for end in travel_limits(robot, joint))
            lengths[i] = travel if np.isfinite(travel) else 0.0
    return lengths


def travel_limits(robot: Robot, joint: Joint) -> tuple[float, float]:
    """Limits of a slide as far as they say something of the arm [m]; ±inf where there are none, or they are `FAR`."""
    links = _links_reach(robot)
    if links and joint.upper - joint.lower > FAR * links:
        lower = joint.lower if abs(joint.lower) <= FAR * links else -np.inf
        return lower, joint.upper if abs(joint.upper) <= FAR * links else np.inf
    return joint.lower, joint.upper


def reach(robot: Robot) -> float:
    """Sum of the link lengths from the first axis to the tip [m]; 1 for an arm without length (a bare wrist)."""
    known = _reaches.get(robot)
    if known is None:
        total = float(link_lengths(robot).sum())
        known = _reaches[robot] = total if total > 0.0 else 1.0
    return known


def _links_reach(robot: Robot) -> float:
    """Sum of the link lengths without the travel of slides [m]; 0 where they are nothing."""
    known = _links.get(robot)
    if known is None:
        known = _links[robot] = float(_polygon(robot).sum())
    return known


def _polygon(robot: Robot) -> Array:
    """`link_lengths` without the travel of slides; all 0 where no more than rounding is there."""
    point = robot.home[:3, 3].copy()
    lengths = np.zeros(len(robot.joints))
    size = float(np.abs(point).max())
    for i in range(len(robot.joints) - 1, -1, -1):
        joint = robot.joints[i]
        if joint.kind is JointKind.PRISMATIC:
            continue
        omega = joint.screw[3:]
        foot = np.cross(omega, joint.screw[:3])  # the axis point nearest to the base origin
        nearest = foot + omega * dot(omega, point - foot)
        lengths[i] = norm(point - nearest)
        point = nearest
        size = max(size, float(np.abs(point).max()))
    return lengths if lengths.sum() > _NOTHING * size else np.zeros(len(lengths))
