"""The Lie product of two screws and the motion that a screw makes, direction first as in GR.

A screw is (s; s_o): direction, and moment about a point O.
"""

from __future__ import annotations

import numpy as np

from rankdrop.local.vectors import hat
from rankdrop.robot.model import Array

NO_TURN = 1e-12
"""A direction shorter than this share of the whole screw: a slide."""


def lie_product(first: Array, second: Array) -> Array:
    """(6,) GR equation 2, direction first."""
    turn = np.cross(first[:3], second[:3])
    return np.concatenate([turn, np.cross(first[:3], second[3:]) - np.cross(second[:3], first[3:])])


def motion(screw: Array, amount: float) -> Array:
    """(6, 6) Ad(exp(amount · screw)), direction first: [[R, 0], [p̂ R, R]].

    A screw with direction s ≠ 0 turns by |s| · amount about its axis and slides along it; else it slides.
    """
    s, moment = screw[:3], screw[3:]
    size = float(np.linalg.norm(s))
    turn, shift = np.eye(3), moment * amount
    if size > NO_TURN * float(np.linalg.norm(screw)):
        axis, angle = s / size, size * amount
        turned = hat(axis)
        turn = np.eye(3) + np.sin(angle) * turned + (1.0 - np.cos(angle)) * turned @ turned
        centre = np.cross(axis, moment) / size
        shift = (np.eye(3) - turn) @ centre + axis * float(axis @ moment) * amount
    result = np.zeros((6, 6))
    result[:3, :3] = result[3:, 3:] = turn
    result[3:, :3] = hat(shift) @ turn
    return result
