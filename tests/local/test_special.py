"""The first lines of `explain` name the part of the arm: random singular configurations of catalogue arms."""

from __future__ import annotations

import re
from textwrap import wrap

import numpy as np
import pytest

from rankdrop.families.points import members
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.local.special import Part, Shape, specials_at
from rankdrop.results.known import shipped
from rankdrop.robot.dh import from_dh
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.text.special import family_label, family_title, place_parts
from rankdrop.text.verdict import summary_lines
from rankdrop.verbs.explain import explain

SOME = ("ur5e", "crx10ia", "gen3", "panda", "sawyer", "j2n6s300", "scara", "pa10")
MORE = ("xarm6", "crb15000", "hc10", "gen3_lite", "cobotta", "baxter", "rizon4", "m1n6s200", "yumi", "tiago", "so101",
        "open_manipulator", "canadarm2", "rcrrrr", "fetch8", "puma560", "planar3r", "almarkhi4")  # fmt: skip


def check(name: str, each: int) -> None:
    """The first line names a part, the answer has at most six lines of 80 columns, and says nothing of screws."""
    found = shipped(name)
    for family in found.families:
        points = members(found.robot, found.task, family, 8, seed=5)[:each]
        for q in points if len(points) else np.array([family.witness]):
            if family.corank > 3:
                continue
            lines = summary_lines(explain(found.robot, q, found.task))
            assert re.search(r"shoulder|elbow|wrist", lines[0]), (q, lines[0])
            assert "screw" not in " ".join(lines), lines
            assert len(wrap(lines[0], 80)) + sum(len(wrap(line, 78)) for line in lines[1:]) <= 6, (q, lines)


@pytest.mark.parametrize("name", SOME)
def test_the_answer_names_a_part_of_the_arm(name: str) -> None:
    check(name, 1)


@pytest.mark.spread(4)
@pytest.mark.by_hand_at("yumi", "canadarm2", "tiago", "fetch8")
@pytest.mark.slow
@pytest.mark.parametrize("name", MORE)
def test_the_answer_names_a_part_of_more_arms(name: str) -> None:
    check(name, 4)


@pytest.mark.parametrize(
    ("q", "part", "shape", "joint"),
    [
        ([0.3, -0.7, 0.5, 0.2, 0.0, 0.4], Part.WRIST, Shape.JOINT, 5),
        ([0.3, -0.7, 0.0, 0.2, 0.9, 0.4], Part.ELBOW, Shape.STRETCHED, 3),
        ([0.3, -0.7, np.pi, 0.2, 0.9, 0.4], Part.ELBOW, Shape.FOLDED, 3),
    ],
)
def test_the_parts_of_an_arm_of_universal_robots(q: list[float], part: Part, shape: Shape, joint: int) -> None:
    arm = shipped("ur5e")
    (one,) = specials_at(arm.robot, arm.task, np.array(q), 1)
    assert (one.part, one.shape, one.joint, one.exact) == (part, shape, joint, True)


SLIDES = [(0, -np.pi / 2, 0, 0), (0, -np.pi / 2, 0, -np.pi / 2), (0, 0, 0, np.pi / 2)]
WRIST = [(0, -np.pi / 2, 0, 0), (0, np.pi / 2, 0, 0), (0, 0, 0.15, 0)]


def test_the_wrist_of_a_gantry_is_no_elbow() -> None:
    gantry = from_dh(SLIDES + WRIST, kinds="PPPRRR", convention="standard")
    q = np.array([1.0, 2.0, 0.5, 0.3, 0.0, 0.2])
    (one,) = specials_at(gantry, resolve_task(None, gantry), q, 1)
    assert (one.part, one.joint, one.exact) == (Part.WRIST, 5, True)
    assert summary_lines(explain(gantry, q))[0].endswith("wrist: joint 5 at 0°.")


def test_a_slide_that_brings_the_wrist_onto_axis_2_is_named() -> None:
    """The wrist centre is 0.15 m from axis 1 then, not above it."""
    turret = [(0, -np.pi / 2, 0.4, 0), (0, np.pi / 2, 0.15, 0), (0, 0, 0.3, -np.pi / 2)]
    robot = from_dh(turret + WRIST, kinds="RRPRRR", convention="standard")
    task = resolve_task(None, robot)
    for q, shape, axis in (([0.3, 0.4, -0.3, 0.2, 0.5, 0.1], Shape.ON_AXIS, 2),
                           ([0.3, 0.0, 0.5, 0.2, 0.5, 0.1], Shape.ABOVE_AXIS, 1)):  # fmt: skip
        (one,) = specials_at(robot, task, np.array(q), 1)
        assert (one.part, one.shape, one.joint) == (Part.SHOULDER, shape, axis)


def test_slides_that_carry_an_arm_leave_it_no_shoulder_and_no_elbow() -> None:
    """PPRRRR, the table of IKBT issue 39: it is singular where 50 c4 + 7 s4 = 0 or √3 c4 s5 + 2 c5 s4 = 0."""
    half = np.pi / 2
    arm = from_dh([(0, -half, 0, 0), (0, half, 0, -half), (0, half, 0.1, 0), (0.25, np.pi / 6, 0.01, 0),
                   (0, 4 * np.pi / 3, 0.07, 0), (0.05, 0, -0.05831, 0)],
                  kinds="PPRRRR", convention="standard")  # fmt: skip
    task = resolve_task(None, arm)
    for q in (np.zeros(6), np.array([0.1, 0.2, 0.5, 0.4, np.arctan2(-2 * np.sin(0.4), np.sqrt(3) * np.cos(0.4)), 0.3])):
        assert singular_values(arm, q, task)[5] < 1e-12
        assert specials_at(arm, task, q, 1) == ()


def test_a_condition_that_is_nearly_satisfied_is_not_exact() -> None:
    """On the one sheet of a CRX the nearest condition of the ideal arm is named, with the angle that is missing."""
    found = shipped("crx10ia")
    for q in members(found.robot, found.task, found.families[0], 8, seed=3)[:3]:
        (one,) = specials_at(found.robot, found.task, q, 1)
        assert not one.exact
        assert 0 < one.off < np.radians(45)


def test_conditions_that_hold_together_are_named_though_slides_make_up_for_each() -> None:
    """At q = 0 of the RCRRRR arm joints 3 and 4 at 0° lose rank; with its slide neither of the two would alone."""
    arm = open_robot("rcrrrr")
    found = specials_at(arm, resolve_task(None, arm), np.zeros(arm.n), 1)
    assert [(one.part, one.shape, one.exact) for one in found] == [
        (Part.SHOULDER, Shape.ABOVE_AXIS, True), (Part.ELBOW, Shape.STRETCHED, True),
    ]  # fmt: skip


@pytest.mark.parametrize(("name", "q", "corank", "parts"), [
    ("five", [0.3, np.pi / 2, 0.0, 0.4, 0.2], 1, ["elbow"]),  # the wrist is above axis 1, which costs no rank
    ("puma560", "shoulder and elbow", 2, ["shoulder", "elbow"]),
    ("iiwa7", [0.3, 0.0, 0.4, 0.0, 0.6, 0.0, 0.2], 2, ["shoulder", "elbow", "wrist"]),
    ("iiwa7", [0.3, 0.0, 0.4, 0.0, 0.6, 0.7, 0.2], 1, ["elbow"]),
])  # fmt: skip
def test_a_part_is_named_where_its_condition_costs_rank(
    name: str, q: list[float] | str, corank: int, parts: list[str]
) -> None:
    """Law: at a configuration with one part named, the arm is regular once the joint of that part is moved."""
    if name == "five":
        half = np.pi / 2
        arm = from_dh([(0, half, 0.3, 0), (0.4, 0, 0, 0), (0.35, 0, 0, 0), (0, half, 0, half), (0, 0, 0.1, 0)],
                      convention="standard")  # fmt: skip
    else:
        arm = open_robot(name)
    task = resolve_task(None, arm)
    if isinstance(q, str):
        families = [family for family in shipped(name).families if family.corank == corank]
        q = next(list(family.witness) for family in families if family.called.short == q)
    rank = generic_rank(arm, task)
    sigma = singular_values(arm, np.array(q), task)
    assert int((sigma[:rank] <= 1e-9).sum()) == corank
    found = specials_at(arm, task, np.array(q), corank)
    assert [one.part.value for one in found] == parts
    if len(found) == 1:
        moved = np.array(q)
        moved[found[0].joint - 1] += 0.3
        assert singular_values(arm, moved, task)[rank - 1] > 1e-3


@pytest.mark.parametrize(("name", "id_", "words"), [
    ("px150", "k2.f1", "shoulder and elbow"), ("panda", "k2.f1", "shoulder and elbow"), ("puma560", "k1.f1", ""),
])  # fmt: skip
def test_a_family_of_two_lost_freedoms_has_the_parts_that_its_members_have(name: str, id_: str, words: str) -> None:
    """The label of the family and the headline at its witness name the same parts."""
    found = shipped(name)
    family = next(family for family in found.families if family.id == id_)
    here = place_parts(found.robot, found.task, np.array(family.witness), family.corank)
    assert here == family_label(found.robot, found.task, family)
    assert family_title(found.robot, found.task, family).startswith(words or family.name)
