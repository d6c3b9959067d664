"""Paths of the UR5 whose elbow and wrist are zero where the rows say it: all of it is told, once, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.local.block import singular_values
from rankdrop.path.check.check import check_path
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot

ELBOW, WRIST = 2, 4  # det J = sin θ3 · sin θ5 · (the shoulder)
VALUES = (-0.5, -0.25, 0.0, 0.0, 0.25, 0.5)


def rows_with_zeros(seed: int) -> Array:
    """(N, 6): elbow and wrist out of `VALUES`, the shoulder away from zero; some rest at their first row."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 6))
    q = rng.uniform(-0.15, 0.15, (count, 6)) + np.array([0.35, -1.0, 0.0, 0.68, 0.0, 0.9])
    q[:, ELBOW] = rng.choice(VALUES, count)
    q[:, WRIST] = rng.choice(VALUES, count)
    if rng.integers(3) == 0 and count > 2:
        q[1] = q[0]
    return q


def shoulder_is_singular(q: Array) -> bool:
    """Whether σ6 is small anywhere once elbow and wrist are moved off zero."""
    places = np.linspace(0.0, len(q) - 1.0, 50 * len(q))
    k = np.minimum(places.astype(int), len(q) - 2)
    there = q[k] + (q[k + 1] - q[k]) * (places - k)[:, None]
    there[:, [ELBOW, WRIST]] = 0.5
    return bool(singular_values(open_robot("ur5"), there, "pose")[:, -1].min() < 0.02)


def zeros_of(q: Array) -> tuple[set[float], list[tuple[int, int]]]:
    """Isolated zeros, and stretches between rows along which one of the two is zero all the time."""
    zeros: set[float] = set()
    stretches = []
    for k in range(len(q) - 1):
        for joint in (ELBOW, WRIST):
            start, end = q[k, joint], q[k + 1, joint]
            if start == end == 0.0 and np.any(q[k] != q[k + 1]):
                stretches.append((k, k + 1))
            elif start * end < 0.0:
                zeros.add(round(k + start / (start - end), 6))
            else:
                zeros.update(float(row) for row, value in ((k, start), (k + 1, end)) if value == 0.0)
    isolated = {zero for zero in zeros if not any(low <= zero <= high for low, high in stretches)}
    return isolated, stretches


@pytest.mark.parametrize("seed", [*range(3), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(3, 24))])
def test_zeros_and_stretches_are_told_once(seed: int) -> None:
    q = rows_with_zeros(seed)
    if shoulder_is_singular(q):
        pytest.skip("the shoulder is singular as well")
    isolated, stretches = zeros_of(q)
    parts = check_path(open_robot("ur5"), q).crossings
    brackets = [[place.row - 1 + place.share for place in part.bracket] for part in parts]
    for zero in isolated:
        assert sum(low - 1e-4 <= zero <= high + 1e-4 for low, high in brackets) == 1, zero
    for low, high in stretches:
        assert any(start <= low + 1e-6 and high - 1e-6 <= end for start, end in brackets)
    for part, (start, end) in zip(parts, brackets, strict=True):
        if part.lies:
            assert not q[[round(start), round(end)]][:, [ELBOW, WRIST]].all(axis=1).any()
        else:
            assert any(start - 1e-4 <= zero <= end + 1e-4 for zero in isolated)
