"""Poses with exact angles and tidy lengths: what a file's numbers mean where they are that but for noise."""

from __future__ import annotations

from math import atan2, pi

import numpy as np

from rankdrop.robot.model import Array
from rankdrop.robot.transform import cos_sin
from rankdrop.tolerances import NOTHING, SQUARE

STEP = pi / 12
"""Angles between parts of an arm are multiples of 15°, or nothing is known of them."""


def step_for(angle: float) -> float:
    """Angles are multiples of this to a tolerance [rad]: of 15° but for noise, of 90° where more is forgiven.

    One of 7 angles is a multiple of 15° to 1°: that would be chance.
    """
    return STEP if angle <= SQUARE else pi / 2


def exact_angle(value: float, angle: float, step: float = STEP) -> float:
    """The multiple of a step, of 15°, that is within `angle` of a value, else the value itself [rad]."""
    nearest = round(value / step) * step
    return nearest if abs(value - nearest) <= angle else value


def exact_rotation(turn: Array, angle: float) -> Array:
    """(3, 3) the rotation by a multiple of `step_for(angle)` that one is to within `angle`, else the one given.

    Rotations by quarter turns about coordinate axes, and those times one by 15°, 30° … about a coordinate axis: they
    have one entry of ±1. Every direction moves by at most `angle`.
    """
    step = step_for(angle)
    row, column = np.unravel_index(int(np.argmax(np.abs(turn))), (3, 3))
    rows, columns = [(row + k) % 3 for k in (1, 2)], [(column + k) % 3 for k in (1, 2)]
    sign = float(np.sign(turn[row, column]))
    block = turn[np.ix_(rows, columns)]
    # det(turn) = sign · det(block), so the block is a rotation or one with its last column reversed
    nearest = round(atan2(block[1, 0] - sign * block[0, 1], block[0, 0] + sign * block[1, 1]) / step)
    c, s = cos_sin(nearest * step)
    found = np.zeros((3, 3))
    found[row, column] = sign
    found[np.ix_(rows, columns)] = [[c, -sign * s], [s, sign * c]]
    return found if _apart(found, turn) <= angle else turn


def exact_direction(direction: Array, angle: float) -> Array:
    """(3,) the direction in a coordinate plane, at a multiple of `step_for(angle)`, near one; else that one."""
    step = step_for(angle)
    out = int(np.argmin(np.abs(direction)))
    i, j = (out + 1) % 3, (out + 2) % 3
    c, s = cos_sin(round(atan2(direction[j], direction[i]) / step) * step)
    found = np.zeros(3)
    found[i], found[j] = c, s
    return found if float(np.linalg.norm(found - direction)) <= angle else direction


def tidy(lengths: Array, unit: float = 1.0) -> Array:
    """Lengths that are a whole number of micrometres to a nanometre are that: 0.240000000000178 m is 0.24.

    Args:
        lengths: in any unit.
        unit: a power of 1000: a metre in it.
    """
    step = 1e6 / unit  # a whole number, or what it divides: 0.24 comes out as it is written
    whole = np.rint(lengths * step) / step
    return np.asarray(np.where(np.abs(lengths - whole) < NOTHING * unit, whole, lengths)) + 0.0


def _apart(one: Array, two: Array) -> float:
    """Angle between two rotations that are near [rad]: ‖A − B‖ = 2 √2 sin(angle / 2)."""
    return float(np.linalg.norm(one - two) / np.sqrt(2.0))
