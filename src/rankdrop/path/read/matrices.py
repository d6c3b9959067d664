"""Poses of the tip as homogeneous matrices: checked, each mistake named, and rounded rotations made orthonormal."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import chain, product

import numpy as np

from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.robot.files import LARGEST_LENGTH, allowed_range
from rankdrop.robot.model import Array
from rankdrop.text.path_files import LAST_AXIS, ROTATIONS_ALONE, TRANSPOSED, mended_rotations

Where = Callable[[int], str]
ENTRIES = tuple(f"m{row}{column}" for row, column in product(range(4), range(4)))
"""Names of the columns of a table of matrices, row by row."""
TRANSLATION = ("m03", "m13", "m23")
ORTHONORMAL = 1e-3
"""Largest entry of |RᵀR − 1| that counts as rounding: numbers of four digits; as for the length of a quaternion."""
REPORTED = 1e-5
"""… and that is mended without a word: numbers of six digits."""
_EXACT = 1e-12  # … and that is rounding of doubles: such rotations stay bit for bit
_BOTTOM = 1e-6  # how far the last row may be from 0 0 0 1: a number of six digits
_BOTTOM_ROW = (0.0, 0.0, 0.0, 1.0)
_ENTRY = re.compile(r"m_?(\d)_?(\d)", re.IGNORECASE)
_MATRICES = ((4, 4), (3, 4))
_SHAPES = "shape (N, 4, 4) or (N, 3, 4)"


def matrix_entries(names: list[str]) -> dict[str, str]:
    """Which entry each name of a column is, by the name; names that are no entry are left out.

    Entries count from 0 (m00 … m33), or from 1 (m11 … m44) where a name has a 4 and none has a 0.

    Example:
        >>> matrix_entries(["m00", "M_2_3", "x"]), matrix_entries(["m11", "m14"])
        ({'m00': 'm00', 'M_2_3': 'm23'}, {'m11': 'm00', 'm14': 'm03'})
    """
    found = {name: (int(match[1]), int(match[2])) for name in names if (match := _ENTRY.fullmatch(name.strip()))}
    numbers = set(chain.from_iterable(found.values()))
    first = int(4 in numbers and 0 not in numbers)
    entries = {name: f"m{row - first}{column - first}" for name, (row, column) in found.items()}
    return {name: entry for name, entry in entries.items() if entry in ENTRIES}


def as_stack(values: Array, where: str) -> Array:
    """(N, 4, 4) or (N, 3, 4) from an array of poses, or of one pose.

    Raises:
        TrajectoryError: another shape; a transposed one, or poses along the last axis, are named as such.
    """
    stack = values[None] if values.ndim == 2 else values
    if stack.ndim == 3 and len(stack) and stack.shape[1:] in _MATRICES:
        return stack
    raise TrajectoryError(
        "the array has another shape than matrices of poses", where=where,
        got=f"shape {values.shape}", allowed=_SHAPES, mend=_what_the_shape_is(values.shape),
    )  # fmt: skip


def _what_the_shape_is(shape: tuple[int, ...]) -> str:
    """How to mend an array of another shape than (N, 4, 4) or (N, 3, 4); "" where its shape does not say."""
    if len(shape) != 3:
        return ""
    if shape[:2] in _MATRICES:
        return LAST_AXIS
    return {(4, 3): TRANSPOSED, (3, 3): ROTATIONS_ALONE}.get(shape[1:], "")


def poses_of(values: Array, where: Where, *, most: float = ORTHONORMAL) -> tuple[Array, tuple[str, ...]]:
    """(N, 4, 4) poses from matrices (N, 4, 4) or (N, 3, 4) [m], and notes on rotations that were mended.

    Args:
        values: R and p of each pose, [R p; 0 1] or [R p].
        where: name of a pose, counted from 0, for errors.
        most: largest entry of |RᵀR − 1| that counts as rounding.

    Raises:
        TrajectoryError: a pose that is no rotation with a translation; each mistake is named.
    """
    poses = np.tile(np.eye(4), (len(values), 1, 1))
    poses[:, : values.shape[1]] = values
    _refuse_infinite(poses, where)
    _refuse_bottom_rows(poses, where)
    _refuse_far(poses, where)
    turns = poses[:, :3, :3]
    off = deviation(turns)
    _refuse_no_rotations(turns, off, where, most)
    rounded = off > _EXACT
    turns[rounded] = nearest_rotations(turns[rounded])
    poses[:, 3] = _BOTTOM_ROW
    worst = int(off.argmax())
    if off[worst] <= REPORTED:
        return poses, ()
    turned = np.linalg.norm(poses[worst, :3, :3] - values[worst, :3, :3]) / np.sqrt(2.0)  # chord of the angle
    count = int((off > REPORTED).sum())
    return poses, (mended_rotations(count, float(off[worst]), worst + 1, float(np.degrees(turned))),)


def deviation(turns: Array) -> Array:
    """(N,) largest entry of |RᵀR − 1| of matrices (N, 3, 3)."""
    return np.asarray(np.abs(turns.swapaxes(1, 2) @ turns - np.eye(3)).max(axis=(1, 2)))


def nearest_rotations(turns: Array) -> Array:
    """(N, 3, 3) rotations nearest to matrices (N, 3, 3) of positive determinant: U Vᵀ of R = U S Vᵀ."""
    left, _, right = np.linalg.svd(turns)
    return np.asarray(left @ right)


def _refuse_infinite(made: Array, where: Where) -> None:
    for row, i, j in np.argwhere(~np.isfinite(made))[:1].tolist():
        raise TrajectoryError("the matrix has a value that is not finite", where=where(row),
                              got=f"{made[row, i, j]:g} in row {i + 1}, column {j + 1}")  # fmt: skip


def _refuse_bottom_rows(made: Array, where: Where) -> None:
    """Refuse a last row that is not 0 0 0 1; a transposed matrix, with the translation in it, is named as such."""
    wrong = (np.abs(made[:, 3] - _BOTTOM_ROW) > _BOTTOM).any(axis=1)
    for row in np.flatnonzero(wrong)[:1].tolist():
        last, column = made[row, 3], made[row, :, 3]
        got = " ".join(f"{number:.6g}" for number in last)
        if (np.abs(column - _BOTTOM_ROW) <= _BOTTOM).all():
            raise TrajectoryError("the matrix is transposed: its translation is in the last row", where=where(row),
                                  got=f"last row {got}", allowed="the translation in the last column",
                                  mend="transpose each matrix")  # fmt: skip
        raise TrajectoryError("the last row of the matrix is not 0 0 0 1", where=where(row), got=got,
                              allowed="0 0 0 1; the translation is the last column")  # fmt: skip


def _refuse_far(made: Array, where: Where) -> None:
    far = np.abs(made[:, :3, 3])
    for row in np.flatnonzero((far > LARGEST_LENGTH).any(axis=1))[:1].tolist():
        raise TrajectoryError("the value is too large", where=where(row), got=f"{far[row].max():g}",
                              allowed=allowed_range("length"))  # fmt: skip


def _refuse_no_rotations(turns: Array, off: Array, where: Where, most: float) -> None:
    """Refuse matrices (N, 3, 3) that are no rotations, by how far `off` (N,) they are; mirrored ones as such."""
    for row in np.flatnonzero(~(off <= most))[:1].tolist():  # NaN: squares beyond the doubles
        lengths = ", ".join(f"{length:.6g}" for length in np.linalg.norm(turns[row], axis=0))
        raise TrajectoryError(
            "the first three rows and columns of the matrix are no rotation", where=where(row),
            got=f"RᵀR differs from 1 by {off[row]:.3g}, columns of length {lengths}",
            allowed=f"columns of length 1 at right angles, to {most:g}",
            mend="write R without a scale, row by row, with six digits or more",
        )  # fmt: skip
    for row in np.flatnonzero(np.linalg.det(turns) < 0.0)[:1].tolist():
        raise TrajectoryError("the matrix is mirrored: its axes are left-handed", where=where(row),
                              got="determinant −1", allowed="a rotation, determinant 1",
                              mend="change the sign of one axis")  # fmt: skip
