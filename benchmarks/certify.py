"""Certified balls: what one enclosure costs, and how much of the distance to the nearest singularity is certified."""

from __future__ import annotations

import measure  # first: sets the number of threads
import numpy as np
from reference.near import cloud, nearest

from rankdrop.cover.ball import LARGEST, Certificate, certified_radius
from rankdrop.cover.setting import Setting, enclose, settings_for
from rankdrop.local.block import sample
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

BUDGETS = (0, 1_000, 5_000, 20_000)


def cost(robot: Robot, setting: Setting, batch: Array, half: Array | None) -> float:
    """Time of one enclosure in a batch, one thread [s]."""
    seconds = measure.best_of(5, lambda: enclose(robot, setting, batch, half, radius=LARGEST, threads=1))
    return seconds / len(batch)


def timed(robot: Robot, q: Array, budget: int) -> tuple[float, Certificate]:
    """One ball, the better of two calls."""
    return measure.quickest(2, lambda: certified_radius(robot, q, evaluations=budget))


def main() -> None:
    """Median ratio over random configurations; distances come from a local search, so ratios are lower bounds.

    The distance is the least over a cloud of singular configurations, each slid along the singular set towards q.
    """
    quick = measure.quick()
    rows = []
    for name in ("puma560", "ur5", "pa10", "panda"):
        robot = open_robot(name)
        task = resolve_task(None, robot)
        settings = settings_for(robot, task)
        setting = settings[len(settings) // 2]
        batch = sample(robot, task, 500 if quick else 20_000, 0)
        box, ball = cost(robot, setting, batch, np.full_like(batch, 0.05)), cost(robot, setting, batch, None)
        points = cloud(robot, task, sample(robot, task, 3_000 if quick else 60_000, 1))
        noise = np.random.default_rng(2)
        queries = sample(robot, task, 3 if quick else 50, 3)
        distance = []
        for q in queries:
            close = cloud(robot, task, q + noise.normal(size=(30 if quick else 300, robot.n)))
            distance.append(nearest(robot, task, q, np.concatenate([points, close]), setting.scale, setting.matters))
        for budget in BUDGETS[:2] if quick else BUDGETS:
            found = [timed(robot, q, budget) for q in queries]
            ratios = np.array([one.radius for _, one in found]) / distance
            rows.append({
                "arm": name, "budget": budget, "median ratio": float(np.median(ratios)), "least": float(ratios.min()),
                "most": float(ratios.max()), "ms": 1e3 * float(np.median([seconds for seconds, _ in found])),
                "us per box": 1e6 * box, "us per ball": 1e6 * ball, "claimed": budget == BUDGETS[-1],
            })  # fmt: skip
    measure.report(
        "certified radius / distance at random configurations: median at least 0.9 with 20 000 enclosures",
        rows, ratio="median ratio", target=0.9,
    )  # fmt: skip


if __name__ == "__main__":
    main()
