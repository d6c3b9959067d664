"""Lost directions of one configuration: in the task's frame, and in the sparsest of all frames of the chain."""

from __future__ import annotations

from functools import partial

import measure  # first: sets the number of threads
import numpy as np

from rankdrop.local.directions import lost_directions, lost_in_sparsest_frame
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import shipped
from rankdrop.robot.model import Array

OWN, SPARSEST = 0.5, {1: 8.0, 2: 8.0, 3: 15.0}  # targets [ms], the second by corank


def main() -> None:
    """Witnesses of all families of a corank; the mean time of a call, over its target."""
    repeats = 2 if measure.quick() else 20
    rows = []
    for name in ("pa10", "ur5", "canadarm2"):
        found = shipped(name)
        for corank, target in SPARSEST.items():
            points = [np.array(family.witness) for family in found.of_corank(corank)]

            alone = 1e3 * measure.best_of(repeats, partial(_own, found, corank, points)) / len(points)
            all_frames = 1e3 * measure.best_of(repeats, partial(_sparsest, found, corank, points)) / len(points)
            rows.append({
                "arm": name, "corank": corank, "own frame ms": alone, "sparsest frame ms": all_frames,
                "of the target": max(alone / OWN, all_frames / target),
            })  # fmt: skip
    measure.report(
        "lost directions: under 0.5 ms in the task's frame; under 8 ms in the sparsest one (15 ms at corank 3)",
        rows, ratio="of the target", target=1.0, at_most=True,
    )  # fmt: skip


def _own(found: Analysis, corank: int, points: list[Array]) -> None:
    for q in points:
        lost_directions(found.robot, q, found.task, corank)


def _sparsest(found: Analysis, corank: int, points: list[Array]) -> None:
    for q in points:
        lost_in_sparsest_frame(found.robot, q, found.task, corank)


if __name__ == "__main__":
    main()
