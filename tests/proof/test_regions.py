"""Boxes of a region, halved at the seam of a turn."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import flint
import numpy as np
import pytest

from rankdrop.proof import covers
from rankdrop.proof.regions import Cell

pytestmark = pytest.mark.usefixtures("precise")


def region_of(lower: tuple[float, ...], upper: tuple[float, ...], cell: Cell) -> Any:
    """The region that the checker makes of a box."""
    plan: Any = SimpleNamespace(variables=tuple(range(1, len(lower) + 1)), lower=lower, upper=upper)
    return covers.region_of(plan, len(lower), cell)


def test_boxes_of_a_whole_turn_overlap_at_its_seam():
    """2π of doubles is shorter than 2π: the first and the last box reach across the gap, and neighbours overlap."""
    lower = -np.pi - np.pi / 8
    upper = lower + 2 * np.pi
    true_turn = 2 * flint.arb.pi()
    first, last, second = (region_of((lower,), (upper,), Cell((index,), (3,))) for index in (0, 7, 1))

    def ends(region: Any) -> tuple[Any, Any]:
        return region.centre[0] - region.half[0], region.centre[0] + region.half[0]

    assert flint.arb(upper) - flint.arb(lower) < true_turn  # the gap that the seam closes
    assert ends(last)[1] > ends(first)[0] + true_turn
    assert ends(first)[1] > ends(second)[0]
