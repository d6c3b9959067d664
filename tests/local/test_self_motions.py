"""Self-motion: the task stays to 1e-10, the end is named, and null motions that lead nowhere are refused."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from reference.measure import central_differences

from rankdrop.errors import ConfigurationError, OptionError, TaskError
from rankdrop.kinematics import jacobian, pose, task_jacobian
from rankdrop.local.block import joint_scale, sample
from rankdrop.local.orientation import Displacement
from rankdrop.local.redundant import redundancy
from rankdrop.local.self_motions import BRANCHES, CLOSED, LIMIT, NONE, REACHED, SelfMotion, self_motion
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import BODY, SPACE, resolve_task

H = pi / 2


def check(robot: Robot, traced: SelfMotion, step: float = 0.05) -> None:
    """What holds for every trace of the pose: the tip stands still, and no step is longer than it should be."""
    still = pose(robot, traced.q) - pose(robot, traced.q[0])
    assert np.abs(still).max() < 1e-10
    assert traced.task_error.max() <= 1e-10
    scale = joint_scale(robot, resolve_task(None, robot))
    steps = np.linalg.norm(np.diff(traced.q, axis=0) / scale, axis=1)
    assert steps.max(initial=0.0) < 1.4 * step
    assert traced.length == pytest.approx(steps.sum())
    assert traced.q.shape == (len(traced.task_error), robot.n)
    assert traced.sigma_min.shape == traced.task_error.shape


@pytest.mark.spread(2)
@pytest.mark.slow
@pytest.mark.parametrize("name", ["pa10", "panda", "iiwa14", "canadarm2", "rcrrrr"])
def test_seven_joints_go_round_and_come_back(name: str) -> None:
    robot = open_robot(name)
    closed = 0
    for q in sample(robot, resolve_task(None, robot), 2, 1, limits=True):
        traced = self_motion(robot, q, limits=False, length=25.0, step=0.1)
        check(robot, traced, 0.1)
        assert traced.length > 1.0
        if traced.ended == CLOSED:
            closed += 1
            turns = (traced.q[-1] - traced.q[0]) / (2 * pi)
            assert np.abs(turns - np.round(turns)).max() < 1e-12
    assert closed >= 1


@pytest.mark.by_hand
@pytest.mark.slow_at("fetch8")
@pytest.mark.slow_at("fetch")
@pytest.mark.parametrize("name", ["panda", "fetch8", "iiwa14", "fetch"])
def test_limits_stop_it_at_the_limit_and_not_beyond(name: str) -> None:
    robot = open_robot(name)
    stopped = 0
    for q in sample(robot, resolve_task(None, robot), 3, 1, limits=True):
        for sense in (1.0, -1.0):
            first = self_motion(robot, q, length=1e-3, step=1e-3, limits=False)
            traced = self_motion(robot, q, direction=sense * (first.q[-1] - first.q[0]))
            check(robot, traced)
            assert (traced.q >= robot.lower).all()
            assert (traced.q <= robot.upper).all()
            if traced.ended == LIMIT:
                stopped += 1
                gap = np.minimum(traced.q[-1] - robot.lower, robot.upper - traced.q[-1])
                assert gap.min() < 1e-5
    assert stopped >= 2  # joints without limits may go round instead


def test_a_start_beyond_a_limit_goes_nowhere() -> None:
    robot = open_robot("panda")
    traced = self_motion(robot, [0.0, 0.3, 0.0, 1.0, 0.0, 1.0, 0.0])
    assert (traced.ended, len(traced.q)) == (LIMIT, 1)
    assert "joint 4" in traced.words


def test_regular_arms_without_redundancy_have_none() -> None:
    traced = self_motion(open_robot("ur5"), [0.1, -0.5, 0.4, 0.3, 0.4, 0.2])
    assert (traced.ended, traced.nullity, len(traced.q)) == (NONE, 0, 1)


@pytest.mark.slow
def test_wrist_singularity_of_a_6r_turns_on_the_spot() -> None:
    """UR5 with θ5 = 0: joints 2, 3, 4 and 6 are parallel, four joints in a plane of three freedoms."""
    robot = open_robot("ur5")
    traced = self_motion(robot, [0.1, -0.5, 0.6, 0.3, 0.0, 0.2], limits=False)
    check(robot, traced)
    assert (traced.corank, traced.nullity, traced.ended) == (1, 1, CLOSED)
    assert np.ptp(traced.q[:, [0, 4]], axis=0).max() < 1e-9
    assert traced.sigma_min.max() < 1e-9


@pytest.mark.parametrize("name", ["ur5", "planar3r"])
def test_a_stretched_arm_has_a_null_motion_but_no_self_motion(name: str) -> None:
    robot = open_robot(name)
    task = None if name == "ur5" else "planar-position"
    q = [0.1, -0.5, 0.0, 0.3, 0.4, 0.2] if name == "ur5" else [0.1, 0.0, 0.0]
    traced = self_motion(robot, q, task)
    assert traced.nullity > 0
    assert (traced.ended, len(traced.q)) == (BRANCHES, 1)
    assert "second order" in traced.words
    for direction in redundancy(robot, q, task).null_basis:
        other = self_motion(robot, q, task, direction=direction)
        assert (other.ended, len(other.q)) == (BRANCHES, 1)
    with pytest.raises(OptionError, match="no part in the null space"):
        self_motion(robot, q, task, direction=jacobian(robot, q)[0])


@pytest.mark.parametrize(
    ("q", "corank"),
    [
        ([0.0] * 7, 3),
        ([0.3, 0.0, H, 0.7, 0.2, 0.4, 1.0], 1),
        ([0.3, 0.5, 0.2, 0.0, 0.2, 0.4, 1.0], 1),
        ([0.3, 0.0, 0.0, 0.0, 0.2, 0.3, 1.0], 2),
        ([0.3, 0.0, 0.4, 0.7, 0.2, pi, 1.0], 1),
    ],
)
def test_from_singular_poses_of_the_pa10_something_is_followed_and_stays(q: list[float], corank: int) -> None:
    robot = open_robot("pa10")
    traced = self_motion(robot, q, limits=False)
    check(robot, traced)
    assert traced.corank == corank
    assert len(traced.q) > 10


def test_a_random_null_motion_of_a_singular_pose_is_refused() -> None:
    robot = open_robot("pa10")
    direction = np.array([0, -0.43, 0, 0.816, 0, -0.387, 0])  # bends the stretched arm: the tip comes nearer
    traced = self_motion(robot, [0.0] * 7, direction=direction, limits=False)
    assert (traced.ended, len(traced.q)) == (BRANCHES, 1)
    assert "second order" in traced.words


def test_a_curve_that_runs_into_a_singularity_ends_there() -> None:
    """PA-10 with θ6 = 0: joints 5 and 7 turn against each other until θ5 = ±π/2, AM's Table 3."""
    robot = open_robot("pa10")
    traced = self_motion(robot, [0.3, 0.5, 0.2, 0.9, 0.2, 0.0, 1.0], limits=False)
    check(robot, traced)
    assert traced.ended == BRANCHES
    assert abs(np.cos(traced.q[-1][4])) < 1e-5
    assert traced.sigma_min[-1] < 1e-6


def test_planar_arm_for_positions_closes_like_a_four_bar_linkage() -> None:
    robot = open_robot("planar3r")
    task = resolve_task("planar-position", robot)
    traced = self_motion(robot, [0.1, 0.7, 0.3], task)
    assert traced.ended == CLOSED
    there = pose(robot, traced.q)[:, :2, 3]
    assert np.abs(there - there[0]).max() < 1e-10


@pytest.mark.parametrize("task", ["position", "orientation", "vx,vy,wz", "scara"])
def test_tasks_of_fewer_rows_keep_their_rows(task: str) -> None:
    robot = open_robot("pa10")
    resolved = resolve_task(task, robot)
    q = sample(robot, resolved, 1, 5)[0]
    traced = self_motion(robot, q, resolved, limits=False, length=4.0)
    assert traced.nullity == 7 - resolved.m
    assert traced.ended == REACHED
    assert traced.length == pytest.approx(4.0, rel=0.01)
    assert traced.task_error.max() < 1e-10
    poses = pose(robot, traced.q)
    if 0 in resolved.rows:
        assert np.abs(poses[:, :2, 3] - poses[0, :2, 3]).max() < 1e-10
    if task == "orientation":
        assert np.abs(poses[:, :3, :3] - poses[0, :3, :3]).max() < 1e-10


@pytest.mark.parametrize("frame", [None, BODY])
@pytest.mark.parametrize("task", ["pose", "position", "vx,vy,wz", "vz,wx"])
def test_displacement_has_the_derivative_it_says(task: str, frame: object) -> None:
    robot = open_robot("fetch8")
    resolved = resolve_task(task, robot, frame=frame)  # type: ignore[arg-type]
    q = sample(robot, resolved, 4, 3, limits=True)
    where = Displacement(robot, q[0], resolved)
    for one in (q[0], q[0] + 0.1, q[1]):
        want = central_differences(lambda x: where.error(x).reshape(-1), one, h=1e-3) * where.joints
        assert np.abs(where.derivative(one) - want).max() < 1e-9
    assert np.abs(where.derivative(q[0]) / where.joints - task_jacobian(robot, q[0], resolved)).max() < 1e-12


def test_options_are_refused() -> None:
    robot = open_robot("pa10")
    q = [0.1, 0.6, 0.3, 1.2, 0.4, 0.9, 0.2]
    with pytest.raises(OptionError, match="length or step"):
        self_motion(robot, q, step=0.0)
    with pytest.raises(OptionError, match="direction"):
        self_motion(robot, q, direction=[0.0] * 7)
    with pytest.raises(ConfigurationError):
        self_motion(robot, [q, q])
    with pytest.raises(TaskError, match="move with the tip"):
        self_motion(robot, q, resolve_task("position", robot, frame=SPACE))
