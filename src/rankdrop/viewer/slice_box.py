"""The box next to the arm in which a slice of a family is drawn."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import degrees

import numpy as np

from rankdrop.local import sampling_box
from rankdrop.robot import Array, Robot
from rankdrop.task import Task

EDGE = 0.8  # of the box, as a share of the arm's size
AXES = np.array([[0.78, 0.62, 0.0], [0.0, 0.0, 1.0], [-0.62, 0.78, 0.0]]) / np.array([[0.9964], [1.0], [0.9964]])
"""Directions of the first, second, third joint: across, up and away from the camera as the viewer places it."""
CORNER = np.array([-1.3, 0.12, 0.0]) @ AXES  # left of the arm, above the floor


@dataclass(frozen=True, eq=False)
class SliceBox:
    """Two or three joints along the edges of a box; two stand upright in a plane.

    Attributes:
        joints: numbers from 1, along `AXES`.
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
        return cls(joints, low[chosen], high[chosen], size * CORNER, EDGE * size)

    def place(self, q: Array) -> Array:
        """(N, 3) where configurations (N, n) stand in the box [m]."""
        share = (q[:, [joint - 1 for joint in self.joints]] - self.low) / np.maximum(self.high - self.low, 1e-300)
        return np.asarray(self.corner + self.edge * share @ AXES[: len(self.joints)])

    def lines(self) -> Array:
        """(E, 2, 3) edges of the box, or of the square of two joints [m]."""
        corners = [np.array(corner, dtype=np.float64) for corner in product((0, 1), repeat=len(self.joints))]
        edges = [[a, b] for i, a in enumerate(corners) for b in corners[i + 1 :] if np.abs(a - b).sum() == 1.0]
        return np.asarray(self.corner + self.edge * np.array(edges) @ AXES[: len(self.joints)])

    def ends(self, robot: Robot) -> Array:
        """(N, 3) corners, and places of labels [m]."""
        return np.vstack([self.lines().reshape(-1, 3), [place for _, place in self.labels(robot)]])

    def labels(self, robot: Robot) -> list[tuple[str, Array]]:
        """What to write where: the joints at the middles of their edges, the ends of their ranges at the corners."""
        labels = []
        for number, (joint, low, high) in enumerate(zip(self.joints, self.low, self.high, strict=True)):
            unit = robot.variables[joint - 1].unit
            way = AXES[number] * self.edge
            aside = -0.09 * self.edge * AXES[0 if number == 1 else 1]
            start = self.corner + (self.edge * AXES[0] if number == 2 else 0.0)
            labels.append((f"{joint} {robot.variables[joint - 1].name}", start + 0.5 * way + 2.0 * aside))
            labels.append((_value(low, unit), start + 0.06 * way + aside))
            labels.append((_value(high, unit), start + 0.94 * way + aside))
        return labels


def _value(value: float, unit: str) -> str:
    if unit == "rad":
        return f"{degrees(value):.0f}°"
    return f"{value:.3g} m"
