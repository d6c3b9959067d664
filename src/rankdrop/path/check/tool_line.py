"""Poses between the poses of a tool path: straight for the tip, about one axis at a constant rate for its turn."""

from __future__ import annotations

import numpy as np

from rankdrop.local.orientation import rotation_vector
from rankdrop.poses.inverse import rotation
from rankdrop.robot.model import Array


def between(start: Array, end: Array, share: Array) -> Array:
    """(N, 4, 4) poses at shares (N,) 0 … 1 from poses `start` to `end`, each (4, 4) or (N, 4, 4).

    The origin goes straight, the orientation turns about one axis at a constant rate, the shorter way round.
    """
    share = np.asarray(share, dtype=np.float64)
    turn = rotation_vector(end[..., :3, :3] @ np.swapaxes(start[..., :3, :3], -1, -2))
    made = np.zeros((len(share), 4, 4))
    made[:, :3, :3] = rotation(share[:, None] * turn) @ start[..., :3, :3]
    made[:, :3, 3] = start[..., :3, 3] + share[:, None] * (end[..., :3, 3] - start[..., :3, 3])
    made[:, 3, 3] = 1.0
    return made


_HALF_TURN = 1e-4  # a turn so near to half a turn has two shortest ways [rad]: printed poses are no sharper


def half_turns(poses: Array) -> tuple[int, ...]:
    """Numbers of the poses (P, 4, 4), from 1, that are half a turn from the next one: `between` takes one of two ways.
    """
    turns = rotation_vector(poses[1:, :3, :3] @ np.swapaxes(poses[:-1, :3, :3], -1, -2))
    return tuple((np.flatnonzero(np.linalg.norm(turns, axis=-1) >= np.pi - _HALF_TURN) + 1).tolist())


def poses_at(poses: Array, place: Array) -> Array:
    """(N, 4, 4) poses of the tip at places (N,) of a tool path (P, 4, 4), counted from 0."""
    k = np.clip(np.floor(place), 0, max(len(poses) - 2, 0)).astype(np.int64)
    return between(poses[k], poses[np.minimum(k + 1, len(poses) - 1)], place - k)
