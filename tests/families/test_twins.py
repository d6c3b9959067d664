"""Joints on one axis."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from rankdrop.families.linear import gathered, gathered_tangent, spread
from rankdrop.family.equation import Equation, Term
from rankdrop.problem import Problem, Twin
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

Q = pi / 2


def problem(robot: Robot, corank: int = 1) -> Problem:
    task = resolve_task(None, robot)
    task = replace(task, length_scale=task.scale(robot))
    return Problem(robot, task, corank)


@pytest.mark.parametrize(("alpha", "sign"), [(0.0, 1), (pi, -1)])
def test_joints_on_one_axis_are_known_with_their_sense(alpha: float, sign: int, rng) -> None:
    rows = [(0.3, Q, 0.2), (0.5, 0.3, 0.1), (0.0, alpha, 0.4), (0.2, -Q, 0.3), (0.1, Q, 0.5), (0.3, 1.0, 0.2),
            (0.1, 0.4, 0.1)]  # fmt: skip
    robot = from_dh([(a, twist, d, 0.0) for a, twist, d in rows], convention="standard", name="twins")
    at = problem(robot)
    assert at.twins == (Twin(2, 3, sign),)
    q = at.random(5, rng)
    together = gathered(q, at.twins)
    assert not together[:, 3].any()
    sigma = [at.sigma(one) for one in (q, together)]
    np.testing.assert_allclose(sigma[0], sigma[1], atol=1e-12)
    f = Equation((Term(1.0, "sin", (0, 2, 2, 0, 0, 0, 0), (0,) * 7), Term(0.5, "cos", (0,) * 7, (0,) * 7)))
    np.testing.assert_allclose(spread(f, at.twins)(q), f(together) / 1.0, atol=1e-14)
    assert problem(open_robot("ur5")).twins == ()


def test_the_tangent_of_the_part_with_a_twin_at_zero() -> None:
    """c = (1, 2, s·2, 0)/3 vanishes on the family; without the twin's entry it is (1, 2, 0, 0)/√5."""
    for sign in (1, -1):
        c = np.array([1.0, 2.0, sign * 2.0, 0.0]) / 3
        part = gathered_tangent((np.eye(4) - np.outer(c, c))[None], (Twin(1, 2, sign),))[0]
        assert np.allclose(part @ [1, 2, 0, 0], 0)
        assert np.linalg.matrix_rank(part) == 3
