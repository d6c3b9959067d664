"""The track of a trajectory in its tab."""

from __future__ import annotations

import numpy as np

from rankdrop.viewer.tab_path import plotted_rows


def test_a_thinned_track_keeps_a_dip_of_one_row() -> None:
    sigma = np.ones(100_000)
    sigma[54_321] = 0.0
    keep = plotted_rows(sigma)
    assert 54_321 in keep
    assert len(keep) <= 602
    assert (np.diff(keep) > 0).all()
