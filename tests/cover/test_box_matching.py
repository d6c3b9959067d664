"""Which boxes of a covering are one place."""

from __future__ import annotations

import numpy as np

from rankdrop.cover.box_matching import keys, touching_groups


def test_leaves_of_many_narrow_variables_are_told_apart():
    """Five variables of 15 bits: more than one number has."""
    cells = np.random.default_rng(0).integers((1 << 15) - 3, 1 << 15, (300, 5), dtype=np.int32)
    told = keys(cells, [1 << 15] * 5)
    assert told.shape == (300, 2)
    assert len(np.unique(told, axis=0)) == len(np.unique(cells, axis=0))


def test_boxes_that_touch_are_one_place_across_the_ends_of_a_turn() -> None:
    cells = np.array([[0, 3], [15, 4], [7, 7], [8, 8], [3, 15], [3, 0]], dtype=np.int32)
    groups = {tuple(sorted(rows.tolist())) for rows in touching_groups(cells, (16, 16), (True, False))}
    assert groups == {(0, 1), (2, 3), (4,), (5,)}
    groups = {tuple(sorted(rows.tolist())) for rows in touching_groups(cells, (16, 16), (True, True))}
    assert (4, 5) in groups
