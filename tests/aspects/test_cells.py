"""Cells of joint space that a sign cannot change in."""

from __future__ import annotations

import numpy as np

from rankdrop.aspects.cells import PartCount, clusters


def test_an_empty_set_makes_a_product_empty() -> None:
    empty, unclear = PartCount(0, 0, proven=True), PartCount(1, 3, proven=False)
    assert empty * unclear == PartCount(0, 0, proven=True)
    assert not (unclear * unclear).proven


def test_cells_at_the_two_ends_of_a_limited_joint_are_no_neighbours() -> None:
    mask = np.array([True, False, True])
    assert len(set(clusters(mask, (True,))[mask])) == 1
    assert len(set(clusters(mask, (False,))[mask])) == 2
