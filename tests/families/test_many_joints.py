"""An arm of thirty joints: what cannot be fitted in bounded work is left unnamed, and `analyze` ends."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from rankdrop.families.library import MOST_SUPPORTS, circuits
from rankdrop.families.row import grow


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
