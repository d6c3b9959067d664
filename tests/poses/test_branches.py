"""Solutions of a pose: none missed, each substituted back, self-motions told as such, and why there is none."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.errors import ConfigurationError
from rankdrop.kinematics import pose
from rankdrop.local.block import singular_values
from rankdrop.poses.branches import inverse, matrix_of, self_motion_curves
from rankdrop.poses.inverse import Aim, joint_difference, rotation
from rankdrop.results.known import shipped
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

GENERIC = {
    "puma560": [0.1, 0.5, 0.3, 0.2, 0.9, 0.6],
    "ur5e": [0.3, -1.2, 1.4, -1.0, 1.2, 0.4],
    "irb120": [0.2, 0.3, -0.4, 0.5, 0.9, -0.3],
    "crx10ia": [0.2, 0.9, 0.4, -0.6, 0.9, 0.0],
    "stanford": [0.2, 0.9, 0.4, -0.6, 0.9, 0.3],
    "scara": [0.3, 0.7, 0.1, 0.2],
    "planar3r": [0.3, 0.7, 0.4],
}


def test_a_quaternion_of_another_length_is_refused_with_the_unit_one() -> None:
    with pytest.raises(ConfigurationError, match=r"length 2; .*; fix: write 0,1,0,0$"):
        matrix_of([0.6, 0.2, 0.3, 0.0, 2.0, 0.0, 0.0])
    with pytest.raises(ConfigurationError, match=r"got length 0; allowed: [^;]*$"):
        matrix_of([0.6, 0.2, 0.3, 0.0, 0.0, 0.0, 0.0])


@pytest.mark.by_hand_at("crx10ia", "stanford", "ur5e")
@pytest.mark.slow_at("irb120")
@pytest.mark.slow_at("puma560", "stanford", "ur5e", "crx10ia")
@pytest.mark.parametrize("name", GENERIC)
def test_dense_starts_find_nothing_that_was_missed(name: str) -> None:
    robot = open_robot(name)
    goal = pose(robot, GENERIC[name])
    found = inverse(robot, goal)
    solved = np.array([one.q for one in found.branches])
    task = resolve_task(None, robot)
    begin = np.random.default_rng(77).uniform(-np.pi, np.pi, (2000, robot.n))
    for q in Aim(robot, task).solve_from(goal, begin):
        assert np.abs(joint_difference(robot, q, solved)).max(axis=1).min() < 1e-5
    assert np.abs(joint_difference(robot, np.array(GENERIC[name]), solved)).max(axis=1).min() < 1e-9
    assert len(solved) <= 16


@pytest.mark.spread(5)
@pytest.mark.slow
@pytest.mark.parametrize("name", GENERIC)
def test_each_solution_is_substituted_back(name: str) -> None:
    robot = open_robot(name)
    goal = pose(robot, GENERIC[name])
    found = inverse(robot, goal, starts=300)
    assert found.branches
    for one in found.branches:
        assert np.abs(pose(robot, one.q) - goal).max() <= 1e-9
        beyond = {number for number, _ in one.beyond}
        outside = np.flatnonzero((one.q > robot.upper + 1e-9) | (one.q < robot.lower - 1e-9)) + 1
        assert beyond == set(outside.tolist())
        for number, amount in one.beyond:
            low, high, value = robot.lower[number - 1], robot.upper[number - 1], one.q[number - 1]
            assert amount == pytest.approx(max(low - value, value - high), abs=1e-8)
    assert found.residual <= 1e-9
    assert found.inside == sum(not one.beyond for one in found.branches)


@pytest.mark.by_hand
def test_the_count_of_usual_arms() -> None:
    assert len(inverse(open_robot("puma560"), pose(open_robot("puma560"), GENERIC["puma560"])).branches) == 8
    assert len(inverse(open_robot("planar3r"), pose(open_robot("planar3r"), GENERIC["planar3r"])).branches) == 2
    found = inverse(open_robot("ur5e"), [0.4, 0.2, 0.3, np.pi, 0.0, 0.5])
    assert len(found.branches) == 8
    assert found.most == 16
    assert len({one.posture for one in found.branches}) == 8
    assert "not proven to be all" in " ".join(str(found).split())
    assert found.sentence.startswith("ur5e: 8 solutions; a 6R arm has at most 16.")


@pytest.mark.slow
def test_limits_are_named() -> None:
    robot = open_robot("irb120")
    q = np.array([3.1, 0.3, -0.4, 0.5, 0.9, -0.3])  # joint 1 ends at 165 degrees
    found = inverse(robot, pose(robot, q))
    mine = min(found.branches, key=lambda one: float(np.abs(joint_difference(robot, q, one.q[None])).max()))
    assert [number for number, _ in mine.beyond] == [1]
    assert mine.beyond[0][1] == pytest.approx(3.1 - robot.upper[0], abs=1e-6)


def test_poses_are_written_in_four_ways() -> None:
    matrix = matrix_of([0.1, 0.2, 0.3, 0.4, -0.5, 0.6])
    x, y, z = (np.eye(3)[i] for i in range(3))
    by_axes = rotation(0.6 * z[None])[0] @ rotation(-0.5 * y[None])[0] @ rotation(0.4 * x[None])[0]
    np.testing.assert_allclose(matrix[:3, :3], by_axes, atol=1e-12)
    np.testing.assert_allclose(matrix_of(matrix), matrix, atol=1e-12)
    turn = rotation(np.array([[0.3, -0.4, 0.5]]))[0]
    angle = np.sqrt(0.5)
    axis = np.array([0.3, -0.4, 0.5]) / angle
    quaternion = [*(np.sin(angle / 2) * axis), np.cos(angle / 2)]
    np.testing.assert_allclose(matrix_of([0.1, 0.2, 0.3, *quaternion])[:3, :3], turn, atol=1e-12)
    np.testing.assert_allclose(matrix_of([0.1, 0.2, 0.3])[:3, 3], [0.1, 0.2, 0.3])
    for wrong in ([1.0, 2.0], [0, 0, 0, 1, 1, 0, 0], [np.nan] * 6, np.zeros((4, 4))):
        with pytest.raises(ConfigurationError):
            matrix_of(wrong)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "elbow", "zero"), [("scara", 2, 0.0), ("planar3r", 2, 0.0), ("px150", 3, None)])
def test_an_arm_with_too_few_joints_for_a_pose_has_a_posture(name: str, elbow: int, zero: float | None) -> None:
    """Law: the sign of the elbow is that of the elbow joint from where the arm is stretched, in every solution."""
    arm = open_robot(name)
    q = np.random.default_rng(1).uniform(np.clip(arm.lower, -2, 2), np.clip(arm.upper, -2, 2))
    found = inverse(arm, pose(arm, q), "pose", starts=200)
    assert len(found.branches) >= 2
    if zero is None:
        elbows = [family for family in shipped(name).families if family.called.short == "elbow" and family.corank == 1]
        zero = next(pin.values[0] for pin in elbows[0].pinned if pin.number == elbow)
    signs = set()
    for branch in found.branches:
        bent = np.sign(np.sin(branch.q[elbow - 1] - zero))
        signs.add(bent * (1 if "+" in branch.posture[0] else -1))
    assert len(signs) == 1
    assert {branch.posture for branch in found.branches} == {("elbow +",), ("elbow −",)}


def test_a_position_without_an_orientation_is_for_tasks_without_rotation() -> None:
    arm = open_robot("irb120")
    with pytest.raises(ConfigurationError, match="no orientation"):
        inverse(arm, [0.3, 0.1, 0.3])
    found = inverse(arm, [0.3, 0.1, 0.3], "position", starts=64)
    assert found.continua
    assert found.sections()[0].lines == ("Position: (300.0, 100.0, 300.0) mm, base axes.",)


def test_a_self_motion_is_shown_in_the_posture_that_people_use() -> None:
    """Panda, tool down in front of it: the curve through (0, −π/4, 0, −3π/4, 0, …), as it is delivered, comes first."""
    arm = open_robot("panda")
    usual = np.array([0.0, -np.pi / 4, 0.0, -3 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4])
    found = inverse(arm, pose(arm, usual))
    first = found.continua[0]
    assert first.beyond == ()
    assert np.abs(first.q - usual).max() < 0.05


@pytest.mark.parametrize("name", ["panda", "lbr_iiwa_7_r800"])
def test_a_self_motion_is_not_shown_near_a_singularity(name: str) -> None:
    """σ at the configuration that is shown, against the largest on the same curve."""
    arm = open_robot(name)
    goal = pose(arm, 0.5 * (arm.lower + arm.upper) + 0.2)
    curves, _ = self_motion_curves(arm, goal)
    found = inverse(arm, goal)
    for continuum in found.continua:
        if continuum.beyond:
            continue
        away = [np.abs(np.angle(np.exp(1j * (curve.points - continuum.q)))).max(axis=1).min() for curve in curves]
        on_it = curves[int(np.argmin(away))].points
        largest = singular_values(arm, on_it, found.task)[:, -1].max()
        assert singular_values(arm, continuum.q[None], found.task)[0, -1] > 0.3 * largest
