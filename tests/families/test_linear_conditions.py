"""Linear conditions: values of covectors, their combinations, completion by symmetry, and covering by full products."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from rankdrop.errors import OptionError
from rankdrop.families.evidence import FamilyEvidence, ObtainedFrom
from rankdrop.families.fit import minors
from rankdrop.families.inspection import Signature
from rankdrop.families.linear_conditions import Linear, canonical, vanishing_on
from rankdrop.families.row import Row
from rankdrop.kinematics import task_jacobian
from rankdrop.problem import Problem, wrap
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

PLANTED = FamilyEvidence(ObtainedFrom.VALUES)


def linear(*covectors, robot="pa10") -> Linear:
    return Linear.of(open_robot(robot), covectors)


def test_place_puts_the_values_where_they_belong(rng):
    conditions = linear((0, 1, 0, 0, 0, 0, 0), (0, 0, 1, 0, 1, 0, 0), (0, 0, 0, 1, 0, 2, 0))
    values = rng.uniform(-3, 3, (50, 3))
    q = conditions.place(rng.uniform(-pi, pi, (50, 7)), values, rng)
    np.testing.assert_allclose(wrap(conditions.values(q) - values), 0, atol=1e-12)
    np.testing.assert_allclose(conditions.covectors @ conditions.kept_motions, 0, atol=1e-12)


def test_pivots_prefer_a_unit_minor():
    assert linear((0, 0, 0, 1, 0, 2, 0)).pivots == (3,)


def test_minus_pi_and_pi_are_one_value(rng):
    conditions = linear((0, 1, 0, 0, 0, 0, 0))
    q = np.zeros((40, 7))
    q[:, 1] = np.where(np.arange(40) % 2, pi, -pi) + rng.uniform(-1e-9, 1e-9, 40)
    assert list(conditions.combinations(q, np.ones(40), 1e-6)) == [(pi,)]


def test_values_that_are_not_simple_are_kept(rng):
    conditions = linear((0, 0, 0, 1, 0, 0, 0))
    q = np.zeros((10, 7))
    q[:, 3] = 0.4321 + rng.uniform(-1e-10, 1e-10, 10)
    (values,) = conditions.combinations(q, np.arange(10.0), 1e-6)
    assert values[0] == pytest.approx(0.4321, abs=1e-10)


def test_a_length_is_not_wrapped():
    conditions = linear((0, 0, 1, 0, 0, 0), robot="stanford")
    assert not conditions.periodic.any()
    assert conditions.values(np.full((1, 6), 5.0))[0, 0] == 5.0


@pytest.mark.parametrize(("angle", "want"), [(-pi, pi), (3 * pi, pi), (1e-14, 0.0), (pi / 2 + 1e-14, pi / 2)])
def test_canonical_angles(angle, want):
    assert canonical(angle) == want


def zeros(values: tuple[float, ...], covector: tuple[int, ...] = (1,), *, periodic: bool = True) -> np.ndarray:
    """|condition| at its values, at values beside them, and the order of the values reversed: all from the equation."""
    one, other = (vanishing_on(covector, order, periodic=periodic) for order in (values, values[::-1]))
    assert str(one) == str(other)
    q = np.array(values)[:, None] * np.array(covector)
    return np.abs([one(q), one(q + 0.3)])


@pytest.mark.parametrize(
    "values",
    [(0.3,), (0.3, 0.3 - pi), (0.3 + pi / 2, 0.3 - pi / 2), (0.0, pi), (0.2, 1.1), (0.2, 1.1, -2.0), (0.0,), (pi,)],
)
def test_a_condition_vanishes_at_its_values_whatever_their_order_and_not_beside_them(values):
    at, beside = zeros(values)
    assert at.max() < 1e-12
    assert beside.min() > 1e-3


def test_a_length_takes_several_values_and_needs_one():
    at, beside = zeros((0.2, -0.7), periodic=False)
    assert at.max() < 1e-12 < 1e-3 < beside.min()
    with pytest.raises(OptionError, match="at least one value"):
        vanishing_on((1,), (), periodic=False)


def test_a_length_near_zero_is_zero():
    conditions = linear((0, 0, 1, 0, 0, 0), robot="stanford")
    q = np.zeros((4, 6))
    q[:, 2] = 1e-9
    assert list(conditions.combinations(q, np.ones(4), 1e-6)) == [(0.0,)]


def test_values_far_apart_stay_two(rng):
    conditions = linear((0, 1, 0, 0, 0, 0, 0))
    q = np.zeros((20, 7))
    q[:, 1] = np.where(np.arange(20) % 2, -2.2, 3.0)
    assert sorted(conditions.combinations(q, np.ones(20), 1e-6)) == [(-2.2,), (3.0,)]


def test_minors_are_of_the_values_that_are_pinned(rng):
    """det J of PUMA is a product of shoulder, elbow and wrist; with θ3 and θ5 pinned, of the shoulder alone."""
    robot = open_robot("puma560")
    problem = Problem(robot, resolve_task(None, robot))
    pinned = linear((0, 0, 1, 0, 0, 0), (0, 0, 0, 0, 1, 0), robot="puma560")
    signature = Signature(2, (2, 4), (), (), ())
    found = minors(problem, Row(pinned, ((0.7,), (0.9,)), (), signature, PLANTED), (1,), 2, rng)
    assert len(found) == 1
    q = rng.uniform(-pi, pi, (8, 6))
    q[:, 2], q[:, 4] = 0.7, 0.9
    at = np.linspace(-pi, pi, 2001)
    line = np.repeat(q[:1], len(at), axis=0)
    line[:, 1] = at
    determinant = np.linalg.det(task_jacobian(robot, line, problem.task))
    value = found[0](line)
    scale = (determinant @ value) / (value @ value)
    np.testing.assert_allclose(scale * value, determinant, atol=1e-12 * np.abs(determinant).max() + 1e-14)
    straight = Row(pinned, ((0.0,), (0.0,)), (), signature, PLANTED)
    assert minors(problem, straight, (1,), 2, rng) == []  # the wrist is straight: nothing is left to vanish
