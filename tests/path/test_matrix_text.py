"""A homogeneous matrix as it is pasted: the same pose in every form, and a mistake refused with its name."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rankdrop.errors import OptionError
from rankdrop.path.read.matrix_text import matrix_of_text
from rankdrop.path.read.pose_text import pose_of_text
from rankdrop.poses.branches import matrix_of

POSE = np.eye(4)
POSE[:3, :3] = Rotation.from_euler("ZYX", [40.0, -25.0, 170.0], degrees=True).as_matrix()
POSE[:3, 3] = [0.4, -0.1, 0.35]
IN_MM = POSE.copy()
IN_MM[:3, 3] *= 1e3
ROWS = POSE.tolist()


def rows(matrix: np.ndarray, between: str = ", ", after: str = "; ") -> str:  # type: ignore[type-arg]
    return after.join(between.join(f"{x!r}" for x in row) for row in matrix.tolist())


@pytest.mark.parametrize("text", [
    f"{ROWS}", f"np.array({ROWS})", f"numpy.asarray({ROWS}, dtype=np.float64)", f"SE3({ROWS})", f"[{rows(POSE)}]",
    rows(POSE, " ", "\n"), rows(POSE[:3], " ", "\n"), f"{ROWS[:3]}", f"[{rows(IN_MM)}] mm",
    f"np.array({IN_MM.tolist()}) mm",
    f"{ROWS}m", ", ".join(map(repr, POSE.ravel().tolist())), ", ".join(map(repr, POSE.T.ravel().tolist())),
])  # fmt: skip
def test_every_form_is_the_same_pose(text: str) -> None:
    read = matrix_of_text(text, "--pose")
    assert read is not None
    assert read.pose == pytest.approx(POSE, abs=1e-12)
    made = pose_of_text(text, "--pose")
    assert made is not None
    assert matrix_of(made.numbers) == pytest.approx(POSE, abs=1e-12)


@pytest.mark.parametrize(("changed", "said"), [
    ((0, 0, 2.0), "no rotation"), ((3, 3, 2.0), "0 0 0 1"), ((0, 3, 400.0), "m or mm is in doubt"),
])  # fmt: skip
def test_a_mistake_is_named(changed: tuple[int, int, float], said: str) -> None:
    matrix = POSE.copy()
    matrix[changed[:2]] = changed[2]
    with pytest.raises(OptionError, match=said):
        matrix_of_text(f"{matrix.tolist()}", "--pose")


@pytest.mark.parametrize("text", [
    "0.4,0,0.3,0,0,0", "[[600,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]",
    "p[1,2,3,4,5,6]", "a b c d e f g h i j k l m n o p", "np.array(",
])  # fmt: skip
def test_other_texts_are_none(text: str) -> None:
    assert matrix_of_text(text, "--pose") is None


def test_numpy_prints_four_digits_and_the_rotation_is_mended_with_a_note() -> None:
    text = np.array2string(POSE, precision=4, suppress_small=True)
    read = matrix_of_text(text, "--pose")
    assert read is not None
    assert read.pose == pytest.approx(POSE, abs=2e-4)
    assert read.pose[:3, :3] @ read.pose[:3, :3].T == pytest.approx(np.eye(3), abs=1e-12)
    assert [note.startswith("the rotation of one pose is replaced") for note in read.notes] == [True]


def test_numbers_column_by_column_are_said_to_be_read_so() -> None:
    """libfranka's O_T_EE; a matrix in rows is not turned over: its translation in the last row is a mistake."""
    read = matrix_of_text(" ".join(map(repr, POSE.T.ravel().tolist())), "--pose")
    assert read is not None
    assert [note.startswith("a matrix written column by column") for note in read.notes] == [True]
    with pytest.raises(OptionError, match="transposed"):
        matrix_of_text(f"{POSE.T.tolist()}", "--pose")
