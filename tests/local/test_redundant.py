"""Range, null space, projector: the same by two formulas, right at singular configurations."""

from __future__ import annotations

import numpy as np
import pytest
from reference import arms
from reference.measure import central_differences

from rankdrop.errors import OptionError
from rankdrop.kinematics import jacobian
from rankdrop.local.block import decompose, sample, singular_values
from rankdrop.local.directions import lost_directions
from rankdrop.local.inverses import factor
from rankdrop.local.redundant import (
    away_from_limits,
    away_from_singularity,
    null_space_motion,
    readable_parts,
    redundancy,
    towards,
)
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

ARMS = ["pa10", "panda", "fetch8", "ur5", "scara", "rcrrrr", "planar2r", "almarkhi4", "canadarm2", "stanford"]


def looked_at(robot: Robot) -> Array:
    task = resolve_task(None, robot)
    return np.concatenate([sample(robot, task, 6, 4), np.zeros((1, robot.n)), np.full((1, robot.n), 1e-3)])


@pytest.mark.parametrize("task_name", [None, "position", "orientation"])
@pytest.mark.parametrize("name", ARMS)
def test_projector_bases_and_rank_nullity(name: str, task_name: str | None) -> None:
    robot = open_robot(name)
    task = resolve_task(task_name, robot)
    for q in looked_at(robot):
        found = redundancy(robot, q, task)
        rows = jacobian(robot, q)[list(task.rows)]
        p, w = found.projector, found.joint_scale
        assert found.check.holds
        dropped = max(1e-12, float(found.rank.sigma[found.rank.rank :].max(initial=0.0)))  # below 1e-9, but not nothing
        assert dropped <= found.rank.tolerance
        assert found.check.largest <= 1.01 * dropped
        assert found.rank.rank + found.rank.nullity == robot.n
        assert found.null_basis.shape == (found.rank.nullity, robot.n)
        assert found.range_basis.shape == (found.rank.rank, 6)
        assert np.abs(p @ p - p).max() < 1e-12
        assert np.abs(rows @ p).max() < 10 * dropped
        scaled = p * w / w[:, None]
        assert np.abs(scaled - scaled.T).max() < 1e-13
        assert np.trace(p) == pytest.approx(found.rank.nullity, abs=1e-12)
        null = found.null_basis / w
        assert np.abs(null @ null.T - np.eye(len(null))).max(initial=0.0) < 1e-12
        assert np.abs(rows @ found.null_basis.T).max(initial=0.0) < 10 * dropped
        assert np.abs(found.range_basis @ found.range_basis.T - np.eye(found.rank.rank)).max() < 1e-12
        six = np.zeros((6, robot.n))
        six[list(task.rows)] = rows
        assert np.abs(six - found.range_basis.T @ (found.range_basis @ six)).max() < 1e-8, "everything made lies in it"
        if found.rank.corank:
            lost = lost_directions(robot, q, task, found.rank.corank)
            assert np.abs(found.range_basis @ lost.T).max() < 1e-9


@pytest.mark.parametrize("name", ["pa10", "ur5", "planar3r", "scara"])
def test_closed_form_is_the_projector_at_exactly_singular_configurations_too(name: str) -> None:
    robot, q = arms.singular_configurations("puma" if name == "ur5" else name, np.random.default_rng(2), 12)
    coranks = set()
    for one in q:
        found = redundancy(robot, one)
        coranks.add(found.rank.corank)
        sigma = found.rank.sigma[found.rank.rank - 1]
        assert found.rank.corank > 0
        assert found.difference < 1e-14 / sigma**2
        assert found.annihilates < 1e-14
    assert coranks == ({1, 2, 3} if name == "pa10" else {1})


def test_closed_form_loses_half_the_digits_near_a_singularity_and_the_projector_none() -> None:
    robot = open_robot("pa10")
    q = np.array([0.3, 0.7, 0.4, 0.0, 0.5, 0.6, 0.2])
    for angle in (1e-2, 1e-3, 1e-4):
        q[3] = angle
        found = redundancy(robot, q)
        sigma = found.rank.sigma[-1]
        assert 1e-19 / sigma**2 < found.difference < 1e-14 / sigma**2
        assert found.annihilates < 1e-14


@pytest.mark.parametrize("name", ["pa10", "fetch8", "ur5", "scara", "almarkhi4"])
def test_null_space_motion_follows_the_twist_and_nothing_of_the_rest_is_seen(name: str) -> None:
    robot = open_robot(name)
    task = resolve_task(None, robot)
    rng = np.random.default_rng(5)
    q = sample(robot, task, 12, 6).reshape(3, 4, -1)
    rows = jacobian(robot, q)[..., list(task.rows), :]
    twist, wished = rng.normal(size=(3, 4, task.m)), rng.normal(size=(3, 4, robot.n))
    found = null_space_motion(robot, q, twist, wished, task)
    assert np.abs((rows @ found[..., None])[..., 0] - twist).max() < 1e-10
    one = redundancy(robot, q[1, 2], task)
    unseen = found[1, 2] - null_space_motion(robot, q[1, 2], twist[1, 2], np.zeros(robot.n), task)
    assert np.abs(unseen - one.projector @ wished[1, 2]).max() < 1e-10
    zero = null_space_motion(robot, np.zeros(robot.n), np.zeros(task.m), wished[0, 0], task)
    assert np.abs(jacobian(robot, np.zeros(robot.n))[list(task.rows)] @ zero).max() < 1e-12


def test_null_space_motion_refuses_wrong_shapes() -> None:
    robot = open_robot("pa10")
    with pytest.raises(OptionError, match="twist"):
        null_space_motion(robot, [0.0] * 7, [0.0] * 5, [0.0] * 7)
    with pytest.raises(OptionError, match="batch"):
        null_space_motion(robot, np.zeros((3, 7)), np.zeros((2, 6)), np.zeros(7))


@pytest.mark.parametrize("name", ["pa10", "ur5", "fetch8", "almarkhi4"])
def test_away_from_singularity_is_the_gradient_of_sigma(name: str) -> None:
    robot = open_robot(name)
    task = resolve_task(None, robot)
    q = sample(robot, task, 8, 9)
    scale = factor(robot, q, task).joints
    for one, gradient in zip(q, away_from_singularity(robot, q), strict=True):
        want = central_differences(lambda x: singular_values(robot, x, task)[..., -1], one, h=1e-4)
        assert np.abs(gradient / scale**2 - want).max() < 1e-7


def test_other_objectives() -> None:
    robot = open_robot("panda")
    q = sample(robot, resolve_task(None, robot), 5, 9, limits=True)
    middle = 0.5 * (robot.lower + robot.upper)
    assert np.abs(q + away_from_limits(robot, q) - middle).max() < 1e-12
    assert not away_from_limits(open_robot("pa10"), np.ones(7)).any()
    goal = np.full(7, 0.2)
    assert np.abs(towards(robot, goal + 2 * np.pi, goal)).max() < 1e-12
    assert np.abs(q + towards(robot, q, goal) - goal).max() < 2 * np.pi + 1


@pytest.mark.parametrize("count", range(8))
def test_readable_parts_span_the_same_whatever_the_basis(count: int) -> None:
    rng = np.random.default_rng(count)
    sparse = rng.normal(size=(7, count)) * (rng.random((7, count)) < 0.5)
    planted = np.linalg.qr(sparse + 1e-3 * rng.normal(size=(7, count)))[0]
    found = readable_parts(planted)
    turned = readable_parts(planted @ np.linalg.qr(rng.normal(size=(count, count)))[0]) if count else found
    assert np.abs(found @ found.T - planted @ planted.T).max(initial=0.0) < 1e-10
    assert np.abs(found.T @ found - np.eye(count)).max(initial=0.0) < 1e-10
    assert np.abs(found - turned).max(initial=0.0) < 1e-6


def test_pa10_at_zero_has_four_null_motions_in_two_blocks() -> None:
    found = redundancy(open_robot("pa10"), [0.0] * 7)
    assert found.check.nullity == 4
    together = {tuple(np.flatnonzero(np.abs(row) > 1e-9) % 2) for row in found.null_basis}
    assert all(len(set(kinds)) == 1 for kinds in together), "odd and even joints do not mix"
    assert decompose(open_robot("pa10"), [0.0] * 7, resolve_task(None, open_robot("pa10"))).sigma[3] < 1e-12
