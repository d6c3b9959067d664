"""σ over a region: bounds that hold for every seed, tight where σ is known in closed form."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import rankdrop
from rankdrop.designs.postures import best_postures, slow_poses, targets_of
from rankdrop.designs.ranking import rank
from rankdrop.designs.region import RegionBounds, region_bounds
from rankdrop.designs.spec import spec_of
from rankdrop.errors import OptionError
from rankdrop.kinematics import pose
from rankdrop.problem import Problem
from rankdrop.robot.drawing import Drawing
from rankdrop.task import resolve_task

SEEDS = (5, 7, 11, 13)
LOW, HIGH = np.array([0.9, -0.2, 0.0]), np.array([1.1, 0.2, 0.0])


def two_links(forearm: float, scale: float) -> Problem:
    drawing = Drawing.of("planar2r")
    arm = drawing.robot({drawing.place("2.a", ""): forearm})
    return Problem(arm, resolve_task("planar-position", arm, length_scale=scale))


def sigma_of_two_links(forearm: float, scale: float, distance: np.ndarray) -> np.ndarray:
    """σ₂ of a planar arm with links 1 and b, the tip at a distance r: σ₁σ₂ = b |sin θ2|, σ₁² + σ₂² = r² + b²."""
    cosine = (distance**2 - 1.0 - forearm**2) / (2.0 * forearm)
    product, total = forearm * np.sqrt(1.0 - cosine**2), distance**2 + forearm**2
    return np.sqrt((total - np.sqrt(total**2 - 4.0 * product**2)) / 2.0) / scale


def bounds(problem: Problem, low: np.ndarray, high: np.ndarray, rpy: np.ndarray | None, seed: int,
           budget: int = 5000) -> RegionBounds:  # fmt: skip
    targets = targets_of(low, high, rpy, 10, seed)
    sigma, q, _ = best_postures(problem, targets, oriented=rpy is not None, starts=12, seed=seed)
    found = np.isfinite(sigma)
    return region_bounds(problem, low, high, rpy, (sigma[found], targets[found, :3, 3], q[found]), starts=12,
                         seed=seed, budget=budget)  # fmt: skip


@pytest.mark.parametrize("forearm", [0.6, 1.0])
def test_bounds_are_tight_on_two_links_and_hold_for_every_seed(forearm: float) -> None:
    scale = 1.6
    distance = np.linspace(0.9, np.hypot(1.1, 0.2), 20_001)  # of the box from the base
    least = float(sigma_of_two_links(forearm, scale, distance).min())
    for seed in SEEDS[:2]:
        found = bounds(two_links(forearm, scale), LOW, HIGH, None, seed)
        assert found.lower <= least <= found.upper
        assert found.upper - found.lower < 0.03 * least
        assert found.covered
        assert not found.spent
        assert found.lower <= found.sigma <= found.upper


def test_a_spent_budget_and_a_region_out_of_reach_leave_the_bounds_open() -> None:
    problem = two_links(0.6, 1.6)
    none = bounds(problem, LOW, HIGH, None, 5, budget=0)
    assert (none.lower, none.upper, none.spent) == (0.0, np.inf, True)
    few = bounds(problem, LOW, HIGH, None, 5, budget=8)
    assert few.lower < 0.25 < 0.31 < few.upper
    assert few.spent
    beyond = bounds(problem, np.array([1.4, -0.1, 0.0]), np.array([1.7, 0.1, 0.0]), None, 5)  # reach 1.6 m
    assert beyond.lower == 0.0
    assert not beyond.covered


SIX: dict[str, Any] = {
    "robot": "planar2r", "task": "planar-position",
    "parameters": {"forearm": {"sets": "2.a", "values": [0.9, 0.95, 1.0, 1.05, 1.1, 1.15]}},
    "region": {"lower": [0.9, -0.3, 0], "upper": [1.3, 0.3, 0], "points": 20},
}  # fmt: skip


@pytest.mark.by_hand
def test_no_seed_excludes_the_winner_of_another() -> None:
    kept, winners, whole = [], [], []
    for seed in SEEDS:
        found = rankdrop.sweep({**SIX, "seed": seed}, workers=1)
        kept.append(set(found.pareto))
        values = [value or 0.0 for value in found.values("sigma")]
        winners.append(int(np.argmax(values)))
        whole.append([(one["region"]["sigma_lower"], one["region"]["sigma_upper"]) for one in found.records])
        assert "with proven bounds; worse only if wholly below another" in str(found)
    for one in kept:
        assert set(winners) <= one
        assert len(one) < 6  # the bounds are narrow enough to exclude something
    low, high = np.array(whole).transpose(2, 0, 1)
    assert (low.max(axis=0) <= high.min(axis=0)).all()  # every two intervals of one arm have a value in common


def test_a_region_has_a_budget() -> None:
    assert spec_of(SIX).asks.region == {**SIX["region"], "rpy": None, "starts": 12, "budget": 5000, "speed": None}
    with pytest.raises(OptionError, match="budget"):
        spec_of({**SIX, "region": {**SIX["region"], "budget": -1}})
    assert rank([], {"sigma": "more"}).best == []


def test_share_of_a_region_in_which_the_tool_is_slow() -> None:
    """Two links at 1 rad/s each: slowest near the outer edge of the reach, where the elbow is nearly straight."""
    plain = Drawing.of("planar2r").nominal
    arm = replace(plain, joints=tuple(replace(joint, velocity=1.0) for joint in plain.joints))
    problem = Problem(arm, resolve_task("planar-position", arm))
    targets = targets_of(np.array([0.6, -0.3, 0.0]), np.array([1.9, 0.3, 0.0]), None, 200, 3)
    told = slow_poses(problem, targets, oriented=False, speed=0.5, starts=8, seed=1)
    assert told is not None
    there, slow, bound = told
    far = np.linalg.norm(targets[:, :2, 3], axis=1)
    first, forearm = 1.0, float(np.linalg.norm(pose(arm, np.zeros(2))[:2, 3])) - 1.0
    angle = np.arccos(np.clip((far**2 - first**2 - forearm**2) / (2 * first * forearm), -1.0, 1.0))
    elbow = np.stack([np.cos(angle), np.sin(angle)], 1) * forearm + np.array([first, 0.0])  # from the base, θ1 = 0
    fore = elbow - np.array([first, 0.0])
    area = np.abs(elbow[:, 0] * fore[:, 1] - elbow[:, 1] * fore[:, 0])
    # |q̇_i| ≤ 1: velocities of the tip fill a parallelogram, sides 2 a and 2 b, area/|a| and area/|b| away
    expected = area / np.maximum(np.linalg.norm(elbow, axis=1), np.linalg.norm(fore, axis=1)) < 0.5
    assert not bound
    assert there.sum() > 150
    assert 0 < slow.sum() < there.sum()
    assert (slow[there] == expected[there]).all()
    unlimited = Problem(plain, problem.task)
    if not any(joint.velocity for joint in plain.joints):
        assert slow_poses(unlimited, targets, oriented=False, speed=0.5, starts=2, seed=1) is None
