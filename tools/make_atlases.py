"""Write the atlases that are shipped: one JSON file for each arm of the catalogue, and the index of their fingerprints.

    .venv/bin/python tools/make_atlases.py            # what is missing or stale, two processes
    .venv/bin/python tools/make_atlases.py --all      # every arm anew
    .venv/bin/python tools/make_atlases.py pa10 ur5   # these, and the index anew

It can be stopped and started again: a file that is there, of these `ANSWERS` and this arm, is kept. An atlas in which
some fresh point is unexplained, a row unsound or a family unnamed is not written, and ends the run with exit code 1.
Their families have the partition, ids and names of the exact conditions, which are shipped beside them and have to be
there first (tools/make_conditions.py).
"""

from __future__ import annotations

import json
import os
import sys
from dataclasses import replace
from multiprocessing import Pool
from pathlib import Path
from time import process_time

from rankdrop.disk import replace_file
from rankdrop.results.analysis import Analysis, robot_to_dict
from rankdrop.results.known import ANSWERS, INDEX, SEED, STARTS
from rankdrop.robot.model import coarse_fingerprint
from rankdrop.robot.open import open_robot, robot_names
from rankdrop.verbs.analyze import analyze

FOLDER = Path(__file__).resolve().parents[1] / "src" / "rankdrop" / "atlases"
PROCESSES = 2


def write(name: str) -> tuple[str, bool, str]:
    """(name, whether its file was written, what to print) of one arm."""
    begun = process_time()
    found = analyze(open_robot(name), starts=STARTS, seed=SEED, exact="auto", threads=1)
    spent = f"{process_time() - begun:.1f} s CPU"
    if not (found.complete and found.verified and found.residual().holds(found.settings.tolerances)):
        return name, False, f"NOT WRITTEN, the analysis is not verified, {spent}"
    record = replace(found, exact=None, aspects=None).to_dict() | {"answers": ANSWERS}
    text = json.dumps(record, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    replace_file(FOLDER / f"{name}.json", f"{text}\n".encode())
    return name, True, f"{len(found.families)} families, {len(text) / 1000:.0f} kB, {spent}"


def stale(name: str) -> bool:
    """Whether an arm's file is missing, made by code that answered otherwise, or of an arm that has changed since."""
    path = FOLDER / f"{name}.json"
    if not path.is_file():
        return True
    record, robot = json.loads(path.read_text(encoding="utf-8")), open_robot(name)
    found = Analysis.from_dict(record)
    changed = robot_to_dict(robot, found.task, 0) != robot_to_dict(found.robot, found.task, 0)
    return changed or record.get("answers") != ANSWERS


def write_index() -> None:
    """Fingerprint -> names, of all files that are there; those of arms that are gone are removed."""
    index: dict[str, list[str]] = {}
    for path in sorted(FOLDER.glob("*.json")):
        if path.name != INDEX and path.stem not in robot_names():
            path.unlink()
        elif path.name != INDEX:
            for tip in (True, False):
                index.setdefault(coarse_fingerprint(open_robot(path.stem), tip=tip), []).append(path.stem)
    replace_file(FOLDER / INDEX, f"{json.dumps(index, indent=1)}\n".encode())


def main(arguments: list[str]) -> int:
    """Analyse, write, and tell how far it is."""
    FOLDER.mkdir(exist_ok=True)
    named = [one for one in arguments if not one.startswith("--")]
    everything = named or "--all" in arguments
    names = named or [name for name in robot_names() if everything or stale(name)]
    refused = []
    with Pool(PROCESSES, os.nice, (5,), maxtasksperchild=8) as pool:
        for done, (name, written, told) in enumerate(pool.imap_unordered(write, names), 1):
            print(f"{done}/{len(names)} {name}: {told}", flush=True)
            if not written:
                refused.append(name)
    write_index()
    print(f"not written: {', '.join(refused) or 'none'}")
    return 1 if refused else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
