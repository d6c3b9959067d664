"""Distances to the nearest singularity against closed forms, brute force, and the rate at which multistart fails."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from known.truths import DETERMINANTS, PA10_TABLES
from rankdrop.families.searching import search
from rankdrop.local.nearest import Nearest, nearest_singularity
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot


def off(angle: Array) -> Array:
    """Distance of angles from the nearest multiple of a turn."""
    return np.abs(np.asarray(angle) - 2 * pi * np.round(np.asarray(angle) / (2 * pi)))


def table_distance(q: Array, corank: int) -> float:
    """AM's tables: every row pins some joints, so its distance is that of the pinned joints to their nearest values."""
    rows = [
        np.linalg.norm([min(off(q[joint - 1] - value) for value in values) for joint, values in row.items()])
        for row in PA10_TABLES[corank]
    ]
    return float(min(rows))


def asked(robot: Robot, q: Array, **options: int) -> Nearest:
    found = nearest_singularity(robot, q, **options)
    assert found is not None
    return found


@pytest.mark.spread(1)
@pytest.mark.by_hand_at("2-60")
@pytest.mark.slow
@pytest.mark.parametrize(("corank", "count"), [(1, 250), (2, 60), (3, 40)])
def test_pa10_distances_are_those_of_the_tables(corank: int, count: int) -> None:
    robot = open_robot("pa10")
    for q in np.random.default_rng(17).uniform(-4, 4, (count, 7)):
        assert asked(robot, q, corank=corank).distance == pytest.approx(table_distance(q, corank), abs=1e-10)


@pytest.mark.parametrize("away", [1e-3, 1e-6, 1e-9])
def test_pa10_beside_each_row(away: float, rng: np.random.Generator) -> None:
    robot = open_robot("pa10")
    for row in PA10_TABLES[1]:
        for _ in range(4):
            q = rng.uniform(-pi, pi, 7)
            aside = rng.standard_normal(len(row))
            aside *= away / np.linalg.norm(aside)
            for (joint, values), one in zip(row.items(), aside, strict=True):
                q[joint - 1] = rng.choice(values) + one
            assert asked(robot, q).distance == pytest.approx(table_distance(q, 1), abs=1e-12)


def curve_distance(curve: Array, q2: float, q3: float) -> float:
    """Distance of (θ2, θ3) from a closed curve (2, N) that is sampled densely, to second order between the samples."""
    squared = off(curve[0] - q2) ** 2 + off(curve[1] - q3) ** 2
    near = int(np.nanargmin(squared))
    window = squared[np.arange(near - 1, near + 2) % len(squared)]
    low, middle, high = (value if np.isfinite(value) else np.inf for value in window)
    bend = low - 2 * middle + high
    lowest = middle - (high - low) ** 2 / (8 * bend) if np.isfinite(bend) and bend > 0 else middle
    return float(np.sqrt(max(lowest, 0.0)))


def shoulder_curves(a: float, b: float, c: float) -> list[Array]:
    """Zero set of a cos θ2 + b cos φ + c sin φ, φ = θ2 + θ3, as θ2 = ±arccos of a function of φ."""
    phi = np.linspace(-pi, pi, 400_000, endpoint=False)
    cosine = -(b * np.cos(phi) + c * np.sin(phi)) / a
    with np.errstate(invalid="ignore"):
        theta = np.arccos(cosine)
    return [np.stack([sign * theta, phi - sign * theta]) for sign in (1, -1)]


SHOULDERS = {  # Memon's and Jin's lectures: shoulder a, b, c; elbow at the multiples of π plus this; wrist sin θ5 = 0
    "puma560": ((0.4318, 0.0203, -0.4318), pi - np.arctan2(0.4318, 0.0203)),
    "anthropomorphic": ((0.5, 0.4, 0.0), 0.0),
}


@pytest.mark.parametrize("name", SHOULDERS)
def test_wrist_partitioned_arms_against_brute_force(name: str, rng: np.random.Generator) -> None:
    """Shoulder curve in the plane of θ2 and θ3 sampled at 800 000 points, elbow and wrist in closed form."""
    robot = open_robot(name)
    coefficients, elbow = SHOULDERS[name]
    curves = shoulder_curves(*coefficients)
    reached = {"shoulder": 0, "elbow": 0, "wrist": 0}
    for q in rng.uniform(-pi, pi, (40, 6)):
        distances = {
            "shoulder": min(curve_distance(curve, q[1], q[2]) for curve in curves),
            "elbow": min(off(q[2] - elbow), off(q[2] - elbow - pi)),
            "wrist": min(off(q[4]), off(q[4] - pi)),
        }
        nearest = min(distances, key=lambda key: distances[key])
        reached[nearest] += 1
        assert asked(robot, q).distance == pytest.approx(distances[nearest], abs=1e-7)
    assert min(reached.values()) > 3


@pytest.mark.spread(3)
@pytest.mark.slow
@pytest.mark.parametrize("name", ["ur5", "panda", "canadarm2", "puma560", "gen3"])
def test_no_singular_point_of_a_large_sample_is_nearer(name: str, rng: np.random.Generator) -> None:
    """20 000 singular configurations, as they are and as starts: none is nearer, nor leads to a nearer one."""
    robot = open_robot(name)
    cloud = search(robot, 1, starts=20_000, seed=21).converged
    assert len(cloud) > 15_000
    for q in rng.uniform(-pi, pi, (12, robot.n)):
        found = asked(robot, q)
        way = cloud - q
        way -= 2 * pi * np.round(way / (2 * pi))  # these arms turn without end
        distance = np.linalg.norm(way, axis=1)
        assert found.distance <= distance.min() * (1 + 1e-9)
        seeds = q + way[np.argsort(distance)[:100]]
        helped = nearest_singularity(robot, q, starts=1, seeds=seeds)
        assert helped is not None
        assert found.distance <= helped.distance + 1e-6


def test_ur5_pose_quoted_as_a_shoulder_singularity_is_none() -> None:
    """[0, −135, 45, 90, −90, 0]° is regular: the real shoulder singularity is 0.43 rad away, by joints 2, 3 and 4."""
    found = asked(open_robot("ur5"), np.radians([0.0, -135.0, 45.0, 90.0, -90.0, 0.0]))
    elbow, wrist, shoulder = (condition(np.array(found.q)) for condition in DETERMINANTS["ur5"])
    assert abs(shoulder) < 1e-12
    assert min(abs(elbow), abs(wrist)) > 0.5
    assert found.distance == pytest.approx(0.43025746, abs=1e-8)
    np.testing.assert_allclose(np.degrees(found.delta), [0, 22.8093, 8.8783, -2.9376, 0, 0], atol=1e-4)


ARMS = ("pa10", "ur5", "puma560", "panda", "canadarm2", "fetch", "gen3", "rcrrrr", "stanford", "fetch8", "irb140")


@pytest.mark.by_hand
@pytest.mark.parametrize("name", ARMS)
def test_multistart_misses_the_best_in_less_than_one_percent(name: str) -> None:
    """200 configurations each, against 3000 starts from another seed: `pytest -m slow tests/known/test_nearest.py`."""
    robot = open_robot(name)
    rng = np.random.default_rng(23)
    missed = 0
    for q in rng.uniform(-pi, pi, (200, robot.n)):
        reference = asked(robot, q, starts=3000, seed=99)
        missed += asked(robot, q).distance > reference.distance + 1e-6
    assert missed <= 1
