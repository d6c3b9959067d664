"""Arms within a tolerance of one arm: the bound on their Jacobians is never passed, and nearly reached."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from reference import arms, region
from reference.displaced import displaced_arm

from rankdrop.cover.ball import ModelTolerance, certified_radius, displaced_columns, displaced_jacobian, points_of
from rankdrop.cover.certificates import asked_about, ball_certificate, verify, write_certificate
from rankdrop.cover.setting import settings_for, settings_for_near_arms
from rankdrop.errors import OptionError
from rankdrop.families.searching import search
from rankdrop.local.block import singular_values
from rankdrop.path.check.certificate import path_certificate, proven_for_near_arms
from rankdrop.path.check.check import check_path
from rankdrop.proof.record import with_hash
from rankdrop.robot.model import JointKind, Mimic
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

NEAR = ModelTolerance(3e-4, 1e-3)
ARMS = {
    **{name: (lambda name=name: open_robot(name)) for name in ("ur5", "puma560", "panda", "pa10")},
    "random 6R": lambda: arms.random_chain(np.random.default_rng(3), "rrrrrr"),
    "stanford": lambda: open_robot("stanford"),
    "random slides": lambda: arms.random_chain(np.random.default_rng(4), "prrprp"),
    "random screws": lambda: arms.random_chain(np.random.default_rng(5), "rhrphr"),
    "mimics": lambda: region.coupled(np.random.default_rng(6), "r p r1:0.3 p1:-0.4 r h0:2.5 r p0:0.3 r"),
}


def directions(rng, count, size):
    """(count, 3) vectors of one length in random directions."""
    found = rng.standard_normal((count, 3))
    return size * found / np.linalg.norm(found, axis=1, keepdims=True)


def moved_columns(robot, other, q, setting):
    """(N, 6) difference of the columns of two arms, both seen from link and point of a setting."""
    return region.columns(other, q, setting) - region.columns(robot, q, setting)


@pytest.mark.by_hand_at("random 6R", "random screws", "mimics", "pa10", "panda", "puma560", "random slides", "ur5")
@pytest.mark.slow
@pytest.mark.slow_at("random 6R", "panda", "mimics", "random screws", "puma560", "ur5", "pa10")
@pytest.mark.parametrize("name", ARMS)
def test_no_displaced_arm_goes_beyond_the_bound(name):
    robot = ARMS[name]()
    rng = np.random.default_rng(1)
    task = resolve_task("pose", robot)
    for setting in settings_for_near_arms(robot, task)[::4]:
        for _ in range(40):
            count = len(robot.joints)
            other = displaced_arm(robot, directions(rng, count, NEAR.angle), directions(rng, count, NEAR.length))
            q = rng.uniform(-np.pi, np.pi, robot.n)
            bound = displaced_columns(robot, setting, NEAR, task.rows, q)
            assert bound.any()
            change = np.linalg.norm(moved_columns(robot, other, q, setting), axis=1)
            assert (change <= bound * (1 + 1e-9) + 1e-13).all()  # rounding of the model


@pytest.mark.by_hand_at("puma560")
@pytest.mark.slow_at("stanford", "puma560")
@pytest.mark.parametrize("name", ["puma560", "stanford"])
def test_a_tool_point_is_moved_with_the_joints(name):
    robot = open_robot(name)
    rng = np.random.default_rng(2)
    setting = settings_for_near_arms(robot, resolve_task("position", robot))[0]
    count, best = len(robot.joints), 0.0
    for _ in range(300):
        tool = directions(rng, 1, NEAR.length)[0]
        other = displaced_arm(robot, directions(rng, count, NEAR.angle), directions(rng, count, NEAR.length))
        q = rng.uniform(-np.pi, np.pi, robot.n)
        there = replace(setting, point=tuple(np.array(setting.point) + tool))
        change = np.linalg.norm(
            (region.columns(other, q, there) - region.columns(robot, q, setting))[:, :3], axis=1
        )  # fmt: skip
        bound = displaced_columns(robot, setting, NEAR, (0, 1, 2), q)
        assert (change <= bound * (1 + 1e-9) + 1e-13).all()
        best = max(best, float((change / np.maximum(bound, 1e-12)).max()))
    assert best > 0.9  # the last axis: the tool point alone


def stretched(carrier):
    """Four turning joints in a row, the second made one that is three metres out along the row; and that posture."""
    robot = planar(4)
    joints, along = list(robot.joints), np.array([1.0, 0.0, 0.0])
    slide = np.concatenate([along, np.zeros(3)])
    screw = np.concatenate([3.0 / (2 * np.pi) * along, along])
    joints[1], q = {
        "slide": (replace(joints[1], kind=JointKind.PRISMATIC, screw=slide), [0.0, 3.0, 0.0, 0.0]),
        "slide that follows, by its offset": (
            replace(joints[1], kind=JointKind.PRISMATIC, screw=slide, mimic=Mimic("j1", 0.5, 3.0)), [0.0, 0.0, 0.0]),
        "slide that follows, by its multiplier": (
            replace(joints[1], kind=JointKind.PRISMATIC, screw=slide, mimic=Mimic("j1", 2.0, 0.0)), [1.5, 0.0, 0.0]),
        "screw": (replace(joints[1], kind=JointKind.HELICAL, screw=screw), [0.0, 2 * np.pi, 0.0, 0.0]),
        "screw that follows, by its offset": (
            replace(joints[1], kind=JointKind.HELICAL, screw=screw, mimic=Mimic("j1", 0.5, 2 * np.pi)),
            [0.0, 0.0, 0.0]),
    }[carrier]  # fmt: skip
    return replace(robot, joints=tuple(joints)), np.array(q)


def reached_by_turns(robot, q):
    """(N,) largest share of D_i that arms reach whose joints are all turned about one direction; 1 is never passed."""
    best, near = np.zeros(len(robot.joints)), ModelTolerance(0.0, 1e-3)
    for turn in near.angle * np.eye(3):
        other = displaced_arm(robot, np.tile(turn, (len(best), 1)), np.zeros((len(best), 3)))
        for setting in settings_for(robot, resolve_task("pose", robot)):
            bound = displaced_columns(robot, setting, near, setting.rows, q)
            change = np.linalg.norm(moved_columns(robot, other, q, setting), axis=1)
            assert (change <= bound * (1 + 1e-9) + 1e-12).all()
            best = np.maximum(best, change / np.maximum(bound, 1e-9))
    return best


@pytest.mark.parametrize("carrier", [
    "slide", "slide that follows, by its offset", "slide that follows, by its multiplier", "screw",
    "screw that follows, by its offset",
])  # fmt: skip
def test_the_bound_of_what_is_carried_far_out_is_reached(carrier):
    """Along an arm that is stretched out: the farther a joint carries, the more a turn before it moves the rest."""
    assert (reached_by_turns(*stretched(carrier)) > 0.9).sum() >= 3


@pytest.mark.parametrize("which", [0, 2, 3])
def test_the_bound_of_a_steep_screw_is_reached(which):
    """Its moment turns with its axis, pitch and all."""
    robot = planar(4)
    joints = list(robot.joints)
    steep = joints[which].screw + np.array([0.0, 0.0, 200.0, 0.0, 0.0, 0.0])
    joints[which] = replace(joints[which], kind=JointKind.HELICAL, screw=steep)
    assert reached_by_turns(replace(robot, joints=tuple(joints)), np.zeros(4))[which] > 0.95


@pytest.mark.by_hand_at("mimics")
@pytest.mark.slow
@pytest.mark.slow_at("mimics")
@pytest.mark.parametrize("name", ["random screws", "mimics"])
def test_near_arms_of_a_certified_ball_keep_their_rank(name, tmp_path):
    """Balls of joints that screw or follow others, proven again; near arms have σ above zero everywhere in them."""
    robot, rng = ARMS[name](), np.random.default_rng(3)
    q = rng.uniform(-0.8, 0.8, robot.n)
    near = ModelTolerance(1e-3, 3e-3)
    whole = certified_radius(robot, q, evaluations=2_000).radius
    record = ball_certificate(robot, q, tolerance=near, radius=0.3 * whole, evaluations=2_000)
    found = verify(write_certificate(record, tmp_path / "b.json"), robot)
    assert found.holds, found.reason
    scale, count = np.array(record["claim"]["scale"]), len(robot.joints)
    least = np.inf
    for _ in range(200):
        other = displaced_arm(robot, directions(rng, count, near.angle), directions(rng, count, near.length))
        at = q + directions(rng, robot.n, 1.0)[:, 0] * 0.3 * whole / np.sqrt(robot.n) * scale
        least = min(least, float(singular_values(other, at[None], resolve_task("pose", other))[0, -1]))
    assert least > 0.0
    record["tolerance"]["angle"] = 0.1
    assert not verify(write_certificate(with_hash(record), tmp_path / "b.json"), enclosures=500).holds


def test_columns_of_joints_that_follow_one_another_change_together():
    """What one variable drives: D_i of its joints, each times the size of its multiplier."""
    robot = ARMS["mimics"]()
    task = resolve_task("pose", robot)
    setting = settings_for_near_arms(robot, task)[0]
    each = displaced_columns(robot, setting, NEAR, task.rows)
    place = {joint.name: k for k, joint in enumerate(robot.variables)}
    expected = np.zeros(robot.n)
    for joint, one in zip(robot.joints, each, strict=True):
        leader, times = (joint.mimic.leader, abs(joint.mimic.multiplier)) if joint.mimic else (joint.name, 1.0)
        expected[place[leader]] += times * one
    np.testing.assert_allclose(displaced_jacobian(robot, setting, NEAR, task.rows), expected, rtol=1e-12)


@pytest.mark.parametrize(("name", "task"), [("stanford", None), ("puma560", "position"), ("scara", "position"),
                                            ("planar3r", "pose")])  # fmt: skip
def test_balls_for_near_arms_of_other_joints_and_tasks_are_proven_again(name, task, tmp_path):
    robot = open_robot(name)
    q = {"stanford": [0.3, 0.9, 0.5, 0.4, 1.2, 0.1], "puma560": [0.3, 0.4, -0.3, 0.4, 1.2, 0.1],
         "scara": [0.3, 1.2, 0.05, 0.2], "planar3r": [0.3, 1.2, 0.4]}[name]  # fmt: skip
    whole = certified_radius(robot, q, resolve_task(task, robot), evaluations=5_000).radius
    record = ball_certificate(robot, q, task, tolerance=NEAR, radius=0.3 * whole, evaluations=5_000)
    found = verify(write_certificate(record, tmp_path / "b.json"), robot)
    assert found.holds, found.reason
    assert "every arm within 0.0003 m" in found.claim
    record["tolerance"] |= {"angle": 0.1, "length": 0.5}
    assert not verify(write_certificate(with_hash(record), tmp_path / "b.json"), enclosures=500).holds


def planar(count):
    """Turning joints one metre apart, all axes parallel."""
    from rankdrop.robot.model import Joint, JointKind, Robot

    joints = []
    for i in range(count):
        frame = np.eye(4)
        frame[0, 3] = float(i)
        screw = np.concatenate([np.cross([float(i), 0.0, 0.0], [0.0, 0.0, 1.0]), [0.0, 0.0, 1.0]])
        joints.append(Joint(f"j{i + 1}", JointKind.REVOLUTE, screw, frame=frame))
    home = np.eye(4)
    home[0, 3] = float(count)
    return Robot("row", tuple(joints), home, task="planar")


def test_where_nothing_slides_the_polygon_of_the_points_is_all_there_is():
    """D_i by hand, seen from a point of the last link: how far turning joints stand from zero plays no part."""
    robot = open_robot("ur5")
    task = resolve_task("position", robot)
    (setting,) = settings_for_near_arms(robot, task)
    points, tip = points_of(robot), robot.home[:3, 3]
    corners = [tip, *points[::-1]]
    reach = np.cumsum([np.linalg.norm(b - a) for a, b in pairwise(corners)])[::-1]
    times = np.arange(5, -1, -1)  # joints between each and the last link, its own side included
    moment = NEAR.angle * (reach + (times + 1) * NEAR.length) + NEAR.length
    expected = (times * moment + NEAR.length) / setting.length
    for far in (None, np.zeros(6), np.full(6, 2.0)):
        bound = displaced_columns(robot, setting, NEAR, task.rows, far)
        np.testing.assert_allclose(bound, expected, rtol=1e-9)


def test_the_bound_is_reached_by_links_that_twist():
    """Stretched out, every link rolled about itself: all of D_i but what the moves add."""
    robot = planar(5)
    count = len(robot.joints)
    best = np.zeros(count)
    for near, moves in ((ModelTolerance(0.0, 1e-3), 0.0), (ModelTolerance(1e-3, 0.0), 1e-3)):
        turns = np.tile([near.angle, 0.0, 0.0], (count, 1))
        shift = np.tile([0.0, moves, 0.0], (count, 1))
        other = displaced_arm(robot, turns, shift)
        for setting in settings_for(robot, resolve_task(None, robot)):
            bound = displaced_columns(robot, setting, near, setting.rows)
            change = np.linalg.norm(moved_columns(robot, other, np.zeros(count), setting), axis=1)
            assert (change <= bound * (1 + 1e-9) + 1e-13).all()
            matter = bound > 0.0
            best[matter] = np.maximum(best[matter], change[matter] / bound[matter])
    assert best.max() > 0.95
    assert (best > 0.9).sum() >= count - 1


@pytest.mark.by_hand_at("puma560")
@pytest.mark.slow_at("puma560", "ur5")
@pytest.mark.parametrize("name", ["ur5", "puma560"])
def test_balls_for_near_arms_hold_none_of_their_singular_configurations(name, tmp_path):
    robot = open_robot(name)
    q = [0.3, -0.8, 1.2, 0.4, 0.9, 0.1] if name == "ur5" else [0.3, 0.4, -0.3, 0.4, 1.2, 0.1]
    near = ModelTolerance(1e-4, 2e-4)
    whole = certified_radius(robot, q, evaluations=20_000).radius
    radius = 0.8 * whole
    record = ball_certificate(robot, q, tolerance=near, radius=radius, evaluations=20_000)
    assert record["tolerance"]["angle"] == near.angle
    with pytest.raises(OptionError, match="not proven"):
        ball_certificate(robot, q, tolerance=ModelTolerance(0.05, 0.1), radius=radius, evaluations=2_000)
    small = ball_certificate(robot, q, tolerance=near, radius=0.2 * whole)
    assert verify(write_certificate(small, tmp_path / "b.json"), robot).holds
    rng = np.random.default_rng(5)
    count = len(robot.joints)
    matters = settings_for(robot, resolve_task(None, robot))[0].matters
    for _ in range(3):
        other = displaced_arm(robot, directions(rng, count, near.angle), directions(rng, count, near.length))
        found = search(other, 1, starts=120, method="reciprocal").q
        off = (found - q)[:, matters]
        off -= 2 * np.pi * np.round(off / (2 * np.pi))
        assert np.linalg.norm(off, axis=1).min() > radius


@pytest.mark.slow
def test_a_path_for_near_arms_is_proven_or_not(tmp_path):
    robot = open_robot("ur5")
    rows = [[0.1, -0.9, 1.0, 0.4, -0.6, 0.2], [0.3, -0.6, 1.2, 0.1, -0.9, 0.0]]
    found, asked = check_path(robot, rows), asked_about(robot, rows=rows)
    assert proven_for_near_arms(found, NEAR)
    assert not proven_for_near_arms(found, ModelTolerance(0.1, 0.1))
    assert not proven_for_near_arms(found, NEAR, evaluations=0)
    assert verify(write_certificate(path_certificate(found, NEAR), tmp_path / "p.json"), asked).holds
    lie = path_certificate(found, ModelTolerance(0.1, 0.1))
    assert not verify(write_certificate(lie, tmp_path / "p.json"), asked).holds


def test_what_a_tolerance_is_not_for_is_refused():
    with pytest.raises(OptionError, match=r"whole tasks.*task='pose'"):
        ball_certificate(open_robot("planar3r"), [0.3, 1.2, 0.4], tolerance=NEAR)
    with pytest.raises(OptionError, match="small angle"):
        ModelTolerance(0.0, 1.0)
    with pytest.raises(OptionError, match="no length"):
        ModelTolerance(float("nan"), 0.0)


def test_points_lie_on_their_axes():
    for name in ("ur5", "panda"):
        robot = open_robot(name)
        for joint, point in zip(robot.joints, points_of(robot), strict=True):
            assert np.linalg.norm(joint.screw[:3] - np.cross(point, joint.screw[3:])) < 1e-12
