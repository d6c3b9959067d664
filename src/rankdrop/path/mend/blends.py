"""A corner of a joint path cut short, where a straight path reaches a singularity around a row at which it turns.

A parabola from a point before the corner to one after it, with the corner as its control point, leaves the path in the
direction it has there and comes back in the direction it goes on in. It stays half as far in as the corner does.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rankdrop.kinematics import pose
from rankdrop.local.block import joint_scale
from rankdrop.path.check.record import FREE, PathCheck, Stretch
from rankdrop.path.curve import Curve
from rankdrop.path.mend.joint_tool_path import tool_path
from rankdrop.path.mend.record import Proposal
from rankdrop.robot.model import Array, Robot

_CORNER = np.cos(np.radians(3.0))  # directions that differ by less are one
_POINTS = 33  # of a parabola
_SIZES = 8
_LOOKS = 201


def blends(check: PathCheck, most: float) -> Iterator[Proposal]:
    """Paths with the corners nearest to where it reaches singularities cut, less first, the tool within `most` [m]."""
    robot, path = check.robot, check.curve
    near = _stretches_to_mend(check)
    steps = np.diff(path.control, axis=1)[:, 0] / joint_scale(robot, check.task)
    size = np.linalg.norm(steps, axis=1)
    cosine = (steps[1:] * steps[:-1]).sum(axis=1) / np.maximum(size[1:] * size[:-1], 1e-300)
    corners = np.flatnonzero(cosine < _CORNER) + 1  # rows at which the direction changes, from 0
    if path.degree != 1 or not near or not len(corners):
        return
    until = np.concatenate([[0.0], np.cumsum(size)])
    at = np.interp([stretch.closest.place.position - 1.0 for stretch in near], np.arange(len(until)), until)
    away = np.abs(until[corners][None] - at[:, None])
    cut, least = np.unique(away.argmin(axis=1)), float(away.min(axis=1).max())
    room = largest_radius(until, corners, cut)
    if not least < room:
        return
    how = "blend" if len(cut) == 1 else "blends"
    rows = ", ".join(str(int(corner) + 1) for corner in corners[cut])
    tool = tool_path(robot, check.task, path)
    for radius in np.geomspace(max(1.05 * least, 1e-3 * room), room, _SIZES):
        place, q, off = cut_corners(robot, path, until, corners[cut], float(radius))
        if off <= most:
            parameters = ("radius", float(radius), "rad"), ("tool off", off, "m")
            trajectory = replace(tool, place=place).trajectory(q, "linear")
            yield Proposal((how, rows), parameters, trajectory, (off, np.nan))


def _stretches_to_mend(check: PathCheck) -> list[Stretch]:
    """The stretches that are not free; where all are, those that come nearer to a singularity than is asked."""
    bad = [stretch for stretch in check.stretches if stretch.verdict != FREE]
    return bad or [stretch for stretch in check.stretches if stretch.closest.distance < check.options.min_distance]


def largest_radius(until: Array, corners: NDArray[np.intp], cut: NDArray[np.intp]) -> float:
    """The largest radius by which corners can be cut: to the next corner, half way where that one is cut as well.

    Args:
        until: (rows,) length of the path up to each row.
        corners: rows at which the direction changes.
        cut: which of the corners.
    """
    ends = np.concatenate([[0.0], until[corners], until[-1:]])
    room: float = min(min(ends[k + 1] - ends[k], ends[k + 2] - ends[k + 1]) for k in cut)
    if (np.diff(cut) == 1).any():
        return 0.5 * room
    return room


def cut_corners(robot: Robot, path: Curve, until: Array, corners: Array, radius: float) -> tuple[Array, Array, float]:
    """Places and rows of a path with corners cut, and how far the tool point is from the old path at most [m]."""
    def joints_at(place: Array) -> Array:
        return path.at(*path.split(place))

    rows = np.arange(len(until), dtype=np.float64)
    keep = np.ones(len(rows), dtype=np.bool_)
    places, values, off = [], [], 0.0
    share = np.linspace(0.0, 1.0, _POINTS)
    for corner in corners.tolist():
        low, high = np.interp([until[corner] - radius, until[corner] + radius], until, rows)
        keep &= (rows < low) | (rows > high)
        start, middle, end = joints_at(np.array([low, float(corner), high]))
        s = share[:, None]
        curve = (1 - s) ** 2 * start + 2 * s * (1 - s) * middle + s**2 * end
        places.append(low + share * (high - low))
        values.append(curve)
        old = pose(robot, joints_at(np.linspace(low, high, _LOOKS)))[:, :3, 3]
        new = pose(robot, curve)[:, :3, 3]
        off = max(off, float(np.linalg.norm(new[:, None] - old[None], axis=2).min(axis=1).max()))
    place = np.concatenate([rows[keep], *places])
    order = np.argsort(place, kind="stable")
    return place[order], np.concatenate([joints_at(rows[keep]), *values])[order], off
