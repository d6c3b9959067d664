"""A fingerprint of an arm's geometry: two arms with the same numbers have the same one, whatever they are called."""

from __future__ import annotations

import hashlib

import numpy as np

from rankdrop.robot.model import Robot


def fingerprint(robot: Robot) -> str:
    """SHA-256 of the numbers that decide the Jacobian: kinds, screws, mimic relations, home pose; 64 hex digits.

    Names, limits, link frames and notes do not enter. −0.0 counts as 0.0; any other difference, even of rounding,
    gives another fingerprint.
    """
    parts = hashlib.sha256()
    index = {joint.name: i for i, joint in enumerate(robot.joints)}
    for joint in robot.joints:
        parts.update(joint.kind.encode())
        parts.update((np.asarray(joint.screw) + 0.0).astype("<f8").tobytes())
        parts.update(b"." if joint.mimic is None else b"=")
        if joint.mimic is not None:
            follows = np.array([index[joint.mimic.leader], joint.mimic.multiplier, joint.mimic.offset])
            parts.update((follows + 0.0).astype("<f8").tobytes())
    parts.update((np.asarray(robot.home) + 0.0).astype("<f8").tobytes())
    return parts.hexdigest()
