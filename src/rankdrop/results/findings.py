"""The outcome of one search as data: JSON (schema rankdrop/find/1), CSV, NumPy archive."""

from __future__ import annotations

import csv
import io
from typing import Any

import numpy as np
from msgspec import UNSET, UnsetType

from rankdrop.codec import Record
from rankdrop.families.search_record import History, Outcome, Search


def configurations(search: Search) -> list[Record]:
    """The starts that were run, in order."""
    return [
        {"start": int(index) + 1, "outcome": Outcome(search.outcome[index]).name.lower(),
         "iterations": search.iterations[index], "q": search.q[index], "sigma": search.sigma[index]}
        for index in _run(search)
    ]  # fmt: skip


def strata(search: Search) -> list[Record] | UnsetType:
    """How many configurations are from each stratum, and the largest σ_r/σ_1 of them; only of method reciprocal."""
    if search.stratum is None:
        return UNSET
    ratio = search.sigma[:, search.rank] / search.sigma[:, 0]
    members = [search.stratum == k for k in range(len(search.strata))]
    return [
        {"name": name, "count": int(mine.sum()), "residual": float(ratio[mine].max(initial=0.0))}
        for name, mine in zip(search.strata, members, strict=True)
    ]


def find_to_csv(search: Search) -> str:
    """One line per start: start, outcome, iterations, q1 … qn, sigma1 … ."""
    n, values = search.q.shape[1], search.sigma.shape[1]
    header = ["start", "outcome", "iterations", *_numbered("q", n), *_numbered("sigma", values)]
    lines = (
        [int(index) + 1, Outcome(search.outcome[index]).name.lower(), int(search.iterations[index]),
         *search.q[index].tolist(), *search.sigma[index].tolist()]
        for index in _run(search)
    )  # fmt: skip
    return _csv(header, lines)


def find_to_npz(search: Search) -> bytes:
    """A NumPy archive: q, sigma, outcome, iterations, and start, counted from 1."""
    index = _run(search)
    return _npz(
        q=search.q[index],
        sigma=search.sigma[index],
        outcome=search.outcome[index],
        iterations=search.iterations[index],
        start=index + 1,
    )


def history_to_csv(history: History) -> str:
    """One line per start and iteration: start, iteration, turning, sigma1 … (AM Figures 1–3)."""
    starts, steps, values = history.sigma.shape
    lines = (
        [start + 1, step, "" if np.isnan(history.turning[start, step]) else float(history.turning[start, step]),
         *history.sigma[start, step].tolist()]
        for start in range(starts) for step in range(steps) if not np.isnan(history.sigma[start, step, 0])
    )  # fmt: skip
    return _csv(["start", "iteration", "turning", *_numbered("sigma", values)], lines)


def history_to_npz(history: History) -> bytes:
    """A NumPy archive: sigma (N, iterations + 1, values), turning (N, iterations + 1) [rad]; NaN after the end."""
    return _npz(sigma=history.sigma, turning=history.turning)


def _run(search: Search) -> np.ndarray[Any, np.dtype[np.intp]]:
    return np.flatnonzero(search.outcome != Outcome.NOT_RUN)


def _numbered(letter: str, count: int) -> list[str]:
    return [f"{letter}{number}" for number in range(1, count + 1)]


def _csv(header: list[str], lines: Any) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(lines)
    return text.getvalue()


def _npz(**arrays: Any) -> bytes:
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **arrays)
    return buffer.getvalue()
