"""Poses as makers of robots write them: which numbers turn the tool, in which order, and in which units.

- Universal Robots: x, y, z, rx, ry, rz; m and rad. The rotation vector r: axis r/|r|, angle |r|.
- KUKA: X, Y, Z, A, B, C; mm and degrees. R = Rz(A) Ry(B) Rx(C).
- FANUC: X, Y, Z, W, P, R; mm and degrees. R = Rz(R) Ry(P) Rx(W); Z counts from the height of axis 2.
- ABB: x, y, z, q1, q2, q3, q4; mm. A unit quaternion, q1 its real part.
- Doosan: posx(x, y, z, A, B, C); mm and degrees. R = Rz(A) Ry(B) Rz(C).

A unit that is not stated is that of the maker where the numbers confirm it; else it is in doubt.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Literal

import numpy as np

from rankdrop.robot.model import Array, Robot

QUATERNION, ANGLES = ("qx", "qy", "qz", "qw"), ("roll", "pitch", "yaw")
"""Names of what turns, as they are read from every file."""
ROTATION_VECTOR, KUKA, FANUC, ABB = ("rx", "ry", "rz"), ("a", "b", "c"), ("w", "p", "r"), ("q1", "q2", "q3", "q4")
"""… and as makers name them."""
EULER_ZYZ = ("zyz A", "zyz B", "zyz C")
"""A, B, C of posx; no file has columns of these names."""
LARGEST_ARM = 10.0
"""No tip of an arm is farther from its base than so many metres, none nearer to it than so many millimetres."""
WHOLE_TURN = 2.0 * pi
"""Angles up to it may be radians; a rotation vector is no longer."""
_DIGITS = 1e-3  # of a rotation vector of a whole turn [rad]
_UPRIGHT = 1e-6  # of directions of axes that count as parallel, and of lengths [m]


@dataclass(frozen=True)
class Writing:
    """How a maker writes poses.

    Attributes:
        maker: its name.
        turn: names of the numbers that turn the tool.
        length, angle: the units of the maker; "" where a quaternion turns.
    """

    maker: str
    turn: tuple[str, ...]
    length: Literal["m", "mm"]
    angle: Literal["rad", "deg", ""]

    @property
    def measure(self) -> str:
        """Of what turns: angles, or numbers of a quaternion."""
        return {"": "number"}.get(self.angle, "angle")

    def unit_of(self, measure: str, largest: float) -> str:
        """The unit of lengths or angles up to a value, where none is stated; "": in doubt.

        Args:
            measure: "length" or "angle".
            largest: length or angle; of rotation vectors their length.
        """
        if measure == "length":
            return self._unit_of_lengths(largest)
        return self._unit_of_angles(largest)

    def _unit_of_lengths(self, largest: float) -> str:
        millimetres = largest > LARGEST_ARM
        if largest == 0.0 or millimetres == (self.length == "mm"):
            return self.length
        return ""

    def _unit_of_angles(self, largest: float) -> str:
        if largest == 0.0 or (largest > WHOLE_TURN + _DIGITS) == (self.angle == "deg"):
            return self.angle
        return ""


WRITINGS = (
    Writing("Universal Robots", ROTATION_VECTOR, "m", "rad"),
    Writing("KUKA", KUKA, "mm", "deg"),
    Writing("FANUC", FANUC, "mm", "deg"),
    Writing("ABB", ABB, "mm", ""),
    Writing("Doosan", EULER_ZYZ, "mm", "deg"),
)
"""Of all makers that are read."""


def writing_of(names: set[str]) -> Writing | None:
    """The maker's form that names of columns or numbers say; None where they say none, or joints q5 … follow."""
    if names & {*QUATERNION, *ANGLES} or not names >= {"x", "y", "z"}:
        return None
    found = next((writing for writing in WRITINGS if names >= set(writing.turn)), None)
    if found is not None and found.turn == ABB and "q5" in names:
        return None
    return found


def sizes_of(keys: tuple[str, ...], values: Array) -> Array:
    """(N,) the largest of the numbers (N, k) with these names; of rotation vectors their length."""
    if keys == ROTATION_VECTOR:
        return np.asarray(np.linalg.norm(values, axis=1))
    return np.asarray(np.abs(values).max(axis=1))


def common_turns(turn: tuple[str, ...], values: Array) -> tuple[tuple[str, ...], Array]:
    """Roll, pitch, yaw or quaternions x, y, z, w, with their names, of what turns, (N, k) [rad]."""
    if turn == KUKA:
        return ANGLES, values[:, ::-1]
    if turn == FANUC:
        return ANGLES, values
    if turn == ABB:
        return QUATERNION, values[:, [1, 2, 3, 0]]
    if turn == ROTATION_VECTOR:
        half = np.linalg.norm(values, axis=1, keepdims=True) / 2.0  # q = (r/|r| sin |r|/2, cos |r|/2)
        return QUATERNION, np.hstack([values / 2.0 * np.sinc(half / pi), np.cos(half)])
    if turn == EULER_ZYZ:
        a, b, c = values.T
        tilted, upright = np.sin(b / 2.0), np.cos(b / 2.0)
        sums, differences = (c + a) / 2.0, (c - a) / 2.0
        return QUATERNION, np.column_stack([tilted * np.sin(differences), tilted * np.cos(differences),
                                            upright * np.sin(sums), upright * np.cos(sums)])  # fmt: skip
    return turn, values


def makers_turn(turn: tuple[str, ...], values: Array, near: Array) -> Array:
    """What turns as a maker names it, of what `common_turns` makes of it; of both rotation vectors that nearer to
    another.
    """
    if turn == KUKA:
        return values[::-1]
    if turn == ABB:
        return values[[3, 0, 1, 2]]
    if turn == ROTATION_VECTOR:
        size = float(np.linalg.norm(values[:3]))
        if size == 0.0:
            return np.zeros(3)
        axis, angle = values[:3] / size, 2.0 * float(np.arctan2(size, values[3]))
        both = axis * np.array([[angle], [angle - WHOLE_TURN]])
        return np.asarray(both[np.linalg.norm(both - near, axis=1).argmin()])
    return values


def raised_by(turn: tuple[str, ...], robot: Robot | None) -> float:
    """Height of the maker's frame above the base of the arm [m]: FANUC's is at the height of axis 2."""
    if turn == FANUC and robot is not None:
        return shoulder_height(robot)
    return 0.0


def shoulder_height(robot: Robot) -> float:
    """Height of axis 2 above the base [m], where axis 1 is the vertical axis of the base and axis 2 is horizontal."""
    if len(robot.joints) < 2:
        return 0.0
    first, second = robot.joints[:2]
    upright = abs(first.axis[2]) > 1.0 - _UPRIGHT and float(np.hypot(*first.foot[:2])) <= _UPRIGHT
    if upright and abs(second.axis[2]) <= _UPRIGHT:
        return float(second.foot[2])
    return 0.0


def axes_2_and_3_opposed(robot: Robot) -> bool:
    """Axes 2 and 3 point against each other, and no joint is a mimic: so FANUC's J3 plus J2 is the angle of joint 3."""
    if len(robot.joints) != robot.n or robot.n < 3:
        return False
    return float(np.dot(robot.joints[1].axis, robot.joints[2].axis)) <= -1.0 + _UPRIGHT
