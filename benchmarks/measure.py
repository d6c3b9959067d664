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

from rankdrop.version import VERSION  # noqa: E402  # after the threads

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


def in_turns(repeats: int, first: Callable[[], object], second: Callable[[], object]) -> tuple[float, float]:
    """Shortest times [s] of both, one after the other each time, after one that is not counted."""
    first(), second()
    pairs = [(once(first)[0], once(second)[0]) for _ in range(repeats)]
    return min(pair[0] for pair in pairs), min(pair[1] for pair in pairs)


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


def chosen(arms: tuple[str, ...]) -> tuple[str, ...]:
    """Those of the arms that `--arms` names, all without it."""
    if "--arms" not in sys.argv[:-1]:
        return arms
    named = sys.argv[sys.argv.index("--arms") + 1].split(",")
    if unknown := [name for name in named if name not in arms]:
        raise SystemExit(f"--arms: {unknown[0]!r} is not one of {', '.join(arms)}")
    return tuple(named)


def collected(one: Callable[[int, int], Row | None], count: int, seed: int) -> tuple[list[Row], int]:
    """So many rows of one(number, seed), for numbers from 0, and how many numbers gave none."""
    rows: list[Row] = []
    number = 0
    while len(rows) < count:
        row = one(number, seed)
        number += 1
        if row is not None:
            rows.append(row)
            print(", ".join(f"{key} {text(value)}" for key, value in row.items()), file=sys.stderr, flush=True)
    return rows, number - len(rows)


def options(parser: argparse.ArgumentParser) -> None:
    """Give a parser the options of every script."""
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--quick", action="store_true", help="a small run: does the script still work?")


def report(
    claim: str, rows: list[Row], *, ratio: str, target: float, at_most: bool = False,
    missing: dict[str, str] | None = None, arguments: argparse.Namespace | None = None,
) -> None:
    """Print the rows as a table, or with `--json` as one object.

    Args:
        claim: one line.
        rows: one dictionary a case, the same keys in each.
        ratio: key of the number that is held against `target`.
        target: at least this, or at most with `at_most`. A row with `claimed` False is for information.
        at_most: the other way round.
        missing: libraries to compare with that are not installed, each with the command that installs it.
        arguments: of a script that has read its own; None: they are read here.
    """
    if arguments is None:
        parser = argparse.ArgumentParser(description=claim)
        options(parser)
        parser.add_argument("--arms", help="some of the arms, with commas; of scripts that go over arms one by one")
        arguments = parser.parse_args()
    for row in rows:
        if row.setdefault("claimed", True):
            row["holds"] = bool(row[ratio] <= target if at_most else row[ratio] >= target)
        else:
            row["holds"] = None
    if arguments.json:
        versions = {"rankdrop": VERSION, "numpy": version("numpy")}
        print(json.dumps({"claim": claim, "target": target, "machine": machine() | versions, "missing": missing or {},
                          "megabytes": peak_megabytes(), "rows": rows}, indent=1))  # fmt: skip
        return
    print(f"{claim}\n{processor()}, Python {platform.python_version()}, NumPy {version('numpy')}")
    print(table(rows))
    for name, command in (missing or {}).items():
        print(f"not compared with {name}: {command}")


def machine() -> Row:
    """What figures depend on, and nothing that names the machine."""
    return {
        "processor": processor(), "cores": os.cpu_count(), "system": platform.system(),
        "python": platform.python_version(),
    }  # fmt: skip


def peak_megabytes() -> float | None:
    """The most memory that this process ever held, 1e6 bytes; None where the system does not say."""
    try:
        import resource
    except ImportError:
        return None
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most / 1e6 if sys.platform == "darwin" else most * 1024 / 1e6


def keys_of(rows: list[Row]) -> list[str]:
    """The columns that are shown."""
    return [key for key in rows[0] if key not in ("claimed", "holds")]


def verdict(row: Row) -> str:
    """What the claim says of a row; nothing for one that is there for information."""
    return "" if row["holds"] is None else "holds" if row["holds"] else "DOES NOT HOLD"


def table(rows: list[Row]) -> str:
    """The rows in columns, with their verdicts."""
    keys = keys_of(rows)
    cells = [keys] + [[text(row[key]) for key in keys] for row in rows]
    widths = [max(len(line[column]) for line in cells) for column in range(len(keys))]
    lines = (
        "  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True)) + f" {said}".rstrip()
        for line, said in zip(cells, ["", *map(verdict, rows)], strict=True)
    )
    return "\n".join(lines)


def text(value: object) -> str:
    """A number with four digits."""
    return f"{value:.4g}" if isinstance(value, float) else str(value)
