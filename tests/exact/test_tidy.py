"""Sums of angles that are constant on a set stand among its conditions."""

from __future__ import annotations

from rankdrop.algebra.ring import Ring
from rankdrop.algebra.work import Work
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact.tidy import _relations, tidy


def test_constant_sums_of_angles_are_found_among_longer_conditions() -> None:
    """On t2 t3 = 1 = t2 t5 the sums θ2 + θ3 and θ2 + θ5 are π, and θ3 − θ5 is 0."""
    ring = Ring([2, 3, 5])
    t2, t3, t5 = ring.t[2], ring.t[3], ring.t[5]
    equations = (t2 * t3 - 1, t3 - t5 + (t2 * t3 - 1) * t5)
    piece = ZeroSet(ring, {}, rest=equations, equations=equations)
    assert [str(f) for f in _relations(piece)] == ["t2*t3 - 1", "t2*t5 - 1", "t3 - t5"]
    other = tidy(piece, Work(20.0, 0))
    assert {str(f) for f in other.equations} <= {"t2*t3 - 1", "t2*t5 - 1", "t3 - t5"}
    assert other.codimension == piece.codimension == 2
    assert other.lies_inside(piece)
    assert piece.lies_inside(other)


def test_a_set_without_a_constant_sum_stays_as_it_is() -> None:
    ring = Ring([2, 3, 5])
    equations = (ring.t[2] - 2 * ring.t[3], ring.t[3] - 3 * ring.t[5])
    piece = ZeroSet(ring, {}, rest=equations, equations=equations)
    assert tidy(piece, Work(20.0, 0)) is piece
