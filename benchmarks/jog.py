"""Whether the advice of `explain` leaves singular configurations, followed literally: one jog or two, then regular.

Configurations of all coranks, inside the limits where such are met, of random arms of the catalogue. The advice counts
where the program's own verdict after it is regular at the speed, with every joint inside its limits (a joint that
begins beyond a limit goes no farther).

    python benchmarks/jog.py [--total 1000] [--count 60] [--seed 0] [--arms ur5e,crx10ia] [--speed 0.025] [--json]

Exit code 1 where the share is below 98 %.
"""

from __future__ import annotations

import argparse
import time
from math import ceil

import measure  # first: sets the number of threads
import numpy as np
from known.jogs import SPEED, fault, singular_configurations

from rankdrop.results.known import known_names
from rankdrop.robot.model import Array, Robot

SHARE = 0.98
"""At least so many configurations are left by the advice."""
_WORST = 10
"""Faults that are printed."""


def configurations(name: str, count: int, seed: int) -> list[tuple[Robot, Array]]:
    """At most so many singular configurations of an arm, spread over its families of all coranks."""
    drawn = list(singular_configurations(name, ceil(count / 2), seed, each=ceil(count / 4)))
    order = np.random.default_rng(seed).permutation(len(drawn))[:count]
    return [drawn[i] for i in order]


def judged(name: str, count: int, seed: int, speed: float) -> tuple[measure.Row, list[str]]:
    """The row of one arm, and a line for each configuration that the advice does not leave."""
    begun = time.process_time()
    every = configurations(name, count, seed)
    faults = [(q, fault(arm, q, speed)) for arm, q in every]
    wrong = [f"{name}: {why}; q = {np.round(q, 4).tolist()}" for q, why in faults if why]
    seconds = time.process_time() - begun
    share = 1.0 - len(wrong) / len(every) if every else 1.0
    return {"arm": name, "configurations": len(every), "share": share, "CPU s": seconds, "claimed": False}, wrong


def main() -> None:
    """Print the share of every arm and of all, and the worst cases."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--total", type=int, default=60 if measure.quick() else 1000, help="configurations (1000)")
    parser.add_argument("--count", type=int, default=6 if measure.quick() else 60, help="arms (60)")
    parser.add_argument("--seed", type=int, default=0, help="of arms and configurations (0)")
    parser.add_argument("--arms", default="", help="names, separated by commas, in place of random ones")
    parser.add_argument("--speed", type=float, default=SPEED, help="at which the verdict is regular [m/s] (0.025)")
    measure.options(parser)
    asked = parser.parse_args()
    names = known_names()
    picked = np.random.default_rng(asked.seed).permutation(len(names))[: asked.count]
    arms = asked.arms.split(",") if asked.arms else sorted(names[i] for i in picked)
    rows: list[measure.Row] = []
    wrong: list[str] = []
    for name in arms:
        row, lines = judged(name, ceil(asked.total / len(arms)), asked.seed, asked.speed)
        rows.append(row)
        wrong += lines
    tested = sum(row["configurations"] for row in rows)
    whole = {"arm": "all", "configurations": tested, "share": 1.0 - len(wrong) / tested,
             "CPU s": sum(row["CPU s"] for row in rows), "claimed": True}  # fmt: skip
    if not asked.json:
        print(*wrong[:_WORST], sep="\n")
    measure.report(
        f"{tested:,} singular configurations of {len(arms)} arms: regular at {1e3 * asked.speed:g} mm/s after one jog "
        "or two as advised", [*rows, whole], ratio="share", target=SHARE, arguments=asked,
    )  # fmt: skip
    raise SystemExit(whole["share"] < SHARE)


if __name__ == "__main__":
    main()
