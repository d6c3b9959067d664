"""The numbers that decide an arm's Jacobian, and what to know an arm by; names, limits, link frames, notes stay out.

`fingerprint` holds every bit, for a proof that must not be used for another arm; `coarse_fingerprint` finds the same
arm read from another file, where the last digits differ.
"""

from __future__ import annotations

import hashlib

import numpy as np

from rankdrop.robot.model import Array, Robot

GRID = 1e-9
"""Numbers that agree to this have one coarse fingerprint [1, m]."""


def geometry(robot: Robot, *, tip: bool = True) -> Array:
    """All numbers that decide the Jacobian: screws, then home pose, then multipliers and offsets of mimic joints.

    Without the `tip`, those that decide the rank of its six rows: another tip adds ω × r to the translation.
    """
    parts = [joint.screw for joint in robot.joints] + [robot.home.reshape(-1)] * tip
    parts += [np.array([joint.mimic.multiplier, joint.mimic.offset]) for joint in robot.joints if joint.mimic]
    return np.concatenate(parts)


def fingerprint(robot: Robot) -> str:
    """SHA-256 of kinds, mimic relations and `geometry`; 64 hex digits.

    −0.0 counts as 0.0; any other difference, even of rounding, gives another fingerprint.
    """
    numbers = (geometry(robot) + 0.0).astype("<f8")
    return hashlib.sha256(_structure(robot) + numbers.tobytes()).hexdigest()


def coarse_fingerprint(robot: Robot, *, tip: bool = True) -> str:
    """24 hex digits, equal for arms that agree to `GRID` (but for numbers on the edge of a cell); see `geometry`."""
    cells = np.rint(np.clip(geometry(robot, tip=tip), -1e9, 1e9) / GRID).astype("<i8")
    return hashlib.sha256(_structure(robot) + cells.tobytes()).hexdigest()[:24]


def _structure(robot: Robot) -> bytes:
    """The kind of every joint and the joint it follows."""
    index = {joint.name: i for i, joint in enumerate(robot.joints)}
    parts = [(str(joint.kind), index[joint.mimic.leader] if joint.mimic else -1) for joint in robot.joints]
    return repr(parts).encode()
