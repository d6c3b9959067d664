"""The variants that no other one beats: for every better value of one measure something else is worse."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

BLOCK = 2000


def pareto(records: Sequence[Mapping[str, Any]], goals: Mapping[str, str]) -> list[int]:
    """Numbers of the variants that are not dominated, from 0.

    Args:
        records: of the variants. One with an error, or without one of the measures, is not among them.
        goals: measure -> "less" or "more".
    """
    if not goals:
        return []
    rows = []
    for number, record in enumerate(records):
        values = [record["measures"].get(name) for name in goals]
        if record.get("error") is None and all(value is not None for value in values):
            rows.append((number, values))
    if not rows:
        return []
    signs = np.array([1.0 if want == "less" else -1.0 for want in goals.values()])
    cost = np.array([values for _, values in rows], dtype=np.float64) * signs
    kept = np.ones(len(cost), dtype=np.bool_)
    for first in range(0, len(cost), BLOCK):
        block = cost[first : first + BLOCK]
        no_worse = np.ones((len(block), len(cost)), dtype=np.bool_)
        better = np.zeros_like(no_worse)
        for k in range(cost.shape[1]):
            no_worse &= cost[None, :, k] <= block[:, None, k]
            better |= cost[None, :, k] < block[:, None, k]
        kept[first : first + BLOCK] = ~(no_worse & better).any(axis=1)
    return [number for (number, _), stays in zip(rows, kept, strict=True) if stays]
