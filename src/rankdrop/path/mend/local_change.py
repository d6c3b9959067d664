"""A local change of a joint path: what bumps and detours have in common."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import asin, nan

import numpy as np

from rankdrop.kinematics import pose
from rankdrop.path.curve import Curve, Place
from rankdrop.poses.inverse import Aim
from rankdrop.robot.model import Array, Robot

ON_PATH = 1e-4
"""A tool that leaves its path by less is on it, lengths divided by the length scale."""


@dataclass(frozen=True, eq=False)
class LocalChange:
    """A part of a path that a local remedy changes; the rest stays as it is.

    Attributes:
        start, end: between them the joints are moved, from the old path and back to it.
        way: (n,) how far the joints are from the old path at most [rad, m].
        off: how far the tool is from the old path at most [m], [rad]; nan for what the task leaves free.
        at_end: (n,) how far the joints are from the old path at its end: zero where they are back on it; else the rest
            is on another branch of the inverse kinematics.
        longer: how much longer it takes in a new time [s].
    """

    start: Place
    end: Place
    way: Array
    off: tuple[float, float]
    at_end: Array
    longer: float = 0.0


@dataclass(frozen=True, eq=False)
class RowsBefore:
    """Rows of a changed path as rows of the path before: outside its changes they are the same rows.

    Attributes:
        after, before: (A,) rows that are the same, from 0, in the changed path and in the one before.
    """

    after: Array
    before: Array

    @classmethod
    def of(cls, original: Curve, changed: Curve, changes: Sequence[LocalChange]) -> RowsBefore:
        """By the last row before each change and the first one after it; changes are in order."""
        rows, others = original.samples, changed.samples
        after, before = [0], [0]
        added = 0
        for change in changes:
            last_same = int(np.floor(change.start.position - 1.0))
            next_same = min(int(np.ceil(change.end.position - 1.0)), len(rows) - 1)
            same = (others[last_same + added :] == rows[next_same]).all(axis=1)
            before += [last_same, next_same]
            after.append(last_same + added)
            after.append(last_same + added + int(same.argmax()))
            added = after[-1] - next_same
        return cls(np.array([*after, len(others) - 1]), np.array([*before, len(rows) - 1]))

    def place(self, place: Place) -> Place:
        """A place of the changed path as one of the path before."""
        position = float(np.interp(place.position - 1.0, self.after, self.before))
        row = int(position)
        return Place(row + 1, position - row, place.time)


def tool_off(robot: Robot, q: Array, moved: Array, aim: Aim | None = None) -> tuple[float, float]:
    """How far the tip is apart at most at pairs of configurations (N, n), as `poses_off`: [m], [rad]."""
    return poses_off(pose(robot, q), pose(robot, moved), aim)


def poses_off(old: Array, new: Array, aim: Aim | None = None) -> tuple[float, float]:
    """How far poses of the tip are apart at most.

    Args:
        old, new: (N, 4, 4) in pairs.
        aim: of a task: only what it holds counts, so that no turning about the axis of a welding gun does. None: all.

    Returns:
        Distance [m] and angle [rad]; nan for what the task leaves free.
    """
    if aim is None:
        rows = [*range(6)]
        away = np.linalg.norm(new[:, :3, 3] - old[:, :3, 3], axis=1)
        chord = np.linalg.norm(new[:, :3, :3] - old[:, :3, :3], axis=(1, 2)) / np.sqrt(2.0)
    else:
        rows = aim.rows
        away, chord = aim.missing_between(old, new)
    farthest, turned = nan, nan
    if min(rows) < 3:
        farthest = float(away.max(initial=0.0))
    if max(rows) >= 3:
        turned = 2.0 * asin(min(1.0, float(chord.max(initial=0.0)) / 2.0))
    return farthest, turned


def largest_off(offs: Iterable[tuple[float, float]]) -> tuple[float, float]:
    """The largest distance and the largest angle of several, nan where all are."""
    farthest, turned = np.fmax.reduce(np.array([*offs]), axis=0).tolist()
    return farthest, turned


def size_of_off(off: tuple[float, float], length: float) -> float:
    """A deviation as one number, its distance divided by a length; what the task leaves free is none."""
    away, turned = np.nan_to_num(off).tolist()
    return float(away / length + turned)


def largest_move(moves: Array) -> Array:
    """(n,) of joint motions (N, n): the largest of each joint, with its sign."""
    return np.asarray(np.take_along_axis(moves, np.abs(moves).argmax(axis=0)[None], axis=0)[0])


def step(share: Array) -> tuple[Array, Array, Array]:
    """(N,) each: the quintic that goes from 0 to 1 with slope and bend zero at both ends, and its two derivatives."""
    x = np.clip(share, 0.0, 1.0)
    return x**3 * (10 - 15 * x + 6 * x * x), 30 * x**2 * (1 - x) ** 2, 60 * x * (1 - x) * (1 - 2 * x)
