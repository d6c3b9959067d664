"""The posture of an arm as engineers name it: shoulder left or right, front or back; elbow up or down; wrist flipped.

Of arms with a vertical first axis, and of SCARA. In the base frame, axis j has direction a_j; S, E are the points of
axes 2 and 3 in the plane of the arm, W the centre of the wrist: where axes 4, 5, 6 meet, else where 5 and 6 meet for
the shoulder and a point of axis 4 for the elbow.

- Shoulder: where the plane of the arm passes axis 1 at a distance, it is left or right of the line from axis 1 to
  W, seen from axis 1; else W is in front of axis 1 or behind it. Front is where axis 2 lies off axis 1; where the two
  meet, it is X of the base at q1 = 0, or Y where axis 2 is along X.
- Elbow: E is above or below the straight line from S to W; of a SCARA left or right of it.
- Wrist, where axes 4, 5, 6 meet: not flipped where joint 5 bends the tool down while joint 4 is at zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TypeVar

import numpy as np

from rankdrop.kinematics import jacobian, pose
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.model import Array, JointKind, Robot

_PARALLEL = 1e-6  # of directions of axes that count as parallel
_NEAR = 1e-6  # of the reach: lengths below it are none
_BESIDE = 3e-3  # of the reach: an arm whose plane passes so near to axis 1 passes through it
_UP = np.array([0.0, 0.0, 1.0])


class Shoulder(StrEnum):
    """Where the shoulder, or the wrist as seen from axis 1, is."""

    LEFT = "left"
    RIGHT = "right"
    FRONT = "front"
    BACK = "back"


class Elbow(StrEnum):
    """Where the elbow is, seen from the line from shoulder to wrist."""

    UP = "up"
    DOWN = "down"
    LEFT = "left"
    RIGHT = "right"


class Wrist(StrEnum):
    """Which way joint 5 bends the tool while joint 4 is at zero: down is not flipped."""

    NOT_FLIPPED = "not flipped"
    FLIPPED = "flipped"


_Part = TypeVar("_Part", Shoulder, Elbow, Wrist)


@dataclass(frozen=True)
class ArmPosture:
    """Parts of a posture; None where the arm has no such part, or the part is singular."""

    shoulder: Shoulder | None = None
    elbow: Elbow | None = None
    wrist: Wrist | None = None


@dataclass(frozen=True, eq=False)
class _ArmAxes:
    """Directions (n, 3) and points (n, 3) of the axes, the tip (3,) and its Z (3,), in the base frame."""

    directions: Array
    points: Array
    tip: Array
    approach: Array


def _axes_at(robot: Robot, q: Array) -> _ArmAxes:
    """The axes from the Jacobian of the tip: a = ω, and the foot from the tip on the axis p = tip + a × v."""
    columns, frame = jacobian(robot, q), pose(robot, q)
    tip = frame[:3, 3]
    directions = columns[3:].T
    return _ArmAxes(directions, tip + np.cross(directions, columns[:3].T), tip, frame[:3, 2])


def _of_sign(value: float, positive: _Part, negative: _Part) -> _Part:
    """The part that the sign of a number means."""
    if value > 0.0:
        return positive
    return negative


def _parallel(first: Array, second: Array) -> bool:
    return float(np.linalg.norm(np.cross(first, second))) <= _PARALLEL


def _meeting(axes: _ArmAxes, numbers: tuple[int, ...], near: float) -> Array | None:
    """(3,) the point where axes (from 1) meet; None where they do not."""
    directions = axes.directions[[number - 1 for number in numbers]]
    points = axes.points[[number - 1 for number in numbers]]
    across = np.eye(3) - directions[:, :, None] * directions[:, None, :]  # each: the part across the axis
    total = across.sum(axis=0)
    if np.linalg.cond(total) > 1.0 / _PARALLEL:
        return None
    point = np.linalg.solve(total, np.einsum("kij,kj->i", across, points))
    away = np.linalg.norm(np.einsum("kij,kj->ki", across, point - points), axis=1)
    if float(away.max()) > near:
        return None
    return np.asarray(point)


class ArmShape:
    """Which parts an arm has; they are found at one regular configuration and hold at all."""

    def __init__(self, robot: Robot) -> None:
        self.robot, self.near = robot, _NEAR * reach(robot)
        turning = [joint.kind is JointKind.REVOLUTE for joint in robot.joints]
        self.plain = robot.n == len(robot.joints) and turning[:3].count(True) >= 2 and robot.n in (4, 5, 6)
        self.scara = self.upright = self.spherical = False
        if self.plain:
            self._find_parts(turning)

    def _find_parts(self, turning: list[bool]) -> None:
        zero = _axes_at(self.robot, np.zeros(self.robot.n))
        first, second, third = zero.directions[:3]
        if not turning[0] or not _parallel(first, _UP):
            return
        self.scara = turning[1] and turning.count(False) == 1 and _parallel(first, second)
        self.upright = all(turning) and abs(float(first @ second)) <= _PARALLEL and _parallel(second, third)
        if self.upright:
            self._find_front(zero)

    def _find_front(self, zero: _ArmAxes) -> None:
        """The front, and which way joint 5 bends the tool down, from the axes at q = 0."""
        some = _axes_at(self.robot, np.linspace(0.3, 0.9, self.robot.n))
        self.spherical = self.robot.n == 6 and _meeting(some, (4, 5, 6), self.near) is not None
        second, side = zero.directions[1], zero.points[1] - zero.points[0]
        forward = np.asarray(side - (side @ _UP) * _UP - (side @ second) * second)
        if np.linalg.norm(forward) <= self.near:
            forward = np.eye(3)[int(_parallel(second, np.eye(3)[0]))]
        self.front = forward / np.linalg.norm(forward)
        self.fronted = abs(float(self.front @ second)) <= _PARALLEL
        bends = float(zero.directions[-2] @ np.cross(_UP, self.front))  # of axis 5 of six
        self.bends_down = float(np.sign(bends)) * (abs(bends) >= 1.0 - _PARALLEL)

    def posture(self, q: Array) -> ArmPosture:
        """The parts at a configuration (n,)."""
        if self.scara:
            return ArmPosture(elbow=self._side_of_elbow(_axes_at(self.robot, q)))
        if not self.upright:
            return ArmPosture()
        axes = _axes_at(self.robot, q)
        if self.spherical:
            wrist = _meeting(axes, (4, 5, 6), self.near)
        else:
            wrist = self._parallel_wrist(axes)
        if wrist is None:
            return ArmPosture()
        root: Array | None = wrist
        if not self.spherical and self.robot.n == 6:
            root = _meeting(axes, (5, 6), self.near)
        elif self.robot.n == 5:
            root = _on_roll_axis(axes, wrist)
        return ArmPosture(self._shoulder(axes, root, float(q[0])), self._elbow(axes, wrist), self._wrist(axes, wrist))

    def _parallel_wrist(self, axes: _ArmAxes) -> Array | None:
        """A point of axis 4, where it is parallel to axis 3."""
        if not _parallel(axes.directions[2], axes.directions[3]):
            return None
        return np.asarray(axes.points[3])

    def _shoulder(self, axes: _ArmAxes, root: Array | None, q1: float) -> Shoulder | None:
        """From the way of W off axis 1: along axis 2, and in the plane of the arm."""
        if root is None:
            return None
        across, way = axes.directions[1], root - axes.points[0]
        aside = float(way @ across)
        ahead = float(way @ np.cross(across, _UP))
        if abs(ahead) <= self.near:
            return None
        if abs(aside) > _BESIDE * reach(self.robot):
            # the plane of the arm is at `aside` along a2; the left of the way is z × way
            return _of_sign(aside * float(across @ np.cross(_UP, way)), Shoulder.LEFT, Shoulder.RIGHT)
        if not self.fronted:
            return None
        turn = q1 * float(axes.directions[0] @ _UP)
        front = np.cos(turn) * self.front + np.sin(turn) * np.cross(_UP, self.front)
        return _of_sign(float(way @ front), Shoulder.FRONT, Shoulder.BACK)

    def _elbow(self, axes: _ArmAxes, wrist: Array) -> Elbow | None:
        """From E off the line from S to W, in the plane of the arm."""
        across = axes.directions[1]
        line, elbow = wrist - axes.points[1], axes.points[2] - axes.points[1]
        line, elbow = line - (line @ across) * across, elbow - (elbow @ across) * across
        length = float(np.linalg.norm(line))
        if length <= self.near:
            return None
        off = elbow - (elbow @ line) / length**2 * line
        if abs(float(off @ _UP)) <= self.near:
            return None
        return _of_sign(float(off @ _UP), Elbow.UP, Elbow.DOWN)

    def _wrist(self, axes: _ArmAxes, wrist: Array) -> Wrist | None:
        """From the turn about axis 5 that takes the forearm to the tool."""
        if not self.spherical or not self.bends_down:
            return None
        forearm = _pointing(axes.directions[3], wrist - axes.points[2], self.near)
        tool = _pointing(axes.directions[5], axes.tip - wrist, self.near)
        if tool is None:  # the tip is the centre of the wrist
            tool = _pointing(axes.directions[5], axes.approach, _PARALLEL)
        if forearm is None or tool is None:
            return None
        bend = self.bends_down * float(np.cross(forearm, tool) @ axes.directions[4])
        if abs(bend) <= _PARALLEL:
            return None
        return _of_sign(bend, Wrist.NOT_FLIPPED, Wrist.FLIPPED)

    def _side_of_elbow(self, axes: _ArmAxes) -> Elbow | None:
        """Of a SCARA: axis 2 left or right of the line from axis 1 to the tip."""
        side = float(np.cross(axes.tip - axes.points[0], axes.points[1] - axes.points[0]) @ _UP)
        if abs(side) <= self.near * reach(self.robot):
            return None
        return _of_sign(side, Elbow.LEFT, Elbow.RIGHT)


def _on_roll_axis(axes: _ArmAxes, wrist: Array) -> Array | None:
    """The point of axis 4 in the plane of the arm, in which axis 5 is; None where axis 5 is in no such plane."""
    across = axes.directions[3]
    if abs(float(axes.directions[4] @ across)) > _PARALLEL:
        return None
    return np.asarray(wrist + across * float((axes.points[4] - wrist) @ across))


def _pointing(axis: Array, along: Array, near: float) -> Array | None:
    """(3,) an axis, so that it points along a way; None where the way is across it."""
    share = float(axis @ along)
    if abs(share) <= near:
        return None
    return np.asarray(axis * np.sign(share))


def arm_postures(robot: Robot, q: Array) -> tuple[ArmPosture, ...]:
    """The posture of each configuration (N, n) [rad, m], by parts of the arm; of other arms no part is known."""
    shape = ArmShape(robot)
    return tuple(shape.posture(row) for row in q)
