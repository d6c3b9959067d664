"""The slowest straight motion: against a linear programme, and what `explain` makes of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rankdrop.kinematics import task_jacobian
from rankdrop.local.rates import rate_limits
from rankdrop.local.slowest import slowest_motions
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.robot.screws import from_screws, revolute
from rankdrop.task import resolve_task
from rankdrop.units import scale_lengths
from rankdrop.verbs.explain import explain


def drawn(arm: Robot, count: int, seed: int) -> Array:
    low, high = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    return np.random.default_rng(seed).uniform(low, high, (count, arm.n))


def speed_along(arm: Robot, q: Array, direction: Array) -> float:
    """The largest speed of a straight translation, by a linear programme."""
    optimize = pytest.importorskip("scipy.optimize")
    task = resolve_task("pose", arm, length_scale=1.0)
    columns, twist = task_jacobian(arm, q, task), np.concatenate([direction, np.zeros(3)])
    limits = rate_limits(arm)
    found = optimize.linprog(
        np.r_[np.zeros(arm.n), -1.0], A_eq=np.c_[columns, -twist], b_eq=np.zeros(6),
        bounds=[*((-x, x) for x in limits), (0, None)],
    )  # fmt: skip
    return float(-found.fun)


@pytest.mark.spread(2)
@pytest.mark.slow
@pytest.mark.parametrize("name", ["gen3", "ur5e", "fetch8"])
def test_the_slowest_motion_is_the_minimum_of_a_linear_programme(name: str, rng: np.random.Generator) -> None:
    arm = open_robot(name)
    q = drawn(arm, 3, seed=1)
    slow = slowest_motions(arm, q, resolve_task("pose", arm))[0]
    for i in range(3):
        best = slow.direction[i]
        assert np.linalg.norm(best) == pytest.approx(1.0)
        assert speed_along(arm, q[i], best) == pytest.approx(slow.speed[i], rel=1e-6)
        others = rng.normal(size=(20, 3))
        others = np.concatenate([others, best + 0.03 * others])
        others /= np.linalg.norm(others, axis=1, keepdims=True)
        assert min(speed_along(arm, q[i], one) for one in others) >= slow.speed[i] * (1 - 1e-6)


def test_a_planar_arm_in_closed_form() -> None:
    """Two joints, position alone: s = min over joints of limit / |row of J⁻¹|."""
    arm = open_robot("planar2r")
    arm = replace(arm, joints=tuple(replace(j, velocity=v) for j, v in zip(arm.joints, (1.0, 0.5), strict=True)))
    task = resolve_task("planar-position", arm, length_scale=1.0)
    q = np.array([0.3, 0.2])
    inverse = np.linalg.inv(task_jacobian(arm, q, task))
    speeds = np.array([1.0, 0.5]) / np.linalg.norm(inverse, axis=1)
    (slow,) = slowest_motions(arm, q, task)
    assert slow.speed[0] == pytest.approx(speeds.min())
    assert slow.joint[0] == 1 + int(speeds.argmin())


def test_limits_that_are_missing_or_zero() -> None:
    arm = open_robot("ur5e")
    q = drawn(arm, 1, seed=2)
    task = resolve_task(None, arm)
    free = replace(arm, joints=tuple(replace(joint, velocity=np.inf) for joint in arm.joints))
    assert slowest_motions(free, q, task) == ()
    assert explain(free, q[0]).straight == ()
    stuck = replace(arm, joints=(replace(arm.joints[0], velocity=0.0), *arm.joints[1:]))
    assert slowest_motions(stuck, q, task)[0].speed[0] == pytest.approx(0.0, abs=1e-12)
    some = replace(arm, joints=(replace(arm.joints[0], velocity=np.inf), *arm.joints[1:]))
    assert slowest_motions(some, q, task)[0].joint[0] != 1
    few = from_screws([revolute([0, 0, 1], [x, 0, 0]) for x in (0.0, 0.4)], order="linear-first")
    assert slowest_motions(few, [0.1, 0.2], resolve_task("pose", few)) == ()


def test_speed_does_not_depend_on_the_unit_of_length() -> None:
    arm = open_robot("ur5e")
    q = drawn(arm, 5, seed=3)
    ours = slowest_motions(arm, q, resolve_task(None, arm))
    mm = scale_lengths(arm, 3)
    theirs = slowest_motions(mm, q, resolve_task(None, mm))
    for one, other in zip(ours, theirs, strict=True):
        assert one.speed == pytest.approx(other.speed, rel=1e-9)
