"""Reach: the sum of the link lengths, the characteristic length of an arm."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np

from rankdrop.robot.model import Array, JointKind, Robot

_reaches: WeakKeyDictionary[Robot, float] = WeakKeyDictionary()  # a robot never changes, and every view asks


def link_lengths(robot: Robot) -> Array:
    """Lengths ‖p_{i+1} − p_i‖ of the polygon tip → axis N → … → axis 1, p_i the point of axis i nearest to p_{i+1}.

    Each length is fixed in one link, so the result depends neither on q nor on the frames of the source. A prismatic
    joint adds its longest travel where it is limited.

    Returns:
        (N,) length from joint i to the next one [m].
    """
    point = robot.home[:3, 3].copy()
    lengths = np.zeros(len(robot.joints))
    for i in range(len(robot.joints) - 1, -1, -1):
        joint = robot.joints[i]
        if joint.kind is JointKind.PRISMATIC:
            travel = max(abs(joint.lower), abs(joint.upper))
            lengths[i] = travel if np.isfinite(travel) else 0.0
            continue
        omega = joint.screw[3:]
        foot = np.cross(omega, joint.screw[:3])  # the axis point nearest to the base origin
        nearest = foot + omega * (omega @ (point - foot))
        lengths[i] = float(np.linalg.norm(point - nearest))
        point = nearest
    return lengths


def reach(robot: Robot) -> float:
    """Sum of the link lengths from the first axis to the tip [m]; 1 for an arm without length (a bare wrist)."""
    known = _reaches.get(robot)
    if known is None:
        total = float(link_lengths(robot).sum())
        known = _reaches[robot] = total if total > 1e-9 else 1.0
    return known
