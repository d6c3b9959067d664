"""The outcome of one search as data: JSON (schema rankdrop/find/1), CSV, NumPy archive."""

from __future__ import annotations

import csv
import io
from typing import Any

import numpy as np

from rankdrop.families.search_record import History, Outcome, Search
from rankdrop.results.codec import Record, robot_to_dict
from rankdrop.units import heading
from rankdrop.version import VERSION

SCHEMA = "rankdrop/find/1"


def find_to_dict(found: Search) -> Record:
    """A search as plain data, starts that were not run left out: see docs/json.md and schema/find.schema.json."""
    return {
        **heading(SCHEMA),
        "robot": robot_to_dict(found.robot, found.task, found.rank + found.corank),
        "settings": {
            "corank": found.corank,
            "rank": found.rank,
            "method": found.method,
            "seed": found.seed,
            "starts": len(found.q),
            "limits": found.limits,
            "step": found.step,
            "tie": found.tie,
            "iterations": found.most,
            "length_scale": float(found.task.scale(found.robot)),
            "tolerances": found.tolerances.to_dict(),
            "version": VERSION,
        },
        **({} if found.stratum is None else {"strata": _strata(found)}),
        "counts": {outcome.name.lower(): found.count(outcome) for outcome in Outcome},
        "complete": found.complete,
        "configurations": [
            {
                "start": int(index) + 1,
                "outcome": Outcome(found.outcome[index]).name.lower(),
                "iterations": int(found.iterations[index]),
                "q": found.q[index].tolist(),
                "sigma": found.sigma[index].tolist(),
            }
            for index in _run(found)
        ],
    }


def _strata(found: Search) -> list[Record]:
    """How many configurations are from each stratum, and the largest σ_r/σ_1 of them."""
    ratio = found.sigma[:, found.rank] / found.sigma[:, 0]
    which = np.zeros(0, np.int32) if found.stratum is None else found.stratum
    rows = []
    for k, name in enumerate(found.strata):
        mine = which == k
        rows.append({"name": name, "count": int(mine.sum()), "residual": float(ratio[mine].max(initial=0.0))})
    return rows


def find_to_csv(found: Search) -> str:
    """One line per start: start, outcome, iterations, q1 … qn, sigma1 … ."""
    n, values = found.q.shape[1], found.sigma.shape[1]
    header = ["start", "outcome", "iterations", *_numbered("q", n), *_numbered("sigma", values)]
    lines = (
        [int(index) + 1, Outcome(found.outcome[index]).name.lower(), int(found.iterations[index]),
         *found.q[index].tolist(), *found.sigma[index].tolist()]
        for index in _run(found)
    )  # fmt: skip
    return _csv(header, lines)


def find_to_npz(found: Search) -> bytes:
    """A NumPy archive: q, sigma, outcome, iterations, and start, counted from 1."""
    index = _run(found)
    return _npz(
        q=found.q[index], sigma=found.sigma[index], outcome=found.outcome[index], iterations=found.iterations[index],
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


def _run(found: Search) -> np.ndarray[Any, np.dtype[np.intp]]:
    return np.flatnonzero(found.outcome != Outcome.NOT_RUN)


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
