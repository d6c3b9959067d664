"""Newton's method towards poses, in the core: errors, steps and poses between against plain NumPy and SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rankdrop import _core
from rankdrop.kinematics import pose
from rankdrop.path.check.tool_line import poses_at
from rankdrop.poses.inverse import Aim
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot
from rankdrop.task import TIP, Frame, Task, resolve_task

TASKS = {
    "whole": ("ur5e", Task("whole", (0, 1, 2, 3, 4, 5))),
    "a point of the tool": ("ur5e", Task("point", (0, 1, 2), Frame(0, TIP, (0.1, 0.0, 0.2)))),
    "axes of the tool": ("iiwa7", Task("tool", (0, 1, 2), Frame(TIP, TIP))),
    "orientation": ("iiwa7", Task("turn", (3, 4, 5))),
    "planar": ("planar3r", Task("planar", (0, 1, 5))),
}


def error_of(task: Task, length: float, now: Array, goal: Array) -> Array:
    """(N, m) e of the task, of full turns or one about a fixed axis, with SciPy's rotations."""
    here, there = now[:, :3, :3], goal[:, :3, :3]
    point = np.array(task.frame.point) if task.m < 6 else np.zeros(3)
    shift = goal[:, :3, 3] - now[:, :3, 3] + (there - here) @ point
    if task.frame.axes == TIP and task.m < 6:
        shift = np.einsum("nji,nj->ni", here, shift)
    turn = Rotation.from_matrix(there @ here.swapaxes(1, 2)).as_rotvec()
    return np.hstack([shift / length, turn])[:, list(task.rows)]


@pytest.mark.parametrize("which", TASKS)
def test_errors_and_steps_are_those_of_plain_numpy(which: str, rng: np.random.Generator) -> None:
    name, task = TASKS[which]
    robot = open_robot(name)
    aim = Aim(robot, task)
    q, away = rng.uniform(-2.0, 2.0, (2, 40, robot.n))  # turns up to half a turn among them
    goal = pose(robot, away)
    error = aim.error(goal, q)
    assert error == pytest.approx(error_of(task, aim.length, pose(robot, q), goal), abs=1e-12)
    assert aim.error(goal[3], q[3:4]) == pytest.approx(error[3:4], abs=0.0)
    wanted = np.linalg.pinv(aim.jacobian(q)) @ error[:, :, None]
    assert aim.step(q, error) == pytest.approx(wanted[:, :, 0] * aim.joints, rel=1e-8, abs=1e-10)


@pytest.mark.parametrize("which", TASKS)
def test_newton_arrives_where_forward_kinematics_is_and_leaves_what_is_out_of_reach(which: str) -> None:
    name, task = TASKS[which]
    robot, rng = open_robot(name), np.random.default_rng(4)
    aim = Aim(robot, task)
    q = rng.uniform(0.3, 1.2, (30, robot.n))
    goal = pose(robot, q)
    found, arrived = aim.solve(goal, q + rng.uniform(-0.01, 0.01, q.shape))
    assert arrived.all()
    assert aim.confirms(goal, found).all()
    far = goal.copy()
    far[:, :3, 3] += 100.0
    if min(task.rows) < 3:
        assert not aim.solve(far, q)[1].any()
        assert (aim.descend(far, q)[1] < 0).all()
    begun = found.copy()
    aim.solve(goal, begun)
    assert np.array_equal(begun, found)  # what was handed in stays


def test_a_row_gets_the_same_bits_alone_and_in_any_batch(rng: np.random.Generator) -> None:
    """600 rows are shared among threads."""
    robot = open_robot("ur5e")
    aim = Aim(robot, resolve_task(None, robot))
    starts = rng.uniform(-2.0, 2.0, (600, 6))
    goal = pose(robot, [0.3, -1.2, 1.4, -1.0, 1.2, 0.4])
    q, arrived = aim.descend(goal, starts)
    there = arrived >= 0
    assert there.any()
    assert aim.confirms(np.broadcast_to(goal, (600, 4, 4)), q)[there].all()
    for row in (0, 299, 599):
        alone, when = aim.descend(goal, starts[row : row + 1])
        assert np.array_equal(alone[0], q[row])
        assert when[0] == arrived[row]


def test_poses_between_turn_about_one_axis_at_a_constant_rate(rng: np.random.Generator) -> None:
    robot = open_robot("ur5e")
    poses = pose(robot, rng.uniform(-2.0, 2.0, (5, 6)))
    assert poses_at(poses, np.arange(5.0)) == pytest.approx(poses, abs=1e-14)
    share = np.linspace(0.0, 1.0, 7)
    made = poses_at(poses, 2.0 + share)
    whole = Rotation.from_matrix(poses[3, :3, :3] @ poses[2, :3, :3].T).as_rotvec()
    turned = Rotation.from_matrix(made[:, :3, :3] @ poses[2, :3, :3].T).as_rotvec()
    assert turned == pytest.approx(share[:, None] * whole, abs=1e-12)
    assert np.diff(made[:, :3, 3], axis=0) == pytest.approx(
        np.tile((poses[3] - poses[2])[:3, 3] / 6, (6, 1)), abs=1e-14
    )
    assert poses_at(poses[:1], np.zeros(2)) == pytest.approx(poses[[0, 0]], abs=1e-14)


def test_sizes_that_do_not_agree_are_refused() -> None:
    robot = open_robot("ur5e")
    aim = Aim(robot, resolve_task(None, robot))
    goal, q = np.tile(np.eye(4), (2, 1, 1)), np.zeros((2, 6))
    with pytest.raises(ValueError, match="one error"):
        aim.step(q, np.zeros((1, 6)))
    with pytest.raises(ValueError, match="finite"):
        aim.step(np.full((1, 6), np.nan), np.zeros((1, 6)))
    with pytest.raises(ValueError, match="one pose"):
        _core.aim_errors(aim._chain, aim._aim, goal[:1], q)
    with pytest.raises(ValueError, match="no pose"):
        _core.poses_at(goal[:0], np.zeros(1))
    with pytest.raises(ValueError, match="finite"):
        _core.poses_at(goal, np.array([np.nan]))
    with pytest.raises(ValueError, match="row"):
        _core.make_aim(rows=[6], length=1.0, point=[0.0] * 3, with_tip=False, free=-1, heading=-1, joints=[1.0] * 6)
