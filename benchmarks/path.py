"""Paths: judged at every point, against dense sampling of σ on the same path. CPU seconds of the process."""

from __future__ import annotations

import time

import measure  # first: sets the number of threads
import numpy as np

from rankdrop.local.block import singular_values
from rankdrop.path.check.check import check_path
from rankdrop.results.known import known_analysis
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

RATE = 1e6  # of the dense samples [Hz]


def waves(rng: np.random.Generator, n: int, rows: int) -> Array:
    """Five waves in every joint."""
    t = np.linspace(0, 1, rows)[:, None]
    parts = (rng.normal(size=n) * np.sin(2 * np.pi * k * t + rng.uniform(0, 6, n)) / k for k in range(1, 6))
    return np.asarray(rng.uniform(-2, 2, n) + sum(parts))


def main() -> None:
    """A minute at 100 Hz, and 50,000 rows, of four arms."""
    quick = measure.quick()
    rng, rows = np.random.default_rng(1), []
    for name in ("ur5", "puma560", "pa10", "panda"):
        arm = open_robot(name)
        task = resolve_task(None, arm)
        known_analysis(arm, task)  # read once
        for count, seconds, target in ((6_000, 60.0, 1.0), (50_000, 60.0, 5.0)):
            q, t = waves(rng, arm.n, count), np.linspace(0, seconds, count)
            begin, wall = time.process_time(), time.perf_counter()
            found = check_path(arm, q, t)
            spent, wall = time.process_time() - begin, time.perf_counter() - wall
            some = 2_000 if quick else 200_000  # of the dense samples; the time of all is in proportion
            begin = time.process_time()
            singular_values(arm, found.curve.at(np.zeros(some, dtype=np.int64), np.linspace(0, 1, some)), task)
            dense = (time.process_time() - begin) * RATE * seconds / some
            rows.append({
                "arm": name, "rows": count, "CPU s": spent, "wall s": wall, "dense CPU s": dense,
                "enclosures": found.evaluations, "verdict": found.verdict, "undecided": found.undecided_share,
                "share of the target": spent / target,
            })  # fmt: skip
    measure.report(
        "a path of 60 s: 6,000 rows in under 1 s, 50,000 in under 5 s (CPU), beside samples of σ at 1 MHz",
        rows, ratio="share of the target", target=1.0, at_most=True,
    )  # fmt: skip


if __name__ == "__main__":
    main()
