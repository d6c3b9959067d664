"""Zeros of a function along a segment, by samples: sign changes halved down, and minima of its size that reach zero."""

from __future__ import annotations

from collections.abc import Callable
from math import ceil

import numpy as np

from rankdrop.robot.model import Array

SAMPLES = 128
"""Points per turn at which a function is looked at along a segment."""
_HALVINGS = 60  # of an interval: to the last digit
Function = Callable[[Array], Array]  # shares of the way (N,) -> values (N,)


def zeros_between(value: Function, turns: float, tolerance: float) -> list[tuple[float, str]]:
    """Where a continuous function of the share 0 … 1 of a way is zero, and how it gets there.

    Args:
        value: of an array of shares.
        turns: how many turns all joints together make on the way; decides how many samples are taken.
        tolerance: values up to it are zero.

    Returns:
        (share, kind) each; kind is "crosses" (the sign changes), "touches", "starts on", "ends on", or "lies in" where
        every sample is zero. Two zeros between the same two samples are missed.

    Example:
        >>> zeros_between(lambda share: (share - 0.25) * (share - 0.75) ** 2, 1.0, 1e-9)
        [(0.25, 'crosses'), (0.75, 'touches')]
    """
    share = np.linspace(0.0, 1.0, SAMPLES * ceil(1 + turns) + 1)
    sample = value(share)
    if np.abs(sample).max() <= tolerance:
        return [(0.0, "lies in")]
    found = [(float(share[i]), _kind(sample, int(i))) for i in np.flatnonzero(np.abs(sample) <= tolerance)]
    for i in np.flatnonzero(sample[:-1] * sample[1:] < 0):
        if min(abs(sample[i]), abs(sample[i + 1])) > tolerance:
            found.append((_halved(value, float(share[i]), float(share[i + 1])), "crosses"))
    for k in _hollows(sample):
        lowest = _lowest(value, float(share[k - 1]), float(share[k + 1]))
        if abs(sample[k]) > tolerance >= abs(value(np.array([lowest]))[0]):
            found.append((lowest, "touches"))
    return sorted(found)


def _hollows(sample: Array) -> list[int]:
    """Samples of least size, of one sign with their neighbours, where the curve bends enough to reach zero between."""
    size = np.abs(sample)
    inner = size[1:-1]
    least = (inner <= size[:-2]) & (inner <= size[2:]) & (sample[:-2] * sample[2:] > 0)
    bend = np.abs(sample[:-2] - 2 * sample[1:-1] + sample[2:])  # f″h², and f ≤ f″h²/2 within h of a double zero
    return [int(k) + 1 for k in np.flatnonzero(least & (inner <= bend))]


def _kind(sample: Array, i: int) -> str:
    """What happens at a sample that is zero."""
    if i in (0, len(sample) - 1):
        return "starts on" if i == 0 else "ends on"
    return "crosses" if sample[i - 1] * sample[i + 1] < 0 else "touches"


def _halved(value: Function, low: float, high: float) -> float:
    """The zero between two points of opposite sign."""
    sign = value(np.array([low]))[0]
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        if value(np.array([middle]))[0] * sign > 0:
            low = middle
        else:
            high = middle
    return (low + high) / 2


def _lowest(value: Function, low: float, high: float) -> float:
    """Where the size is smallest between two points, by thirds."""
    for _ in range(_HALVINGS):
        left, right = low + (high - low) / 3, high - (high - low) / 3
        sizes = np.abs(value(np.array([left, right])))
        low, high = (low, right) if sizes[0] < sizes[1] else (left, high)
    return (low + high) / 2
