"""Rows and columns cleared by numbers: blocks, and the rest."""

from __future__ import annotations

import numpy as np
import pytest
from exact.strata import derived

from rankdrop.exact import elementary


def _sparse(rng: np.random.Generator, rows: int, columns: int) -> np.ndarray:
    entries = rng.integers(-3, 4, (rows, columns))
    return np.where(rng.random((rows, columns)) < 0.45, entries, 0)


@pytest.mark.parametrize("shape", [(1, 1), (3, 3), (5, 5), (3, 4), (4, 6)])
def test_full_rank_is_that_of_the_blocks_and_of_the_rest(shape: tuple[int, int]) -> None:
    rng, both = np.random.default_rng(5), set()
    for _ in range(60):
        matrix = _sparse(rng, *shape)
        blocks, rest = elementary._blocks(matrix.T.tolist())
        full = all(np.linalg.matrix_rank(np.array(block)) == len(block) for block in blocks)
        if rest:
            full &= np.linalg.matrix_rank(np.array(rest)) == len(rest[0])
        assert full == (np.linalg.matrix_rank(matrix) == shape[0])
        assert not (rest and shape[0] == shape[1] and full)
        both.add(full)
    assert both == {True, False}


@pytest.mark.parametrize(("name", "blocks"), [("scara", 3), ("ur5", 2), ("stanford", 2), ("irb120", 1)])
def test_elementary_transformations_leave_blocks(name: str, blocks: int) -> None:
    assert derived(name, "elementary").sizes["blocks"] == blocks
