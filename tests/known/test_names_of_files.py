"""Names of families in files are read into facts, and worded again as they stand there."""

from __future__ import annotations

import pytest

from rankdrop.families.name import ArmPart, Detail, FamilyName, Geometry, JointValues, LowRank, Shorter, Variable
from rankdrop.local.dependence import Common, Dependence, SlideWay
from rankdrop.results.known import known_names, shipped
from rankdrop.text.names import name_words, short_name
from rankdrop.text.read_names import read_name

WRIST = Detail(Geometry.ALIGNED, ((3, 5),))


@pytest.mark.parametrize(
    ("text", "facts", "short"),
    [
        ("wrist: axes 4 and 6 aligned", FamilyName((ArmPart.WRIST,), details=(WRIST,)), "wrist"),
        (
            "elbow and wrist, axes 2, 3, 4, 6 parallel and coplanar",
            FamilyName(
                (ArmPart.ELBOW, ArmPart.WRIST), True, (Detail(Geometry.PARALLEL_AND_COPLANAR, ((1, 2, 3, 5),)),)
            ),
            "elbow and wrist",
        ),
        (
            "axes 4 and 6 aligned, 2 ∥ 3, with a condition on θ2–θ4",
            FamilyName(
                details=(WRIST, Detail(Geometry.PARALLEL, ((1, 2),), brief=True)),
                bound=(Variable(2), Variable(3), Variable(4)),
            ),
            "axes 4 and 6 aligned, 2 ∥ 3",
        ),
        (
            "axes 1, 4 aligned; axes 2–5 parallel",
            FamilyName(details=(Dependence(Common.ALIGNED, (0, 3)), Dependence(Common.PARALLEL, (1, 2, 3, 4)))),
            "axes 1, 4 aligned; axes 2–5 parallel",
        ),
        (
            "axes 1, 2, 3 parallel, slides 4, 5 normal to them",
            FamilyName(details=(Dependence(Common.PARALLEL, (0, 1, 2), (3, 4), SlideWay.NORMAL_TO_AXES),)),
            "axes 1, 2, 3 parallel, slides 4, 5 normal to them",
        ),
        ("screws 1–7 of rank 5", FamilyName(details=(LowRank(7, 5, True),)), "screws 1–7 of rank 5"),
        (
            "elbow (q2 = −0.5 m or 0.3 m, second)",
            FamilyName((ArmPart.ELBOW,), values=(JointValues(Variable(2, True), (-0.5, 0.3)),), ordinal=2),
            "elbow",
        ),
        (
            "elbow (θ2 − θ3 − θ4 = π)",
            FamilyName((ArmPart.ELBOW,), condition="θ2 − θ3 − θ4 = π"),
            "elbow",
        ),
        (
            "wrist, with a condition",
            FamilyName((ArmPart.WRIST,), True, bound=(Variable(0),), shorter=Shorter.CONDITION_WITHOUT_JOINTS),
            "wrist",
        ),
        ("unnamed family", FamilyName(unnamed=True), "unnamed family"),
        ("a name: of the user", FamilyName(given="a name: of the user"), "a name: of the user"),
    ],
)
def test_a_name_is_read_into_facts(text: str, facts: FamilyName, short: str) -> None:
    assert read_name(text) == facts
    assert (name_words(facts), short_name(facts)) == (text, short)


def test_the_way_values_are_written_is_a_fact_of_its_own() -> None:
    found = read_name("shoulder and wrist (θ2 = ±113°, θ3 = −157° or 22°)")
    assert found.shorter == Shorter.PLUS_MINUS | Shorter.WHOLE_DEGREES
    angles = read_name("wrist (θ2 = ±113°)").values[0].values
    assert angles == pytest.approx((-1.9722, 1.9722), abs=1e-4)


def unread(names: list[str]) -> list[str]:
    """Names of families in shipped analyses whose words are not read into facts, or are worded otherwise."""
    families = (family.called for name in names for family in shipped(name).families)
    return [str(one) for one in families if one.given]


def test_names_of_shipped_files_are_facts() -> None:
    assert unread(["planar3r", "ur5e"]) == []


@pytest.mark.by_hand
def test_every_name_of_a_shipped_file_is_facts() -> None:
    assert unread(list(known_names())) == []
