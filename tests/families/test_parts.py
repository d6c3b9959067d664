"""The parts of the arm that a family is about, where its name holds axes alone."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from rankdrop.designs.measure import _family
from rankdrop.families import ArmPart, FamilyName
from rankdrop.families.parts import FamilyParts, parts_of
from rankdrop.results.known import shipped
from rankdrop.robot.open import robot_names
from rankdrop.text.brief import compared_arms
from rankdrop.text.claims import opening, summary_of_analysis
from rankdrop.text.special import family_label, family_title, place_name
from rankdrop.text.stretches import stretch_place

S, E, W = ArmPart


@pytest.mark.parametrize(
    ("name", "id", "expected"),
    [
        ("ur5e", "k1.f2", FamilyParts((E,))),
        ("crx10ial", "k1.f1", FamilyParts((S, E, W), either=True)),
        ("gen3", "k1.f1", FamilyParts((S, E, W), either=True)),
        ("panda", "k1.f3", FamilyParts((E,))),
        ("panda", "k1.f5", FamilyParts((E, W), either=True)),
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


def test_a_label_names_the_parts_and_a_title_the_axes_too() -> None:
    found = shipped("crx10ial")
    robot, task, family = found.robot, found.task, found.families[0]
    assert family_label(robot, task, family) == "shoulder, elbow or wrist"
    assert family_title(robot, task, family) == "shoulder, elbow or wrist: joints 1–6 dependent"
    own = replace(family, called=FamilyName(given="my own family"))
    assert family_label(robot, task, own) == family_title(robot, task, own) == "my own family"


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


def test_a_comparison_and_a_path_name_the_parts_of_an_arm_with_offsets() -> None:
    """A CRX has one long condition: its stored name is "joints 1–6 dependent"."""
    found = shipped("crx10ial")
    family = found.families[0]
    record = {"error": "", "families": [_family(one, found.robot, found.task) for one in found.families]}
    (line,) = compared_arms(["crx"], [record]).lines
    assert line.startswith("crx: shoulder, elbow or wrist (corank 1)")
    q = np.array(family.witness)
    check = SimpleNamespace(robot=found.robot, task=found.task)
    closest = SimpleNamespace(q=q + 0.3, foot=q)
    stretch = SimpleNamespace(corank=0, closest=closest, name=family.name)
    assert stretch_place(check, stretch) == place_name(found.robot, found.task, family)
    assert stretch_place(check, stretch).startswith(("shoulder", "elbow", "wrist"))
    closest.foot = np.zeros(0)
    assert stretch_place(check, stretch) == family.name
