"""A tool path that was given as poses, of which joint paths are made anew."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from rankdrop.local.orientation import orientation_coordinates
from rankdrop.path.check.record import PathCheck
from rankdrop.path.check.tool_line import poses_at
from rankdrop.path.curve import Curve
from rankdrop.path.mend.joint_tool_path import JointToolPath
from rankdrop.robot.model import Array

_LEAST = 1e-9  # length of a step between two poses at least


@dataclass(frozen=True, eq=False, kw_only=True)
class GivenToolPath(JointToolPath):
    """Poses between given ones straight for the tip, about one axis for its turn. There is no joint path: `q` is the
    start at each place, and lengths are those of the tool's way.

    Attributes:
        given: (P, 4, 4) of the tip.
    """

    given: Array

    @property
    def lengths(self) -> Array:
        """(K,) of the tool's way up to each place, increasing [rad; lengths divided by the length scale]."""
        return way_lengths(self.poses, self.aim.length)

    def at_places(self, place: Array) -> Self:
        """The same tool path at other places (K,), counted in poses from 0."""
        poses = self.moved[0] @ poses_at(self.given, place) @ self.moved[1]
        whole = place == np.floor(place)
        poses[whole] = self.moved[0] @ self.given[place[whole].astype(np.int64)] @ self.moved[1]
        start = np.broadcast_to(self.q[:1], (len(place), self.robot.n))
        return replace(self, place=place, q=start, poses=poses)


def given_tool_path(check: PathCheck, start: Array) -> GivenToolPath:
    """The poses of a check, from a configuration (n,) at the first one."""
    given = check.poses
    assert given is not None
    count = len(given.matrices)
    still = np.broadcast_to(start, (max(count - 1, 1), 2, len(start)))
    place = np.arange(count, dtype=np.float64)
    q = np.broadcast_to(start, (count, len(start)))
    return GivenToolPath(check.robot, given.task, Curve(still, given.times), place, q, given.matrices, True,
                         given=given.matrices)  # fmt: skip


def way_lengths(poses: Array, length_scale: float) -> Array:
    """(P,) the tool's way and turn up to each pose (P, 4, 4), increasing [rad; lengths divided by the length scale]."""
    move = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1) / length_scale
    turn = poses[1:, :3, :3] @ poses[:-1, :3, :3].swapaxes(1, 2)
    turned = np.linalg.norm(orientation_coordinates(turn, "rotvec"), axis=1)
    return np.concatenate([[0.0], np.cumsum(move + turned + _LEAST)])
