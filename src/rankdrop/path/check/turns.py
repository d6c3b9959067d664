"""Joints that turn far within a short part of a path, as those of a wrist do when the tool passes by a singularity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop.path.curve import Curve, Place
from rankdrop.robot.model import Array, Robot

FAR = np.radians(60.0)
"""Turns that are smaller are not listed [rad]."""
_SHORT = 0.2  # share of the path within which a turn is made
_SLOW = 0.1  # share of the largest rate of a turn at which it begins and ends
_SEAM = np.radians(270.0)  # a step from which on the other way round is at most a quarter turn [rad]
_MOST = 3  # turns, the largest


@dataclass(frozen=True, eq=False)
class FarTurn:
    """A joint that turns far in one go.

    Attributes:
        joint: number from 1.
        angle: how far, with its sign [rad].
        start, end: on the path.
    """

    joint: int
    angle: float
    start: Place
    end: Place


def far_turns(robot: Robot, path: Curve) -> tuple[FarTurn, ...]:
    """The largest turns of a path, in order: each in one direction, in a fifth of the path at most.

    Args:
        robot: the arm.
        path: by time, or by the length of its joint motion where it has no times.
    """
    steps = path.control[:, -1] - path.control[:, 0]
    if path.times is None:
        lasts = np.linalg.norm(steps, axis=1) + 1e-12
    else:
        lasts = np.diff(path.times)
    clock = np.concatenate([[0.0], np.cumsum(lasts)])
    turns: list[FarTurn] = []
    for joint in np.flatnonzero([variable.unit == "rad" for variable in robot.variables]).tolist():
        rate = steps[:, joint] / lasts
        for first, last in _runs(rate, steps[:, joint]):
            first, last = _fast(rate, first, last)
            angle = float(steps[first:last, joint].sum())
            if abs(angle) >= FAR and clock[last] - clock[first] <= _SHORT * clock[-1]:
                turns.append(FarTurn(joint + 1, angle, path.place((first, 0.0)), path.place((last - 1, 1.0))))
    largest = sorted(turns, key=lambda turn: -abs(turn.angle))[:_MOST]
    return tuple(sorted(largest, key=lambda turn: turn.start))


def jump(robot: Robot, rows: Array) -> tuple[int, int, float, float] | None:
    """The largest step of a turning joint that looks like the seam of angles written within one turn; None: none.

    From 20° to 340° a joint turns by 320° as the rows say; an encoder that counts from 0° to 360° went by −40°.

    Args:
        robot: the arm.
        rows: (T, n) samples [rad, m].

    Returns:
        Number of the joint (from 1), number of the row after the step (from 1), and both angles [rad].
    """
    turning = np.array([variable.unit == "rad" for variable in robot.variables])
    if len(rows) < 2 or not turning.any():
        return None
    steps = np.where(turning, np.abs(np.diff(rows, axis=0)), 0.0)
    row, joint = np.unravel_index(int(steps.argmax()), steps.shape)
    if not _SEAM <= steps[row, joint] <= 2.0 * np.pi:
        return None
    return int(joint) + 1, int(row) + 2, float(rows[row, joint]), float(rows[row + 1, joint])


def _runs(rate: Array, steps: Array) -> list[tuple[int, int]]:
    """Runs of stretches in which a joint turns far in one direction."""
    turns = np.flatnonzero(np.diff(np.sign(rate)) != 0) + 1
    ends = np.concatenate([[0], turns, [len(rate)]])
    sums = np.add.reduceat(steps, ends[:-1])
    return [(int(ends[k]), int(ends[k + 1])) for k in np.flatnonzero(np.abs(sums) >= FAR)]


def _fast(rate: Array, first: int, last: int) -> tuple[int, int]:
    """The part of a run around its largest rate that is not much slower."""
    size = np.abs(rate[first:last])
    slow = np.flatnonzero(size < _SLOW * size.max())
    peak = int(size.argmax())
    low = slow[slow < peak].max(initial=-1) + 1
    high = slow[slow > peak].min(initial=last - first)
    return first + int(low), first + int(high)
