"""Facts about axes: what holds always is the arm's structure, and a fact costs the rank that it states, and never less.
"""

from __future__ import annotations

import numpy as np
import pytest
from reference.arms import remade
from reference.kinematics import exponential

from rankdrop.families.facts import Structure, candidate_facts, structure_of
from rankdrop.families.name import Centre, Geometry
from rankdrop.families.points import cloud
from rankdrop.local.axes import Scene
from rankdrop.local.block import generic_rank, sample, singular_values
from rankdrop.results.known import shipped
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import Task, resolve_task

TIGHT = ("puma560", "ur5", "anthropomorphic", "scara", "planar3r", "irb140")
"""Arms with as many joints as their rank."""


def known(name: str, task: str | None = None) -> tuple[Robot, Task, Structure]:
    robot = open_robot(name)
    resolved = resolve_task(task, robot)
    return robot, resolved, structure_of(robot, resolved, generic_rank(robot, resolved))


@pytest.mark.parametrize(
    ("name", "shoulder", "wrist", "wrist_point", "bundles"),
    [
        ("puma560", (), (3, 4, 5), (), ((1, 2),)),
        ("iiwa14", (0, 1, 2), (4, 5, 6), (), ()),
        ("panda", (0, 1, 2), (), (4, 5), ()),
        ("ur5", (), (), (), ((1, 2, 3),)),
        ("planar3r", (), (), (), ((0, 1, 2),)),
        ("stanford", (), (3, 4, 5), (), ()),
    ],
)
def test_known_arms_have_their_structure(
    name: str, shoulder: tuple[int, ...], wrist: tuple[int, ...], wrist_point: tuple[int, ...],
    bundles: tuple[tuple[int, ...], ...],
) -> None:  # fmt: skip
    found = known(name)[2]
    assert (found.shoulder, found.wrist, found.wrist_point) == (shoulder, wrist, wrist_point)
    assert found.bundles == bundles


def test_the_structure_does_not_depend_on_where_the_base_stands() -> None:
    robot, task, found = known("puma560")
    motion = exponential(np.array([0.3, -0.2, 0.5, 0.6, 0.0, 0.8]), 1.9)
    other = structure_of(remade(robot, motion=motion, sign=-1.0), task, 6)
    assert (other.wrist, other.bundles, other.tight) == (found.wrist, found.bundles, found.tight)


def test_the_tip_takes_the_place_of_the_wrist_centre_where_the_task_leaves_rotation_free() -> None:
    robot, _, found = known("anthropomorphic", "position")
    scene = Scene(robot, sample(robot, resolve_task("position", robot), 5, 1))
    assert (found.tip_is_centre, found.centre_kind) == (True, Centre.TIP)
    assert found.centre(scene) == pytest.approx(scene.tip)
    assert known("puma560")[2].centre_kind is Centre.WRIST
    assert known("ur5")[2].centre(scene) is None


@pytest.mark.parametrize("name", TIGHT)
def test_no_fact_that_costs_rank_holds_where_the_rank_is_full(name: str) -> None:
    robot, task, structure = known(name)
    q = sample(robot, task, 300, 5)
    q = q[singular_values(robot, q, task)[:, -1] > 1e-3]
    scene = Scene(robot, q)
    at_singular = Scene(robot, cloud(robot, task, 1, 60).q)
    for facts_of in (scene, at_singular):
        for fact in candidate_facts(structure, facts_of):
            assert not (fact.losses and fact.holds(scene).any()), (fact.geometry, fact.joints)


@pytest.mark.parametrize(("name", "corank"), [(name, corank) for name in TIGHT for corank in (1, 2)])
def test_a_fact_lowers_the_rank_by_what_it_states(name: str, corank: int) -> None:
    """At every singular configuration of a search, by singular values of the Jacobian."""
    robot, task, structure = known(name)
    points = cloud(robot, task, corank, 60).q
    seen = 0
    for q in points:
        scene = Scene(robot, q[None])
        lost = int((singular_values(robot, q, task) < 1e-7).sum())
        for fact in candidate_facts(structure, scene):
            if fact.holds(scene)[0]:
                assert fact.losses <= lost, (fact.geometry, fact.joints)
                seen += fact.losses > 0
    assert seen > 0 or not len(points)


def test_a_stretched_arm_of_seven_joints_is_named_so_at_its_elbow_alone() -> None:
    robot, task, structure = known("iiwa14")
    q = sample(robot, task, 40, 2)
    q[:20, 3] = 0.0
    (stretched,) = [fact for fact in candidate_facts(structure, Scene(robot, q)) if fact.geometry is Geometry.STRETCHED]
    assert stretched.holds(Scene(robot, q)).tolist() == [True] * 20 + [False] * 20


@pytest.mark.parametrize("name", ["puma560", "ur5", "irb140", "anthropomorphic"])
def test_each_family_of_corank_one_has_a_fact_about_its_part_of_the_arm(name: str) -> None:
    """Shoulder, elbow and wrist of the catalogue: at its witness such a fact of this part holds, and of no other."""
    robot, _, structure = known(name)
    families = [family for family in shipped(name).families if family.corank == 1]
    assert {family.name.split(":")[0] for family in families} >= {"shoulder", "elbow"}
    for family in families:
        scene = Scene(robot, np.array([family.witness]))
        facts = [fact for fact in candidate_facts(structure, scene) if fact.losses and fact.holds(scene)[0]]
        assert {str(role) for fact in facts for role in fact.roles} == {family.name.split(":")[0]}
