"""The closed inverse of a square Jacobian: its adjugate over its determinant, entry by entry, both in factors."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass

from rankdrop.errors import OptionError
from rankdrop.exact.algebra.field import P, complete, trig_evaluator
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.algebra.work import Work
from rankdrop.exact.methods.apart import factors_within
from rankdrop.exact.writing.quotient import Quotient
from rankdrop.exact.writing.value import Value

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
    below = _value(ring, whole, work)
    adjugate = [[_cofactor(ring, rows, j, i, work) for j in range(n)] for i in range(n)]
    entries = tuple(tuple(Quotient(_value(ring, x, work), below) for x in row) for row in adjugate)
    agree = sum(_agrees(ring, rows, adjugate, whole, seed) for seed in range(POINTS))
    return ClosedInverse(below, entries, agree, POINTS)


def _value(ring: Ring, p: Polynomial, work: Work) -> Value:
    work.check()
    return Value(ring, p, None if p == 0 else factors_within(ring, p, work.left))


def _cofactor(ring: Ring, rows: Sequence[Sequence[Polynomial]], i: int, j: int, work: Work) -> Polynomial:
    """(−1)^(i+j) times the determinant without row i and column j."""
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
    rng, evaluate, n = random.Random(seed), trig_evaluator(ring), len(rows)
    point = None
    while point is None:
        point = complete(ring, {name: rng.randrange(P) for name in ring.names}, {})
    one = [[evaluate(x, point) for x in row] for row in rows]
    two = [[evaluate(x, point) for x in row] for row in adjugate]
    middle = evaluate(whole, point)
    entries = ((i, j, sum(one[i][k] * two[k][j] for k in range(n)) % P) for i in range(n) for j in range(n))
    return all(value == (middle if i == j else 0) for i, j, value in entries)
