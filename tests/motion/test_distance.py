"""Distances from many configurations: on the families, and never at odds with `nearest_singularity`."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.local.block import generic_rank, joint_scale, sample, singular_values
from rankdrop.local.nearest import nearest_singularity
from rankdrop.motion.distance import distances
from rankdrop.results.known import known_analysis
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

ARMS = ("ur5", "puma560", "pa10", "panda", "canadarm2", "iiwa14", "sawyer", "m10ia", "stanford", "xarm6")


@pytest.mark.parametrize("name", ARMS)
def test_distances_agree_with_the_search(name: str) -> None:
    arm = open_robot(name)
    task = resolve_task(None, arm)
    q = sample(arm, task, 60, 31)
    far = distances(known_analysis(arm, task).families, arm, q, task).nearest()[1]
    ratio = far / [nearest_singularity(arm, one, task).distance for one in q]
    assert (np.abs(ratio - 1) < 0.05).mean() >= 0.95
    assert (ratio > 1.2).mean() <= 0.03  # none is the aim; Canadarm2, Sawyer, Gen3 and Rizon 4 miss it in 1 to 3 %


@pytest.mark.parametrize("name", ["ur5", "panda", "stanford", "gen3"])
def test_what_is_reached_is_singular_and_as_far_as_it_says(name: str) -> None:
    arm = open_robot(name)
    task = resolve_task(None, arm)
    families = known_analysis(arm, task).families
    q = sample(arm, task, 30, 32)
    found = distances(families, arm, q, task)
    rank, scale, seen = generic_rank(arm, task), joint_scale(arm, task), 0
    columns = [(found.foot[:, k], found.distance[:, k], one.corank) for k, one in enumerate(families)]
    for foot, distance, corank in [*columns, (found.anywhere_foot, found.anywhere, 1)]:
        there = np.isfinite(distance)
        if there.any():
            assert singular_values(arm, foot[there], task)[:, rank - corank].max() < 1e-6
            np.testing.assert_allclose(np.linalg.norm((foot - q) / scale, axis=1)[there], distance[there])
            seen += int(there.sum())
    assert seen >= 30


def test_within_the_limits_feet_are_inside() -> None:
    arm = open_robot("panda")
    task = resolve_task(None, arm)
    q = np.clip(sample(arm, task, 20, 33), arm.lower, arm.upper)
    found = distances(known_analysis(arm, task).families, arm, q, task, limits=True)
    feet = found.foot[np.isfinite(found.distance)]
    assert len(feet) > 20
    assert ((feet >= arm.lower - 1e-8) & (feet <= arm.upper + 1e-8)).all()
    free = distances(known_analysis(arm, task).families, arm, q, task)
    assert (found.nearest()[1] >= 0.99 * free.nearest()[1]).all()
