"""Names of one table: unique, with the first short condition that only one family has, or counted."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rankdrop.families.distinct_names import distinct_names
from rankdrop.families.name import ArmPart, FamilyName

ELBOW, WRIST = FamilyName((ArmPart.ELBOW,)), FamilyName((ArmPart.WRIST,))


def told(*texts: str) -> Callable[[], Sequence[str]]:
    return lambda: texts


def never() -> Sequence[str]:
    raise AssertionError("asked for the conditions of a name that is alone")


def test_a_name_that_is_alone_stays_and_its_conditions_are_not_asked_for() -> None:
    assert distinct_names([ELBOW, WRIST], [never, never]) == [ELBOW, WRIST]


def test_equal_names_get_the_condition_that_only_they_have() -> None:
    names = distinct_names([ELBOW, ELBOW, WRIST], [told("θ2 = 0", "θ3 = 0"), told("θ2 = 0", "θ3 = π"), never])
    assert list(map(str, names)) == ["elbow (θ3 = 0)", "elbow (θ3 = π)", "wrist"]


def test_names_that_no_short_condition_tells_apart_are_counted() -> None:
    long = "s2 c3 + 0.5 s23 c4 − 0.25 c2 = 0"
    names = distinct_names([WRIST, WRIST], [told("θ5 = 0", long), told("θ5 = 0")])
    assert list(map(str, names)) == ["wrist (first)", "wrist (second)"]
