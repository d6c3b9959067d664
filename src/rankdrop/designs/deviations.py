"""How far measures of two designs may be apart by chance: the standard deviation of their difference."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from rankdrop.robot import Array

Record = Mapping[str, Any]


def deviations(record: Record, measure: str) -> Array:
    """Vector z of a sampled measure: the error of the difference of two variants is |z − z'|; empty without samples."""
    if measure in ("near", "slow"):
        sampled = record.get(measure) or {}
        hits = np.frombuffer(bytes.fromhex(sampled.get("hits", "")), np.uint8)
        return _of_mean(np.unpackbits(hits)[: sampled.get("samples", 0)].astype(float))
    region = record.get("region") or {}
    if measure == "slow_poses":
        slow = region.get("slow") or {}
        hits = np.frombuffer(bytes.fromhex(slow.get("hits", "")), np.uint8)
        return _of_mean(np.unpackbits(hits)[: slow.get("poses", 0)].astype(float))
    each = region.get("each")
    if each is None or measure != "reached":
        return np.zeros(0)
    return _of_mean(np.array([value is not None for value in each], dtype=float))


def _of_mean(values: Array) -> Array:
    """Of the mean of samples."""
    if len(values):
        return np.asarray((values - values.mean()) / len(values))
    return values
