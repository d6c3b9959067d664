"""A slice of joint space as a box beside the arm: where a configuration stands in it."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees

import numpy as np

from rankdrop.local.block import sampling_box
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task

EDGE = 0.9  # of the box, as a share of the arm's size
ASIDE = (0.0, 1.1, 0.1)  # its corner, as shares of the size: beside the arm, above the floor


@dataclass(frozen=True, eq=False)
class SliceBox:
    """Two or three joints along the edges of a box; two stand upright in a plane.

    Attributes:
        joints: numbers from 1, along y, z (two) or y, z, x (three).
        low, high: (d,) range of each [rad, m].
        corner: (3,) of the box [m].
        edge: [m].
    """

    joints: tuple[int, ...]
    low: Array
    high: Array
    corner: Array
    edge: float

    @classmethod
    def of(cls, robot: Robot, task: Task, joints: tuple[int, ...], size: float, *, limits: bool) -> SliceBox:
        """The box for some joints of an arm of this size [m]."""
        low, high = sampling_box(robot, task, limits=limits)
        chosen = [joint - 1 for joint in joints]
        return cls(joints, low[chosen], high[chosen], size * np.array(ASIDE), EDGE * size)

    def place(self, q: Array) -> Array:
        """(N, 3) where configurations (N, n) stand in the box [m]."""
        share = (q[:, [joint - 1 for joint in self.joints]] - self.low) / np.maximum(self.high - self.low, 1e-300)
        points = np.zeros((len(q), 3))
        points[:, [1, 2, 0][: len(self.joints)]] = share
        return np.asarray(self.corner + self.edge * points)

    def lines(self) -> Array:
        """(E, 2, 3) edges of the box, or of the square of two joints [m]."""
        spans = [(0.0, 1.0) if axis in [1, 2, 0][: len(self.joints)] else (0.0,) for axis in range(3)]
        corners = [np.array([x, y, z]) for x in spans[0] for y in spans[1] for z in spans[2]]
        edges = [[a, b] for i, a in enumerate(corners) for b in corners[i + 1 :] if np.abs(a - b).sum() == 1.0]
        return np.asarray(self.corner + self.edge * np.array(edges))

    def labels(self, robot: Robot) -> list[tuple[str, Array]]:
        """What to write where: the joints at the middles of their edges, the ends of their ranges at the corners."""
        found = []
        for axis, joint, low, high in zip([1, 2, 0], self.joints, self.low, self.high, strict=False):
            unit = robot.variables[joint - 1].unit
            way = np.eye(3)[axis] * self.edge
            aside = -0.06 * self.edge * np.eye(3)[2 if axis != 2 else 1]
            found.append((f"{joint} {robot.variables[joint - 1].name}", self.corner + 0.5 * way + 1.6 * aside))
            found.append((_value(low, unit), self.corner + 0.06 * way + aside))
            found.append((_value(high, unit), self.corner + 0.94 * way + aside))
        return found


def _value(value: float, unit: str) -> str:
    return f"{degrees(value):.0f}°" if unit == "rad" else f"{value:.3g} m"
