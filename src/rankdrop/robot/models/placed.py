"""What every package is told of an arm: its joints one after the other, each with a point of its axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop.errors import RobotError
from rankdrop.robot.model import Array, Joint, JointKind, Robot


@dataclass(frozen=True, slots=True)
class Placed:
    """A joint with a frame on its axis, with the axes of the base at q = 0: numbers of the arm stay as they are.

    Attributes:
        joint: of the arm.
        step: (3,) from the frame of the joint before it (the base origin) to this one's [m].
        axis: (3,) unit, in the base frame.
        pitch: of a helical joint [m/rad], else 0.
        link: name for the link that it carries; all differ, and from `Robot.base` and `Robot.tip`.
    """

    joint: Joint
    step: Array
    axis: Array
    pitch: float
    link: str


def placed(robot: Robot, package: str, *, mimics: bool = False, helical: bool = False) -> tuple[list[Placed], Array]:
    """The joints of an arm for another package, and the (4, 4) pose of the tip in the frame of the last one at q = 0.

    Args:
        robot: the arm.
        package: its name, for errors.
        mimics, helical: whether it knows joints that follow others, and helical ones.

    Raises:
        RobotError: a joint of a kind that the package does not know.
    """
    taken = {robot.base, robot.tip}
    at = np.zeros(3)
    found = []
    for joint in robot.joints:
        where = f"robot {robot.name!r}, joint {joint.name!r}"
        if joint.mimic is not None and not mimics:
            raise RobotError(f"{package} is told of no joint that follows another", where=where,
                             got=f"it follows {joint.mimic.leader!r}", allowed="joints that are variables")  # fmt: skip
        if joint.kind is JointKind.HELICAL and not helical:
            raise RobotError(f"{package} has no helical joints", where=where, allowed="revolute, prismatic")
        slides = joint.kind is JointKind.PRISMATIC
        axis = joint.screw[:3] if slides else joint.screw[3:]
        pitch = float(joint.screw[:3] @ axis) if joint.kind is JointKind.HELICAL else 0.0
        point = joint.frame[:3, 3] if slides else _point(joint, axis)
        link = f"{joint.name}_link"
        while link in taken:
            link += "_"
        taken.add(link)
        found.append(Placed(joint, point - at, axis, pitch, link))
        at = point
    tip = robot.home.copy()
    tip[:3, 3] -= at
    return found, tip


def _point(joint: Joint, axis: Array) -> Array:
    """(3,) a point of the axis: where the joint's frame is, if that is on it, else the nearest to the base origin."""
    foot, origin = np.cross(axis, joint.screw[:3]), joint.frame[:3, 3]
    beside = origin - foot - axis * (axis @ (origin - foot))
    return origin if float(np.abs(beside).max()) <= 1e-15 * (1.0 + float(np.abs(origin).max())) else foot
