"""Which variants are better than others by more than the error of their samples.

Every variant is measured on the same random configurations and poses. So two variants are compared by paired
differences: of a mean over samples, error² = Σ (d − mean d)²/N² with d the difference at each sample; of a minimum
over poses, the jackknife. A measure that is not sampled has no error.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rankdrop.robot.model import Array

Record = Mapping[str, Any]
Rows = NDArray[np.intp]
BLOCK = 500
LEVEL = 0.05
"""Chance that any two equal variants of a sweep are called different."""


def bits_to_text(mask: NDArray[np.bool_]) -> str:
    """Samples as hexadecimal digits, a bit each, the first one highest."""
    return np.packbits(mask).tobytes().hex()


def deviations(record: Record, measure: str) -> Array:
    """Vector z of a sampled measure: the error of the difference of two variants is |z − z'|; empty without samples."""
    if measure == "near" and "hits" in (record.get("near") or {}):
        samples = record["near"]["samples"]
        hits = np.unpackbits(np.frombuffer(bytes.fromhex(record["near"]["hits"]), np.uint8))[:samples].astype(float)
        return np.asarray((hits - hits.mean()) / samples)
    each = (record.get("region") or {}).get("each")
    if each is None or measure not in ("sigma", "reached"):
        return np.zeros(0)
    values = np.array([np.nan if value is None else value for value in each])
    if measure == "reached":
        hits = np.isfinite(values).astype(float)
        return np.asarray((hits - hits.mean()) / len(hits))
    values = np.where(np.isfinite(values), values, np.inf)
    first, second = np.partition(values, 1)[:2] if len(values) > 1 else (values[0], values[0])
    without = np.full(len(values), first)  # the minimum without each pose in turn (jackknife)
    without[values.argmin()] = second if np.isfinite(second) else first
    return np.asarray(np.sqrt(1.0 - 1.0 / len(values)) * (without - without.mean()))


def threshold(variants: int, measures: int = 1) -> float:
    """Standard errors beyond which a difference counts, for all pairs of so many variants together (Bonferroni).

    Example:
        >>> round(threshold(2), 2), round(threshold(200), 2)
        (1.96, 4.71)
    """
    return NormalDist().inv_cdf(1.0 - LEVEL / (max(2, variants) * (max(2, variants) - 1) * max(1, measures)))


class Ranking(NamedTuple):
    """The best of a set of variants.

    Attributes:
        best: numbers, from 0, of the variants that no other one dominates.
        differ: whether some of the best differ from one another beyond the error.
    """

    best: list[int]
    differ: bool


def rank(records: Sequence[Record], goals: Mapping[str, str]) -> Ranking:
    """Compare variants pair by pair.

    A variant dominates another one where it is better beyond the error by one measure and worse beyond the error by
    none.

    Args:
        records: of the variants. One with an error, or without one of the measures, is not ranked.
        goals: measure -> "less" or "more".
    """
    numbers = [
        number for number, one in enumerate(records)
        if goals and one.get("error") is None and all(one["measures"].get(name) is not None for name in goals)
    ]  # fmt: skip
    ranked = [records[number] for number in numbers]
    spreads = {name: _stacked([deviations(one, name) for one in ranked]) for name in goals}
    beyond = threshold(len(ranked), sum(bool(spread.shape[1]) for spread in spreads.values()))

    def better(name: str, rows: Rows, columns: Rows) -> NDArray[np.bool_]:
        """(R, C) whether each of `rows` is better than each of `columns` by more than the error."""
        cost = np.array([one["measures"][name] for one in ranked]) * (1.0 if goals[name] == "less" else -1.0)
        return _smaller(cost, spreads[name], beyond, rows, columns)

    def dominated(rows: Rows) -> NDArray[np.bool_]:
        """(R,) whether some variant dominates each of `rows`."""
        worse = np.any([better(name, every, rows).T for name in goals], axis=0)
        return np.asarray((worse & ~np.any([better(name, rows, every) for name in goals], axis=0)).any(axis=1))

    every = np.arange(len(ranked))
    kept = np.array([i for rows in _blocks(every) for i in rows[~dominated(rows)]], dtype=np.intp)
    differ = any(better(name, rows, kept).any() for name in goals for rows in _blocks(kept))
    return Ranking([numbers[i] for i in kept], differ)


def _blocks(rows: Rows) -> Iterator[Rows]:
    return (rows[first : first + BLOCK] for first in range(0, len(rows), BLOCK))


def _smaller(cost: Array, spread: Array, beyond: float, rows: Rows, columns: Rows) -> NDArray[np.bool_]:
    """(R, C) whether each cost of `rows` is below each of `columns` by more than so many errors |z − z'|."""
    gap = cost[None, columns] - cost[rows, None]
    if not spread.shape[1]:
        return np.asarray(gap > 0.0)
    first, second = spread[rows], spread[columns]
    square = (first**2).sum(axis=1)[:, None] + (second**2).sum(axis=1)[None, :] - 2.0 * first @ second.T
    rounding = 1e-9 * np.maximum(np.abs(cost[rows, None]), np.abs(cost[None, columns]))
    return np.asarray(gap > np.maximum(beyond * np.sqrt(np.maximum(square, 0.0)), rounding))


def _stacked(rows: Sequence[Array]) -> Array:
    """(V, K) rows of one length, those without samples zero."""
    most = max((len(row) for row in rows), default=0)
    found = np.zeros((len(rows), most), dtype=np.float32 if most > 10_000 else np.float64)
    for row, values in zip(found, rows, strict=True):
        row[: len(values)] = values
    return found
