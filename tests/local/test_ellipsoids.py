"""Ellipsoids: image of the ball of rates, dual to the ball of torques; indices from singular values."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest

from rankdrop.configuration import configuration_at
from rankdrop.kinematics import jacobian
from rankdrop.local.block import joint_scale, sample
from rankdrop.local.ellipsoids import ellipsoids
from rankdrop.local.rates import rate_limits
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task


@pytest.mark.parametrize("name", ["pa10", "panda", "fetch8", "ur5", "scara", "planar2r"])
def test_velocity_and_force_ellipsoids_are_dual(name: str) -> None:
    robot = open_robot(name)
    task = resolve_task(None, robot)
    for q in [*sample(robot, task, 4, 3), np.zeros(robot.n)]:
        found = ellipsoids(robot, q)
        sets = [(found.unit_rates, joint_scale(robot, task))]
        if np.isfinite(rate_limits(robot)).all():
            assert found.rate_limits is not None
            sets.append((found.rate_limits, rate_limits(robot)))
        for group, weights in sets:
            for part, first in ((group.translation, 0), (group.rotation, 3), (group.task, 0)):
                if part is None:
                    continue
                rows = jacobian(robot, q)[first : first + part.velocity.axes.shape[1]] * weights
                for twist, wrench, speed, force in zip(
                    part.velocity.semi_axes, part.force.semi_axes, part.velocity.half_lengths,
                    part.force.half_lengths, strict=True,
                ):  # fmt: skip
                    if speed == 0.0:
                        assert force == inf
                        assert np.isinf(wrench).any()
                        continue
                    rates = np.linalg.pinv(rows, rcond=1e-9) @ twist
                    assert speed * force == pytest.approx(1.0)
                    assert twist @ wrench == pytest.approx(1.0), "a unit of power"
                    kept = twist[np.abs(part.velocity.axes).max(axis=0) > 0]
                    assert kept.size
                    if name not in ("scara", "planar2r"):
                        assert np.linalg.norm(rows.T @ wrench) == pytest.approx(1.0), "unit torques"
                        if part is not group.task:
                            assert np.linalg.norm(rates) == pytest.approx(1.0), "unit rates"


@pytest.mark.parametrize("name", ["pa10", "panda", "ur5", "almarkhi4"])
def test_indices_are_those_of_the_verdict_and_the_determinant(name: str) -> None:
    robot = open_robot(name)
    task = resolve_task(None, robot)
    for q in sample(robot, task, 5, 8):
        part = ellipsoids(robot, q).unit_rates.task
        sigma = configuration_at(robot, q, task).measured.sigma
        assert part.sigma_min.value == pytest.approx(sigma[-1], rel=1e-12)
        assert part.condition.value == pytest.approx(sigma[0] / sigma[-1], rel=1e-12)
        rows = jacobian(robot, q)[list(task.rows)]
        rows[:3] /= task.scale(robot)
        assert part.manipulability.value == pytest.approx(np.sqrt(np.linalg.det(rows @ rows.T)), rel=1e-6)
        assert part.sigma_min.length_scale == task.scale(robot)


def test_translation_does_not_know_the_length_scale() -> None:
    robot = open_robot("pa10")
    q = [0.3, 0.5, 0.2, 0.9, 0.2, 0.7, 1.0]
    plain = ellipsoids(robot, q).unit_rates.translation
    other = ellipsoids(robot, q, resolve_task(None, robot, length_scale=3.0)).unit_rates.translation
    assert plain is not None
    assert other is not None
    assert np.allclose(plain.velocity.half_lengths, other.velocity.half_lengths, rtol=1e-12)
    assert plain.velocity.unit == "m/s"
    assert plain.manipulability.unit == "(m/rad)^3"
    assert plain.sigma_min.length_scale is None


def test_parts_that_the_task_lacks_are_none() -> None:
    robot = open_robot("panda")
    assert ellipsoids(robot, [0.1] * 7, "position").unit_rates.rotation is None
    assert ellipsoids(robot, [0.1] * 7, "orientation").unit_rates.translation is None
    assert ellipsoids(open_robot("pa10"), [0.1] * 7).rate_limits is None, "no limits are known"
