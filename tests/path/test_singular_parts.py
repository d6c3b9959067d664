"""Where a checked path is singular or too near: cores, crossings in pairs, and crossings to the other side."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import rankdrop
from rankdrop.path.mend.joint_tool_path import tool_path
from rankdrop.path.mend.singular_parts import SingularParts
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot

CLEARANCE = np.radians(0.5)
ROWS = 301


def parts_of(bend: Array, times: Array | None = None, **options: float) -> SingularParts:
    """An arm of two links that turns while its elbow bends so."""
    q = np.stack([np.linspace(0.0, 1.0, len(bend)), bend], axis=1)
    check = rankdrop.check_path(open_robot("planar2r"), q, times, task="planar-position", **options)
    return SingularParts(check, tool_path(check.robot, check.task, check.curve))


def dip(depth: float, at: float = 0.5, width: float = 0.1) -> Array:
    """(ROWS,) an elbow that dips from 0.4 rad by a depth, in a window of the path."""
    share = np.linspace(0.0, 1.0, ROWS)
    return 0.4 - depth * np.exp(-(((share - at) / width) ** 2))


def bends(parts: SingularParts, *places: float) -> Array:
    return parts.configurations(np.array(places))[:, 1]


def test_a_dip_across_and_back_is_one_core_that_ends_where_the_elbow_is_clear() -> None:
    parts = parts_of(dip(0.45))
    (core,), single = parts.cores(CLEARANCE, 1.0)
    assert single == []
    assert core.crossed
    assert len(core.stretches) == 2
    inside = bends(parts, *np.linspace(core.low, core.high, 200))
    assert inside.min() < 0.0
    ends = bends(parts, core.low, core.high)
    assert (ends > CLEARANCE).all()
    assert (ends < 4.0 * CLEARANCE).all()
    middle = parts.spot(core)
    assert abs(bends(parts, middle[0] + middle[1])[0]) < 1e-6


def test_two_crossings_that_lie_deeper_than_allowed_are_no_pair() -> None:
    parts = parts_of(dip(0.45))
    cores, single = parts.cores(CLEARANCE, 0.01)
    assert cores == []
    assert [core.crossed for core in single] == [False, False]
    assert single[0].high < single[1].low


@pytest.mark.parametrize("order", [1, -1])
def test_of_three_crossings_the_shallowest_pair_is_lifted_and_one_leads_to_the_other_side(order: int) -> None:
    share = np.linspace(0.0, 1.0, ROWS)
    bend = 0.5 - 1.2 * share  # across at 0.42
    bend += 0.45 * np.exp(-(((share - 0.62) / 0.05) ** 2))  # back, and across again
    bend = bend[::order]
    parts = parts_of(bend)
    (core,), (other,) = parts.cores(CLEARANCE, 1.0)
    assert core.crossed
    crossings = np.flatnonzero(np.diff(np.sign(bend)) != 0)
    assert len(crossings) == 3
    depths = [np.abs(bend[first:last]).max() for first, last in pairwise(crossings)]
    k = int(np.argmin(depths))
    assert core.low < crossings[k] + 1 < crossings[k + 1] < core.high + 1
    left = crossings[2] if k == 0 else crossings[0]
    assert other.low < left + 1 < other.high + 1


def test_a_path_that_comes_too_near_is_lifted_where_a_distance_is_asked_for() -> None:
    parts = parts_of(dip(0.35), min_distance=0.1)
    (core,), single = parts.cores(0.1, 1.0)
    assert (single, core.crossed) == ([], False)
    assert core.low < 150 < core.high
    assert parts_of(dip(0.35)).cores(0.1, 1.0) == ([], [])


def test_parts_that_overlap_are_one() -> None:
    near = parts_of(np.minimum(dip(0.45, at=0.45, width=0.05), dip(0.45, at=0.55, width=0.05)))
    assert len(near.cores(CLEARANCE, 1.0)[0]) == 2
    (core,), _ = near.cores(0.35, 1.0)
    assert core.crossed
    assert len(core.stretches) == 4


@pytest.mark.parametrize("times", [None, np.linspace(0.0, 2.0, ROWS) ** 2])
def test_places_and_the_clock_are_inverse(times: Array | None, rng: np.random.Generator) -> None:
    parts = parts_of(dip(0.35), times)
    place = np.sort(rng.uniform(0.0, ROWS - 1.0, 50))
    np.testing.assert_allclose(parts.place_at(parts.time(place)), place, atol=1e-9)
    if times is not None:
        np.testing.assert_array_equal(parts.clock, times)


def test_places_are_spread_evenly_along_the_joint_path() -> None:
    bend = np.concatenate([np.linspace(1.0, 1.1, 200), np.linspace(1.1, 2.0, 20)])
    parts = parts_of(bend)
    place = parts.spread(10.0, 215.0, 40)
    np.testing.assert_allclose(place[[0, -1]], [10.0, 215.0])
    rows = parts.path.samples
    until = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(rows, axis=0), axis=1))])
    steps = np.diff(np.interp(place, np.arange(len(rows)), until))
    np.testing.assert_allclose(steps, steps.mean(), rtol=1e-6)


def test_a_deviation_counts_lengths_in_length_scales() -> None:
    parts = parts_of(dip(0.35))
    assert parts.size((parts.check.length_scale, 0.5)) == pytest.approx(1.5)
