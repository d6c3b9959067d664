"""Matrices as lists of columns: entries, rows, parts, so that a line names one thing."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import chain
from typing import Any, TypeVar

From = TypeVar("From")
To = TypeVar("To")


def each_entry(function: Callable[[From], To], columns: Iterable[Iterable[From]]) -> list[list[To]]:
    """The matrix of f(x) for every entry x.

    Example:
        >>> each_entry(abs, [[-1, 2], [3, -4]])
        [[1, 2], [3, 4]]
    """
    return [list(map(function, column)) for column in columns]


def entries(columns: Iterable[Iterable[From]]) -> list[From]:
    """All entries, one column after another.

    Example:
        >>> entries([[1, 2], [3, 4]])
        [1, 2, 3, 4]
    """
    return list(chain.from_iterable(columns))


def with_rows(columns: Iterable[Sequence[From]], rows: Iterable[int]) -> list[list[From]]:
    """The columns with the chosen rows alone, in that order.

    Example:
        >>> with_rows([[1, 2, 3], [4, 5, 6]], [2, 0])
        [[3, 1], [6, 4]]
    """
    chosen = tuple(rows)
    return [[column[row] for row in chosen] for column in columns]


def submatrix(
    columns: Sequence[Sequence[From]], chosen: Iterable[int], rows: Iterable[int]
) -> list[list[From]]:
    """The rows of the matrix with the chosen rows and columns alone.

    Example:
        >>> submatrix([[1, 2, 3], [4, 5, 6]], [1, 0], [0, 2])
        [[4, 1], [6, 3]]
    """
    some = [columns[column] for column in chosen]
    return [[column[row] for column in some] for row in rows]


def count_terms(columns: Iterable[Iterable[Any]]) -> int:
    """Number of terms of all entries, which are polynomials."""
    return sum(map(len, entries(columns)))
