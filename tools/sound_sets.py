"""Is anything lost that is called complete? The rank tree alone on random structured arms, against the numeric search.

    .venv/bin/python tools/sound_sets.py              # 300 arms, 6R to 8R, an hour or more
    .venv/bin/python tools/sound_sets.py 0 40 --seconds 120

One line an arm: its number, joints, whether the tree calls its families complete, how many they are, how many singular
configurations of how many found numerically lie on none of them, CPU seconds. Exit code 1 where some lie on no family
of an arm that is called complete.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from time import process_time

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from reference.structured import lost, structured


def main() -> int:
    """Goes through the arms; the last line is the sum."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("first", nargs="?", type=int, default=0, help="number of the first arm")
    parser.add_argument("last", nargs="?", type=int, default=300, help="number after the last arm")
    parser.add_argument("--seconds", type=float, default=45.0, help="limit for the tree on an arm [s]")
    asked = parser.parse_args()
    complete = tested = false = 0
    for seed in range(asked.first, asked.last):
        begun, robot = process_time(), structured(seed)
        found = lost(robot, seconds=asked.seconds)
        wrong = found.complete and found.left > 0
        complete, tested, false = complete + found.complete, tested + found.tested, false + wrong
        print(
            f"{seed:4d} {robot.n}R {'complete' if found.complete else 'open':8s} {found.families:3d} families, "
            f"{found.left} of {found.tested} on none, {process_time() - begun:.1f} s{'  LOST' if wrong else ''}",
            flush=True,
        )
    print(
        f"{asked.last - asked.first} arms, {complete} called complete, {tested} singular configurations; "
        f"called complete and not: {false}"
    )
    return int(false > 0)


if __name__ == "__main__":
    sys.exit(main())
