"""ML's planar arm: closed forms equal the product's Jacobian and its inverse."""

from __future__ import annotations

from math import inf, pi

import numpy as np
import pytest

from papers.planar import FORMULAS, LATEX, planar_two_link, rate_table
from rankdrop.errors import OptionError
from rankdrop.kinematics import jacobian
from rankdrop.local.rates import joint_rates
from rankdrop.robot.open import open_robot
from rankdrop.task import TIP, Frame, resolve_task

AXES_1 = Frame(axes=1, origin=TIP)


@pytest.mark.parametrize("theta2", [0.7, -2.1, 1e-3, 1e-6, pi - 1e-4, pi / 2])
@pytest.mark.parametrize("theta1", [0.0, 0.4, -2.9])
def test_closed_forms_equal_the_jacobian_in_the_axes_of_link_1(theta1: float, theta2: float) -> None:
    rows = jacobian(open_robot("planar2r"), [theta1, theta2], AXES_1)[:2]
    arm = planar_two_link(1.0, 0.7, theta2)
    assert np.abs(arm.jacobian - rows).max() < 1e-15
    assert arm.determinant == pytest.approx(np.linalg.det(rows), rel=1e-9)
    assert arm.inverse is not None
    assert np.abs(arm.inverse - np.linalg.inv(rows)).max() < 1e-9 * np.abs(arm.inverse).max()
    assert np.abs(arm.inverse[:, 0] - arm.rates_x).max() <= 1e-12 * np.abs(arm.inverse).max()
    assert np.abs(arm.inverse[:, 1] - arm.rates_y).max() <= 1e-12 * np.abs(arm.inverse).max()
    assert not arm.fails


@pytest.mark.parametrize("theta2", [0.0, pi, -pi])
def test_at_the_singularity_there_is_no_inverse_and_the_jacobian_has_one_row(theta2: float) -> None:
    arm = planar_two_link(1.0, 0.7, theta2)
    assert arm.fails
    assert arm.inverse is None
    assert arm.rates_x == (inf, inf)
    assert np.abs(arm.jacobian[0]).max() < 1e-15
    assert arm.rates_y == (1.0, -1.0)
    assert arm.jacobian[1] @ arm.rates_y == pytest.approx(1.0)
    robot = open_robot("planar2r")
    task = resolve_task(None, robot, frame=AXES_1)
    x, y = joint_rates(robot, [0.4, theta2], task).axes
    assert (x.possible, x.speed, y.possible) == (False, 0.0, True)


def test_rates_blow_up_as_one_over_the_angle_along_the_arm_only() -> None:
    table = rate_table(1.0, 0.7, [1e-1, 1e-2, 1e-3, 1e-4])
    grown = table[1:, 1:3] / table[:-1, 1:3]
    assert np.abs(grown - 10).max() < 0.1
    assert (table[:, 3:] == [1.0, -1.0]).all()
    robot = open_robot("planar2r")
    for row in table:
        x, y = joint_rates(robot, [0.4, row[0]], resolve_task(None, robot, frame=AXES_1)).axes
        assert np.allclose(x.joint_rates, row[1:3], rtol=1e-9)
        assert np.allclose(y.joint_rates, row[3:], rtol=1e-6)


def test_formulas_are_there_in_both_forms_and_nonsense_is_refused() -> None:
    assert FORMULAS.keys() == LATEX.keys()
    assert rate_table(1.0, 1.0, []).shape == (0, 5)
    with pytest.raises(OptionError, match="a2"):
        planar_two_link(1.0, 0.0, 0.3)
    with pytest.raises(OptionError, match="theta2"):
        planar_two_link(1.0, 1.0, inf)


def test_the_inverse_without_its_factors_a2_is_no_inverse() -> None:
    arm = planar_two_link(1.0, 0.7, 0.5)
    c, s = np.cos(0.5), np.sin(0.5)
    lacking = np.array([[c, s], [-1.0 - 0.7 * c, -0.7 * s]]) / (0.7 * s)
    assert np.abs(arm.jacobian @ lacking - np.eye(2)).max() > 0.1
    assert np.abs(arm.jacobian @ arm.inverse - np.eye(2)).max() < 1e-14
