"""Named on the spot as in the atlas: dimension, joints and name, for the arms that have an atlas to compare with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known.arms import KINDS
from known.members import members

from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.families import on_the_spot
from rankdrop.families.evidence import ObtainedFrom
from rankdrop.families.name import FamilyName
from rankdrop.families.naming import name_family
from rankdrop.families.on_the_spot import name_on_the_spot
from rankdrop.families.record import Family, LocalConditions
from rankdrop.families.table import _told_apart as told_apart_rows
from rankdrop.kinematics import task_jacobian
from rankdrop.local.block import singular_values
from rankdrop.problem import wrap
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import shipped
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.text.family_conditions import local_conditions

H = np.pi / 2
EACH = 2
DIFFERENT = {("canadarm2", "k2.f2"), ("gen3", "k1.f1"), ("tiago", "k1.f1")}
"""Families whose members get another name: with θ3 = θ5 = 0 more axes of Canadarm2 are aligned than on all of its
k2.f2, Gen3 is nearly degenerate by its offset of 12 mm, and TIAGo's k1.f1 is two sets, θ3 = 0 and θ3 = π, each with
values of θ4 of its own."""
UNLIKE = {("canadarm2", "k1.f1"), ("gen3", "k1.f1"), ("tiago", "k1.f1")}
"""Those whose joints may come out otherwise: members of Canadarm2's k1.f1 next to a place where D loses rank."""


def alike(found: Family, family: Family) -> bool:
    """Same dimension and free joints; pinned here is what is pinned there.

    Conditions of an atlas may hold a joint at some values without naming them: it is coupled there, and pinned here.
    """
    pinned = {one.number for one in found.pinned}
    return (found.dimension, found.free) == (family.dimension, family.free) and (
        {one.number for one in family.pinned} <= pinned <= {one.number for one in family.pinned} | set(family.coupled)
    )


@pytest.fixture
def whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """Names on the spot are not cut at 60 characters."""
    monkeypatch.setattr(on_the_spot, "shorten_names", list)


def whole_name(atlas: Analysis, family: Family) -> FamilyName:
    """The name of a family, of any length, from members all over it."""
    points = members(atlas.robot, atlas.task, family, 12, seed=9)
    pinned = [one.number for one in family.pinned]
    return name_family(atlas.robot, atlas.task, points, pinned, coupled=family.coupled)


def facts_of(name: FamilyName) -> FamilyName:
    """Parts and details of a name."""
    return FamilyName(name.parts, name.independent, name.details)


def same_name(found: Family, whole: FamilyName) -> bool:
    """The same facts, and the same condition; a joint that it holds at a few values has its value in the name here."""
    free = {joint.number for joint in found.called.bound}
    held = {joint.number for joint in whole.bound}
    valued = held - free
    named = {one.number for one in found.pinned} | set(found.coupled)
    same = facts_of(found.called) == facts_of(whole) and free <= held and valued <= named
    return same and valued <= {one.joint.number for one in found.called.values}


@pytest.mark.spread(4)
@pytest.mark.by_hand_at("canadarm2", "iiwa14", "kr16", "tiago", "yumi")
@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_members_of_an_atlas_are_named_as_in_it(name: str, whole: None) -> None:
    """Word for word, and the atlas has these names, cut and told apart."""
    atlas = shipped(name)
    full = {family.id: whole_name(atlas, family) for family in atlas.families}
    for summary in atlas.coranks:
        rows = atlas.of_corank(summary.corank)
        if not any((name, family.id) in DIFFERENT for family in rows):
            made = told_apart_rows([replace(family, called=full[family.id]) for family in rows])
            assert [family.name for family in made] == [family.name for family in rows]
    for family in atlas.families:
        q = members(atlas.robot, atlas.task, family, EACH, seed=5)
        assert len(q) == EACH
        for configuration in q:
            found = name_on_the_spot(atlas.robot, configuration, atlas.task, family.corank)
            if (name, family.id) not in DIFFERENT:
                assert same_name(found, full[family.id]), (family.id, found.name, full[family.id])
            if (name, family.id) in UNLIKE:
                continue
            assert alike(found, family), (family.id, found)
            assert not found.parts
            here = {one.number: one for one in found.pinned}
            for row in family.pinned:
                one = here[row.number]
                assert min(abs(float(wrap(np.array(one.values[0] - v)))) for v in row.values) < 1e-9
                assert abs(float(wrap(np.array(one.values[0] - configuration[one.number - 1])))) < 1e-6


@pytest.mark.parametrize(
    ("name", "q", "corank", "words"),
    [
        ("pa10", [0.3, 0.4, 0.5, 0.0, 0.2, 0.4, 1.0], 1, ("θ4 = 0",)),
        ("pa10", [0.3, 0.0, 0.0, 0.0, 0.2, 0.3, 1.0], 2, ("θ2 = 0", "θ3 = 0", "θ4 = 0")),
        ("ur5", [0.3, -1.0, 0.0, 0.4, 0.7, 1.0], 1, ("θ3 = 0",)),
        ("stanford", [0.3, 0.4, 0.0, 0.7, 0.9, 1.0], 1, ("q3 = 0 m",)),
    ],
)
def test_conditions_in_words(name: str, q: list[float], corank: int, words: tuple[str, ...]) -> None:
    robot = open_robot(name)
    found = name_on_the_spot(robot, q, resolve_task(None, robot), corank)
    if name == "pa10" and corank == 2:  # what AM's Table 4 pins there, whatever the number of joints
        assert set(local_conditions(found)) <= {*words, "coupled: joints 2 and 3"}
        assert found.pinned
    else:
        assert local_conditions(found) == words


def test_where_families_meet_all_of_them_are_listed() -> None:
    robot = open_robot("iiwa14")
    found = name_on_the_spot(robot, [0.1, 0.0, H, 0.0, 0.3, 1.2, 0.0], resolve_task(None, robot), 1)
    assert found.parts
    assert found.name.startswith("meeting point of families: ")
    assert "elbow: arm stretched or folded" in found.name
    assert len(found.parts) >= 2
    assert {part.dimension for part in found.parts} >= {6}


def test_a_square_condition_is_found_where_d_vanishes() -> None:
    """det J of the Stanford arm is q3² sin θ2 sin θ5: D = 0 all over q3 = 0."""
    robot = open_robot("stanford")
    task = resolve_task(None, robot)
    found = name_on_the_spot(robot, [0.3, 0.4, 0.0, 0.7, 0.9, 1.0], task, 1)
    assert found.dimension == 5
    assert [(one.number, one.values) for one in found.pinned] == [(3, (0.0,))]
    assert found.evidence.kind is ObtainedFrom.SHARED_VALUES


def test_the_equation_of_coupled_joints_is_fitted_when_asked_for(rng: np.random.Generator) -> None:
    atlas = shipped("puma560")
    family = next(f for f in atlas.families if f.coupled and f.corank == 1)
    q = members(atlas.robot, atlas.task, family, 1)[0]
    plain = name_on_the_spot(atlas.robot, q, atlas.task, 1)
    assert plain.equations == ()
    assert local_conditions(plain)[-1].startswith("coupled: joints ")
    fitted = name_on_the_spot(atlas.robot, q, atlas.task, 1, fit=True)
    assert fitted.equations
    others = members(atlas.robot, atlas.task, family, 20, seed=77)
    near: Array = np.array([[abs(float(e(x))) for e in fitted.equations] for x in others])
    assert np.median(near.max(axis=1)) < 1e-8 or (near[:, -1] < 1e-8).mean() > 0.3
    assert "coupled" not in local_conditions(fitted)[-1]


def test_the_same_seed_gives_the_same_family_and_another_the_same_name() -> None:
    robot = open_robot("panda")
    task = resolve_task(None, robot)
    q = members(robot, task, shipped("panda").families[2], 1)[0]
    corank = shipped("panda").families[2].corank
    first = name_on_the_spot(robot, q, task, corank, seed=1)
    assert name_on_the_spot(robot, q, task, corank, seed=1).local == first.local
    assert name_on_the_spot(robot, q, task, corank, seed=2).name == first.name


def test_an_arm_without_an_atlas_is_named_too(rng: np.random.Generator) -> None:
    """PA-10 with other lengths of links: the same conditions."""
    robot = open_robot("pa10")
    stretch = np.array([1.3, 1.3, 1.3, 1, 1, 1])
    joints = tuple(replace(joint, screw=joint.screw * stretch) for joint in robot.joints)
    home = robot.home.copy()
    home[:3, 3] *= 1.3
    longer = replace(robot, joints=joints, home=home)
    found = name_on_the_spot(longer, [0.3, 0.4, 0.5, 0.0, 0.2, 0.4, 1.0], resolve_task(None, longer), 1)
    assert found.name == "elbow: arm stretched or folded"


def test_a_regular_configuration_and_broken_input_are_refused() -> None:
    robot = open_robot("pa10")
    task = resolve_task(None, robot)
    q = np.array([0.3, 0.4, 0.5, 0.9, 0.2, 0.4, 1.0])
    assert singular_values(robot, q, task)[-1] > 1e-3
    assert task_jacobian(robot, q, task).shape == (6, 7)
    with pytest.raises(ConfigurationError, match="does not have this corank"):
        name_on_the_spot(robot, q, task, 1)
    with pytest.raises(ConfigurationError):
        name_on_the_spot(robot, np.zeros(6), task, 1)
    for corank in (0, 7):
        with pytest.raises(OptionError):
            name_on_the_spot(robot, np.zeros(7), task, corank)


@pytest.mark.parametrize(
    ("multiples", "value", "words"),
    [((0, 0, 1, 0, 1), 0.0, "θ3 + θ5 = 0"), ((0, 2, 0, -1), np.pi, "2 θ2 − θ4 = π"), ((-1, 3), 0.0, "−θ1 + 3 θ2 = 0")],
)
def test_a_relation_of_angles_in_words(multiples: tuple[int, ...], value: float, words: str) -> None:
    robot = open_robot("ur5")
    found = name_on_the_spot(robot, [0.3, -1.0, 0.0, 0.4, 0.7, 1.0], resolve_task(None, robot), 1)
    local = LocalConditions(relations=((multiples, value),))
    assert local_conditions(replace(found, pinned=(), local=local)) == (words,)


def test_a_place_without_conditions_says_why() -> None:
    robot = open_robot("ur5")
    found = name_on_the_spot(robot, [0.3, -1.0, 0.0, 0.4, 0.7, 1.0], resolve_task(None, robot), 1)
    alone = replace(found, local=LocalConditions(isolated=True))
    assert local_conditions(alone) == ("an isolated singular configuration",)
    assert local_conditions(replace(found, named=False)) == ("no condition found around it",)
