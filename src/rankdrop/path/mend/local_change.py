"""A local change of a joint path: what bumps and detours have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rankdrop.kinematics import pose
from rankdrop.local.orientation import orientation_coordinates
from rankdrop.path.curve import Curve, Place
from rankdrop.robot.model import Array, Robot

ON_PATH = 1e-4
"""A tool that leaves its path by less is on it, lengths divided by the length scale."""


@dataclass(frozen=True, eq=False)
class LocalChange:
    """A part of a path that a local remedy changes; the rest stays as it is.

    Attributes:
        start, end: between them the joints are moved, from the old path and back to it.
        way: (n,) how far the joints are from the old path at most [rad, m].
        off: how far the tool is from the old path at most [m], [rad].
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


def tool_off(robot: Robot, q: Array, moved: Array) -> tuple[float, float]:
    """How far the tip is apart at most at pairs of configurations (N, n): [m], [rad]."""
    old, new = pose(robot, q), pose(robot, moved)
    turn = orientation_coordinates(new[:, :3, :3] @ old[:, :3, :3].swapaxes(1, 2), "rotvec")
    apart = np.linalg.norm(new[:, :3, 3] - old[:, :3, 3], axis=1)
    return float(apart.max(initial=0.0)), float(np.linalg.norm(turn, axis=1).max(initial=0.0))


def largest_move(moves: Array) -> Array:
    """(n,) of joint motions (N, n): the largest of each joint, with its sign."""
    return np.asarray(np.take_along_axis(moves, np.abs(moves).argmax(axis=0)[None], axis=0)[0])


def step(share: Array) -> tuple[Array, Array, Array]:
    """(N,) each: the quintic that goes from 0 to 1 with slope and bend zero at both ends, and its two derivatives."""
    x = np.clip(share, 0.0, 1.0)
    return x**3 * (10 - 15 * x + 6 * x * x), 30 * x**2 * (1 - x) ** 2, 60 * x * (1 - x) * (1 - 2 * x)
