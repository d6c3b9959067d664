"""An arm of thirty joints: what cannot be fitted in bounded work is left unnamed, and `analyze` ends."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.families.library import MOST_SUPPORTS, circuits


@pytest.mark.slow
def test_sets_of_bound_joints_among_thirty_are_tried_in_bounded_number(monkeypatch: pytest.MonkeyPatch) -> None:
    """A family in general position of 30 joints and dimension 20: no set of fewer than 21 joints is bound."""
    basis = np.linalg.qr(np.random.default_rng(0).normal(size=(30, 20)))[0]
    calls = 0
    made = np.linalg.eigvalsh

    def counted(matrix: np.ndarray) -> np.ndarray:
        nonlocal calls
        calls += 1
        assert calls <= MOST_SUPPORTS + 1
        return made(matrix)

    monkeypatch.setattr(np.linalg, "eigvalsh", counted)
    assert circuits((basis @ basis.T)[None], tuple(range(30))) == []
