"""Method "elementary": rows and columns cleared by numbers, then blocks (Xu et al. 2013, 2016).

Seen from a link in the middle many entries of the Jacobian are numbers. Row and column operations clear the row and the
column of one after another; none of these pivots ever vanishes, so that the rank of the smaller matrix is lower by
their number everywhere. Permutations make it block triangular: where k rows are zero outside k columns, J is singular
where the determinant of these k × k entries vanishes, or where the matrix without them loses rank.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

from rankdrop.algebra.polynomial import Polynomial
from rankdrop.exact.conjunctions import Columns, SetDerivation, conjunctions
from rankdrop.exact.vanishing_minors import factor_by_factor


def elementary(builder: SetDerivation) -> None:
    """Conditions of the blocks that remain when rows and columns have been cleared by numbers.

    Args:
        builder: filled in. Sizes: "blocks" with a determinant of their own, "terms" of all determinants, "minors" of
            the rest, where the arm has joints to spare.

    Raises:
        OptionError: the rank is not full anywhere.
        OutOfTime: no time is left.
    """
    builder.full_rank()
    columns, _ = builder.chain.cleared_columns
    builder.note("cleared", rows=len(columns[0]), columns=len(columns))
    if len(columns) < len(columns[0]):
        columns = [list(row) for row in zip(*columns, strict=True)]  # the rank is that of the transpose
    blocks, rest = _blocks(columns)
    builder.sizes |= {"blocks": len(blocks), "terms": 0, "minors": 0}
    for block in blocks:
        determinant = builder.minor(block, range(len(block)))
        builder.sizes["terms"] += len(determinant)
        builder.note("block", order=len(block), terms=len(determinant))
        builder.conditions += factor_by_factor(builder.equality(determinant))
    if rest:
        minors = [minor for minor in builder.minors(rest, len(rest[0])) if minor != 0]
        builder.sizes["minors"] = len(minors)
        builder.sizes["terms"] += sum(map(len, minors))
        builder.note("rest", rows=len(rest[0]), columns=len(rest), minors=len(minors))
        builder.conditions += conjunctions(map(builder.equality, minors))


def _blocks(columns: Columns) -> tuple[list[Columns], Columns]:
    """Square blocks of a matrix with no more rows than columns, and the rest: it has full rank where all of them have.

    A block are the fewest rows that are zero outside as many columns as there are of them; they and their columns are
    then left out. Of a square matrix there is no rest: its last block is all that remains.
    """
    blocks: list[Columns] = []
    rest = columns
    while rest:
        rows = _tight_rows(rest)
        if rows is None:
            return blocks, rest
        inside = [column for column in rest if _meets(column, rows)]
        outside = [column for column in rest if not _meets(column, rows)]
        others = [row for row in range(len(rest[0])) if row not in rows]
        blocks.append([_entries(column, rows) for column in inside])
        if not others:
            return blocks, []
        rest = [_entries(column, others) for column in outside]
    return blocks, rest


def _entries(column: Sequence[Polynomial], rows: Sequence[int]) -> list[Polynomial]:
    return [column[row] for row in rows]


def _meets(column: Sequence[Polynomial], rows: Sequence[int]) -> bool:
    """Whether a column has an entry besides zero in some rows."""
    return any(column[row] != 0 for row in rows)


def _tight_rows(columns: Columns) -> tuple[int, ...] | None:
    """The fewest rows that are zero outside as many columns as there are of them; None where there are none."""
    count = len(columns[0])
    for size in range(1, count + 1):
        for rows in combinations(range(count), size):
            if sum(_meets(column, rows) for column in columns) == size:
                return rows
    return None
