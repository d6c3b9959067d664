"""A step of a control loop from Python, and verdict, family, directions and distance of many configurations at once."""

from __future__ import annotations

import measure  # first: sets the number of threads
import numpy as np

from rankdrop import Monitor
from rankdrop.results.known import shipped

STEP, MANY = 10.0, 5.0  # targets [us]


def main() -> None:
    """Random configurations, every second one on a family; one thread. A ratio is the time over its target."""
    count = 2_000 if measure.quick() else 20_000
    rows = []
    for name in ("puma560", "pa10", "panda", "iiwa14", "canadarm2", "gen3", "sawyer", "rizon4"):
        found = shipped(name)
        monitor = Monitor(found.robot, found.task, found.families)
        q = np.random.default_rng(0).uniform(-3.0, 3.0, (count, found.robot.n))
        witnesses = np.array([family.witness for family in found.families])
        q[::2] = witnesses[np.arange(len(q[::2])) % len(witnesses)]
        if (monitor.look(q).family[::2] < 0).any():
            raise SystemExit(f"{name}: a witness was not attributed")
        single = list(q[:2_000])

        rates = np.random.default_rng(1).normal(size=found.robot.n)

        def step(monitor: Monitor = monitor, single: list[np.ndarray] = single, rates: np.ndarray = rates) -> None:
            for row in single:
                monitor.step(row, rates)

        def many(monitor: Monitor = monitor, q: np.ndarray = q) -> None:
            monitor.look(q, threads=1)

        alone = 1e6 * measure.least_cpu(9, step) / len(single)
        batched = 1e6 * measure.least_cpu(5, many) / len(q)
        rows.append({
            "arm": name, "joints": found.robot.n, "families": len(found.families), "step us": alone,
            "batched us": batched, "of the target": max(alone / STEP, batched / MANY),
        })  # fmt: skip
    measure.report(
        f"monitor: a step from Python under {STEP:g} us, batched under {MANY:g} us each on one thread (CPU)",
        rows, ratio="of the target", target=1.0, at_most=True,
    )  # fmt: skip


if __name__ == "__main__":
    main()
