"""An S-R-S arm with equal links, AM's excluded case d3 = d5: folded at the elbow it loses two freedoms at once."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from known.truths import PA10_TABLES, all_explained, all_sound
from rankdrop.robot.dh import from_dh
from rankdrop.verbs.analyze import analyze


@pytest.fixture(scope="module")
def analysis():
    q = pi / 2  # (a, alpha, d)
    rows = [(0, -q, 0), (0, q, 0), (0, -q, 0.4), (0, q, 0), (0, -q, 0.4), (0, q, 0), (0, 0, 0.1)]
    robot = from_dh([(*row, 0) for row in rows], convention="standard", name="srs")
    return analyze(robot, starts=1500, seed=2, exact="off")


def pinned(analysis, corank):
    return [
        {one.number: one.values for one in family.pinned} for family in analysis.families if family.corank == corank
    ]


@pytest.mark.slow
def test_folded_elbow_moves_from_corank_one_to_corank_two(analysis):
    assert {4: (0.0,)} in pinned(analysis, 1)
    assert any(row.keys() == {4} and np.allclose(row[4], pi) for row in pinned(analysis, 2))
    assert all_explained(analysis, at_least=1000)
    assert all_sound(analysis)


@pytest.mark.slow
def test_no_row_repeats_part_of_a_larger_row(analysis):
    # of AM's Table 4 only the half with θ4 = 0 is left, as θ4 = π alone is a row of its own
    found = pinned(analysis, 2)
    assert len(found) == 1 + len(PA10_TABLES[2])
    for row in found:
        if 4 in row and len(row) > 1:
            assert row[4] == (0.0,)


def test_dimension_holds_at_every_combination_of_values(analysis):
    assert sorted(family.dimension for family in analysis.families if family.corank == 2) == [3, 4, 4, 4, 6]
