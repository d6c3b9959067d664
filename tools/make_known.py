"""Write what is shipped of the catalogue's arms: one file for each, analysis and exact conditions, and the index.

    .venv/bin/python tools/make_known.py            # what is missing or stale, two processes
    .venv/bin/python tools/make_known.py --all      # every arm anew
    .venv/bin/python tools/make_known.py pa10 ur5   # these, and the index anew

It can be stopped and started again: a file that is there, of these `ANSWERS` and this arm, is kept. Conditions that are
not complete or not verified are not written; the arm is listed at the end. An analysis in which some fresh point is
unexplained, a row unsound or a family unnamed is not written, nor its conditions, and ends the run with exit code 1.
The analysis has the partition, ids and names of the conditions, which are written first.
"""

from __future__ import annotations

import json
import os
import sys
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from time import process_time

from rankdrop.disk import replace_file
from rankdrop.results.analysis import Analysis, robot_to_dict
from rankdrop.results.known import ANALYSIS, ANSWERS, CONDITIONS, INDEX, SEED, STARTS, file_text, is_of, part_of_file
from rankdrop.results.stored_conditions import to_stored
from rankdrop.robot.model import coarse_fingerprint
from rankdrop.robot.open import open_robot, robot_names
from rankdrop.task import resolve_task
from rankdrop.verbs.analyze import analyze
from rankdrop.verbs.conditions import conditions

FOLDER = Path(__file__).resolve().parents[1] / "src" / "rankdrop" / "known"
PROCESSES = 2


def write(name: str) -> tuple[str, tuple[str, ...], str]:
    """(name, what of it was not written, what to print) of one arm."""
    begun, robot, path = process_time(), open_robot(name), FOLDER / f"{name}.jsonl"
    derived = conditions(robot, special=True, fresh=True)
    missing, told, record = [], "", None
    if derived.verified:
        record = to_stored(derived)
    else:
        missing.append("conditions")
        why = "; ".join(map(str, (*derived.left, *derived.disagreements))) or "a check does not hold"
        told = f"; NO CONDITIONS, {derived.verdict.word}: {why[:300]}"
    replace_file(path, file_text(None, record).encode())  # for the analysis, which takes its families from there
    found = analyze(robot, starts=STARTS, seed=SEED, exact="auto", threads=1)
    spent = f"{process_time() - begun:.1f} s CPU"
    if not (found.complete and found.verified and found.residual().holds(found.settings.tolerances)):
        path.unlink()
        return name, ("analysis", *missing), f"NOT WRITTEN, the analysis is not verified, {spent}{told}"
    families = tuple(replace(family, exact=None) for family in found.families)
    analysis = replace(found, families=families, exact=None, aspects=None).to_dict() | {"answers": ANSWERS}
    content = file_text(analysis, record).encode()
    replace_file(path, content)
    return name, tuple(missing), f"{len(families)} families, {len(content) / 1000:.0f} kB, {spent}{told}"


def stale(name: str) -> bool:
    """Whether an arm's file is missing, made by code that answered otherwise, or of an arm that has changed since."""
    path, robot = FOLDER / f"{name}.jsonl", open_robot(name)
    analysis, derived = part_of_file(path, ANALYSIS), part_of_file(path, CONDITIONS)
    if analysis is None:
        return True
    found = Analysis.from_dict(analysis)
    changed = robot_to_dict(robot, found.task, 0) != robot_to_dict(found.robot, found.task, 0)
    if changed or analysis.get("answers") != ANSWERS:
        return True
    if derived is None:  # not to be had by this code either
        return False
    return derived.get("answers") != ANSWERS or not is_of(derived, robot, resolve_task(None, robot))


def write_index() -> None:
    """Fingerprint -> names, of all files that are there; those of arms that are gone are removed."""
    index: dict[str, list[str]] = {}
    for path in sorted(FOLDER.glob("*.jsonl")):
        if path.stem not in robot_names():
            path.unlink()
            continue
        for tip in (True, False):
            index.setdefault(coarse_fingerprint(open_robot(path.stem), tip=tip), []).append(path.stem)
    replace_file(FOLDER / INDEX, f"{json.dumps(index, indent=1)}\n".encode())


def main(arguments: list[str]) -> int:
    """Derive, analyse, write, and tell how far it is."""
    FOLDER.mkdir(exist_ok=True)
    named = [one for one in arguments if not one.startswith("--")]
    everything = named or "--all" in arguments
    names = named or [name for name in robot_names() if everything or stale(name)]
    refused: dict[str, list[str]] = {"analysis": [], "conditions": []}
    new_process = get_context("spawn").Pool  # for each arm: what a process has read of a file, it keeps
    with new_process(PROCESSES, os.nice, (5,), maxtasksperchild=1) as pool:
        for done, (name, missing, told) in enumerate(pool.imap_unordered(write, names), 1):
            print(f"{done}/{len(names)} {name}: {told}", flush=True)
            for part in missing:
                refused[part].append(name)
    write_index()
    print(f"not written: {', '.join(refused['analysis']) or 'none'}")
    print(f"without conditions: {', '.join(refused['conditions']) or 'none'}")
    return 1 if refused["analysis"] else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
