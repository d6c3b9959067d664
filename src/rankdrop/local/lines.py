"""The arm as lines in space at one configuration, mimic joints too, and what two of the lines have in common.

`scene` asks the same of many configurations at once, about the variables.
"""

from __future__ import annotations

import numpy as np

from rankdrop.frames import SPACE
from rankdrop.kinematics import jacobian
from rankdrop.local.unlocked import unlocked
from rankdrop.local.vectors import cross
from rankdrop.reach import reach
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.tolerances import ALIGNED


class Lines:
    """Axes and slides of every joint, mimic joints too, at one configuration."""

    def __init__(self, robot: Robot, q: Array, tolerance: float = ALIGNED) -> None:
        """Directions z (N, 3), points p (N, 3), pitches h (N,) [m/rad] in the base frame."""
        free, values, _ = unlocked(robot, q)
        screws = jacobian(free, values, SPACE).T
        self.tolerance, self.length = tolerance, reach(robot)
        self.slides = [i for i, joint in enumerate(free.joints) if joint.kind is JointKind.PRISMATIC]
        self.turns = [i for i in range(free.n) if i not in self.slides]
        self.z = np.where(np.isin(np.arange(free.n), self.slides)[:, None], screws[:, :3], screws[:, 3:])
        self.p = cross(screws[:, 3:], screws[:, :3])
        self.h = np.einsum("ni,ni->n", screws[:, :3], screws[:, 3:])
        self.cross = np.linalg.norm(cross(self.z[:, None], self.z[None, :]), axis=-1)
        self.dot = np.abs(self.z @ self.z.T)
        offset = cross(self.p[None, :] - self.p[:, None], self.z[:, None]) / self.length
        self.line = (np.linalg.norm(offset, axis=-1) < tolerance) & (self.cross < tolerance)

    def parallel(self, i: int, j: int) -> bool:
        """|z_i × z_j| = 0."""
        return bool(self.cross[i, j] < self.tolerance)

    def normal(self, i: int, j: int) -> bool:
        """z_i · z_j = 0."""
        return bool(self.dot[i, j] < self.tolerance)

    def through(self, point: Array) -> list[bool]:
        """Of every joint: (point − p_i) × z_i = 0."""
        offset = cross(point - self.p, self.z) / self.length
        near: list[bool] = (np.linalg.norm(offset, axis=-1) < self.tolerance).tolist()
        return near

    def one_line(self, i: int, j: int) -> bool:
        """Parallel, and p_j on axis i."""
        return bool(self.line[i, j])

    def one_pitch(self, i: int, j: int) -> bool:
        """h_i = h_j."""
        return bool(abs(self.h[i] - self.h[j]) < self.tolerance * self.length)

    def meeting_point(self, i: int, j: int) -> Array | None:
        """The point of two axes that meet and are not parallel: p_i + s z_i, s from (p_j − p_i) × z_j = s z_i × z_j."""
        if self.parallel(i, j):
            return None
        skew, apart = cross(self.z[i], self.z[j]), self.p[j] - self.p[i]
        if abs(float(apart @ skew)) > self.tolerance * self.length:  # at least their distance · |z_i × z_j|
            return None
        s = float(cross(apart, self.z[j]) @ skew) / float(skew @ skew)
        point = np.asarray(self.p[i] + s * self.z[i])
        return point if self.through(point)[j] else None
