"""The posture of a solution: parts of the arm, short factors, or det J; no name of a family with a sign behind it."""

from __future__ import annotations

from rankdrop.exact.signs import Flag
from rankdrop.families.name import Detail, FamilyName, Geometry


def test_a_family_of_no_part_is_called_a_factor() -> None:
    line = FamilyName(details=(Detail(Geometry.LINE_THROUGH_TIP),))
    long = "a2 s3 − d2 c3 + a3 s3 c4 + d4 s4"
    assert Flag(long, line, -1, -0.3).label == "factor of det J −"
    assert Flag("a2 + a3 c3", line, 1, 0.3).label == "(a2 + a3 c3) +"
