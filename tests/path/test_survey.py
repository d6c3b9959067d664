"""Measures along a path: the closest approach to families, rates and ranges of joints."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.path.check.check import check_path
from rankdrop.robot.open import open_robot


def test_the_closest_approach_is_found_between_samples() -> None:
    robot = open_robot("planar3r")
    q = np.array([[0.0, 1.0, 0.0], [0.4, 0.25, 0.0], [0.8, 0.3, 0.1], [1.0, 1.2, 0.1]])
    found = check_path(robot, q)
    (one,) = found.stretches
    assert one.verdict == "free"
    assert one.closest.distance == pytest.approx(0.25, abs=1e-6)
    assert one.closest.place.row + one.closest.place.share == pytest.approx(2.0, abs=1e-5)
    np.testing.assert_allclose(one.closest.foot, [0.4, 0.0, 0.0], atol=1e-5)
    bent = check_path(robot, q[[0, 1]], [0.0, 1.0], velocities=[[0, -1.5, 0], [0, 1.5, 0]], interpolate="cubic")
    dip = bent.curve.at(np.zeros(100_001, dtype=int), np.linspace(0, 1, 100_001))[:, 1]
    assert 0.05 < dip.min() < 0.24
    assert bent.stretches[0].closest.distance == pytest.approx(float(dip.min()), abs=1e-6)


@pytest.mark.slow
def test_joint_rates_are_held_against_the_limits() -> None:
    robot = open_robot("ur5e")
    q = np.array([[0.0, -1.2, 1.3, -1.0, 0.9, 0.1]] * 3)
    q[1, 0], q[2, 0] = 1.0, 1.5
    limit = robot.variables[0].velocity
    found = check_path(robot, q, [0.0, 0.1, 1.0])
    (one,) = found.stretches
    np.testing.assert_allclose(one.rates, [10.0, 0, 0, 0, 0, 0])
    assert one.speed_factor == pytest.approx(limit / 10.0)
    assert one.slowest == 1
    slower = check_path(robot, q, np.array([0.0, 0.1, 1.0]) / one.speed_factor)
    assert slower.stretches[0].speed_factor == pytest.approx(1.0)
    assert slower.stretches[0].slowest == 0
    assert np.isnan(check_path(robot, q).stretches[0].speed_factor)
    np.testing.assert_allclose(found.profile.rates.max(), 10.0 / limit)


@pytest.mark.slow
def test_the_rates_of_a_cubic_are_not_below_those_it_has() -> None:
    robot = open_robot("ur5e")
    rng = np.random.default_rng(5)
    q, v = np.array([0.0, -1.2, 1.3, -1.0, 0.9, 0.1]) + rng.normal(size=(4, 6)) * 0.1, rng.normal(size=(4, 6))
    t = np.arange(4.0)
    found = check_path(robot, q, t, velocities=v, interpolate="cubic")
    share = np.tile(np.linspace(0, 1, 200), 3)
    rates = np.abs(found.curve.slope(np.repeat(np.arange(3), 200), share)).max(axis=0)
    most = np.max([one.rates for one in found.stretches], axis=0)
    assert (most >= rates - 1e-12).all()
    assert (most <= 3 * rates).all()
    bent = np.array([0.1, 0.2, -0.1, 0.3, 0.1, 0.2])
    q, v = q[0] + t[:, None] ** 2 * bent, 2 * t[:, None] * bent  # fastest at its end: the bound is reached
    found = check_path(robot, q, t, velocities=v, interpolate="cubic")
    most = np.max([one.rates for one in found.stretches], axis=0)
    np.testing.assert_allclose(most, np.abs(v).max(axis=0), rtol=1e-9)


@pytest.mark.slow
def test_joints_outside_their_limits_are_named() -> None:
    robot = open_robot("panda")
    q = np.tile([0.0, 0.3, 0.0, -1.0, 0.1, 1.9, 0.7], (3, 1))
    assert check_path(robot, q).violations == ()
    q[1:, 3] = [0.5, 0.6]
    found = check_path(robot, q)
    (one,) = found.violations
    assert (one.what, one.joint, one.rows, one.place.row, one.proven) == ("range", 4, 2, 2, True)
    assert one.amount == pytest.approx(0.6 - robot.upper[3])
    assert found.verdict == "outside limits"
    assert "joint 4 (panda_joint4) is outside its limits in 2 rows, first at row 2" in found.sentence.lower()
