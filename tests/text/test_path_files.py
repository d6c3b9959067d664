"""Notes on files of paths and poses."""

from __future__ import annotations

import pytest

from rankdrop.text.path_files import mended_rotations

WORST = "(pose 4, which turns by 0.0058°)"


@pytest.mark.parametrize(("count", "said"), [
    (1, "the rotation of one pose is replaced by the nearest one: RᵀR differs from 1 by 0.00018"),
    (3, "rotations of 3 poses are replaced by the nearest ones: RᵀR differs from 1 by up to 0.00018"),
])  # fmt: skip
def test_a_note_on_mended_rotations_counts_them(count: int, said: str) -> None:
    assert mended_rotations(count, 1.8e-4, 4, 0.0058) == f"{said} {WORST}"
