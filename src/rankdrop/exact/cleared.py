"""A Jacobian less the freedoms that are never lost: rows and columns cleared by entries that are numbers.

Where an entry of a matrix is a number c ≠ 0, steps of elimination with it need no division by a polynomial:

    rank [[c, r], [k, B]] = 1 + rank(B − k r / c)        (Schur's complement)

everywhere, so that all drops of rank are those of a smaller matrix. In its own link's frame an axis is such a column. A
slide of a base or a gantry moves the whole arm along a line that does not turn with the joints before it: what the
other joints do along that line does not matter, and the joints of a mobile base that only drive it along and about
fixed lines leave the problem with their rows.
"""

from __future__ import annotations

from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.arm.chain import Chain


def smallest(chain: Chain) -> tuple[list[list[Polynomial]], int]:
    """Columns of a matrix, and by how much its rank is lower than that of the arm's Jacobian, everywhere.

    For redundant arms with slides and all six rows: the smallest cleared Jacobian over the frames of the links, counted
    by its terms times its rows. For others the Jacobian as it stands.
    """
    if chain.task.rows != (0, 1, 2, 3, 4, 5) or chain.n <= 6 or not chain.ring.prismatic:
        return chain.columns, 0
    found = (cleared(chain.ring, chain.screws(k)) for k in chain.frames)
    return min(found, key=lambda one: sum(len(x) for column in one[0] for x in column if x != 0) * len(one[0][0]))


def cleared(ring: Ring, columns: list[list[Polynomial]]) -> tuple[list[list[Polynomial]], int]:
    """The columns of a smaller matrix, and by how much its rank is lower than theirs, everywhere.

    Args:
        ring: of the entries.
        columns: of a matrix over `ring.trig`.

    Of the numbers that could clear a row and a column the one whose own row and column are shortest is taken first:
    what it adds to other entries is shortest.
    """
    here, lower = [list(column) for column in columns], 0
    while True:
        place = _pivot(here)
        if place is None:
            return here, lower
        j, i = place
        pivot = here.pop(j)
        row = [column.pop(i) for column in here]
        number = pivot.pop(i)
        for column, value in zip(here, row, strict=True):
            if value != 0:
                for k, entry in enumerate(pivot):
                    if entry != 0:
                        column[k] = ring.reduce(column[k] - entry * value / number.coeffs()[0])
        lower += 1


def _pivot(columns: list[list[Polynomial]]) -> tuple[int, int] | None:
    """(column, row) of the number that is cheapest to clear with; None where no entry is a number."""
    best: tuple[int, int, int] | None = None
    for j, column in enumerate(columns):
        for i, entry in enumerate(column):
            if entry != 0 and entry.is_constant():
                across = sum(len(other[i]) for other in columns if other is not column and other[i] != 0)
                down = sum(len(x) for k, x in enumerate(column) if k != i and x != 0)
                if best is None or across * down < best[0]:
                    best = (across * down, j, i)
    return None if best is None else best[1:]
