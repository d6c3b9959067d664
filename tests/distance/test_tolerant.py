"""Configurations that bear a failed joint best: known optima, local maxima, limits, seeds."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.distance.tolerant import climb_to_tolerant
from rankdrop.kinematics import task_jacobian
from rankdrop.local.block import sample
from rankdrop.local.failures import worst_case
from rankdrop.questions import TolerantOptions
from rankdrop.robot.open import open_robot
from rankdrop.sections import text
from rankdrop.task import resolve_task
from rankdrop.text.words import tolerant_sections
from rankdrop.verbs.tolerant import most_tolerant


@pytest.fixture(scope="module")
def regional():
    robot = open_robot("almarkhi4")
    return robot, resolve_task("position", robot, length_scale=1.0)


@pytest.mark.slow
def test_the_optimum_that_am_s_4r_arm_was_made_for_is_found(regional):
    robot, task = regional
    found = most_tolerant(robot, task, relative=True, starts=60)
    best = found.places[0]
    assert best.value == pytest.approx(0.5, abs=1e-9)
    assert found.bound == 0.5
    assert found.optimal
    assert found.free == (1,)
    gap = best.q[1:] - [np.pi, np.pi, np.pi - np.arctan(1 / np.sqrt(2))]
    assert gap == pytest.approx([0.0] * 3, abs=1e-6)
    assert best.failures.bound == pytest.approx(0.5, abs=1e-6)
    assert "reaches it, none is better" in text(tolerant_sections(found))


def test_the_largest_sigma_left_is_larger_elsewhere(regional):
    robot, task = regional
    found = most_tolerant(robot, task, starts=60)
    assert found.places[0].value == pytest.approx(0.7718711, abs=1e-6)
    assert found.places[0].failures.worst_numbers == (1, 2, 3, 4)
    assert worst_case(robot, sample(robot, task, 20_000, 3), task).max() < found.places[0].value
    values = [place.value for place in found.places]
    assert values == sorted(values, reverse=True)
    assert "a better one may have been missed" in text(tolerant_sections(found))


@pytest.mark.slow
def test_within_limits_it_stays_inside_and_no_sample_is_better():
    robot = open_robot("panda")
    found = most_tolerant(robot, limits=True, starts=60, show=2)
    for place in found.places:
        assert (place.q >= robot.lower).all()
        assert (place.q <= robot.upper).all()
        assert place.value == pytest.approx(float(worst_case(robot, place.q, found.task)), abs=1e-9)
    assert worst_case(robot, sample(robot, found.task, 3000, 1, limits=True), found.task).max() < found.places[0].value
    assert found.free == (1, 7)


@pytest.mark.slow
def test_the_same_seed_gives_the_same_places(regional):
    robot, task = regional
    one, other = (most_tolerant(robot, task, starts=55, seed=4) for _ in range(2))
    assert all(np.array_equal(a.q, b.q) for a, b in zip(one.places, other.places, strict=True))
    third = most_tolerant(robot, task, starts=55, seed=5)
    assert third.places[0].value == pytest.approx(one.places[0].value, abs=1e-6)


@pytest.mark.parametrize("relative", [False, True])
def test_no_configuration_next_to_a_maximum_is_better(regional, relative: bool, rng: np.random.Generator) -> None:
    """Worst cases by deleting columns of the Jacobian one after the other, 1e-3 rad away in any direction."""
    robot, task = regional
    found = climb_to_tolerant(robot, task, TolerantOptions(relative=relative, starts=40, show=2))
    assert found.places
    for place in found.places:
        steps = rng.normal(size=(500, robot.n))
        around = place.q + 1e-3 * steps / np.linalg.norm(steps, axis=1)[:, None]
        values = [worst_by_columns(task_jacobian(robot, q, task), relative=relative) for q in (place.q, *around)]
        assert values[0] == pytest.approx(place.value, abs=1e-9)
        assert max(values[1:]) <= place.value + 1e-9
        assert place.value <= found.bound + 1e-9 or not relative


def worst_by_columns(jacobian: np.ndarray, *, relative: bool) -> float:
    """The least σ that is left when one column is missing; relative: divided by the largest of the whole."""
    without = [np.delete(jacobian, j, axis=1) for j in range(jacobian.shape[1])]
    least = min(np.linalg.svd(matrix, compute_uv=False)[-1] for matrix in without)
    return float(least / np.linalg.norm(jacobian, 2) if relative else least)


def test_an_arm_without_a_joint_to_spare_has_none_and_every_joint_is_crucial() -> None:
    found = climb_to_tolerant(open_robot("puma560"), resolve_task(None, open_robot("puma560")), TolerantOptions())
    assert (found.places, found.spare, found.done) == ((), 0, 0)
    assert found.crucial == (1, 2, 3, 4, 5, 6)
    assert found.complete
    assert not found.optimal


def test_joints_that_change_nothing_stand_at_zero(regional) -> None:
    robot, task = regional
    found = climb_to_tolerant(robot, task, TolerantOptions(starts=20, show=1))
    assert found.free == (1,)
    assert found.places[0].q[0] == 0.0
    assert np.abs(found.places[0].q).max() <= np.pi + 1e-6


def test_joints_that_change_nothing_stand_in_the_middle_of_their_limits() -> None:
    robot = open_robot("panda")
    task = resolve_task(None, robot)
    found = climb_to_tolerant(robot, task, TolerantOptions(starts=4, show=1, limits=True))
    middle = (robot.lower + robot.upper) / 2
    assert found.free == (1, 7)
    assert found.places[0].q[[0, 6]] == pytest.approx(middle[[0, 6]], abs=1e-12)
    assert ((found.places[0].q >= robot.lower) & (found.places[0].q <= robot.upper)).all()
