"""Each guard against a false row or a missing one, with a case in which nothing else would notice."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from families.planted import pinned, problem

from rankdrop.families import table as families_module
from rankdrop.families.descent import verify_points
from rankdrop.families.fit import linear_rows
from rankdrop.families.inspection import inspect
from rankdrop.families.row import membership, on_row
from rankdrop.families.searching import search, unseen
from rankdrop.local.block import singular_values
from rankdrop.problem import Problem
from rankdrop.robot.model import Joint, JointKind, Robot
from rankdrop.task import resolve_task
from rankdrop.units import in_units


def test_a_point_near_a_square_that_is_not_singular_to_rounding_is_not_on_the_row() -> None:
    """Stanford arm: σ ~ q3² near q3 = 0. 50 µm off, σ is small and far above rounding."""
    at = problem("stanford", 1)
    row = pinned(at, 2, values=(0.0,))
    q = np.array([[0.3, 1.0, 5e-5, 0.4, 1.1, 0.2]])
    sigma = singular_values(at.robot, q, at.task)[0, at.rank]
    assert 1e-9 < sigma < 5e-8
    assert not on_row(at, row, q).any()
    assert on_row(at, row, q * [1, 1, 0, 1, 1, 1]).all()


def test_a_point_on_two_rows_is_one_point(rng) -> None:
    """PA-10, corank 1: the elbow twice over. Counted twice, single points would look like pieces met twice."""
    at = problem("pa10", 1)
    inspection = inspect(at, verify_points(at, search(at.robot, 1, task=at.task, starts=60).converged))
    cover = membership(at, inspection.q)
    elbow, again = pinned(at, 3), pinned(at, 3)
    once = families_module._pieces(cover, [elbow], inspection)
    assert families_module._pieces(cover, [elbow, again], inspection) == once
    assert sum(once) == int((inspection.exact & cover(elbow)).sum())
    assert unseen([1, 1, 8]).estimate == pytest.approx(0.2)


def spot_arm() -> Robot:
    """Arm of Boston Dynamics' Spot: screws (v; ω) at q = 0 of `spot_arm.urdf` in the ROS package spot_description."""
    screws = [
        [0, 0, 0, 0, 0, 1], [0, -0.115, 0, -1, 0, 0], [0, 0.115, -0.3125, 1, 0, 0],
        [-0.0475, 0, -0.001, 0, 1, 0], [0, 0.0475, -0.69859, 1, 0, 0], [-0.0475, 0, -0.0085, 0, 1, 0],
    ]  # fmt: skip
    home = np.eye(4)
    home[:3, 3] = -0.0085, 0.77959, 0.0475
    joints = [Joint(f"j{i + 1}", JointKind.REVOLUTE, np.array(s, dtype=float)) for i, s in enumerate(screws)]
    return Robot("spot_arm", tuple(joints), home)


def test_values_of_a_square_that_round_to_pi_are_pi(rng) -> None:
    """Elbow and wrist of Spot's arm, where D vanishes too much: values are known to 2e-12, and π was two values."""
    robot = in_units(spot_arm())
    task = resolve_task(None, robot)
    at = Problem(robot, replace(task, length_scale=task.scale(robot)), 2)
    points = search(at.robot, 2, task=at.task, starts=400).converged
    rows = linear_rows(at, points[np.abs(np.cos(points[:, 1])) < 1e-6], rng)
    assert sorted(row.sets[2] for row in rows) == [(0.0,), (pi,)]
    assert all(singular_values(at.robot, row.sample(at, 1, rng)[0][0, :1], at.task)[0, 4] < 1e-9 for row in rows)


@pytest.mark.parametrize("step", [0.3, 6e-6])
def test_the_value_at_the_witness_is_among_those_that_are_listed(step: float) -> None:
    """Twelve of 20 values are listed, the smallest; a file with a witness at another one was refused as damaged."""
    at = problem("puma560", 1)
    q = np.zeros((20, 6))
    q[:, 4] = 0.2 + step * np.arange(20)
    for witness in q[:, 4]:
        values = families_module._values(at, q, 4, float(witness))
        assert min(abs(np.sin((value - witness) / 2)) for value in values) <= 0.5 * at.tolerances.value
        assert len(values) == (12 if step > 1e-5 else 1)
