"""Which values a fitted family takes: completed by symmetry, tested by the rank, covered by full products."""

from __future__ import annotations

from math import pi
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from families.planted import pinned, problem

from rankdrop.families.linear_conditions import Linear
from rankdrop.families.value_sets import boxes, grow, verify_values
from rankdrop.robot.open import open_robot


def linear(*covectors, robot="pa10") -> Linear:
    return Linear.of(open_robot(robot), covectors)


def test_symmetry_completes_a_family_from_one_combination():
    conditions = linear((0, 1, 0, 0, 0, 0, 0), (0, 0, 1, 0, 0, 0, 0))
    found = grow(
        [(0.0, pi / 2)], conditions, lambda batch: [abs(np.sin(a)) + abs(np.cos(b)) < 1e-9 for a, b in batch]
    )
    assert found == {(a, b) for a in (0.0, pi) for b in (pi / 2, -pi / 2)}


def test_rounding_makes_no_new_combinations():
    conditions = linear((0, 1, 0, 0, 0, 0, 0))
    found = grow([(1.0274947943129,)], conditions, lambda batch: [abs(np.sin(v) - 0.85604) < 1e-3 for (v,) in batch])
    assert len(found) == 2


def test_boxes_cover_by_full_products():
    square = {(a, b) for a in (0.0, pi) for b in (0.5, -0.5)}
    assert boxes(square) == [((0.0, pi), (0.5, -0.5))]
    corner = square | {(1.0, 0.5)}
    covered = {v for a, b in boxes(corner) for v in [(x, y) for x in a for y in b]}
    assert covered == corner
    assert boxes({(0.0, 1.0), (1.0, 0.0)}) == [((0.0,), (1.0,)), ((1.0,), (0.0,))]


@pytest.mark.slow
def test_combinations_of_many_values_are_tested_in_bounded_number() -> None:
    """Of an arm of thirty parallel joints every one of 2^29 combinations of 0 and π holds."""
    linear: Any = SimpleNamespace(
        neighbours=lambda values: [(*values[:i], np.pi - values[i], *values[i + 1 :]) for i in range(len(values))]
    )
    sizes: list[int] = []

    def holds(values: list[tuple[float, ...]]) -> list[bool]:
        sizes.append(len(values))
        return [True] * len(values)

    assert len(grow([(0.0,) * 29], linear, holds)) == sum(sizes) == 1024


def test_what_loses_more_everywhere_is_no_row_of_this_corank(rng) -> None:
    """PUMA, shoulder and elbow at once: every point is singular, and of corank 2; no family of corank 1."""
    values = [(pi / 2, float(np.arctan2(-0.4318, 0.0203)))]  # θ2; a3 s3 + d4 c3 = 0
    for corank, holds in ((1, False), (2, True)):
        at = problem("puma560", corank)
        assert verify_values(at, pinned(at, 1, 2), values, rng) == [holds]
