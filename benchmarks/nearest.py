"""Nearest singular configuration from Python, one thread: processor time per question, multistart included."""

from __future__ import annotations

import measure  # first: it sets the number of threads
import numpy as np

from rankdrop.distance.distance import family_distances
from rankdrop.local.nearest import nearest_singularity
from rankdrop.robot.open import open_robot
from rankdrop.verbs.analyze import analyze

ARMS = ("pa10", "ur5", "puma560", "panda")
MORE = ("gen3", "canadarm2", "fetch8", "stanford")  # for information
QUESTIONS = 5 if measure.quick() else 100
REPEATS = 1 if measure.quick() else 5
TARGET = 1.0  # ms of processor time


def row(name: str, *, claimed: bool) -> measure.Row:
    robot = open_robot(name)
    q = np.random.default_rng(1).uniform(-np.pi, np.pi, (QUESTIONS, robot.n))
    times, walks = [], []
    for one in q:
        times.append(measure.least_cpu(REPEATS, lambda one=one: nearest_singularity(robot, one)) * 1e3)
        walks.append(measure.least_cpu(REPEATS, lambda one=one: nearest_singularity(robot, one, starts=128)) * 1e3)
    return {
        "question": f"nearest of {name}",
        "median ms": float(np.median(times)),
        "worst ms": max(times),
        "128 walks ms": float(np.median(walks)),
        "claimed": claimed,
    }


def families(name: str) -> measure.Row:
    robot = open_robot(name)
    found = analyze(robot, starts=100 if measure.quick() else 2000, seed=8, exact="off")
    rows = [family for family in found.families if family.corank == 1]
    q = np.random.default_rng(1).uniform(-np.pi, np.pi, (min(QUESTIONS, 20), robot.n))
    times = [
        measure.least_cpu(REPEATS, lambda one=one: family_distances(rows, robot, one, found.task)) * 1e3 for one in q
    ]
    return {
        "question": f"all {len(rows)} families of {name}",
        "median ms": float(np.median(times)),
        "worst ms": max(times),
        "128 walks ms": "",
        "claimed": False,
    }


def main() -> None:
    rows = [row(name, claimed=True) for name in ARMS] + [row(name, claimed=False) for name in MORE]
    rows += [families(name) for name in ("pa10", "canadarm2")]
    claim = f"nearest singularity with multistart, one thread: under {TARGET:g} ms of processor time at the median"
    measure.report(claim, rows, ratio="median ms", target=TARGET, at_most=True)


if __name__ == "__main__":
    main()
