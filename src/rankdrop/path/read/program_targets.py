"""Targets of the moves of a program, of numbers as its language writes them; checked for their range."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np

from rankdrop.path.read.program_record import Posture, Reason, Target
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.robot.files import LARGEST_ANGLE, LARGEST_LENGTH, allowed_range
from rankdrop.robot.model import Array
from rankdrop.robot.transform import from_xyz_rpy

MILLIMETRE = 1e-3


def joint_target(values: list[float], where: str, posture: Posture | None = None) -> Target:
    """Joint values as a target.

    Raises:
        TrajectoryError: one is out of range.
    """
    in_range(values, min(LARGEST_ANGLE, LARGEST_LENGTH), where, "angle")
    return Target(joints=tuple(values), posture=posture or Posture())


def angle_target(values: list[float], where: str, posture: Posture | None = None) -> Target:
    """A target of x, y, z [mm] and turns about the fixed axes x, y, z in this order [deg]: R = Rz Ry Rx.

    Raises:
        TrajectoryError: one is out of range.
    """
    in_range(values[:3], LARGEST_LENGTH, where, "length")
    in_range(values[3:], LARGEST_ANGLE, where, "angle")
    x, y, z = (MILLIMETRE * value for value in values[:3])
    roll, pitch, yaw = map(radians, values[3:])
    return Target(pose=from_xyz_rpy((x, y, z), (roll, pitch, yaw)), posture=posture or Posture())


def turned_target(place: list[float], turn: Array, where: str, posture: Posture | None = None) -> Target:
    """A target of a place [m] and a rotation (3, 3).

    Raises:
        TrajectoryError: the place is out of range.
    """
    in_range(place, LARGEST_LENGTH, where, "length")
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, place
    return Target(pose=pose, posture=posture or Posture())


def in_base(target: Target | Reason, base: Array | None) -> Target | Reason:
    """A target whose pose is in a frame (4, 4), in the base frame of the arm; without a frame its pose is not known."""
    if isinstance(target, Reason) or target.pose is None:
        return target
    if base is None:
        return Reason.BASE
    return replace(target, pose=base @ target.pose)


def in_range(values: list[float], most: float, where: str, measure: str) -> None:
    """Refuse values beyond what all readers accept.

    Raises:
        TrajectoryError: one is.
    """
    for value in values:
        if abs(value) > most:
            raise TrajectoryError("the value is too large", where=where, got=f"{value:g}",
                                  allowed=allowed_range(measure))  # fmt: skip
