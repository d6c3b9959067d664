"""Tool motions along the direction that the tool loses at a singularity, and poses moved by them."""

from __future__ import annotations

import numpy as np

from rankdrop.poses.inverse import Aim, rotation
from rankdrop.robot.model import Array

_SHARE = 1e-3  # along the lost direction of a way or a turn that is tried, at least


def moved_along(aim: Aim, poses: Array, twist: Array) -> Array:
    """(N, 4, 4) poses moved by twists (N, m) in the rows and axes of a task, lengths divided by ℓ."""
    whole = np.zeros((len(poses), 6))
    whole[:, aim.rows] = twist
    turn, here = rotation(whole[:, 3:]), poses[:, :3, :3]
    shift = aim.length * whole[:, :3]
    if aim.with_tip:
        shift = (here @ shift[:, :, None])[:, :, 0]
    out = poses.copy()
    if aim.with_tip:
        out[:, :3, :3] = here @ turn
    else:
        out[:, :3, :3] = turn @ here
    out[:, :3, 3] += shift + (here - out[:, :3, :3]) @ aim.point
    return out


def lost_motions(aim: Aim, rank: int, q: Array) -> list[Array]:
    """Tool motions (m,) of size 1: the way and the turn along the lost direction û, the larger share û·w first.

    û is the left singular vector of σ_r at q (n,). A size is a sum, |w_v| + |w_ω|: a way alone, or a turn alone, has
    the largest share. The branch goes on along w only where its shares along û before the singularity, and along û′
    after it, half a turn of two joints on, have opposite signs: û·w û′·w < 0. Where that is so for w = û, it is so for
    its way, or for its turn.
    """
    left = np.linalg.svd(aim.jacobian(q[None])[0])[0]
    lost = left[:, rank - 1]
    ways = np.array([row < 3 for row in aim.rows])
    parts = [np.where(ways, lost, 0.0), np.where(ways, 0.0, lost)]
    parts.sort(key=lambda part: -float(np.linalg.norm(part)))
    sizes = [float(np.linalg.norm(part)) for part in parts]
    return [part / size for part, size in zip(parts, sizes, strict=True) if size > _SHARE]
