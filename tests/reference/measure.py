"""How far two arrays are apart, and derivatives by differences."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rankdrop.robot.model import Array


def relative(got: Array, want: Array) -> float:
    """Largest difference as a share of the largest entry wanted (at least 1); infinite when the shapes differ."""
    if np.shape(got) != np.shape(want):
        return float("inf")
    if not np.size(want):
        return 0.0
    return float(np.abs(got - want).max() / max(1.0, np.abs(want).max()))


def central_differences(function: Callable[[Array], Array], q: Array, h: float = 0.01) -> Array:
    """∂f/∂q_k in one more last axis, from the six-point rule: error h⁶/140 · f⁽⁷⁾, about 1e-14 for a sine."""
    columns = []
    for unit in np.eye(q.shape[-1]) * h:
        differences = [function(q + j * unit) - function(q - j * unit) for j in (1, 2, 3)]
        columns.append((45 * differences[0] - 9 * differences[1] + differences[2]) / (60 * h))
    return np.stack(columns, axis=-1)
