"""Three conditions that hold on curves: whether they hold at points beside these, too."""

from __future__ import annotations

from itertools import combinations

import pytest

pytest.importorskip("flint")

from rankdrop.algebra import decompose as decomposing
from rankdrop.algebra.decompose import decompose
from rankdrop.algebra.polynomial import Polynomial
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.solving import only_curves
from rankdrop.algebra.work import Work

RING = Ring([1, 2, 3])
X, Y, Z = RING.half.gens()
MATRIX = ((X * Y + 2, Y * Z - 3 * X + 1, X + Z**2 + 5), (Y**2 + Z + 1, X * Z + 7, Y - 2 * X * Z + 3))


def minors() -> list[Polynomial]:
    """Of two rows and three columns: they vanish on a curve and, two of them, on further ones."""
    first, second = MATRIX
    return [first[i] * second[j] - first[j] * second[i] for i, j in combinations(range(3), 2)]


def test_the_minors_of_two_rows_vanish_on_curves_alone() -> None:
    assert only_curves(minors(), RING.moving, {})


def test_a_point_beside_a_curve_is_not_overlooked() -> None:
    """The line x = y = 0 and the point (2, 2, 3); the last condition alone decides whether the point is one."""
    line = [X - Y, X * (Z - 3) + Y * (X - 2)]
    assert not only_curves([*line, X * (X - 2)], RING.moving, {})
    assert only_curves([*line, X * (X - 2) + Y * (Z - 4)], RING.moving, {})


def test_a_point_above_a_curve_is_not_overlooked() -> None:
    """The line x = y = 0 and the point (2, 0, 3): along x the point lies over the line, in a random direction not."""
    assert not only_curves([Y + X * (Z - 3), Y + X * (X - 2), Y], RING.moving, {})


def test_the_two_conditions_that_cut_the_curves_are_a_set_where_nothing_else_is_there() -> None:
    def alone(system: list[Polynomial]) -> int | None:
        found = decomposing._curves_alone(RING, {}, system, Work(20.0))
        return None if found is None else len(found)

    assert alone(minors()) == 1
    assert alone([X - Y, X * (Z - 3) + Y * (X - 2), X * (X - 2)]) is None  # the line x = y = 0 and a point


def test_a_system_of_minors_is_taken_apart() -> None:
    """They vanish together on a set of codimension 2 with all joints free: nothing is left over."""
    work = Work(20.0)
    found = decompose(RING, {}, [RING.form(f) for f in minors()], 3, work)
    assert not work.unresolved
    curve = next(piece for piece in found if piece.codimension == 2 and not piece.pins)
    assert all(curve.half_vanishes(minor) for minor in minors())
