"""Names of families with many details."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rankdrop.families.name import ArmPart, Centre, Detail, FamilyName, Geometry, JointValues, Variable
from rankdrop.families.naming import LONGEST, shorten_names
from rankdrop.local.dependence import Common, Dependence

STRETCHED = FamilyName(
    (ArmPart.ELBOW,), details=(Detail(Geometry.COPLANAR_WITH_CENTRE, ((1, 2),), Centre.WRIST),)
)  # fmt: skip

FLAT = Detail(Geometry.PARALLEL_AND_COPLANAR, ((1, 2, 3, 5),))

ALIGNED = FamilyName(tuple(ArmPart), details=(Detail(Geometry.ALIGNED, ((0, 2), (4, 6))),))


def at(joint: int, *degrees: float) -> tuple[JointValues, ...]:
    """Values of one joint."""
    return (JointValues(Variable(joint), tuple(np.radians(degrees).tolist())),)


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        ([STRETCHED], ["elbow: axes 2, 3 and wrist centre coplanar"]),
        (
            [replace(STRETCHED, values=at(3, -87.3, 92.7))],
            ["elbow: arm stretched or folded (θ3 = −87.3° or 92.7°)"],
        ),
        (
            [FamilyName((ArmPart.ELBOW, ArmPart.WRIST), True, (FLAT,), values=at(4, -90.1, 89.9))],
            ["elbow and wrist (θ4 = −90.1° or 89.9°)"],  # not −90° or 90°: that is another posture
        ),
        (
            [replace(ALIGNED, bound=(Variable(joint),)) for joint in (3, 5)],
            ["shoulder, elbow and wrist: axes 1, 3 and 5, 7 aligned", None],
        ),
    ],
)
def test_a_long_name_is_shortened_and_stays_the_only_one(names: list[FamilyName], expected: list[str | None]) -> None:
    short = list(map(str, shorten_names(names)))
    assert all(len(one) <= LONGEST for one in short)
    assert len(set(short)) == len(names)
    assert all(want in (None, got) for want, got in zip(expected, short, strict=True))


@pytest.mark.slow
def test_a_name_of_very_many_details_is_shortened_at_once() -> None:
    sets = tuple(Dependence(Common.DEPENDENT_SCREWS, (i, i + 1, i + 2)) for i in range(59))
    (short,) = shorten_names([FamilyName(details=sets)])
    assert str(short) == "joints 1, 2, 3 dependent; joints 2, 3, 4 dependent"
