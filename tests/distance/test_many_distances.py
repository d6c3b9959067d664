"""Distances from many configurations: on the families, and never at odds with `nearest_singularity`."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.distance.many_distances import Ruler, distances
from rankdrop.formula.equation import System
from rankdrop.local.block import generic_rank, joint_scale, sample, singular_values
from rankdrop.local.nearest import nearest_singularity
from rankdrop.results.known import known_analysis
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.units import in_metres, task_in_metres

ARMS = ("ur5", "puma560", "pa10", "panda", "canadarm2", "gen3", "sawyer", "rizon4", "stanford", "xarm6")


def compared(name: str, count: int, seed: int) -> np.ndarray:
    """Ratios of distance to what the search finds; the bound from below is held on the way."""
    arm = open_robot(name)
    task = resolve_task(None, arm)
    q = sample(arm, task, count, seed)
    found = distances(known_analysis(arm, task).families, arm, q, task)
    far = found.nearest()[1]
    searched = np.array([nearest_singularity(arm, one, task).distance for one in q])
    assert (found.at_least <= np.minimum(far, searched)).all()
    assert found.at_least.min() > 0.0
    return far / searched


@pytest.mark.spread(2)
@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_distances_agree_with_the_search(name: str) -> None:
    ratio = compared(name, 60, 31)
    assert (np.abs(ratio - 1) < 0.05).mean() >= 0.95
    assert ratio.max() < 1.2


@pytest.mark.by_hand
@pytest.mark.by_hand_at("puma560", "pa10", "panda", "canadarm2", "gen3", "sawyer", "rizon4", "stanford", "xarm6")
@pytest.mark.parametrize("name", ARMS)
def test_distances_agree_with_the_search_a_thousand_times(name: str) -> None:
    ratio = compared(name, 1000, 41)
    assert (np.abs(ratio - 1) < 0.05).mean() >= 0.95
    assert ratio.max() < 1.2


def test_where_a_family_is_near_by_another_way_it_is_credited() -> None:
    arm = open_robot("gen3")  # its family of corank 1 has too many terms to be walked on by itself
    task = resolve_task(None, arm)
    families = known_analysis(arm, task).families
    found = distances(families, arm, sample(arm, task, 20, 34), task)
    first = [k for k, one in enumerate(families) if one.corank == 1]
    assert (found.nearest()[0] == first[0]).mean() >= 0.9


def test_along_a_path_the_feet_of_neighbours_are_tried() -> None:
    arm = in_metres(open_robot("gen3"))
    task = task_in_metres(resolve_task(None, arm), arm)
    ruler = Ruler(known_analysis(arm, task).families, arm, task, starts=(0, 0))
    ends = sample(arm, task, 2, 35)
    q = ends[0] + np.linspace(0, 1, 60)[:, None] * (ends[1] - ends[0])
    alone, along = ruler.measure(q).nearest()[1], ruler.measure(q, along=True).nearest()[1]
    assert (along <= alone + 1e-12).all()
    assert (along < 0.99 * alone).sum() >= 3


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


def test_of_no_configurations_there_are_no_distances():
    arm = open_robot("ur5")
    task = resolve_task(None, arm)
    families = known_analysis(arm, task).families
    found = distances(families, arm, np.zeros((0, 6)), task)
    assert found.distance.shape == (0, len(families))
    assert found.foot.shape == (0, len(families), 6)


def test_equations_with_double_zeros_do_not_lead_walks_astray() -> None:
    """Points a twentieth of a radian from points of a family of a UR5, one equation of which has double zeros."""
    arm = open_robot("ur5")
    task = resolve_task(None, arm)
    (family,) = (one for one in known_analysis(arm, task).families if one.id == "k2.f2")
    rng = np.random.default_rng(0)
    starts = rng.uniform(-np.pi, np.pi, (400, 6))
    there, _ = System(family.equations[:3]).solve(starts)
    there = there[np.abs(family.system.values(there)).max(axis=1) < 1e-9][:100]
    assert len(there) == 100
    off = rng.standard_normal(there.shape)
    off *= 0.05 / np.linalg.norm(off, axis=1, keepdims=True)
    far = distances([family], arm, there + off, task).distance[:, 0]
    assert (far <= 0.05 + 1e-6).all()


@pytest.mark.by_hand
def test_folds_of_a_family_are_reached() -> None:
    """Where θ4 = π two conditions of a UR5's family have one tangent plane, and other zeros nearby."""
    arm = open_robot("ur5")
    task = resolve_task(None, arm)
    (family,) = (one for one in known_analysis(arm, task).families if one.id == "k2.f2")
    rng = np.random.default_rng(0)
    starts = rng.uniform(-np.pi, np.pi, (2000, 6))
    starts[:, 2] = 0.0
    there, _ = family.system.solve(starts, iterations=40)
    there = there[(np.abs(family.system.values(there)).max(axis=1) < 1e-10) & (np.abs(np.sin(there[:, 3])) < 1e-3)]
    assert len(there) > 20
    off = rng.standard_normal(there.shape)
    off *= 0.02 / np.linalg.norm(off, axis=1, keepdims=True)
    far = distances([family], arm, there + off, task).distance[:, 0]
    assert (far <= 0.02 + 1e-5).all()
