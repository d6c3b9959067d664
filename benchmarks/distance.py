"""Distances of many configurations, held against the search for the nearest singularity. CPU seconds of the process."""

from __future__ import annotations

import time

import measure  # first: sets the number of threads
import numpy as np

from rankdrop import Monitor
from rankdrop.distance.many_distances import distances
from rankdrop.local.block import sample
from rankdrop.local.nearest import nearest_singularity
from rankdrop.results.known import known_analysis
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

ARMS = ("ur5", "puma560", "pa10", "panda", "canadarm2", "gen3", "sawyer", "rizon4", "stanford", "xarm6")


def main() -> None:
    """Random configurations of ten arms: within 5 % in 95 %, never above by more than 20 %; and what a step says."""
    count, rows = (200 if measure.quick() else 10_000), []
    for name in measure.chosen(ARMS):
        arm = open_robot(name)
        task = resolve_task(None, arm)
        families = known_analysis(arm, task).families
        q = sample(arm, task, count, 77)
        begin = time.process_time()
        found = distances(families, arm, q, task)
        spent = time.process_time() - begin
        step = Monitor(arm, task, families).look(q).distance
        truth = np.array([nearest_singularity(arm, one, task).distance for one in q])
        ratio = found.nearest()[1] / truth
        rows.append({
            "arm": name, "ms each": 1e3 * spent / count, "within 5 %": float((np.abs(ratio - 1) < 0.05).mean()),
            "over 20 %": int((ratio > 1.2).sum()), "worst ratio": float(ratio.max()),
            "proven share": float(np.median(found.at_least / truth)),
            "step within 5 %": float((np.abs(step / truth - 1) < 0.05).mean()),
            "step over 20 %": int((step / truth > 1.2).sum()), "step worst": float((step / truth).max()),
        })  # fmt: skip
    measure.report(
        f"distance against the search, {count:,} configurations each: never above it by more than 20 %",
        rows, ratio="worst ratio", target=1.2, at_most=True,
    )  # fmt: skip


if __name__ == "__main__":
    main()
