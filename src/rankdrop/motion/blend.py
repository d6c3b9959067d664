"""Corners cut short: where a straight path meets a singularity around a row at which it turns.

A parabola from a point before the corner to one after it, with the corner as its control point, leaves the path in the
direction it has there and comes back in the direction it goes on in. It stays half as far in as the corner does.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rankdrop.kinematics import pose
from rankdrop.motion.curve import Curve
from rankdrop.motion.tool_path import joints_at
from rankdrop.robot.model import Array, Robot

_CORNER = np.cos(np.radians(3.0))  # directions that differ by less are one
_POINTS = 33  # of a parabola
_SIZES = 8
_LOOKS = 201


@dataclass(frozen=True, eq=False)
class Blend:
    """A path with some corners cut.

    Attributes:
        place: (K,) where each row was on the path; inside a blend, in proportion of its parameter.
        q: (K, n).
        rows: the corners cut, numbered from 1.
        radius: joint motion before and after each corner that is replaced [rad; slides divided by the scale].
        off: farthest that the tool point is from the old path [m].
    """

    place: Array
    q: Array
    rows: tuple[int, ...]
    radius: float
    off: float


def blends(robot: Robot, path: Curve, scale: Array, met: Array, most: float) -> Iterator[Blend]:
    """Paths with the corners nearest to where it meets singularities cut, less first.

    Args:
        robot: the arm.
        path: a straight curve.
        scale: (n,) of joint motions.
        met: (M,) places that have to go, stretch and share, counted from 0.
        most: how far the tool point may leave the path [m].
    """
    until = _until(path, scale)
    corners = _corners(path, scale)
    if path.degree != 1 or not len(corners) or not len(met):
        return
    at = np.interp(met, np.arange(len(until)), until)
    nearest = np.abs(until[corners][None] - at[:, None]).argmin(axis=1)
    cut = np.unique(nearest)
    least = max(float(np.abs(at[nearest == k] - until[corners[k]]).max()) for k in cut)
    ends = np.concatenate([[0.0], until[corners], until[-1:]])
    room = min(min(ends[k + 1] - ends[k], ends[k + 2] - ends[k + 1]) for k in cut)
    together = bool((np.diff(cut) == 1).any())
    room *= 0.5 if together else 1.0
    for radius in np.geomspace(max(1.05 * least, 1e-3 * room), room, _SIZES) if least < room else ():
        made = _cut(robot, path, until, corners[cut], float(radius))
        if made.off <= most:
            yield made


def _until(path: Curve, scale: Array) -> Array:
    length = np.linalg.norm(np.diff(path.control, axis=1)[:, 0] / scale, axis=1)
    return np.concatenate([[0.0], np.cumsum(length)])


def _corners(path: Curve, scale: Array) -> Array:
    """Rows, counted from 0, at which the direction changes."""
    step = np.diff(path.control, axis=1)[:, 0] / scale
    size = np.linalg.norm(step, axis=1)
    cosine = (step[1:] * step[:-1]).sum(axis=1) / np.maximum(size[1:] * size[:-1], 1e-300)
    return np.asarray(np.flatnonzero(cosine < _CORNER) + 1)


def _cut(robot: Robot, path: Curve, until: Array, corners: Array, radius: float) -> Blend:
    rows = np.arange(len(until), dtype=np.float64)
    keep = np.ones(len(rows), dtype=np.bool_)
    places, values, off = [], [], 0.0
    share = np.linspace(0.0, 1.0, _POINTS)
    for corner in corners.tolist():
        low, high = np.interp([until[corner] - radius, until[corner] + radius], until, rows)
        keep &= (rows < low) | (rows > high)
        place = low + share * (high - low)
        start, end = joints_at(path, np.array([low, high]))
        middle = joints_at(path, np.array([float(corner)]))[0]
        s = share[:, None]
        curve = (1 - s) ** 2 * start + 2 * s * (1 - s) * middle + s**2 * end
        places.append(place)
        values.append(curve)
        old = pose(robot, joints_at(path, np.linspace(low, high, _LOOKS)))[:, :3, 3]
        new = pose(robot, curve)[:, :3, 3]
        off = max(off, float(np.linalg.norm(new[:, None] - old[None], axis=2).min(axis=1).max()))
    place = np.concatenate([rows[keep], *places])
    q = np.concatenate([joints_at(path, rows[keep]), *values])
    order = np.argsort(place, kind="stable")
    return Blend(place[order], q[order], tuple(int(k) + 1 for k in corners), radius, off)
