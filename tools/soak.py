"""Memory over many calls in one process: explanations and analyses, each of another configuration or seed.

    .venv/bin/python tools/soak.py --explains 100000 --analyses 1000      # half an hour of CPU time
    .venv/bin/python tools/soak.py --explains 500 --analyses 10           # a try

At twenty points of each run the memory that the process holds is printed (resident set, Linux). Memory is flat where
the largest of the last quarter is at most --most MB above the largest of the second quarter; the first fills caches.
Exit code 1 where it is not.
"""

from __future__ import annotations

import argparse
import gc
import json
import resource
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from rankdrop import analyze, explain, open_robot

ARMS = ("planar2r", "planar3r")
POINTS = 20


def held() -> float:
    """Resident memory of this process [MB]."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * resource.getpagesize() / 2**20


def flat(memory: list[float], most: float) -> float:
    """By how much the last quarter lies above the second [MB].

    Raises:
        SystemExit: by more than `most`.
    """
    quarter = len(memory) // 4
    grown = max(memory[-quarter:]) - max(memory[quarter : 2 * quarter])
    if grown > most:
        print(f"memory grew by {grown:.1f} MB", file=sys.stderr)
        raise SystemExit(1)
    return grown


def soak(what: str, count: int, call: Callable[[int], object], most: float) -> None:
    """Call so many times, and tell memory at twenty points."""
    memory: list[float] = []
    begin = time.process_time()
    for i in range(count):
        call(i)
        if (i + 1) * POINTS // count > i * POINTS // count:
            gc.collect()
            memory.append(held())
            print(f"{what} {i + 1}: {memory[-1]:.1f} MB, {time.process_time() - begin:.0f} s of CPU time", flush=True)
    grown = flat(memory, most)
    told = {"what": what, "calls": count, "held_mb": [round(x, 1) for x in memory], "grown_mb": round(grown, 2)}
    print(json.dumps(told | {"cpu_s": round(time.process_time() - begin)}), flush=True)


def main(argv: list[str] | None = None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--explains", type=int, default=100_000, help="calls of explain; 0: none")
    parser.add_argument("--analyses", type=int, default=1_000, help="calls of analyze; 0: none")
    parser.add_argument("--most", type=float, default=1.0, help="growth that is still flat [MB]")
    given = parser.parse_args(argv)
    arms = [open_robot(name) for name in ARMS]
    rng = np.random.default_rng(0)

    def one_explanation(i: int) -> object:
        arm = arms[i % 50 == 0]  # one in fifty of the arm that has more to tell
        q = rng.uniform(-np.pi, np.pi, arm.n)
        if i % 3 == 0:
            q[1] = 0.0  # singular
        return str(explain(arm, q))

    def one_analysis(i: int) -> object:
        found = analyze(arms[i % 2], starts=40, seed=i)
        assert found.families
        return found.to_dict()

    for what, count, call in (("explain", given.explains, one_explanation), ("analyze", given.analyses, one_analysis)):
        if count:
            soak(what, count, call, given.most)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
