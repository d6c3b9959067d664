"""Parameters as a calibration leaves them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from reference.kinematics import exponential

from rankdrop.robot.model import Array, Robot

ANGLE, LENGTH = 1e-5, 1e-6


def small(rng: np.random.Generator, angle: float, length: float) -> Array:
    """(4, 4) a turn and a shift, each of a random direction and this size."""
    turn, shift = rng.normal(size=(2, 3))
    found = exponential(np.concatenate([np.zeros(3), turn / np.linalg.norm(turn)]), angle)
    found[:3, 3] = length * shift / np.linalg.norm(shift)
    return found


def noisy(arm: Robot, rng: np.random.Generator, angle: float = ANGLE, length: float = LENGTH) -> Robot:
    """The arm with noise on the pose of every link in the one before; an axis goes with the frame it stands on."""
    moved = np.eye(4)  # from the true place of the link before to where noise has brought it
    joints = []
    for entry in arm.joints:
        carried = moved
        moved = moved @ entry.frame @ small(rng, angle, length) @ np.linalg.inv(entry.frame)
        frame = moved if stands(entry.screw, entry.frame) else carried
        joints.append(replace(entry, screw=carried_screw(frame, entry.screw), frame=moved @ entry.frame))
    return replace(arm, joints=tuple(joints), home=moved @ arm.home)


def stands(screw: Array, frame: Array) -> bool:
    return bool(np.linalg.norm(screw[:3] - np.cross(frame[:3, 3], screw[3:])) < 1e-9)


def carried_screw(transform: Array, screw: Array) -> Array:
    turn, shift = transform[:3, :3], transform[:3, 3]
    omega = turn @ screw[3:]
    return np.concatenate([turn @ screw[:3] + np.cross(shift, omega), omega])
