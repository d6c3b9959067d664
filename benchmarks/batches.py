"""Batches: results into memory that is there against fresh memory; two threads against one where little is to do."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import measure  # first: sets the number of threads
import numpy as np
from reference import arms

from rankdrop import _core
from rankdrop.kinematics import chain_of, task_view
from rankdrop.task import resolve_task

ENTRY = {"jacobian": (6, 7), "derivative": (6, 7, 7)}


def alternately(repeats: int, first: Callable[[], object], second: Callable[[], object]) -> measure.Row:
    """Shortest times of both and their ratio."""
    slow, fast = measure.in_turns(repeats, first, second)
    return {"first us": 1e6 * slow, "second us": 1e6 * fast, "ratio": slow / fast}


def memory(name: str, told: tuple[Any, Any], q: np.ndarray, repeats: int) -> measure.Row:
    """Fresh results, the last two of which are kept, as a program does that uses them; then the same array again."""
    function, out, kept = getattr(_core, name), np.zeros((len(q), *ENTRY[name])), [None, None]

    def fresh() -> None:
        kept[0], kept[1] = kept[1], function(*told, q, threads=1)

    found = alternately(repeats, fresh, lambda: function(*told, q, out, threads=1))
    return {"what": f"{name}, {len(q)} rows: fresh / out="} | found


def threads(name: str, told: tuple[Any, Any], q: np.ndarray, repeats: int) -> measure.Row:
    """A batch that is hardly worth a second thread."""
    function = getattr(_core, name)
    found = alternately(repeats, lambda: function(*told, q, threads=1), lambda: function(*told, q, threads=2))
    return {"what": f"{name}, {len(q)} rows: one thread / two", "claimed": False} | found


def main() -> None:
    """PA-10, pose task."""
    robot = arms.pa10()
    told = chain_of(robot), task_view(robot, resolve_task("pose", robot))
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (200_000, 7))
    quick = measure.quick()
    rows = [
        memory(name, told, q[:size], 5 if quick else 2_000_000 // size)
        for name in ENTRY for size in ([2_000] if quick else [2_000, 200_000])
    ]  # fmt: skip
    rows += [threads(name, told, q[:257], 20 if quick else 2_000) for name in ENTRY]
    measure.report("results into memory that is there: faster than fresh memory", rows, ratio="ratio", target=1.0)


if __name__ == "__main__":
    main()
