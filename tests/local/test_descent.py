"""Descent with a step rule: gradients are right, ties are treated as AM say, angles are what the rule makes them."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.errors import OptionError
from rankdrop.local.block import sample, singular_values
from rankdrop.local.descent import descend, gradient_tensor, plane_rotation, spread, tied_gradients
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


def test_steps_to_linearised_zero_reach_rank_1_quickly(pa10):
    robot, task = pa10
    found = [descend(robot, q, 1, task=task) for q in sample(robot, task, 20, 1)]
    assert all(one.converged for one in found)
    assert max(one.iterations for one in found) < 60
    for one in found:
        assert one.sigma.shape == (one.iterations + 1, 6)
        assert len(one.angles) == one.iterations
        assert one.iterations == 0 or np.isnan(one.angles[0])
        assert np.array_equal(singular_values(robot, one.q, task), one.sigma[-1])


def test_a_small_share_falls_by_that_share_where_no_tie_is_met(pa10):
    robot, task = pa10
    found = descend(robot, [0.1, 0.9, 0.3, 1.4, 0.5, 1.1, 0.7], 1, task=task, share=0.01, iterations=50)
    ratios = found.sigma[1:, 5] / found.sigma[:-1, 5]
    assert ratios == pytest.approx(0.99 * np.ones(50), abs=2e-3)


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


def test_first_tie(pa10):
    robot, task = pa10
    found = descend(robot, sample(robot, task, 1, 2)[0], 2, task=task, iterations=30)
    assert found.first_tie(gap=2.0) == 0
    assert found.first_tie(gap=-1.0) is None


def test_a_corank_that_is_not_there_is_refused(pa10):
    with pytest.raises(OptionError):
        descend(pa10[0], np.zeros(7), 7)
