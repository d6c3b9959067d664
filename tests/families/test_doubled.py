"""Families on which the rank drops twice over, and joints on one axis."""

from __future__ import annotations

from dataclasses import replace
from math import atan, pi

import numpy as np
import pytest

from rankdrop.families import irregular, signature
from rankdrop.families.irregular import inspect_doubled
from rankdrop.families.linear import gathered, gathered_tangent, spread
from rankdrop.families.signature import inspect
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


def squared() -> Robot:
    """6R whose determinant contains (0.2 c3 + s3)²."""
    rows = [(0.5, 0.0, 0.5), (0.0, -Q, 0.0), (0.2, Q, 0.0), (0.0, -Q, 1.0), (0.0, Q, 0.0), (1.0, 0.0, 1.0)]
    return from_dh([(a, alpha, d, 0.0) for a, alpha, d in rows], convention="standard", name="squared")


@pytest.mark.parametrize(("robot", "joint", "value"), [(squared(), 2, -atan(0.2)), (open_robot("stanford"), 2, 0.0)])
def test_points_come_to_rounding_and_the_joint_is_pinned(robot: Robot, joint: int, value: float, rng) -> None:
    at = problem(robot)
    q = at.random(40, rng)
    q[:, joint] = value + 3e-7 * rng.standard_normal(40)
    found, good = inspect_doubled(at, q)
    assert good.mean() > 0.9
    assert np.abs(found.q[good, joint] - value).max() < 1e-11
    told = [one for one in found.signatures if one is not None]
    assert len(told) > 30
    assert {(one.rank, one.pinned) for one in told} == {(1, (joint,))}


def test_points_that_have_not_settled_are_left_where_they_were(rng, monkeypatch) -> None:
    """One step lands them so near that σ calls them singular: it is no word of where they would have ended."""
    at = problem(squared())
    q = at.random(20, rng)
    q[:, 2] = -atan(0.2) + 3e-7
    monkeypatch.setattr(irregular, "ROUNDS", 1)
    found, good = inspect_doubled(at, q)
    assert not good.any()
    np.testing.assert_array_equal(found.q, q)


def test_points_of_long_arms_are_inspected_in_parts_with_the_same_result(rng, monkeypatch) -> None:
    at = problem(squared())
    q = at.random(30, rng)
    q[:, 2] = -atan(0.2) + 3e-7 * rng.standard_normal(30)
    whole, good = inspect_doubled(at, q)
    plain = inspect(at, q)
    monkeypatch.setattr(irregular, "_ENTRIES", 7)
    monkeypatch.setattr(signature, "_ENTRIES", 50)
    for one, other in ((inspect_doubled(at, q)[0], whole), (inspect(at, q), plain)):
        assert one.signatures == other.signatures
        for name in ("q", "sigma", "exact", "regular", "condition", "tangent"):
            np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=0, atol=1e-9)
    np.testing.assert_array_equal(inspect_doubled(at, q)[1], good)


def test_a_simple_family_and_regular_configurations_are_left_alone(rng) -> None:
    at = problem(open_robot("puma560"))
    q = at.random(20, rng)
    found, good = inspect_doubled(at, q)
    assert not found.regular.any()
    assert not good.any()
    np.testing.assert_array_equal(found.q, q)
    q[:, 4] = 0.0
    assert not inspect_doubled(at, q)[0].regular.any()  # D says it all there
    assert not len(inspect_doubled(at, q[:0])[0].q)


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
