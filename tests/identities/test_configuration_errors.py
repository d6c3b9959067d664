"""A configuration that cannot be used is refused in one line that says where, what and what would do."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from reference import arms

from rankdrop.errors import ConfigurationError, TaskError
from rankdrop.kinematics import jacobian, jacobian_derivative, pose, task_jacobian
from rankdrop.local.block import block, decompose, singular_values
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Frame, resolve_task

FUNCTIONS: dict[str, Callable[[Robot, Array], object]] = {
    "pose": pose,
    "jacobian": jacobian,
    "jacobian_derivative": jacobian_derivative,
    "task_jacobian": lambda robot, q: task_jacobian(robot, q, resolve_task("pose", robot)),
    "singular_values": lambda robot, q: singular_values(robot, q, resolve_task("pose", robot)),
    "decompose": lambda robot, q: decompose(robot, q, resolve_task("pose", robot)),
    "block": lambda robot, q: block(robot, q, resolve_task("pose", robot), 5),
}


@pytest.mark.parametrize("function", FUNCTIONS.values(), ids=FUNCTIONS)
@pytest.mark.parametrize("shape", [(6,), (8,), (4, 6), (7, 4), (7, 1), (), (0,)], ids=str)
def test_wrong_shape_names_the_shape_wanted(function: Callable[[Robot, Array], object], shape: tuple[int, ...]) -> None:
    with pytest.raises(ConfigurationError, match=r"\(\.\.\., 7\)") as caught:
        function(arms.pa10(), np.zeros(shape))
    assert str(shape) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("function", FUNCTIONS.values(), ids=FUNCTIONS)
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_values_that_are_not_finite_are_named_by_index(function: Callable[[Robot, Array], object], bad: float) -> None:
    q = np.zeros((5, 7))
    q[3, 2] = bad
    with pytest.raises(ConfigurationError, match="3") as caught:
        function(arms.pa10(), q)
    assert str(bad) in str(caught.value)


@pytest.mark.parametrize("link", [-2, 8, 99])
def test_a_link_that_does_not_exist_is_refused(link: int) -> None:
    for frame in (Frame(link, 0), Frame(0, link)):
        with pytest.raises(TaskError, match="no such link"):
            jacobian(arms.pa10(), np.zeros(7), frame)
