"""Denavit and Hartenberg's numbers of a chain, in floating point, whatever its frames: what lies between its axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import asin, atan2, pi

import numpy as np

from rankdrop.robot.model import Array, Robot
from rankdrop.robot.normals import Line, Normal, axis_lines, common_normals
from rankdrop.tolerances import NOTHING


@dataclass(frozen=True, slots=True)
class Numbers:
    """One joint and the link after it.

    Attributes:
        phase: angle about the axis from the normal before to the one after, at q = 0 [rad].
        d: offset along the axis between these normals, at q = 0 [m].
        a: distance from this axis to the next one along their normal [m].
        twist: angle from this axis to the next one about their normal [rad].
        tilt: where the two count as parallel, how far the next one leans along the normal [rad]; else 0.
    """

    phase: float
    d: float
    a: float
    twist: float
    tilt: float = 0.0


def numbers_of(robot: Robot, *, angle: float, length: float) -> list[Numbers]:
    """The numbers of all joints of a robot, mimic joints too; the link after the last has no length and no twist.

    Args:
        robot: joints of any kind.
        angle: axes that are parallel to this have a normal where their frames stand [rad].
        length: axes this near meet [m].
    """
    lines = axis_lines(robot, length=length)
    return between(lines, common_normals(robot, lines, angle=angle, length=length))


def between(lines: Sequence[Line], normals: Sequence[Normal]) -> list[Numbers]:
    """The numbers of n axes with their n + 1 normals."""
    found = []
    for i, line in enumerate(lines):
        before, after, z = normals[i], normals[i + 1], line.direction
        phase = _turn(before.direction, after.direction, z)
        d = float((after.near - before.far) @ z)
        a = twist = tilt = 0.0
        if i + 1 < len(lines):
            twist = _turn(z, lines[i + 1].direction, after.direction)
            tilt = asin(max(-1.0, min(1.0, float(lines[i + 1].direction @ after.direction))))
            a = float((after.far - after.near) @ after.direction)
        found.append(Numbers(phase, d, a, twist, tilt))
    return found


def parallel_runs(numbers: Sequence[Numbers]) -> list[list[int]]:
    """Indices of axes, from 0, parted where two that follow each other are not exactly parallel."""
    runs = [[0]]
    for i, one in enumerate(numbers[:-1]):
        if parallel(one.twist):
            runs[-1].append(i + 1)
        else:
            runs.append([i + 1])
    return runs


def along(numbers: Sequence[Numbers], run: Sequence[int]) -> list[float]:
    """The offsets of axes that are parallel, all in the direction of the first [m]; only their sum moves axes."""
    sign, found = 1.0, []
    for k in run:
        found.append(sign * numbers[k].d)
        sign *= 1.0 if abs(numbers[k].twist) < 1.0 else -1.0
    return found


def parallel(twist: float) -> bool:
    """Whether a twist is that of parallel axes, whichever way they point."""
    return abs(twist - round(twist / pi) * pi) < NOTHING


def wrapped(angle: float) -> float:
    """The same angle in −π … π."""
    return (angle + pi) % (2 * pi) - pi


def _turn(one: Array, two: Array, about: Array) -> float:
    return atan2(float(np.cross(one, two) @ about), float(one @ two))
