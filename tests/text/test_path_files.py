"""Notes on files of paths and poses."""

from __future__ import annotations

import numpy as np
import pytest
from path.test_matrix_text import POSE

from rankdrop.errors import OptionError
from rankdrop.path.read.matrix_text import matrix_of_text


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
