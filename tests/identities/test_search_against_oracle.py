"""The core's search finds what the NumPy oracle's search finds."""

from __future__ import annotations

import numpy as np
import pytest
from reference import arms, block, newton

from rankdrop.families.searching import Outcome, refine, search
from rankdrop.task import resolve_task
from rankdrop.tolerances import DEFAULT


@pytest.mark.slow_at("3")
@pytest.mark.parametrize("corank", [1, 2, 3])
def test_every_start_on_the_pa10_becomes_singular_in_both(corank: int, rng: np.random.Generator) -> None:
    robot = arms.pa10()
    task = resolve_task("pose", robot)
    starts = rng.uniform(-np.pi, np.pi, (200, 7))
    mine, theirs = refine(robot, starts, corank, task=task), newton.refine(robot, starts, task, 6 - corank)
    assert mine.count(Outcome.CONVERGED) >= 198
    assert theirs.converged.sum() >= 198
    sigma = block.singular_values(robot, mine.converged, task)
    assert sigma[:, 6 - corank].max() <= DEFAULT.singular
    assert np.median(sigma[:, 6 - corank]) < 1e-12


@pytest.mark.parametrize("starts", [0, 1, 17])
def test_any_number_of_starts(starts: int) -> None:
    if starts == 0:
        assert refine(arms.pa10(), np.zeros((0, 7)), 1).q.shape == (0, 7)
        return
    assert search(arms.pa10(), 1, starts=starts).q.shape == (starts, 7)


def test_corank_4_of_the_pa10_is_reported_as_missed_not_as_found() -> None:
    """Nothing of corank 4 exists (AM section 4); its smallest local minima are far from zero."""
    missed = search(arms.pa10(), 4, starts=300)
    assert missed.count(Outcome.CONVERGED) == 0
    assert missed.count(Outcome.NEAR_MISS) > 0
    assert missed.smallest_near_miss is not None
    assert missed.smallest_near_miss > 1e-3


@pytest.mark.slow
def test_corank_2_of_the_four_joint_arm_does_not_exist() -> None:
    """AM section 3.2: only corank 1. In metres the smallest local minimum of (σ2² + σ3²)/2 has σ2 = 0.7177, and that of
    σ2 itself is 0.70833."""
    robot = arms.almarkhi4()
    task = resolve_task("position", robot, length_scale=1.0)
    missed = search(robot, 2, task=task, starts=300)
    assert missed.count(Outcome.CONVERGED) == 0
    assert missed.sigma[missed.outcome == Outcome.NEAR_MISS, 1].min() == pytest.approx(0.7177, abs=1e-4)
    assert missed.smallest_near_miss == pytest.approx(0.70833, abs=1e-5)
    assert newton.search(robot, task, 1, starts=100).sigma[:, 1].min() == pytest.approx(0.7177, abs=1e-4)
