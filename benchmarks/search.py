"""Time per converged singular configuration of the PA-10: block-LM in the core against the same method in NumPy."""

from __future__ import annotations

import os

import measure  # first: sets the number of threads
import numpy as np
from reference import arms, newton

from rankdrop.families.search_record import Outcome
from rankdrop.families.searching import refine
from rankdrop.task import resolve_task


def main() -> None:
    """Both begin at the same uniform random starts and stop at σ ≤ 1e-13; the core on all cores, then on one."""
    many, few = (1_000, 100) if measure.quick() else (40_000, 4_000)
    robot = arms.pa10()
    task = resolve_task("pose", robot)
    starts = np.random.default_rng(0).uniform(-np.pi, np.pi, (many, 7))
    rows = []
    for corank in (1, 2, 3):
        numpy_time, other = measure.quickest(2, lambda k=corank: newton.refine(robot, starts[:few], task, 6 - k))
        theirs = numpy_time / int(other.converged.sum())
        for threads in (0, 1):
            core_time, core = measure.quickest(
                3, lambda k=corank, t=threads: refine(robot, starts, k, task=task, threads=t)
            )
            mine = core_time / core.count(Outcome.CONVERGED)
            rows.append({
                "corank": corank, "threads": threads or os.cpu_count(), "core us": 1e6 * mine, "NumPy us": 1e6 * theirs,
                "ratio": theirs / mine, "core converged": core.count(Outcome.CONVERGED) / many,
                "NumPy converged": float(other.converged.mean()), "core iterations": float(np.median(core.iterations)),
                "NumPy iterations": float(np.median(other.iterations)), "claimed": threads == 0,
            })  # fmt: skip
    measure.report(
        f"block-LM on the PA-10, {many} starts in the core, {few} of them in NumPy, time per converged start: at least "
        "50 times the same method in batched NumPy with all cores; one thread for information",
        rows, ratio="ratio", target=50.0,
    )  # fmt: skip


if __name__ == "__main__":
    main()
