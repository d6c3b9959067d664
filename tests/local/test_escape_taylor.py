"""The Taylor series of the Jacobian along a motion: every joint kind, frame and task."""

from __future__ import annotations

import numpy as np
import pytest
from reference import arms

from rankdrop.kinematics import jacobian, task_jacobian, task_jacobian_derivative
from rankdrop.local.departure import taylor
from rankdrop.robot.transform import brackets
from rankdrop.task import BODY, SPACE, WORLD_ALIGNED, Frame, resolve_task

FRAMES = (WORLD_ALIGNED, SPACE, BODY, Frame(1, 2, (0.1, 0.2, -0.3)), Frame(2, -1), Frame(0, 1))
KINDS = ("rpr", "rhr", "rrrrrr", "hrprhr", "rrmrrrr", "mrrhpmr", "rrrrrrrr")


@pytest.mark.parametrize("kinds", KINDS)
@pytest.mark.parametrize("frame", FRAMES, ids=str)
def test_the_series_sums_up_to_the_moved_jacobian(kinds: str, frame: Frame, rng: np.random.Generator) -> None:
    robot = arms.random_chain(rng, kinds)
    task = resolve_task("pose", robot, frame=frame)
    q = rng.uniform(-np.pi, np.pi, robot.n)
    directions = np.concatenate([np.eye(robot.n), rng.normal(size=(3, robot.n))])
    series = taylor(robot, q, task, directions, 9)
    for t in (-0.1, 0.05):
        summed = np.einsum("p,pdmn->dmn", t ** np.arange(10), series)
        moved = task_jacobian(robot, q + t * directions, task)
        assert np.abs(summed - moved).max() < 1e-8


@pytest.mark.parametrize("words", ["pose", "position", "planar", "wx,vy"])
def test_the_first_coefficient_is_the_derivative(words: str, rng: np.random.Generator) -> None:
    robot = arms.random_chain(rng, "mrrhpmr")
    task = resolve_task(words, robot)
    q = rng.uniform(-np.pi, np.pi, robot.n)
    got = taylor(robot, q, task, np.eye(robot.n), 1)
    want = task_jacobian_derivative(robot, q, task)  # (m, i, k)
    assert np.abs(got[1] - np.moveaxis(want, -1, 0)).max() < 1e-12


def test_a_turning_joint_is_a_turn_of_its_series(rng: np.random.Generator) -> None:
    """One angle: J''' = −J', so the third coefficient is −1/6 of the first."""
    robot = arms.pa10()
    task = resolve_task("pose", robot)
    series = taylor(robot, rng.uniform(-np.pi, np.pi, 7), task, np.eye(7), 4)
    assert np.abs(series[3] + series[1] / 6).max() < 1e-14
    assert np.abs(series[4] + series[2] / 12).max() < 1e-14


def test_brackets_are_the_derivative_in_space(rng: np.random.Generator) -> None:
    robot = arms.pa10()
    task = resolve_task("pose", robot, frame=SPACE, length_scale=1.0)
    q = rng.uniform(-np.pi, np.pi, 7)
    want = np.moveaxis(task_jacobian_derivative(robot, q, task), -1, 0)
    assert np.abs(brackets(jacobian(robot, q, SPACE)) - want).max() < 1e-13
