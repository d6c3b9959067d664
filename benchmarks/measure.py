"""What the benchmark scripts share: one thread for NumPy's linear algebra, timing, and the printed and JSON output.

Import this first: the number of threads has to be set before NumPy is loaded.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

if "numpy" in sys.modules:
    raise ImportError("import measure before numpy: it sets the number of threads")
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))  # the NumPy oracle

Row = dict[str, Any]


def best_of(repeats: int, function: Callable[[], object]) -> float:
    """Shortest time of `repeats` calls, after one that is not counted [s]."""
    function()
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        function()
        times.append(time.perf_counter() - begin)
    return min(times)


def least_cpu(repeats: int, function: Callable[[], object]) -> float:
    """Least processor time of `repeats` calls, after one that is not counted [s]: what else runs does not count."""
    function()
    times = []
    for _ in range(repeats):
        begin = time.process_time()
        function()
        times.append(time.process_time() - begin)
    return min(times)


def once(function: Callable[[], Any]) -> tuple[float, Any]:
    """Time [s] and result of one call."""
    begin = time.perf_counter()
    result = function()
    return time.perf_counter() - begin, result


def quickest(repeats: int, function: Callable[[], Any]) -> tuple[float, Any]:
    """Shortest time [s] of `repeats` calls, and the result."""
    runs = [once(function) for _ in range(repeats)]
    return min(seconds for seconds, _ in runs), runs[0][1]


def processor() -> str:
    """The processor's name as the system gives it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def quick() -> bool:
    """Whether a small run was asked for (`--quick`: does the script still work?)."""
    return "--quick" in sys.argv


def report(claim: str, rows: list[Row], *, ratio: str, target: float, at_most: bool = False) -> None:
    """Print the rows as a table, or with `--json` as one object.

    Args:
        claim: one line.
        rows: one dictionary a case, the same keys in each.
        ratio: key of the number that is held against `target`.
        target: at least this, or at most with `at_most`. A row with `claimed` False is for information.
        at_most: the other way round.
    """
    parser = argparse.ArgumentParser(description=claim)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--quick", action="store_true", help="a small run: does the script still work?")
    arguments = parser.parse_args()
    for row in rows:
        if row.setdefault("claimed", True):
            row["holds"] = bool(row[ratio] <= target if at_most else row[ratio] >= target)
        else:
            row["holds"] = None
    if arguments.json:
        machine = {"processor": processor(), "cores": os.cpu_count(), "python": platform.python_version()}
        versions = {name: version(name) for name in ("rankdrop", "numpy")}
        print(json.dumps({"claim": claim, "target": target, "machine": machine | versions, "rows": rows}, indent=1))
        return
    print(f"{claim}\n{processor()}, Python {platform.python_version()}, NumPy {version('numpy')}")
    keys = [key for key in rows[0] if key not in ("claimed", "holds")]
    cells = [keys] + [[_text(row[key]) for key in keys] for row in rows]
    widths = [max(len(line[column]) for line in cells) for column in range(len(keys))]
    verdicts = [""] + ["" if row["holds"] is None else "holds" if row["holds"] else "DOES NOT HOLD" for row in rows]
    for line, verdict in zip(cells, verdicts, strict=True):
        print("  ".join(text.rjust(width) for text, width in zip(line, widths, strict=True)), verdict)


def _text(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
