"""Gradients of tied singular values, what turning their vectors does to them, and descent across a crease."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.families.searching import Outcome, refine
from rankdrop.local import minimax
from rankdrop.local.block import sample, singular_values
from rankdrop.local.minimax import brought_down, gradient_tensor, plane_rotation, spread, stays_up, tied_gradients
from rankdrop.problem import Problem
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task


@pytest.fixture(scope="module")
def pa10():
    robot = open_robot("pa10")
    return robot, resolve_task("pose", robot, length_scale=1.0)


def test_the_diagonal_holds_the_gradients(pa10):
    robot, task = pa10
    for q in sample(robot, task, 5, 0):
        sigma, tensor = gradient_tensor(robot, q, task, 3)
        measured = [
            (singular_values(robot, q + 1e-6 * e, task) - singular_values(robot, q - 1e-6 * e, task)) / 2e-6
            for e in np.eye(7)
        ]
        assert np.abs(np.einsum("aan->an", tensor) - np.array(measured).T[3:]).max() < 1e-7
        assert np.array_equal(sigma, singular_values(robot, q, task))


def test_rotation_of_a_plane_is_orthogonal_and_keeps_the_sum_of_gradients(rng):
    tensor = rng.normal(size=(3, 3, 7))
    for a, b in ((0, 1), (0, 2), (1, 2)):
        turned = plane_rotation(3, a, b, 0.7)
        assert np.allclose(turned.T @ turned, np.eye(3))
        gradients = tied_gradients(tensor, turned)
        assert np.allclose(gradients.sum(axis=0), tied_gradients(tensor, np.eye(3)).sum(axis=0))


def test_spread_is_the_sum_of_angles():
    assert spread(np.eye(3)) == pytest.approx(3 * np.pi / 2)
    assert spread(np.array([[1.0, 0.0], [-2.0, 0.0]])) == pytest.approx(np.pi)


def test_many_configurations_at_once_are_each_on_its_own(pa10):
    robot, task = pa10
    q = sample(robot, task, 4, 3)
    sigma, tensor = gradient_tensor(robot, q, task, 4)
    for row in range(4):
        one = gradient_tensor(robot, q[row], task, 4)
        assert np.array_equal(one[0], sigma[row])
        assert np.allclose(one[1], tensor[row], atol=1e-14)


def test_almarkhi4_second_singular_value_is_least_at_0_70833(rng):
    robot = open_robot("almarkhi4")
    task = resolve_task("position", robot, length_scale=1.0)
    found = brought_down(Problem(robot, task, 2), sample(robot, task, 40, 1))
    best = int(np.argmin(found.value))
    assert found.value[best] == pytest.approx(0.7083299566, abs=1e-8)
    assert found.slope[best] < 1e-5
    assert stays_up(Problem(robot, task, 2), found.q[best : best + 1])[0]
    around = found.q[best] + 1e-3 * rng.normal(size=(2000, 4))
    assert singular_values(robot, around, task)[:, 1].min() >= found.value[best] - 1e-9
    printed = [found.q[best, 0], 3.04691, 2.28528, -2.57122]
    assert singular_values(robot, printed, task)[1] == pytest.approx(0.70833, abs=1e-5)


def test_a_descent_never_rises_and_stays_in_its_limits():
    robot = open_robot("panda")
    task = resolve_task(None, robot)
    start = sample(robot, task, 30, 5, limits=True)
    found = brought_down(Problem(robot, task, 2, limits=True), start, iterations=60)
    assert (found.q >= robot.lower).all()
    assert (found.q <= robot.upper).all()
    assert (found.value <= singular_values(robot, start, task)[:, 4]).all()
    assert np.array_equal(found.value, singular_values(robot, found.q, task)[:, 4])


def test_a_crease_is_no_minimum_and_a_minimum_is_none_of_its_slopes():
    """F = max(x + y, −x + y) has a crease along x = 0 and falls along it; F = max(x, −x) + y² has its minimum at 0."""

    def falls(q):
        values = np.stack([q[:, 0] + q[:, 1], q[:, 1] - q[:, 0]], axis=1)[:, :, None]
        return values, np.broadcast_to(np.array([[[[1.0, 1.0]]], [[[-1.0, 1.0]]]]), (len(q), 2, 1, 1, 2))

    def rests(q):
        values = np.stack([q[:, 0] + q[:, 1] ** 2, q[:, 1] ** 2 - q[:, 0]], axis=1)[:, :, None]
        tensor = np.zeros((len(q), 2, 1, 1, 2))
        tensor[:, 0, 0, 0, 0], tensor[:, 1, 0, 0, 0] = 1.0, -1.0
        tensor[:, :, 0, 0, 1] = 2 * q[:, None, 1]
        return values, tensor

    at = np.zeros((1, 2))
    assert minimax.promised_step(*falls(at), np.ones(1))[1] == pytest.approx([1.0])
    assert minimax.promised_step(*rests(at), np.ones(1))[2] == pytest.approx([0.0], abs=1e-12)
    found = minimax.descend(rests, np.array([[0.7, -0.4], [-0.2, 0.9]]))
    assert np.abs(found.q).max() < 1e-5
    assert found.value == pytest.approx([0.0, 0.0], abs=1e-9)


def test_a_mixture_of_tied_vectors_counts_too():
    """λ_max of [[x, y], [y, −x]] is √(x² + y²): with the diagonal alone the tie at 0 would look like a crease in x."""

    def cone(q):
        tensor = np.zeros((len(q), 1, 2, 2, 2))
        tensor[:, 0, 0, 0, 0], tensor[:, 0, 1, 1, 0] = 1.0, -1.0
        tensor[:, 0, 0, 1, 1] = tensor[:, 0, 1, 0, 1] = 1.0
        return np.zeros((len(q), 1, 2)), tensor

    move, _, most, _ = minimax.promised_step(*cone(np.zeros((1, 2))), np.ones(1))
    assert np.abs(move).max() < 1e-9
    assert most == pytest.approx([0.0], abs=1e-9)


def test_where_a_plain_descent_stops_on_a_tie_is_no_minimum(pa10):
    robot, task = pa10
    q = sample(robot, task, 106, 2)[-1:]
    stuck = refine(robot, q, 2, task=task, method="gradient", step=0.0)
    assert stuck.outcome[0] == Outcome.CREASE
    assert stuck.sigma[0, 4] == pytest.approx(5.1e-4, rel=0.02)
    assert not stays_up(Problem(robot, task, 2), stuck.q)[0]
    assert brought_down(Problem(robot, task, 2), stuck.q).value[0] < 1e-6
