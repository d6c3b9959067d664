"""What follows from a problem, held against what is known of an arm."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.local.block import generic_rank, joint_scale, singular_values
from rankdrop.problem import Problem, whole_turns, wrap, wrap_joints
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task


def asked(name: str, corank: int = 1, *, limits: bool = False) -> Problem:
    robot = open_robot(name)
    return Problem(robot, resolve_task(None, robot), corank, limits=limits)


@pytest.mark.parametrize("name", ["planar3r", "scara", "puma560", "pa10"])
def test_it_knows_what_the_functions_of_robot_and_task_say(name: str, rng: np.random.Generator) -> None:
    problem = asked(name)
    robot, task = problem.robot, problem.task
    assert problem.generic_rank == generic_rank(robot, task) == problem.rank + 1
    assert problem.at(2).rank == problem.rank - 1
    np.testing.assert_array_equal(problem.scale, joint_scale(robot, task))
    q = problem.random(20, rng)
    np.testing.assert_array_equal(problem.sigma(q), singular_values(robot, q, task))
    assert ((q >= problem.box[0]) & (q <= problem.box[1])).all()


def test_singular_is_what_has_lost_that_many_freedoms() -> None:
    """PUMA 560: θ5 = 0 loses one freedom, the arm stretched as well a second one."""
    elbow = float(np.arctan2(-0.4318, 0.0203) + np.pi)
    q = np.array([[0.3, 0.5, 0.4, 0.2, 0.7, 0.6], [0.3, 0.5, 0.4, 0.2, 0.0, 0.6], [0.3, 0.5, elbow, 0.2, 0.0, 0.6]])
    assert asked("puma560").singular(q[:2]).tolist() == [False, True]
    assert not asked("puma560", 2).singular(q[:2]).any()
    assert asked("puma560").singular(q[:0]).shape == (0,)


def test_the_first_and_the_last_joint_of_a_pose_are_idle() -> None:
    assert np.flatnonzero(asked("puma560").idle).tolist() == [0, 5]


def test_limits_bind_only_where_they_are_asked_for_and_whole_turns_do_not_count() -> None:
    free, bound = asked("panda"), asked("panda", limits=True)
    inside = (bound.robot.lower + bound.robot.upper) / 2
    q = np.array([inside, inside + 2 * np.pi, inside])
    q[2, 3] = 0.5  # joint 4 bends one way only
    assert free.within_limits(q).all()
    assert bound.within_limits(q).tolist() == [True, True, False]
    assert free.walls is None
    assert bound.walls is not None


def test_angles_come_to_the_half_open_turn_and_slides_stay(rng: np.random.Generator) -> None:
    assert wrap(np.array([np.pi, -np.pi, 0.0, 3 * np.pi])).tolist() == pytest.approx([np.pi, np.pi, 0.0, np.pi])
    robot = open_robot("scara")  # joint 3 slides
    q = rng.uniform(-20, 20, (50, 4))
    near = wrap_joints(robot, q)
    np.testing.assert_array_equal(near[:, 2], q[:, 2])
    assert (np.abs(near[:, [0, 1, 3]]) <= np.pi).all()
    np.testing.assert_allclose(np.exp(1j * near[:, 0]), np.exp(1j * q[:, 0]), atol=1e-12)
    way = q - whole_turns(robot, q)
    np.testing.assert_array_equal(way[:, 2], q[:, 2])
    np.testing.assert_allclose(np.abs(way[:, 0]), np.abs(near[:, 0]), atol=1e-12)
