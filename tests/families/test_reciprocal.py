"""Reciprocal wrenches give exact singular configurations of every family they can meet, and refuse what they cannot."""

from __future__ import annotations

import json

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from reference import arms
from reference.kinematics import jacobian as reference_jacobian

from rankdrop.codec import json_text, record_of
from rankdrop.cover.setting import enclose, settings_for
from rankdrop.errors import OptionError
from rankdrop.families.incidence import families_at
from rankdrop.families.reciprocal import EXACT
from rankdrop.families.searching import refine, search
from rankdrop.local.block import generic_rank
from rankdrop.results.known import shipped
from rankdrop.robot.model import Joint, JointKind, Robot
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema
from rankdrop.task import resolve_task
from rankdrop.tolerances import DEFAULT

ARMS = ("planar3r", "almarkhi4", "ur5", "puma560", "pa10", "panda", "stanford", "canadarm2", "scara")


@pytest.mark.spread(1)
@pytest.mark.slow
@pytest.mark.by_hand_at("canadarm2", "almarkhi4", "pa10", "puma560", "stanford")
@pytest.mark.by_hand_at("panda")
@pytest.mark.parametrize("name", ARMS)
def test_every_configuration_is_singular_to_rounding(name):
    robot = open_robot(name)
    found = search(robot, 1, starts=400, method="reciprocal", seed=2)
    assert len(found.q) == 400
    assert len(set(found.stratum.tolist())) >= 2
    task = resolve_task(None, robot)
    scale = task.scale(robot)
    for q in found.q[:60]:  # an independent model of the arm agrees
        full = reference_jacobian(robot, q)[list(task.rows)] if name != "canadarm2" else None
        if full is None:
            continue
        full = full / np.array([scale if row < 3 else 1.0 for row in task.rows])[:, None]
        sigma = np.linalg.svd(full, compute_uv=False)
        assert sigma[found.rank] <= 10 * EXACT * sigma[0]
    assert (found.sigma[:, found.rank] <= EXACT * found.sigma[:, 0]).all()
    assert (np.abs(found.q[:, robot.periodic]) <= np.pi).all()


FAMILIES = {"puma560": 3, "pa10": 4, "panda": 4, "scara": 1}


@pytest.mark.by_hand
@pytest.mark.by_hand_at("panda")
@pytest.mark.slow_at("panda", "pa10")
@pytest.mark.parametrize("name", FAMILIES)
def test_shoulder_elbow_and_wrist_are_among_them(name):
    robot = open_robot(name)
    found = search(robot, 1, starts=300, method="reciprocal", seed=1)
    task = resolve_task(None, robot)
    families = [one for one in shipped(name).families if one.corank == 1]
    met = {one.family.id for q in found.q for one in families_at(families, robot, q, task, DEFAULT)}
    assert len(met) >= FAMILIES[name]


@pytest.mark.by_hand
def test_every_stratum_has_families_of_its_own():
    # at two joints a random wrench goes past the wrist centre, so that axes 4 and 6 align; nothing else comes of it
    robot = open_robot("puma560")
    found = search(robot, 1, starts=1500, method="reciprocal", seed=1)
    task = resolve_task(None, robot)
    families = [one for one in shipped("puma560").families if one.corank == 1]
    names = np.array(found.strata)[found.stratum]
    begins = {"joint 2 alone": "shoulder", "joint 3 alone": "elbow", "joint 5 alone": "wrist",
              "wrenches of joints 1-2": "wrist"}  # fmt: skip
    for stratum, name in begins.items():
        met = [families_at(families, robot, q, task, DEFAULT) for q in found.q[names == stratum]]
        assert len(met) > 20
        share = np.mean([any(one.family.name.startswith(name) for one in here) for here in met])
        assert share > (0.9 if "wrenches" in stratum else 0.2), stratum
        assert all(met)


@pytest.mark.by_hand
@pytest.mark.by_hand_at("ur5-2")
@pytest.mark.slow_at("ur5-2", "puma560-2")
@pytest.mark.parametrize(("name", "corank"), [("puma560", 2), ("ur5", 2)])
def test_higher_coranks_are_drawn_too(name, corank):
    robot = open_robot(name)
    found = search(robot, corank, starts=300, method="reciprocal", seed=2)
    assert len(found.q) == 300
    assert found.rank == 6 - corank
    assert not any("wrenches" in one for one in found.strata)
    task = resolve_task(None, robot)
    for q in found.q[:60]:
        full = reference_jacobian(robot, q) / np.array([task.scale(robot)] * 3 + [1.0] * 3)[:, None]
        sigma = np.linalg.svd(full, compute_uv=False)
        assert sigma[6 - corank] <= 10 * EXACT * sigma[0]
    families = [one for one in shipped(name).families if one.corank == corank]
    met = {one.family.id for q in found.q for one in families_at(families, robot, q, task, DEFAULT)}
    assert met == {one.id for one in families}


@pytest.mark.slow
def test_a_corank_that_an_arm_has_nowhere_is_told():
    with pytest.raises(OptionError, match="no reciprocal wrench"):
        search(open_robot("scara"), 3, starts=10, method="reciprocal")
    with pytest.raises(OptionError, match="corank"):
        search(open_robot("scara"), 5, starts=10, method="reciprocal")


def test_a_slide_that_is_pinned_is_solved_for():
    """Two parallel axes and a slide between them that brings one onto the other."""
    turn, slide = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    away = [0.0, -0.25, 0.0, 0.0, 0.0, 1.0]
    joints = [Joint("a", JointKind.REVOLUTE, np.array(turn)),
              Joint("b", JointKind.PRISMATIC, np.array(slide), lower=-1.0, upper=1.0),
              Joint("c", JointKind.REVOLUTE, np.array(away))]  # fmt: skip
    home = np.eye(4)
    home[0, 3] = 0.5
    found = search(Robot("rpr", tuple(joints), home, task="planar"), 1, starts=100, method="reciprocal")
    assert set(np.array(found.strata)[found.stratum]) >= {"joint 2 alone", "joints 1, 2 together"}
    np.testing.assert_allclose(found.q[:, 1], -0.25, atol=1e-12)


@pytest.mark.slow
def test_same_seed_same_configurations_and_another_seed_others():
    robot = open_robot("ur5")
    one, same, other = (search(robot, 1, starts=50, method="reciprocal", seed=seed).q for seed in (3, 3, 4))
    assert (one == same).all()
    assert not np.isclose(one, other).all()


def test_within_limits_every_configuration_is_inside_them():
    robot = open_robot("panda")
    found = search(robot, 1, starts=20, method="reciprocal", limits=True)
    assert len(found.q) == 20
    assert ((found.q >= robot.lower) & (found.q <= robot.upper)).all()


def test_an_arm_in_millimetres_has_the_same_ones():
    robot = open_robot("stanford")
    from reference import region

    one = search(robot, 1, starts=40, method="reciprocal", seed=5).q
    big = search(region.scaled(robot, 1000.0), 1, starts=40, method="reciprocal", seed=5).q
    turns = [j for j, joint in enumerate(robot.variables) if joint.unit == "rad"]
    np.testing.assert_allclose(one[:, turns], big[:, turns], atol=1e-7)


@pytest.mark.slow
def test_random_arms_have_them_too_and_searching_from_them_stays():
    for seed, kinds in ((1, "rrrrrr"), (2, "rrrrrrr"), (3, "rprrrr")):
        robot = arms.random_chain(np.random.default_rng(seed), kinds)
        found = search(robot, 1, starts=40, method="reciprocal", seed=seed)
        assert len(found.q) == 40
        again = refine(robot, found.q, 1)
        assert (np.abs(again.q - found.q).max(axis=1) < 1e-9).all()


def test_the_record_satisfies_its_schema_and_tells_the_strata():
    record = json.loads(json_text(record_of("find", search(open_robot("ur5"), 1, starts=40, method="reciprocal"))))
    Draft202012Validator(load_schema("find")).validate(record)
    assert sum(one["count"] for one in record["strata"]) == 40
    assert all(one["residual"] <= EXACT for one in record["strata"])


@pytest.mark.by_hand
@pytest.mark.by_hand_at("fetch-vx,vy")
@pytest.mark.slow_at("fetch-vx,vy", "ur5-position", "puma560-orientation")
@pytest.mark.parametrize(("name", "task"), [
    ("scara", "pose"), ("xarm5", None), ("open_manipulator", None), ("fetch", "vx,vy"), ("ur5", "position"),
    ("puma560", "orientation"),
])  # fmt: skip
def test_any_task_is_drawn_of(name, task):
    """Arms that never fill their task, tasks of some rows, whole blocks: by Newton's method at least."""
    robot = open_robot(name)
    found = search(robot, 1, starts=60, method="reciprocal", task=task)
    assert len(found.q) == 60
    assert (found.sigma[:, found.rank] <= EXACT * found.sigma[:, 0]).all()
    assert found.rank == generic_rank(robot, resolve_task(task, robot)) - 1


def test_mimics_and_screws_are_drawn_of_too():
    from reference import region

    coupled = region.coupled(np.random.default_rng(6), "r r r1:0.3 r r r r")
    for robot in (coupled, arms.random_chain(np.random.default_rng(5), "rhrrrr")):
        found = search(robot, 1, starts=60, method="reciprocal")
        assert len(found.q) == 60
        assert not any("wrenches" in one for one in found.strata)
        sigma = np.linalg.svd(reference_jacobian(robot, found.q[0]) / np.array(
            [resolve_task(None, robot).scale(robot)] * 3 + [1.0] * 3)[:, None], compute_uv=False)  # fmt: skip
        assert sigma[found.rank] <= 10 * EXACT * sigma[0]


def test_what_is_no_search_is_refused():
    with pytest.raises(OptionError, match="nothing is iterated"):
        search(open_robot("ur5"), 1, method="reciprocal", iterations=5)


@pytest.mark.by_hand
def test_families_of_four_conditions_are_met_from_a_joint_at_a_right_angle():
    """Two families of the Cobotta pin joints 2 to 5 all at once: random starts of these four hardly ever lead there."""
    robot = open_robot("cobotta")
    found = search(robot, 2, starts=600, method="reciprocal", seed=1)
    families = [one for one in shipped("cobotta").families if one.id in ("k2.f1", "k2.f2")]
    names = np.array(found.strata)[found.stratum]
    task = resolve_task(None, robot)
    on = [families_at(families, robot, q, task, DEFAULT) for q in found.q]
    from_a_pin = ["joint" in name and " at " in name for name in names]
    assert {one.family.id for here, pin in zip(on, from_a_pin, strict=True) if pin for one in here} == {
        "k2.f1", "k2.f2"}  # fmt: skip


@pytest.mark.slow
@pytest.mark.by_hand_at("pa10", "stanford", "panda")
@pytest.mark.parametrize("name", ["ur5", "puma560", "pa10", "panda", "almarkhi4", "stanford"])
def test_no_enclosure_around_one_is_called_free(name):
    """The oracle of certificates: a ball or box proven free holds none of them."""
    robot = open_robot(name)
    q = search(robot, 1, starts=200, method="reciprocal", seed=6).q
    rng = np.random.default_rng(7)
    for setting in settings_for(robot, resolve_task(None, robot))[::6]:
        half = rng.uniform(0, 0.3, (len(q), 1)) ** 2 * np.ones_like(q)
        centre = np.ascontiguousarray(q + rng.uniform(-1, 1, q.shape) * half * setting.scale * 0.999)
        assert not enclose(robot, setting, centre, half)[0].any()
        away = np.linalg.norm(((centre - q) / setting.scale)[:, setting.matters], axis=1)
        assert (enclose(robot, setting, centre, radius=3.0)[1] <= away * (1 + 1e-12)).all()
