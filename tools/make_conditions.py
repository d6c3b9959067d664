"""Write the exact conditions that are shipped: one JSON file for each arm of the catalogue that they are complete for.

    .venv/bin/python tools/make_conditions.py              # what is missing or stale, two processes
    .venv/bin/python tools/make_conditions.py --all        # every arm anew
    .venv/bin/python tools/make_conditions.py pa10 ur5     # these

It can be stopped and started again: a file that is there, of these `ANSWERS` and this arm, is kept. A derivation that
is not complete or not verified is not written, and the arm is told at the end; its old file is taken away.
"""

from __future__ import annotations

import json
import os
import sys
from multiprocessing import Pool
from pathlib import Path
from time import process_time

from rankdrop.disk import replace_file
from rankdrop.results.known import conditions_names, known_conditions, to_stored
from rankdrop.robot.open import open_robot, robot_names
from rankdrop.verbs.conditions import conditions

FOLDER = Path(__file__).resolve().parents[1] / "src" / "rankdrop" / "derivations"
PROCESSES = 2


def write(name: str) -> tuple[str, bool, str]:
    """(name, whether a file was written, what to print) of one arm."""
    begun = process_time()
    path = FOLDER / f"{name}.json"
    found = conditions(open_robot(name), special=True, fresh=True)
    spent = f"{process_time() - begun:.1f} s CPU"
    if not found.verified:
        path.unlink(missing_ok=True)
        why = "; ".join((*found.left, *found.disagreements)) or "a check does not hold"
        return name, False, f"NOT WRITTEN, {found.verdict}, {spent}: {why[:300]}"
    text = json.dumps(to_stored(found), ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    replace_file(path, f"{text}\n".encode())
    return name, True, f"{len(found.families)} families, {len(text) / 1000:.0f} kB, {spent}"


def wanted(arguments: list[str]) -> list[str]:
    """Names of the arms to derive."""
    named = [one for one in arguments if not one.startswith("--")]
    if named or "--all" in arguments:
        return named or list(robot_names())
    return [name for name in robot_names() if known_conditions(open_robot(name)) is None]


def main(arguments: list[str]) -> int:
    """Derive, write, and tell how far it is."""
    FOLDER.mkdir(exist_ok=True)
    for name in set(conditions_names()) - set(robot_names()):
        (FOLDER / f"{name}.json").unlink()
    names, refused = wanted(arguments), []
    with Pool(PROCESSES, os.nice, (5,), maxtasksperchild=8) as pool:
        for done, (name, written, told) in enumerate(pool.imap_unordered(write, names), 1):
            print(f"{done}/{len(names)} {name}: {told}", flush=True)
            if not written:
                refused.append(name)
    print(f"not shipped: {', '.join(refused) or 'none'}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
