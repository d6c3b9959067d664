"""Matrices as lists of columns, against NumPy's."""

from __future__ import annotations

import numpy as np

from rankdrop.algebra.matrix import count_terms, each_entry, entries, submatrix, with_rows
from rankdrop.algebra.ring import Ring


def columns_of(matrix: np.ndarray) -> list[list[int]]:
    """The matrix as it is kept: one list for each column."""
    return matrix.T.tolist()


def test_parts_of_a_matrix_are_those_of_numpy(rng: np.random.Generator) -> None:
    matrix = rng.integers(-9, 10, (4, 6))
    columns = columns_of(matrix)
    assert with_rows(columns, [3, 0, 0]) == columns_of(matrix[[3, 0, 0]])
    assert submatrix(columns, [5, 1], [2, 0, 3]) == matrix[np.ix_([2, 0, 3], [5, 1])].tolist()
    assert entries(columns) == matrix.ravel(order="F").tolist()
    assert each_entry(lambda x: x * x, columns) == columns_of(matrix**2)


def test_a_minor_of_chosen_rows_and_columns_is_that_of_numpy(rng: np.random.Generator) -> None:
    ring, matrix = Ring([1]), rng.integers(-9, 10, (5, 5))
    columns = each_entry(lambda x: ring.one * int(x), columns_of(matrix))
    minor = ring.determinant(submatrix(columns, [4, 0, 2], [1, 3, 4]))
    assert minor == round(float(np.linalg.det(matrix[np.ix_([1, 3, 4], [4, 0, 2])])))


def test_terms_are_counted_over_all_entries() -> None:
    ring = Ring([1, 2])
    c, s = ring.c, ring.s
    assert count_terms([[c[1] + s[1], ring.zero], [ring.one, c[1] * c[2] + s[1] * s[2] + 1]]) == 2 + 0 + 1 + 3
