"""From which distance of a family a speed is kept: the proven bound, and the slower configuration below it."""

from __future__ import annotations

import numpy as np
import pytest
from cover.regions import region_of

from rankdrop.families.speed_distance import SpeedDistance
from rankdrop.results.known import shipped
from rankdrop.verbs.analyze import speed_distances

SPAN = np.radians(8.0)


@pytest.fixture(scope="module")
def wrist() -> SpeedDistance:
    """From the wrist singularity of an arm, θ5 = 0."""
    return region_of("irb120", span=SPAN).distance("k1.f7", 5, (0.0,))


def test_a_distance_names_its_family_and_its_joint(wrist: SpeedDistance) -> None:
    robot = region_of("irb120").robot
    assert (wrist.family, wrist.number, wrist.joint) == ("k1.f7", 5, robot.variables[4].name)
    assert (wrist.measure, wrist.unit, wrist.numbers, wrist.values) == ("joint", "rad", (), ())
    assert wrist.value == 0.0


def test_slower_configurations_are_nearer_than_the_distance_that_keeps_the_speed(wrist: SpeedDistance) -> None:
    assert wrist.slower_at is not None
    assert wrist.kept_from is not None
    assert 0.0 < wrist.slower_at <= wrist.kept_from <= wrist.end
    assert 0.0 < wrist.slower_speed < region_of("irb120").speed
    assert wrist.boxes > 0


def test_families_that_share_the_smallest_corank_have_a_distance_or_are_named() -> None:
    region = region_of("irb120", span=SPAN, budget=200)
    families = shipped("irb120").families
    seen: list[tuple[int, int]] = []
    result = speed_distances(region, families, lambda done, count: seen.append((done, count)))
    smallest = min(family.corank for family in families)
    ids = [family.id for family in families if family.corank == smallest]
    assert sorted([*(distance.family for distance in result.distances), *result.others]) == sorted(ids)
    assert seen == [(k, len(ids)) for k in range(len(ids))]
    assert (result.tool_speed, result.span, result.free) == (region.speed, SPAN, region.free)
    np.testing.assert_array_equal(result.around, region.around)


def test_several_joints_at_values_are_told_by_their_numbers() -> None:
    distances = speed_distances(region_of("irb120", span=SPAN, budget=200), shipped("irb120").families).distances
    assert distances
    for distance in distances:
        if distance.measure == "joints":
            assert len(distance.numbers) == len(distance.values) > 1
        else:
            assert distance.values == ()
        if distance.measure == "joint":
            assert (distance.numbers, distance.unit) == ((), "rad")
        else:
            assert distance.number in distance.numbers
        assert distance.kept_from is None or distance.kept_from <= distance.end
