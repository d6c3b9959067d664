"""Names of families in files: facts, worded as they were when the file was written; words up to version 0.2."""

from __future__ import annotations

import json

import pytest

from rankdrop.codec import encode
from rankdrop.families.name import ArmPart, Detail, FamilyName, Geometry, JointValues, LowRank, Shorter, Variable
from rankdrop.local.dependence import Common, Dependence, SlideWay
from rankdrop.results.known import known_names, shipped_record
from rankdrop.results.names import name_from_dict, name_of
from rankdrop.results.old_files import name_of_words
from rankdrop.schema.families import CALLED
from rankdrop.text.names import name_words, short_name

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
        ("joints 1–7 of rank 5", FamilyName(details=(LowRank(7, 5, True),)), "joints 1–7 of rank 5"),
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
def test_a_name_is_written_and_read_as_facts(text: str, facts: FamilyName, short: str) -> None:
    record = json.loads(json.dumps(encode(CALLED, facts)))
    assert name_from_dict(record) == facts
    assert (name_words(facts), short_name(facts)) == (text, short)


@pytest.mark.parametrize("damage", [{"parts": ["knee"]}, {"relations": [{"geometry": "odd"}]}, {"ordinal": "second"}])
def test_an_entry_that_is_no_fact_of_a_name_is_refused(damage: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=r"Invalid enum value|Expected"):
        name_from_dict(damage)


@pytest.mark.parametrize(
    ("words", "parts", "short"),
    [
        ("elbow: arm stretched or folded (θ3 = −87.3° or 92.7°)", (ArmPart.ELBOW,), "elbow"),
        ("elbow and wrist, axes 2, 3, 4 parallel", (ArmPart.ELBOW, ArmPart.WRIST), "elbow and wrist"),
        ("shoulder, elbow and wrist (θ3 = 0)", tuple(ArmPart), "shoulder, elbow and wrist"),
        ("wrist centre on axis 1", (), "wrist centre on axis 1"),
        ("my own family", (), "my own family"),
    ],
)
def test_a_name_of_a_file_up_to_0_2_keeps_its_words(words: str, parts: tuple[ArmPart, ...], short: str) -> None:
    found = name_of({"name": words})
    assert (str(found), found.parts, found.short) == (words, parts, short)


def test_an_unnamed_family_of_a_file_up_to_0_2_is_unnamed() -> None:
    assert name_of_words("unnamed family") == FamilyName(unnamed=True)


def strays(names: list[str]) -> list[tuple[str, str]]:
    """(words of a family in a shipped analysis, words of its facts) where the facts are none, or worded otherwise."""
    families = [family for name in names for family in shipped_record(name)["families"]]
    named = [(family["name"], name_from_dict(family["called"])) for family in families]
    return [(words, str(facts)) for words, facts in named if facts.given or str(facts) != words]


def test_names_of_shipped_files_are_facts() -> None:
    assert strays(["planar3r", "ur5e"]) == []


@pytest.mark.by_hand
def test_every_name_of_a_shipped_file_is_facts() -> None:
    assert strays(list(known_names())) == []
