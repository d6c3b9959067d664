"""The closed inverse of a square Jacobian: its adjugate over its determinant, entry by entry, both in factors."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass

from rankdrop.algebra.field import P, random_point, residues, value_at
from rankdrop.algebra.polynomial import Polynomial
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.work import Work
from rankdrop.errors import OptionError
from rankdrop.exact.determinants import factored_value
from rankdrop.formula.value import Quotient, Value

POINTS = 3
"""Random points at which the product with the Jacobian is computed modulo the prime."""


@dataclass(frozen=True, eq=False)
class ClosedInverse:
    """The inverse of a square matrix over the trigonometric ring.

    Attributes:
        determinant: in factors where they were found.
        entries: entries[i][j] of the inverse.
        agree, tested: at how many of the random points modulo the prime J · adj J = det J · 1.
    """

    determinant: Value
    entries: tuple[tuple[Quotient, ...], ...]
    agree: int
    tested: int


def closed_inverse(ring: Ring, rows: Sequence[Sequence[Polynomial]], work: Work) -> ClosedInverse:
    """J⁻¹ = adj J / det J.

    Args:
        ring: of the entries.
        rows: square.
        work: limit.

    Raises:
        OptionError: not square, or the determinant vanishes everywhere.
        OutOfTime: the limit was met.
    """
    n = len(rows)
    if any(len(row) != n for row in rows):
        raise OptionError(
            "only a square Jacobian has an inverse", got=f"{n} rows, {len(rows[0])} joints",
            mend="a task with as many rows as joints",
        )
    work.check()
    whole = ring.determinant(rows)
    if whole == 0:
        raise OptionError("a Jacobian that is singular everywhere has no inverse", mend="a task that the arm can serve")
    below = factored_value(ring, whole, work)
    adjugate = [[_cofactor(ring, rows, j, i, work) for j in range(n)] for i in range(n)]
    entries = tuple(tuple(Quotient(factored_value(ring, x, work), below) for x in row) for row in adjugate)
    agree = sum(_agrees(ring, rows, adjugate, whole, seed) for seed in range(POINTS))
    return ClosedInverse(below, entries, agree, POINTS)


def _cofactor(ring: Ring, rows: Sequence[Sequence[Polynomial]], i: int, j: int, work: Work) -> Polynomial:
    work.check()
    minor = ring.determinant([[x for b, x in enumerate(row) if b != j] for a, row in enumerate(rows) if a != i])
    return -minor if (i + j) % 2 else minor


def _agrees(
    ring: Ring,
    rows: Sequence[Sequence[Polynomial]],
    adjugate: Sequence[Sequence[Polynomial]],
    whole: Polynomial,
    seed: int,
) -> bool:
    """Whether J · adj J = det J · 1 at a random point modulo the prime."""
    n, point = len(rows), random_point(ring, random.Random(seed))
    (jacobian, _), (adjoint, _) = (residues(ring, matrix, [point])[0] for matrix in (rows, adjugate))
    middle = value_at(ring, whole, point)
    entries = ((i, j, sum(jacobian[i][k] * adjoint[k][j] for k in range(n)) % P) for i in range(n) for j in range(n))
    return all(value == (middle if i == j else 0) for i, j, value in entries)
