"""The share of random structured arms whose exact conditions are derived to the end, and the reasons of the others.

    python -m benchmarks.structured                                  # 40 arms, 30 s of processor time each
    python -m benchmarks.structured --count 60 --seed 100 --cpu 30   # arms 100 to 159
    python -m benchmarks.structured --arms 3,17                      # some arms

Arms are those of `tests/reference/structured.py` (`fifteen`): 6R to 8R, some with a slide, twists in multiples of 15°,
lengths out of a few, and a task. Each is derived in a process of its own with a limit on the processor's time; the
children's memory and caches end with them. An arm is finished where the result is complete and nothing is left open;
`wrong` counts results that are complete and contradicted by the numeric search.
"""

from __future__ import annotations

import argparse
import multiprocessing
import re
import resource
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from reference.structured import fifteen

from rankdrop.verbs.conditions import conditions

POINTS = 200  # configurations found numerically, at each corank, that are tried on the families
GRACE = 2  # the system ends a child after so many times the limit


@dataclass(frozen=True)
class Outcome:
    """Result of one arm.

    Attributes:
        finished: complete, and nothing left open.
        wrong: complete, and contradicted by configurations found numerically.
        reasons: statements on the open part.
        cases: number of cases that were not taken apart.
        seconds: of the processor [s].
    """

    finished: bool
    wrong: bool
    reasons: tuple[str, ...]
    seconds: float
    cases: int = 0


def derive(seed: int, cpu: float, method: str) -> Outcome:
    """One arm, in this process."""
    begun = time.process_time()
    robot, task = fifteen(seed)
    try:
        found = conditions(robot, task, method=method, points=POINTS, special=False, seconds=cpu)
    except Exception as error:
        return Outcome(False, False, (f"{type(error).__name__}: {error}",), time.process_time() - begun)
    wrong = found.complete and (bool(found.disagreements) or not found.explained.holds)
    finished = found.complete and not wrong
    return Outcome(finished, wrong, found.left, time.process_time() - begun, len(found.undivided))


def _child(pipe: Connection, seed: int, cpu: float, method: str) -> None:
    most = int(GRACE * cpu) + 1
    resource.setrlimit(resource.RLIMIT_CPU, (most, most))
    pipe.send(derive(seed, cpu, method))


def outcome(seed: int, cpu: float, method: str) -> Outcome:
    """One arm, in a process of its own."""
    here, there = multiprocessing.Pipe(duplex=False)
    child = multiprocessing.get_context("fork").Process(target=_child, args=(there, seed, cpu, method))
    child.start()
    there.close()
    try:
        return here.recv()
    except EOFError:
        return Outcome(False, False, (f"ended by the system after {GRACE} times the limit",), GRACE * cpu)
    finally:
        child.join()


def kind(reason: str) -> str:
    """A reason without its numbers, for counting."""
    return re.sub(r"\d[\d,.]*", "#", reason)[:110]


def report(outcomes: Sequence[tuple[str, Outcome]]) -> list[str]:
    """The share that finished, in all and for each task, and the reasons of the others, frequent ones first."""
    lines = []
    for task in (*sorted({task for task, _ in outcomes}), "all"):
        here = [one for own, one in outcomes if task in (own, "all")]
        done, spent = sum(one.finished for one in here), sum(one.seconds for one in here)
        lines.append(f"{task:16} {done:4} of {len(here):3} finished, {done / len(here):4.0%}, {spent:6.0f} s")
    reasons = Counter(kind(reason) for _, one in outcomes for reason in one.reasons)
    return [*lines, *(f"{number:4}  {reason}" for reason, number in reasons.most_common())]


def main() -> int:
    """Print each arm and the shares; 1 where a complete result is contradicted."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0, help="number of the first arm")
    parser.add_argument("--cpu", type=float, default=30.0, help="limit for each arm [s of the processor]")
    parser.add_argument("--method", default="tree", help="as of the command conditions")
    parser.add_argument("--arms", help="numbers of arms, with commas, in place of --seed and --count")
    given = parser.parse_args()
    if given.arms is None:
        seeds = list(range(given.seed, given.seed + given.count))
    else:
        seeds = [int(one) for one in given.arms.split(",")]
    outcomes = []
    for seed in seeds:
        robot, task = fifteen(seed)
        one = outcome(seed, given.cpu, given.method)
        outcomes.append((task, one))
        if one.finished:
            verdict = "finished" + f", {one.cases} cases not taken apart" * bool(one.cases)
        elif one.wrong:
            verdict = "WRONG"
        else:
            verdict = "open: " + "; ".join(one.reasons)[:200]
        print(f"{seed:5} {robot.n}R {task:16} {one.seconds:6.1f} s  {verdict}", flush=True)
    print("\n".join(report(outcomes)))
    return int(any(one.wrong for _, one in outcomes))


if __name__ == "__main__":
    sys.exit(main())
