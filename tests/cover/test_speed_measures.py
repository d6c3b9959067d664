"""Distances in which a speed is known."""

from __future__ import annotations

import numpy as np
import pytest
from cover.regions import family_of, region_of

import rankdrop
from rankdrop.cover.speed import SpeedRegion
from rankdrop.cover.speed_measures import at_values, residual
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task


@pytest.mark.parametrize("name", ["irb120", "ur5e", "kr6r900"])
def test_a_residual_in_metres_is_how_far_the_wrist_is_from_the_shoulder(name: str, rng) -> None:
    """From the tip: the last two axes meet so far behind it, which is on the last one; beside axis 1 by joint 1."""
    robot, family = open_robot(name), family_of(name, "k1.f1")
    found = residual(robot, family)
    assert found is not None
    assert found.unit == "m"
    q = rng.uniform(-np.pi, np.pi, (50, 6))
    q[:, 0] = 0.0
    last = robot.joints[-1]
    other = robot.joints[-2]
    behind = float((robot.home[:3, 3] - other.foot) @ last.axis)
    tip = rankdrop.pose(robot, q)
    wrist = tip[:, :3, 3] - behind * (tip[:, :3, :3] @ (robot.home[:3, :3].T @ last.axis))
    across = np.cross(robot.joints[0].axis, robot.joints[1].axis)
    assert found.at(q) == pytest.approx(np.abs((wrist - robot.joints[0].foot) @ across), abs=1e-9)


@pytest.mark.parametrize(("name", "number"), [("irb120", "k1.f1"), ("ur5e", "k1.f1"), ("iiwa7", "k1.f3")])
def test_no_point_of_a_box_is_farther_than_its_bound(name: str, number: str, rng) -> None:
    region, family = region_of(name), family_of(name, number)
    measure = residual(region.robot, family) or at_values(region.robot, family, region.around)
    half = rng.uniform(0.0, 0.3, (50, len(region.around)))
    centre = rng.uniform(-2.0, 2.0, half.shape)
    most = measure.most(centre, half)
    for _ in range(50):
        assert (measure.at(centre + rng.choice([-1.0, 0.3, 1.0], half.shape) * half) <= most).all()
    corner = measure.far_corner(centre, half)
    assert (np.abs(corner - centre) <= half + 1e-15).all()
    assert (measure.at(corner) > measure.at(centre)).mean() > 0.7
    none = np.zeros_like(half)
    assert measure.most(centre, none) == pytest.approx(measure.at(centre), rel=1e-8, abs=1e-9)


def test_values_beyond_the_limits_are_not_taken_and_several_conditions_have_no_measure() -> None:
    robot = open_robot("panda")
    around = np.radians([30.0, 100.0, 70.0, -140.0, 30.0, 80.0, 10.0])
    measure = at_values(robot, family_of("panda", "k1.f4"), around)
    assert measure.values[0] == pytest.approx(-0.467, abs=1e-3)  # not 153° − 360°, which is nearer
    mixed = family_of("panda", "k1.f1")
    assert at_values(robot, mixed, around) is None
    assert residual(robot, mixed) is None
    region = SpeedRegion(robot, resolve_task(None, robot), 0.25, around=around)
    assert region.distance_from(mixed) is None
