"""A full explanation of one configuration: verdict, family, lost motions, circuits, ways out, distance, proof."""

from __future__ import annotations

from functools import partial

import measure  # first: sets the number of threads
import numpy as np

from rankdrop.local.block import sample
from rankdrop.results.known import shipped
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.verbs.explain import explain

TARGET = 40.0  # [ms] of processor time


def main() -> None:
    """Median over configurations, half of them singular, of the least processor time of three calls."""
    count = 4 if measure.quick() else 20
    rows = []
    for name in ("puma560", "ur5", "pa10", "panda", "canadarm2", "gen3", "sawyer"):
        found = shipped(name)
        arm, task = found.robot, found.task
        regular = sample(arm, task, count, seed=1)
        singular = np.array([found.families[i % len(found.families)].witness for i in range(count)])

        both = _median(arm, task, regular), _median(arm, task, singular)
        rows.append({"arm": name, "regular ms": both[0], "singular ms": both[1], "of the target": max(both) / TARGET})
    measure.report(
        f"explain: median under {TARGET:g} ms of processor time from Python", rows, ratio="of the target", target=1.0,
        at_most=True,
    )  # fmt: skip


def _median(arm: Robot, task: Task, configurations: Array) -> float:
    """Median over the configurations of the least processor time of three calls [ms]."""
    times = [measure.least_cpu(3, partial(explain, arm, q, task)) for q in configurations]
    return 1e3 * float(np.median(times))


if __name__ == "__main__":
    main()
