"""Poses between the poses of a tool path: straight for the tip, about one axis at a constant rate for its turn."""

from __future__ import annotations

import numpy as np

from rankdrop import _core
from rankdrop.local.orientation import rotation_vector
from rankdrop.robot.model import Array

_HALF_TURN = 1e-4  # a turn so near to half a turn has two shortest ways [rad]: printed poses are no sharper


def poses_between(start: Array, end: Array, share: Array) -> Array:
    """(N, 4, 4) poses at shares (N,) 0 … 1 from pose `start` to pose `end`, each (4, 4).

    The origin goes straight, the orientation turns about one axis at a constant rate, the shorter way round.
    """
    return poses_at(np.stack([start, end]), share)


def half_turns(poses: Array) -> tuple[int, ...]:
    """Numbers of the poses (P, 4, 4), from 1, that are half a turn from the next one: `poses_between` takes one of
    two ways.
    """
    turns = rotation_vector(poses[1:, :3, :3] @ np.swapaxes(poses[:-1, :3, :3], -1, -2))
    return tuple((np.flatnonzero(np.linalg.norm(turns, axis=-1) >= np.pi - _HALF_TURN) + 1).tolist())


def poses_at(poses: Array, place: Array) -> Array:
    """(N, 4, 4) poses of the tip at places (N,) of a tool path (P, 4, 4), counted from 0."""
    return _core.poses_at(np.ascontiguousarray(poses), np.ascontiguousarray(place, dtype=np.float64))
