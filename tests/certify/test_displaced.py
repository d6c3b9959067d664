"""Arms within a tolerance of one arm: the bound on their Jacobians is never passed, and nearly reached."""

from __future__ import annotations

import numpy as np
import pytest
from reference import arms, region
from reference.displaced import displaced_arm

from rankdrop.certify.ball import certified_radius
from rankdrop.certify.displaced import ModelTolerance, displaced_columns, points_of
from rankdrop.certify.proof.verifying import verify
from rankdrop.certify.proof.writing import ball_certificate, write_certificate
from rankdrop.certify.setting import settings_for
from rankdrop.errors import OptionError
from rankdrop.families.searching import search
from rankdrop.motion.certificate import path_certificate, proven_for_near_arms
from rankdrop.motion.check import check_path
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

NEAR = ModelTolerance(3e-4, 1e-3)
ARMS = {
    **{name: (lambda name=name: open_robot(name)) for name in ("ur5", "puma560", "panda", "pa10")},
    "random 6R": lambda: arms.random_chain(np.random.default_rng(3), "rrrrrr"),
}


def directions(rng, count, size):
    """(count, 3) vectors of one length in random directions."""
    found = rng.standard_normal((count, 3))
    return size * found / np.linalg.norm(found, axis=1, keepdims=True)


def moved_columns(robot, other, q, setting):
    """(N, 6) difference of the columns of two arms, both seen from link and point of a setting."""
    return region.columns(other, q, setting) - region.columns(robot, q, setting)


@pytest.mark.parametrize("name", ARMS)
def test_no_displaced_arm_goes_beyond_the_bound(name):
    robot = ARMS[name]()
    rng = np.random.default_rng(1)
    task = resolve_task("pose", robot)
    for setting in settings_for(robot, task)[::4]:
        bound = displaced_columns(robot, setting, NEAR, task.rows)
        assert bound.any()
        for _ in range(40):
            count = len(robot.joints)
            other = displaced_arm(robot, directions(rng, count, NEAR.angle), directions(rng, count, NEAR.length))
            q = rng.uniform(-np.pi, np.pi, robot.n)
            change = np.linalg.norm(moved_columns(robot, other, q, setting), axis=1)
            assert (change <= bound * (1 + 1e-9) + 1e-13).all()  # rounding of the model


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


def test_a_path_for_near_arms_is_proven_or_not(tmp_path):
    robot = open_robot("ur5")
    found = check_path(robot, [[0.1, -0.9, 1.0, 0.4, -0.6, 0.2], [0.3, -0.6, 1.2, 0.1, -0.9, 0.0]])
    assert proven_for_near_arms(found, NEAR)
    assert not proven_for_near_arms(found, ModelTolerance(0.1, 0.1))
    assert not proven_for_near_arms(found, NEAR, evaluations=0)
    assert verify(write_certificate(path_certificate(found, NEAR), tmp_path / "p.json"), robot).holds
    lie = path_certificate(found, ModelTolerance(0.1, 0.1))
    assert not verify(write_certificate(lie, tmp_path / "p.json"), robot).holds


def test_what_a_tolerance_is_not_for_is_refused():
    with pytest.raises(OptionError, match="joints all turn"):
        ball_certificate(open_robot("stanford"), [0.3] * 6, tolerance=NEAR)
    with pytest.raises(OptionError, match="rotation"):
        ball_certificate(open_robot("puma560"), [0.3] * 6, "position", tolerance=NEAR)
    with pytest.raises(OptionError, match="whole tasks"):
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
