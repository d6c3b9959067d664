"""What a reader of a file of a path should know, and the columns of one that is written."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from rankdrop.options import advise
from rankdrop.robot.model import Array

COLUMNS = {
    "row": "number of the sample, from 1",
    "time_s": "of the sample",
    "pose": "number of the pose, from 1, with the share of the way on",
    "joint": "value of {0}",
    "verdict": "worst on the way from this row to the next",
    "family": "id of the nearest known family",
    "family_name": "its name",
    "distance_rad": "to the nearest singular configuration known or found; slides by the length scale",
    "at_least_rad": "no singular configuration is nearer: proven",
    "sigma": "σ{0}, translation divided by {1:.6g} m",
    "speed_factor": "largest, at most 1, that keeps the velocity limits on its stretch",
}
"""Meanings of the columns of a checked path row by row."""
MILLIMETRES = "positions up to {0:.4g} look like millimetres and are read as metres; {1}"
MILLIMETRES_STATED = {
    "columns": "write x [mm], y [mm], z [mm]",
    "matrix columns": "write m03 [mm], m13 [mm], m23 [mm]",
    "objects": 'write "length": "mm" next to "poses"',
    "arrays": "divide poses[:, :3, 3] by 1000",
}
"""How each form of poses states millimetres."""
AS_RTDE = "columns {0} … {1} are the joints in the arm's order, as Universal Robots' RTDE logs them"
PREFIX_OF_FILE = "names of the file have {0!r} in front of those of the joints"
PREFIX_OF_ARM = "names of the arm's joints have {0!r} in front of those of the file"
"""How joints were found under other names."""
POSE_COLUMNS = (
    "x, y, z with qx, qy, qz, qw, with roll, pitch, yaw, or alone; rx, ry, rz, or A, B, C, or W, P, R, or q1 … q4 as "
    "makers write them; or matrices, m00 … m23 or m00 … m33"
)
"""Columns of a table of poses."""
_MAKERS_TURNS = {
    ("rx", "ry", "rz"): "rotation vector [{0}]",
    ("a", "b", "c"): "R = Rz(A)·Ry(B)·Rx(C) [{0}]",
    ("w", "p", "r"): "R = Rz(R)·Ry(P)·Rx(W) [{0}]",
    ("q1", "q2", "q3", "q4"): "quaternion with its real part q1 first",
    ("zyz A", "zyz B", "zyz C"): "R = Rz(A)·Ry(B)·Rz(C) [{0}]",
}
MAKERS_UNITS = {
    ("rx", "ry", "rz"): "Universal Robots: m and rad",
    ("a", "b", "c"): "KUKA: mm and degrees",
    ("w", "p", "r"): "FANUC: mm and degrees",
    ("q1", "q2", "q3", "q4"): "ABB: mm",
    ("zyz A", "zyz B", "zyz C"): "Doosan: mm and degrees",
}
"""Units of the makers, by what turns."""
UNIT_IN_DOUBT = {
    "length": "m or mm is in doubt: the lengths are not as the maker writes them",
    "angle": "radians or degrees is in doubt: the angles are not as the maker writes them",
}
"""Errors of poses of a maker's form without a unit."""
ROTATION_VECTORS = (
    'a rotation vector "rx [rad]", "ry [rad]", "rz [rad]"; or "roll [deg]", "pitch [deg]", "yaw [deg]", '
    "R = Rz(yaw)·Ry(pitch)·Rx(roll)"
)
"""How turns about x, y and z are written without doubt."""
STATE_POSE_UNITS = {
    "length": "write a unit behind each length, such as X 400mm or X 0.4m",
    "angle": "write a unit behind each angle, such as B 90deg or roll 1.57rad",
}
"""How a pose in a text states units."""
NAMED_UNITS = "other units need names: x 400mm, y 0mm, z 300mm, roll 180deg, pitch 0deg, yaw 0deg"
ORDER_IN_DOUBT = "the order of the quaternion is in doubt: its real part is the first number or the last"
POSE_TEXTS = "X, Y, Z and roll, pitch, yaw; qx, qy, qz, qw; rx, ry, rz; A, B, C; W, P, R; q1 … q4; or none of these"
"""Names of a pose in a text."""
BY_COLUMNS = "a matrix written column by column, as libfranka writes O_T_EE: its last column is 0 0 0 1"
"""How a matrix of sixteen numbers was read."""
LARGEST_IN_METRES = 20.0
"""A translation beyond it is hardly in metres [m]."""
MATRIX_UNIT = "write mm or m behind the matrix"
RAISED = "Z counts from the height of axis 2, {0:.6g} mm above the base, as FANUC counts it"

TRANSPOSED = "the matrices are transposed: write poses.transpose(0, 2, 1)"
LAST_AXIS = "the poses are along the last axis: write numpy.moveaxis(poses, -1, 0)"
ROTATIONS_ALONE = "these are rotations alone: add the translation as the fourth column"
MATRIX_SHAPE = "matrices of the tip have the shape (N, {0}, 4)"
QUATERNION_HEAD = "a first line x,y,z,qx,qy,qz,qw makes them poses of the tip"
QUATERNIONS_AS_TEXT = f"poses with quaternions are read from CSV: {QUATERNION_HEAD}"
POINTS_WITHOUT_NAMES = "the points name no joints: their values are taken in the order of the arm's joints"
SAVED_WITH_COMMAS = 'separate them by commas: numpy.savetxt(file, rows, delimiter=",")'
MATRIX_HEAD = "a first line m00,m01, … m{0}3 makes them matrices of the tip"
"""What mends arrays and tables of matrices."""
TWO_TURNS = "radians, at most two turns"
DEGREES_STATED = {
    "columns": 'name the columns "roll [deg]", "pitch [deg]", "yaw [deg]"',
    "objects": 'write "angle": "deg" next to "poses"',
}
"""How each form of poses states degrees."""

BAG_NOTES = {
    "others": "{0} of {1} messages have none of this arm's joints and are passed over",
    "recording": "headers have no times: those of the recording are taken",
    "plans": "{0} plans follow each other; {1} points were replaced",
    "repeated": "{0} rows are repeated word for word and count once",
}
"""What a reader of a bag should know."""
BAG_MEND = "mend the bag first: rosbag reindex, ros2 bag reindex, or mcap recover"
DAMAGES: dict[type[Exception], str] = {
    OverflowError: "a record that is longer than any file",
    AssertionError: "records that contradict each other",
    **dict.fromkeys((KeyError, IndexError), "a record about one that is not there"),
    UnicodeDecodeError: "a name that is no text",
}
"""What the errors of Python mean that a damaged bag raises; readers say the others themselves."""

DECIMAL_COMMAS = "decimals have commas: 0,5 is read as 0.5"


def makers_note(maker: str, turn: tuple[str, ...], length: str, angle: str) -> str:
    """How poses of a maker's form are read: their order of turns and their units."""
    return f"poses as {maker} writes them: {', '.join('xyz')} [{length}], {_MAKERS_TURNS[turn].format(angle)}"


def passed_over_notes(names: Sequence[str]) -> tuple[str, ...]:
    """A note on parts of a pose that say nothing of where the tip is; none where there are none."""
    if not names:
        return ()
    return (f"not used: {', '.join(names)}",)


def state_units(keys: tuple[str, ...]) -> str:
    """How a table states the unit of lengths x, y, z, or of what turns."""
    if keys[0] == "x":
        return "name the columns x [mm], y [mm], z [mm], or x [m], y [m], z [m]"
    if keys[0] == "rx":
        return f"write {ROTATION_VECTORS}"
    names = [key.upper() for key in keys]
    return f"name the columns {_with_unit(names, 'deg')} or {_with_unit(names, 'rad')}"


def _with_unit(names: Sequence[str], unit: str) -> str:
    """Names of columns with a unit behind each."""
    return ", ".join(f"{name} [{unit}]" for name in names)


def mended_rotations(count: int, off: float, number: int, turned: float) -> str:
    """A note on rotations of few digits: how many poses have one, how far the worst is from one, and which it is.

    Args:
        count: of the poses with a rotation that was replaced by the nearest one.
        off: largest entry of |RᵀR − 1|.
        number: of the worst pose, from 1.
        turned: how far that one was turned [°].
    """
    if count == 1:
        rotations, by = "the rotation of one pose is replaced by the nearest one", "by"
    else:
        rotations, by = f"rotations of {count} poses are replaced by the nearest ones", "by up to"
    return f"{rotations}: RᵀR differs from 1 {by} {off:.2g} (pose {number}, which turns by {turned:.2g}°)"


def reading_remarks(name: str, hint: str | None, notes: Sequence[str], unused: Sequence[str]) -> Iterator[str]:
    """What a reader of a file should know.

    Args:
        name: of the file.
        hint: of a unit that looks wrong.
        notes: of how it was read.
        unused: its columns or joints that are ignored.
    """
    if hint is not None:
        yield f"warning: {name}: {hint}"
    yield from (f"{name}: {note}" for note in notes)
    if unused:
        yield f"{name}: not used: {', '.join(unused)}"


def degrees_advice(hint: str) -> str:
    """A hint that angles look like degrees, with what reads them so."""
    return f"{hint}; {advise('deg')} reads them as degrees"


def radians_hint(angles: Array) -> str | None:
    """A line of warning where angles that were read as degrees look like radians; None where they do not.

    Args:
        angles: (T, k) [rad].
    """
    typed = float(np.degrees(np.abs(angles).max(initial=0.0)))
    moves = len(angles) > 0 and float(np.ptp(angles, axis=0).max(initial=0.0)) > 0.0
    if moves and typed <= np.pi:
        return f"angles up to {typed:.4g} look like radians and are read as degrees"
    return None
