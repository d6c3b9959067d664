"""A homogeneous matrix as it is pasted from NumPy, MATLAB, a terminal or libfranka: 16 numbers, or the 12 of [R p].

Brackets, commas, semicolons and the name of the function around it (np.array, SE3) count as blanks. The translation is
the last column. Sixteen numbers without rows are written column by column where their last column is 0 0 0 1, as
libfranka writes O_T_EE; twelve, as IKFast takes them, row by row where that makes a rotation. Lengths are in m, or in
mm with that word behind the matrix.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from rankdrop.errors import OptionError
from rankdrop.path.read.csv_file import UNITS
from rankdrop.path.read.matrices import poses_of
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.robot.model import Array
from rankdrop.text.path_files import BY_COLUMNS, LARGEST_IN_METRES, MATRIX_UNIT

_FUNCTION = re.compile(r"^(?:[A-Za-z_]\w{0,40}\.){0,3}(?:array|asarray|matrix|SE3)\s*\(", re.IGNORECASE)
_TYPE = re.compile(r",\s*dtype\s*=[\w.\s'\"]{1,40}$")
_UNIT = re.compile(r"(?<![A-Za-z])(mm|m)$")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_BLANKS = re.compile(r"[\s,;\[\]()]+")
_ROWS = re.compile(r"[\[\];\n]")
_LAST = np.array([0.0, 0.0, 0.0, 1.0])
_NEARLY = 1e-3  # of an entry of RᵀR − 1 in numbers without rows
_NEAR = 1e-6  # of the last row and column: numbers of six digits


@dataclass(frozen=True)
class MatrixText:
    """A matrix that was read.

    Attributes:
        pose: (4, 4) [m].
        notes: how it was read.
    """

    pose: Array
    notes: tuple[str, ...]


def matrix_of_text(text: str, where: str) -> MatrixText | None:
    """A pose from the text of a homogeneous matrix; None where it is none.

    Args:
        text: as pasted.
        where: the option, for errors.

    Raises:
        OptionError: its first three rows and columns are no rotation, its last row is not 0 0 0 1, or m or mm is in
            doubt, or the order of twelve numbers.

    Example:
        >>> matrix_of_text("[[1, 0, 0, 0.4], [0, -1, 0, 0.1], [0, 0, -1, 0.3], [0, 0, 0, 1]]", "--pose").pose[:3, 3]
        array([0.4, 0.1, 0.3])
    """
    body, unit = _without_unit(_inside_function(text.strip()))
    words = [word for word in _BLANKS.split(body) if word]
    in_rows = bool(_ROWS.search(body.strip("[]() \t\r\n")))
    if not _is_matrix(words):
        return None
    matrix = np.array(words, dtype=np.float64).reshape(-1, 4)
    if not in_rows and len(matrix) == 3:
        _refuse_other_orders(matrix, where)
    notes: tuple[str, ...] = ()
    if not in_rows and _is_by_columns(matrix):
        matrix, notes = matrix.T.copy(), (BY_COLUMNS,)
    matrix[:3, 3] *= _metres(matrix[:3, 3], unit, where)
    try:
        poses, mended = poses_of(matrix[None], lambda _row: where)
    except TrajectoryError as error:
        raise OptionError(**error.parts) from error
    return MatrixText(poses[0], (*notes, *mended))


def _is_matrix(words: list[str]) -> bool:
    """Whether words are the numbers of a matrix: sixteen, or twelve."""
    return len(words) in (12, 16) and all(map(_NUMBER.fullmatch, words))


def _refuse_other_orders(matrix: Array, where: str) -> None:
    """Refuse twelve numbers that are not [R p] row by row (3, 4), or that may be nine of a rotation, then the place.

    Raises:
        OptionError: with how to write them.
    """
    if not _is_rotation(matrix[:, :3]) or _is_rotation(matrix.ravel()[:9].reshape(3, 3)):
        raise OptionError("the order of twelve numbers is in doubt", where=where,
                          allowed="r11, r12, r13, x, r21, …: [R p] row by row, with a rotation R",
                          mend="write the rows in brackets: [[r11, r12, r13, x], [r21, …], [r31, …]]")  # fmt: skip


def _is_rotation(turn: Array) -> bool:
    with np.errstate(over="ignore", invalid="ignore"):
        off = np.abs(turn.T @ turn - np.eye(3)).max()
    return bool(off <= _NEARLY) and float(np.linalg.det(turn)) > 0.0


def _inside_function(text: str) -> str:
    """The text inside the brackets of np.array(…) and its like."""
    function = _FUNCTION.match(text)
    if function is None:
        return text
    inside, closing, behind = text[function.end() :].rpartition(")")
    if not closing:
        return text
    return f"{_TYPE.sub('', inside)} {behind}".strip()


def _without_unit(text: str) -> tuple[str, str]:
    """The text without the unit behind it, and the unit; "" for none."""
    unit = _UNIT.search(text)
    if unit is None:
        return text, ""
    return text[: unit.start()].rstrip(), unit[1]


def _is_by_columns(matrix: Array) -> bool:
    """Whether 0 0 0 1 is the last column (4, 4), and not the last row."""
    if matrix.shape != (4, 4):
        return False
    in_row = np.abs(matrix[3] - _LAST).max() <= _NEAR
    return bool(not in_row and np.abs(matrix[:, 3] - _LAST).max() <= _NEAR)


def _metres(place: Array, unit: str, where: str) -> float:
    """The factor from the unit of a place (3,) to metres.

    Raises:
        OptionError: no unit is stated, and the numbers are too large for metres.
    """
    if unit:
        return UNITS["length"][unit]
    farthest = float(np.abs(place).max())
    if farthest > LARGEST_IN_METRES:
        raise OptionError("m or mm is in doubt: the translation looks like millimetres", where=where,
                          got=f"{farthest:.6g} in the last column", mend=MATRIX_UNIT)  # fmt: skip
    return 1.0
