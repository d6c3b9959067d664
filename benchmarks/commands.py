"""Whole commands as people type them, start of the interpreter included: wall time, processor time, memory."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import measure  # first: sets the number of threads

COMMANDS = {
    "--version": None,
    "robots --json -": None,
    "explain pa10 --q 0,0.5,0,0,0,1,0": 1.5,
    "nearest ur5 --q 0,-1,1,0.5,1,0": 1.5,
    "conditions panda": 1.5,
    "conditions puma560 --fresh": None,
    "jacobian puma560": None,
    "analyze ur5": 2.0,
    "analyze pa10 --fresh --starts 10000": 30.0,
    "analyze panda --fresh": None,
    "analyze gen3 --fresh": None,
    "analyze sawyer --fresh": None,
    "analyze canadarm2 --fresh": None,
}
"""What is typed, and the wall time that is claimed [s]; none: for information."""


def run(words: list[str], folder: Path) -> tuple[float, float, float]:
    """Wall and processor time [s] and peak memory [1e6 bytes] of one command with its children."""
    begin = time.perf_counter()
    with (folder / "out").open("wb") as out:
        child = subprocess.Popen([sys.executable, "-m", "rankdrop", *words], stdout=out, stderr=out, cwd=folder)
        _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode not in (0, 1, 3):
        raise SystemExit(f"rankdrop {' '.join(words)}: {(folder / 'out').read_text()[-400:]}")
    return time.perf_counter() - begin, used.ru_utime + used.ru_stime, used.ru_maxrss * 1024 / 1e6


def main() -> None:
    """Every command in a folder of its own; the least of three runs, of one where it takes long."""
    quick, rows = measure.quick(), []
    for line, target in list(COMMANDS.items())[: 4 if quick else None]:
        with tempfile.TemporaryDirectory() as folder:
            runs = [run(line.split(), Path(folder)) for _ in range(1 if quick or "--fresh" in line else 3)]
        wall, cpu, megabytes = (min(one) for one in zip(*runs, strict=True))
        rows.append({"rankdrop": line, "wall s": wall, "CPU s": cpu, "MB": megabytes,
                     "of the target": wall / target if target else "", "claimed": target is not None})  # fmt: skip
    measure.report("commands, start-up included: wall time within what is claimed", rows, ratio="of the target",
                   target=1.0, at_most=True)  # fmt: skip


if __name__ == "__main__":
    main()
