"""What the failure of single joints leaves, against plain NumPy and against what is known of AM's 4R arm."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.kinematics import jacobian, task_jacobian
from rankdrop.local import directions
from rankdrop.local.block import joint_scale, sample
from rankdrop.local.directions import lost_without
from rankdrop.local.failures import failure_model, failures_at, worst_case
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.units import in_units, task_in_units

OPTIMUM = np.array([0.7, np.pi, np.pi, np.pi - np.arctan(1 / np.sqrt(2))])


@pytest.fixture(scope="module")
def regional():
    robot = open_robot("almarkhi4")
    return robot, resolve_task("position", robot, length_scale=1.0)


def test_the_4r_arm_is_optimally_fault_tolerant_where_all_is_equal(regional):
    robot, task = regional
    jacobian = task_jacobian(robot, OPTIMUM, task)
    assert np.linalg.svd(jacobian, compute_uv=False) == pytest.approx([1.0, 1.0, 1.0], abs=1e-12)
    null = np.linalg.svd(jacobian)[2][3]
    assert null * np.sign(null[0]) == pytest.approx([0.5] * 4, abs=1e-12)
    found = failures_at(robot, OPTIMUM, task)
    assert [one.sigma_min for one in found.single] == pytest.approx([0.5] * 4, abs=1e-12)
    assert [one.share for one in found.single] == pytest.approx([0.5] * 4, abs=1e-12)
    assert found.bound == pytest.approx(np.sqrt(1 / 4), abs=1e-12)
    assert all(one.rank == 3 and not one.lost_words for one in found.single)
    assert found.worst_numbers == (1, 2, 3, 4)


@pytest.mark.parametrize("name", ["almarkhi4", "panda", "fetch8", "pa10", "ur5"])
def test_singular_values_and_shares_are_those_of_numpy(name, rng):
    robot = open_robot(name)
    task = resolve_task(None, robot)
    for q in sample(robot, task, 4, 8):
        whole = task_jacobian(robot, q, task) * joint_scale(robot, task)
        found = failures_at(robot, q, task)
        leverage = np.diag(np.linalg.pinv(whole) @ whole)
        for j, one in enumerate(found.single):
            left = np.linalg.svd(np.delete(whole, j, axis=1), compute_uv=False)
            assert one.sigma == pytest.approx(left, abs=1e-9)
            assert one.share**2 == pytest.approx(1.0 - leverage[j], abs=1e-9)
            assert one.sigma_min <= found.sigma_min * (1 + 1e-12)
        assert sum(one.share**2 for one in found.single) == pytest.approx(robot.n - found.generic_rank, abs=1e-9)
        assert found.worst.sigma_min <= found.bound * (1 + 1e-12)


def test_what_is_lost_cannot_be_made_by_the_others():
    robot = open_robot("pa10")
    task = resolve_task("pose", robot, length_scale=1.0)
    q = np.array([0.3, -0.4, 1.1, 0.9, -0.7, 1.3, 0.5])
    found = failures_at(robot, q, task)
    assert [one.rank for one in found.single] == [6, 6, 6, 5, 6, 6, 6]
    (elbow,) = [one for one in found.single if one.number == 4]
    assert elbow.sigma_min == 0.0
    assert elbow.share == pytest.approx(0.0, abs=1e-12)
    assert len(elbow.lost) == len(elbow.lost_words) == 1
    assert "cannot translate" in elbow.lost_words[0]
    framed = lost_without(robot, q, task, {3: 1})[3]
    seen = jacobian(robot, q, framed.frame)
    assert np.abs(np.delete(framed.directions @ seen, 3, axis=1)).max() < 1e-12
    assert abs((framed.directions @ seen)[0, 3]) > 0.1


def test_a_singular_place_has_no_bound_and_an_arm_without_spare_loses_one_each():
    singular = failures_at(open_robot("pa10"), np.zeros(7))
    assert singular.bound is None
    assert all(one.rank <= 3 and len(one.lost_words) == 6 - one.rank for one in singular.single)
    spare = failures_at(open_robot("ur5"), [0.1, -1.2, 0.8, 1.5, -1.5, 0.3])
    assert [one.rank for one in spare.single] == [5] * 6
    assert all(len(one.lost_words) == 1 for one in spare.single)
    alone = failures_at(open_robot("scara"), [0.3, 0.5, 0.1, 0.2])
    assert alone.generic_rank == 4
    assert all(one.rank == 3 for one in alone.single)


@pytest.mark.parametrize("name", ["almarkhi4", "fetch8"])
@pytest.mark.parametrize("relative", [False, True])
def test_the_model_is_the_worst_case_and_its_derivative(name, relative):
    robot = in_units(open_robot(name))
    task = task_in_units(resolve_task(None, robot), robot)
    scale = joint_scale(robot, task)
    model = failure_model(robot, task, relative=relative)
    q = sample(robot, task, 6, 2)
    values, tensor = model(q / scale)
    assert -values.max(axis=(1, 2)) == pytest.approx(worst_case(robot, q, task, relative=relative), abs=1e-12)
    worst = values.max(axis=2).argmax(axis=1), values.max(axis=1).argmax(axis=1)
    for k, e in enumerate(np.eye(robot.n)):
        ahead, behind = (worst_case(robot, q + sign * 1e-6 * e * scale, task, relative=relative) for sign in (1, -1))
        slope = tensor[np.arange(6), worst[0], worst[1], worst[1], k]
        assert -slope == pytest.approx((ahead - behind) / 2e-6, abs=1e-6)


def test_joints_that_cost_as_much_are_asked_together(monkeypatch):
    """Where every joint's failure costs a freedom, the motions lost are made readable in one call."""
    calls = []
    readable_bases = directions.readable_bases
    monkeypatch.setattr(directions, "readable_bases", lambda bases: calls.append(len(bases)) or readable_bases(bases))
    arm = open_robot("pa10")
    found = failures_at(arm, [0.3, 0.4, 0.5, 0.0, 0.2, 0.4, 1.0], resolve_task(None, arm))
    lost = {len(one.lost) for one in found.single}
    assert len(calls) == len(lost - {0}) < sum(len(one.lost) > 0 for one in found.single)
