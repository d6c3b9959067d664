"""Conditions of a family for people: values in degrees, exact where they are shipped, never many terms."""

from __future__ import annotations

from dataclasses import replace

import pytest
from text.bent import bent

from rankdrop import analyze, conditions
from rankdrop.families.record import with_exact
from rankdrop.results.known import known_names, shipped
from rankdrop.results.stored_conditions import shipped_conditions
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.robot.screws import from_screws
from rankdrop.task import resolve_task
from rankdrop.text.families import conditions_of
from rankdrop.text.family_conditions import LONGEST, condition_sentences

pytestmark = pytest.mark.shipped


def told(name: str, id: str, robot: Robot | None = None) -> tuple[str, ...]:
    arm = robot or open_robot(name)
    (family,) = (one for one in shipped(name).families if one.id == id)
    return condition_sentences(arm, resolve_task(None, arm), family)


@pytest.mark.parametrize(
    ("name", "id", "expected"),
    [
        ("panda", "k1.f4", ("θ4 = −26.76° or 153.24°", "θ5 = 0 or π")),
        ("puma560", "k1.f3", ("θ5 = 0 or π",)),
        ("ur5e", "k1.f1", ("a2 c2 + a3 c23 + d5 s234 = 0, a2 = −0.425 m, a3 = −0.3922 m, d5 = 0.0997 m",)),
        ("panda", "k1.f1", ("θ2 = 0 or π", "a long condition on joints 3, 4, 5, 6 (`rankdrop conditions` prints it)")),
        ("scara", "k1.f1", ("θ2 = 0 or π",)),
    ],
)
def test_a_family_of_the_catalogue_is_told_exactly_with_its_lengths(
    name: str, id: str, expected: tuple[str, ...]
) -> None:
    assert told(name, id) == expected


def test_of_another_arm_the_conditions_are_those_of_its_own_families() -> None:
    ur = open_robot("ur5e")
    home = ur.home.copy()
    home[0, 3] += 1e-3
    screws = [joint.screw for joint in ur.joints]
    bent = from_screws(screws, order="linear-first", kinds="RRRRRR", name="mine", home=home)
    (text,) = told("ur5e", "k1.f1", bent)
    assert "a2" not in text
    assert text.endswith(" = 0")


def test_a_condition_in_which_an_angle_is_only_squared_is_told_with_its_joints() -> None:
    """c4² is of joint 4: the joints of a condition come from its terms, not from its text."""
    assert told("gen3_lite", "k2.f3")[2].startswith("d3² d4² + d5² (a2² c4² − a2² + d3² c4²) = 0, a2 = 0.28 m")
    assert told("crb15000", "k1.f1") == (
        "a long condition on joints 2, 3, 4, 5 (`rankdrop conditions` prints it)",
    )
    assert told("gen3", "k1.f1") == ("4 long conditions on joints 2, 3, 4, 5, 6 (`rankdrop conditions` prints them)",)


@pytest.mark.parametrize("name", known_names()[::7])
def test_no_line_is_longer_than_can_be_read(name: str) -> None:
    arm = open_robot(name)
    task = resolve_task(None, arm)
    for family in shipped(name).families:
        lines = condition_sentences(arm, task, family)
        assert lines
        assert all(len(line) <= LONGEST + 80 for line in lines)  # the values of its lengths stand after it


def test_the_report_shows_the_exact_conditions_in_place_of_the_fitted_ones() -> None:
    found, derived = shipped("panda"), shipped_conditions("panda")
    assert derived is not None
    families = with_exact(found.families, derived.families)
    labels = {label for family in families for label, _ in conditions_of(family)}
    assert labels == {"exactly"}
    fifth = families[4]
    assert fifth.id == "k1.f5"
    assert conditions_of(fifth) == [
        ("exactly", "a3 c4 (a6 + s6 (d3 + d5)) − s4 (a3² s6 − a6 d3 − d3 d5 s6) = 0")
    ]
    assert conditions_of(found.families[4])[0][0] != "exactly"
    other = replace(found.families[4], corank=2)
    assert with_exact([other], derived.families)[0].exact is None


def test_where_conditions_count_an_angle_from_elsewhere_the_joints_own_value_is_told() -> None:
    lines = str(conditions(bent(), task="planar", points=0)).splitlines()
    at = next(i for i, line in enumerate(lines) if line.strip() == "θ2 = 0 or π")
    assert lines[at + 1].strip() == "the joint's own value: q2 = −22.92° or 157.08°"


def test_inside_limits_the_table_says_all_of_a_joint_at_one_of_its_values() -> None:
    """A line "exactly θ2 = 0 or π" beside θ2 = −22.9° would contradict it, and tell a value that is outside."""
    joints = [replace(joint, lower=-1.0, upper=1.0) for joint in bent().joints]
    found = analyze(replace(bent(), joints=tuple(joints)), "planar", starts=200, limits=True)
    (row,) = found.families
    assert [round(value, 9) for value in row.pinned[0].values] == [-0.4]
    assert found.exact is not None
    assert found.exact.agrees
    assert conditions_of(row) == []
