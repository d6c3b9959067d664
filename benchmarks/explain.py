"""An explanation of one configuration: verdict and distances, and all of it (ways out, blame, proof) as data."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import measure  # first: sets the number of threads
import numpy as np

from rankdrop.configuration import Rank
from rankdrop.cover.ball import LARGEST, certified_radius
from rankdrop.local.block import sample
from rankdrop.local.nearest import nearest_singularity
from rankdrop.local.ways_out import escape
from rankdrop.results.known import shipped
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import EVALUATIONS
from rankdrop.verbs.explain import explain

TARGET = 5.0  # [ms] of processor time


def main() -> None:
    """Median over configurations, half of them singular, of the least processor time of three calls."""
    count = 4 if measure.quick() else 20
    rows = []
    for name in ("puma560", "ur5", "pa10", "panda", "canadarm2", "gen3", "sawyer"):
        found = shipped(name)
        arm, task = found.robot, found.task
        regular = sample(arm, task, count, seed=1)
        singular = np.array([found.families[i % len(found.families)].witness for i in range(count)])

        both = [_median(partial(_first, arm, task), q) for q in (regular, singular)]
        whole = [_median(partial(_whole, arm, task), q) for q in (regular, singular)]
        rows.append({
            "arm": name, "regular ms": both[0], "singular ms": both[1], "whole regular ms": whole[0],
            "whole singular ms": whole[1], **_parts(arm, task, regular), "of the target": max(both) / TARGET,
        })  # fmt: skip
    measure.report(
        f"explain: verdict and distances, median under {TARGET:g} ms of processor time from Python; whole: as data",
        rows, ratio="of the target", target=1.0, at_most=True,
    )  # fmt: skip


def _first(arm: Robot, task: Task, q: Array) -> tuple[str, Rank, float | None]:
    """The first answer; each part is computed when it is read."""
    found = explain(arm, q, task)
    return found.verdict, found.rank, found.distance


def _whole(arm: Robot, task: Task, q: Array) -> object:
    """Every part, as `--json` writes it."""
    return explain(arm, q, task).to_dict()


def _median(question: Callable[[Array], object], configurations: Array) -> float:
    """Median over the configurations of the least processor time of three calls [ms]."""
    times = [measure.least_cpu(3, partial(question, q)) for q in configurations]
    return 1e3 * float(np.median(times))


def _parts(arm: Robot, task: Task, configurations: Array) -> measure.Row:
    """What parts of it take at regular configurations, medians [ms]."""
    times = []
    for q in configurations:
        found = explain(arm, q, task)
        ball, away = found.far.certificate, found.far.nearest
        enough = np.inf if away is None else away.distance
        parts = (
            partial(nearest_singularity, arm, q, task),
            partial(escape, arm, q, task),
            partial(
                certified_radius, arm, q, task, at_most=min(LARGEST, enough * (1 + 1e-9)), enough=enough * (1 - 1e-4),
                evaluations=EVALUATIONS,
            ),
        )  # fmt: skip
        times.append([*(1e3 * measure.least_cpu(3, part) for part in parts), 0 if ball is None else ball.evaluations])
    names = ("nearest ms", "escape ms", "certificate ms", "enclosures")
    return dict(zip(names, np.median(times, axis=0).tolist(), strict=True))


if __name__ == "__main__":
    main()
