"""`python -m benchmarks`: everything that is claimed of speed, measured beside its peers, in one table with a date.

    python -m benchmarks                       # hours are not needed: about 40 minutes on two cores
    python -m benchmarks --only core,search    # some groups
    python -m benchmarks --quick               # small runs: does everything still work?
    python -m benchmarks --out FILE            # instead of benchmarks/results/DATE.md

What is run goes into the table of the day; what else is there of the same day stays, so that a table can be made in
parts while a machine is quiet, and each part says how busy it was. Each script is run in a process of its own, one
after the other, so that a figure is not that of its neighbour's caches and the memory told is its own; both sides of
a ratio stand in one process.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import measure  # noqa: E402  # a script beside this one

GROUPS = {
    "core": ("core", "calls", "batches", "monitor"),
    "search": ("search", "almarkhi", "nearest", "distance"),
    "conditions": ("conditions", "suppression"),
    "paths": ("path", "cover", "certify", "soundness"),
    "commands": ("commands", "earlier", "explain", "directions", "viewer", "sweep"),
    "growth": ("growth",),
    "advice": ("jog", "names"),
    "programs": ("tool_lines", "through", "branches", "mended", "deviation", "detours"),
    "aspects": ("aspects",),
}
"""The scripts of each group: linear algebra of the Jacobian, singular configurations, exact conditions, what is
proven of paths and regions, whole commands and verbs, growth, whether advice holds, tool paths and programs, numbers of
aspects."""


def run(script: str, quick: bool) -> dict[str, Any]:
    """What one script found, or the last line that it said before it failed."""
    command = [sys.executable, str(HERE / f"{script}.py"), "--json", *(["--quick"] if quick else [])]
    begun, load = time.perf_counter(), os.getloadavg()[0]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    seconds = time.perf_counter() - begun
    try:
        return json.loads(done.stdout[done.stdout.index("{") :]) | {"seconds": seconds, "load": load}
    except ValueError:
        return {"failed": (done.stderr.strip().splitlines() or ["it said nothing"])[-1], "seconds": seconds}


def in_markdown(script: str, found: dict[str, Any]) -> str:
    """One script's part of the page."""
    if "failed" in found:
        return f"### {script}\n\nNot measured: `{found['failed']}`\n"
    rows = found["rows"]
    keys = measure.keys_of(rows)
    cells = [[*(measure.text(row[key]).replace("|", "\\|") for key in keys), measure.verdict(row)] for row in rows]
    lines = [f"### {script}", "", found["claim"], ""]
    lines += ["| " + " | ".join(line) + " |" for line in ([*keys, ""], ["---"] * (len(keys) + 1), *cells)]
    for name, command in found["missing"].items():
        lines.append(f"\nNot compared with {name}, which is not installed: `{command}`")
    memory = "" if found["megabytes"] is None else f", {found['megabytes']:.0f} MB at most"
    return "\n".join(lines) + f"\n\n{found['seconds']:.0f} s{memory}; load {found['load']:.1f} when it began.\n"


def parts_of(page: str) -> dict[str, str]:
    """The parts of a page by their scripts."""
    parts = re.split(r"^### ", re.sub(r"^## .*\n\n?", "", page, flags=re.MULTILINE), flags=re.MULTILINE)[1:]
    return {part.split("\n", 1)[0]: f"### {part.rstrip()}\n" for part in parts}


def page_of(date: str, command: str, parts: dict[str, str]) -> str:
    """The whole page, in the order of the groups."""
    machine = ", ".join(f"{name} {value}" for name, value in measure.machine().items())
    lines = [f"# Measured on {date}", "", f"`{command}`; {machine}. Ratios are of one run; benchmarks/README.md says "
             "what is compared.", ""]  # fmt: skip
    for group, scripts in GROUPS.items():
        if there := [parts[script] for script in scripts if script in parts]:
            lines += [f"## {group}", "", *there]
    return "\n".join(lines)


def main() -> int:
    """Run what was asked for; 1 if a claim does not hold or a script failed."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description="Speed beside other libraries.")
    parser.add_argument("--only", default=",".join(GROUPS), help=f"groups or scripts, with commas: {', '.join(GROUPS)}")
    parser.add_argument("--quick", action="store_true", help="small runs, written down only with --out")
    parser.add_argument("--out", type=Path, help="where the table goes (benchmarks/results/DATE.md)")
    arguments = parser.parse_args()
    known = {script for scripts in GROUPS.values() for script in scripts}
    asked = [name.strip() for name in arguments.only.split(",")]
    if unknown := [name for name in asked if name not in GROUPS and name not in known]:
        allowed = f"groups: {', '.join(GROUPS)}; scripts: {', '.join(sorted(known))}"
        parser.error(f"no group and no script {unknown[0]!r}; {allowed}")
    today = datetime.now(UTC).date().isoformat()
    out = arguments.out or (None if arguments.quick else HERE / "results" / f"{today}.md")
    parts = parts_of(out.read_text(encoding="utf-8")) if out is not None and out.exists() else {}
    wrong = 0
    for group, scripts in GROUPS.items():
        chosen = [script for script in scripts if group in asked or script in asked]
        for script in chosen:
            print(f"{group}: {script} …", file=sys.stderr, flush=True)
            found = run(script, arguments.quick)
            parts[script] = in_markdown(script, found)
            if out is not None:  # after each: what ends early keeps what was measured
                out.parent.mkdir(parents=True, exist_ok=True)
                command = f"python -m benchmarks{' --quick' if arguments.quick else ''}"
                out.write_text(page_of(today, command, parts), encoding="utf-8")
            wrong += "failed" in found or any(row["holds"] is False for row in found["rows"])
            if "failed" in found:
                print(f"{script}: {found['failed']}", flush=True)
            else:
                print(f"{found['claim']}\n{measure.table(found['rows'])}\n", flush=True)
    if out is not None:
        print(f"written to {out}")
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
