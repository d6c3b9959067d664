"""The parts of the arm that a family is about, where its name holds axes alone."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rankdrop.families import ArmPart
from rankdrop.families.parts import FamilyParts, parts_of
from rankdrop.results.known import shipped
from rankdrop.robot.open import robot_names
from rankdrop.text.claims import opening, summary_of_analysis
from rankdrop.text.special import family_label

S, E, W = ArmPart


@pytest.mark.parametrize(
    ("name", "id", "expected"),
    [
        ("ur5e", "k1.f2", FamilyParts((E,))),
        ("crx10ial", "k1.f1", FamilyParts((S, E, W), either=True)),
        ("gen3", "k1.f1", FamilyParts((S, E, W), either=True)),
        ("panda", "k1.f3", FamilyParts((E,))),
        ("panda", "k1.f5", FamilyParts((E, W), either=True)),
        ("yumi", "k1.f1", FamilyParts((E, W), either=True)),
        ("yumi", "k1.f6", FamilyParts((E, W))),
        ("gen72", "k1.f1", FamilyParts((W,))),
        ("crx10ial", "k2.f1", FamilyParts((S, E))),
        ("fetch8", "k1.f1", FamilyParts((E,))),
    ],
)
def test_the_parts_of_a_family(name: str, id: str, expected: FamilyParts) -> None:
    found = shipped(name)
    family = next(one for one in found.families if one.id == id)
    assert parts_of(found.robot, found.task, family) == expected


def test_a_family_that_binds_a_joint_of_the_base_says_so() -> None:
    """Fetch with its torso lift: the seven axes after it are the arm."""
    found = shipped("fetch8")
    family = found.families[0]
    bound = replace(family, coupled=(1, *family.coupled))
    assert parts_of(found.robot, found.task, bound) == FamilyParts((E,), base=True)
    assert family_label(found.robot, found.task, bound) == "base and elbow"


def first_sentence(name: str) -> str:
    return opening(summary_of_analysis(shipped(name)))


@pytest.mark.parametrize(
    ("name", "start"),
    [
        ("crx10ial", "crx10ial has 6 families of singularities: shoulder, elbow or wrist (rank 5); "),
        ("panda", "panda has 8 families of singularities: shoulder (2 families), elbow (2 families), elbow or wrist "),
        ("fetch8", "fetch8 has 8 families of singularities: elbow (2 families), wrist (4 families), shoulder (rank 5"),
    ],
)
def test_the_first_sentence_names_parts_of_the_arm(name: str, start: str) -> None:
    assert first_sentence(name).startswith(start)


@pytest.mark.slow
@pytest.mark.parametrize("name", robot_names())
def test_no_first_sentence_speaks_of_screws_or_axes(name: str) -> None:
    found = shipped(name)
    if found is None or not found.families:
        return
    sentence = first_sentence(name)
    assert "screws" not in sentence
    assert "axes" not in sentence
    assert "joints" not in sentence
