"""Record what every command prints and writes, for every arm of the catalogue: ground to change code on.

    .venv/bin/python tools/record_outputs.py before                      # every arm, two processes
    .venv/bin/python tools/record_outputs.py before --arms pa10 ur5e     # these
    .venv/bin/python tools/record_outputs.py before --arms few           # the few of tests/known/arms.py
    .venv/bin/python tools/compare_outputs.py before after

A folder for each arm, in it for each command a text (command line, stdout, stderr, exit code) and the files that it
wrote. `_all` holds what is of no arm. Shipped analyses and conditions are used as a user's commands use them; searches
are short and seeded. Times are taken out, nothing else is: two records of the same code are equal byte by byte.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import re
import shlex
import sys
import tempfile
from collections.abc import Iterator
from multiprocessing import Pool
from pathlib import Path
from time import process_time

import numpy as np

from rankdrop.cli.main import run
from rankdrop.disk import replace_file
from rankdrop.results.known import shipped
from rankdrop.robot.open import open_robot, robot_names

FEW = ("planar3r", "scara", "stanford", "puma560", "ur5e", "iiwa14", "canadarm2", "fetch8")
"""These are asked more: derivations from nothing, other tasks, methods and options."""
ALL = "_all"
COMMANDS = ("analyze", "conditions", "escape", "explain", "find", "nearest", "report", "robots", "view")
_STARTS = 300
_NEAR = 0.01  # rad, m; from a singular configuration
_TIMES = ((re.compile(r"Time\s+taken:\s+[\d.,]+\s+s\b"), "Time taken: (some) s"),)
_SECONDS = {"seconds", "cpu_seconds", "time_taken"}

Line = tuple[str, str, tuple[str, ...]]
"""Label, command line, files that it writes."""


def lines_of(name: str) -> Iterator[Line]:
    """The command lines for one arm of the catalogue."""
    yield "analyze", f"analyze {name} --starts {_STARTS} --threads 1 --quiet --json analyze.json", ("analyze.json",)
    written = {"--json": "conditions.json", "--latex": "conditions.tex", "--python": "conditions.py",
               "--c": "conditions.h"}  # fmt: skip
    options = " ".join(f"{option} {file}" for option, file in written.items())
    yield "conditions", f"conditions {name} --quiet {options}", tuple(written.values())
    yield "find", f"find {name} --corank 1 --starts 50 --threads 1 --quiet --json find.json", ("find.json",)
    yield "report", f"report {name} --quiet --out report.html", ("report.html",)
    for label, q in configurations(name):
        for command, more in (("explain", "--evaluations 500"), ("escape", ""), ("nearest", "--evaluations 500")):
            file = f"{command}-{label}.json"
            yield f"{command}-{label}", f"{command} {name} --q '{q}' {more} --json {file}".replace("  ", " "), (file,)
    if name in FEW:
        yield from more_of(name)


def more_of(name: str) -> Iterator[Line]:
    """Further command lines for one of the few: what is derived anew, and the options."""
    robot = open_robot(name)
    singular, regular = dict(configurations(name))["k1"], dict(configurations(name))["regular"]
    derived = f"conditions {name} --fresh --quiet --points 100"
    yield "conditions-fresh", f"{derived} --json fresh.json", ("fresh.json",)
    yield "conditions-steps", f"{derived} --coranks 1 --steps", ()
    yield "conditions-numbers", f"{derived} --coranks 1 --lengths numbers", ()
    yield "conditions-tree", f"{derived} --coranks 1 --method tree", ()
    yield "conditions-position", f"conditions {name} --quiet --coranks 1 --points 100 --task position", ()
    yield "conditions-test", f"conditions {name} --quiet --coranks 1 --test 'sin(q2)'", ()
    yield "conditions-flags", f"conditions {name} --quiet --flags '{regular}'", ()
    yield "conditions-parted", f"conditions {name} --quiet --from '{regular}' --to '{singular}'", ()
    short = f"--starts {_STARTS} --threads 1 --quiet"
    yield "analyze-limits", f"analyze {name} {short} --limits --exact off", ()
    yield "analyze-position", f"analyze {name} {short} --task position --exact off", ()
    yield "analyze-ideal", f"analyze {name} {short} --ideal 1mm,0.5deg --exact off", ()
    yield "explain-full", f"explain {name} --q '{singular}' --full --evaluations 0", ()
    yield "explain-full-regular", f"explain {name} --q '{regular}' --full --limits --evaluations 0", ()
    yield "explain-position", f"explain {name} --q '{singular}' --task position --evaluations 0", ()
    yield "nearest-limits", f"nearest {name} --q '{regular}' --limits --evaluations 0", ()
    yield "escape-lie", f"escape {name} --q '{singular}' --lie", ()
    for method in ("gradient", "almarkhi"):
        yield f"find-{method}", f"find {name} --corank 1 --starts 20 --threads 1 --quiet --method {method}", ()
    yield "wrong-length", f"explain {name} --q '{regular},0.5'", ()
    yield "wrong-corank", f"find {name} --corank {robot.n + 1}", ()


def lines_of_all() -> Iterator[Line]:
    """The command lines that name no arm, and refusals."""
    yield "help", "--help", ()
    for command in COMMANDS:
        yield f"help-{command}", f"{command} --help", ()
    yield "robots", "robots", ()
    yield "robots-json", "robots --json", ()
    yield "robots-some", "robots 'spherical shoulder'", ()
    wrong = ("analyze nowhere.urdf", "analyze pa10 --task flying", "analyze pa10 --starts 0", "analyze pa10 --wrong",
             "conditions pa10 --lengths a=0.4", "conditions puma560 --test 'sin(q5)*foo(q3)'", "find pa10 --corank 9",
             "explain pa10 --q 0,0,0,0,x,0,0", "explain pa10", "report pa10 --format gif", "nothing")  # fmt: skip
    for number, line in enumerate(wrong, 1):
        yield f"wrong-{number:02}", line, ()


def configurations(name: str) -> Iterator[tuple[str, str]]:
    """(label, value of --q): a regular one, the first family of every corank, beside one, and where all is zero."""
    found, rng = shipped(name), np.random.default_rng(20240229)
    n = found.robot.n
    yield "zero", _joined(np.zeros(n))
    yield "regular", _joined(np.round(rng.uniform(-1.5, 1.5, n), 3))
    for corank in sorted({family.corank for family in found.families}):
        witness = next(family.witness for family in found.families if family.corank == corank)
        yield f"k{corank}", _joined(np.asarray(witness))
        if corank == 1:
            yield "near", _joined(np.asarray(witness) + _NEAR * rng.choice((-1, 1), n))


def _joined(q: np.ndarray) -> str:
    return ",".join(repr(float(value) + 0.0) for value in q)


def told(line: str) -> str:
    """What one command line prints, run in this process: line, stdout, stderr and exit code."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = run(shlex.split(line))
    parts = [f"$ rankdrop {line}", out.getvalue(), "--- stderr", err.getvalue(), f"--- exit code {code}", ""]
    return without_time("\n".join(part.rstrip("\n") for part in parts))


def without_time(text: str) -> str:
    """The same text, whatever the time taken."""
    for pattern, plain in _TIMES:
        text = pattern.sub(plain, text)
    return text


def readable(path: Path) -> str:
    """A file that was written, without times; JSON with one entry a line."""
    text = path.read_text(encoding="utf-8")
    if path.suffix != ".json":
        return without_time(text)
    return json.dumps(_timeless(json.loads(text)), ensure_ascii=False, indent=1) + "\n"


def _timeless(value: object) -> object:
    if isinstance(value, dict):
        return {key: "(some)" if key in _SECONDS and value[key] is not None else _timeless(inner)
                for key, inner in value.items()}  # fmt: skip
    if isinstance(value, list):
        return [_timeless(inner) for inner in value]
    return without_time(value) if isinstance(value, str) else value


def record(task: tuple[str, Path]) -> str:
    """Record one arm, or what is of none, and say how long it took."""
    name, out = task
    os.environ.update(COLUMNS="100", NO_COLOR="1")
    folder, begun = out / name, process_time()
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.iterdir():
        old.unlink()
    done, here = 0, Path.cwd()
    with tempfile.TemporaryDirectory() as place:
        os.chdir(place)
        try:
            for label, line, files in lines_of_all() if name == ALL else lines_of(name):
                replace_file(folder / f"{label}.txt", told(line).encode())
                for file in files:
                    if Path(file).exists():
                        replace_file(folder / file, readable(Path(file)).encode())
                done += 1
        finally:
            os.chdir(here)
    return f"{name}: {done} commands, {process_time() - begun:.1f} s CPU"


def main(arguments: list[str]) -> int:
    """Record, and tell how far it is."""
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("out", type=Path)
    reader.add_argument("--arms", nargs="+", metavar="NAME", help="names of the catalogue, few, or _all for no arm")
    reader.add_argument("--processes", type=int, default=2)
    asked = reader.parse_args(arguments)
    names = [*robot_names(), ALL]
    if asked.arms:
        names = [name for one in asked.arms for name in (FEW if one == "few" else (one,))]
        unknown = sorted(set(names) - {*robot_names(), ALL})
        if unknown:
            reader.error(f"not in the catalogue: {', '.join(unknown)}")
    first = sorted(names, key=lambda name: (name != ALL, name not in FEW))  # the long ones first
    tasks = [(name, asked.out.resolve()) for name in first]
    if asked.processes == 1:
        for number, task in enumerate(tasks, 1):
            print(f"{number}/{len(tasks)} {record(task)}", flush=True)
        return 0
    with Pool(asked.processes, os.nice, (5,), maxtasksperchild=20) as pool:
        for number, line in enumerate(pool.imap_unordered(record, tasks), 1):
            print(f"{number}/{len(tasks)} {line}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
