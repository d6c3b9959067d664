"""Write the table of aspects that is shipped: how many each arm of the catalogue has, and whether it is cuspidal.

    .venv/bin/python tools/make_aspects.py            # arms that are missing in the table
    .venv/bin/python tools/make_aspects.py --all      # every arm anew
    .venv/bin/python tools/make_aspects.py pa10 ur5   # these anew

Each arm is counted as `rankdrop aspects NAME` does at default settings, 1 to 12 s of CPU for each arm. The table is
written after every arm, so that the run can be stopped and started again; arms that are gone are removed.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from pathlib import Path
from time import process_time

from rankdrop.aspects.arm import summary_of as aspects_summary
from rankdrop.aspects.posture_paths import aspects_of
from rankdrop.disk import replace_file
from rankdrop.results.aspect_summary import FILE, AspectSummary
from rankdrop.robot.open import open_robot, robot_names

TABLE = Path(__file__).resolve().parents[1] / "src" / "rankdrop" / "aspects" / FILE


def summary_of(name: str) -> AspectSummary:
    """The aspects of one arm of the catalogue, counted anew."""
    found = aspects_of(open_robot(name))
    return aspects_summary(found.count, found.verdict)


def read_table() -> dict[str, dict[str, object]]:
    """The table as it is; empty where there is none."""
    if not TABLE.is_file():
        return {}
    table: dict[str, dict[str, object]] = json.loads(TABLE.read_text(encoding="utf-8"))
    return table


def write_table(table: dict[str, dict[str, object]]) -> None:
    """One arm a line, sorted by name."""
    lines = [f"{json.dumps(name)}: {json.dumps(table[name])}" for name in sorted(table)]
    replace_file(TABLE, ("{\n" + ",\n".join(lines) + "\n}\n").encode())


def main(arguments: list[str]) -> int:
    """Count the arms that are asked for, and write the table."""
    names = robot_names()
    table = {name: entry for name, entry in read_table().items() if name in names}
    named = [one for one in arguments if not one.startswith("--")]
    if named:
        wanted = named
    elif "--all" in arguments:
        wanted = list(names)
    else:
        wanted = [name for name in names if name not in table]
    write_table(table)
    for done, name in enumerate(wanted, start=1):
        begun = process_time()
        found = summary_of(name)
        table[name] = asdict(found)
        write_table(table)
        print(f"{done}/{len(wanted)} {name}: {found}, {process_time() - begun:.1f} s CPU", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
