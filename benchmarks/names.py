"""The share of singular configurations of the catalogue whose first line of `explain` names a part of the arm.

    python benchmarks/names.py                       # ten configurations per arm
    python benchmarks/names.py --total 3000          # 3,000 in all
    python benchmarks/names.py --arms ur5e,crx10ia   # some arms

Configurations are random members of the families of coranks 1 to 3 of each arm, in turn; of a family without equations,
its witness. A summary is counted as too long where it has more than six lines at 80 columns.
"""

from __future__ import annotations

import argparse
import re
from collections import Counter
from math import ceil
from textwrap import wrap

import numpy as np

from rankdrop.families.points import members
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import known_names, shipped
from rankdrop.robot.model import Array
from rankdrop.text.explanation import summary_lines
from rankdrop.verbs.explain import explain

PARTS = re.compile(r"\b(shoulder|elbow|wrist|rail|tip)\b")
WIDTH, INDENT, LINES = 80, 2, 6
HIGHEST_CORANK = 3
SHARE = 0.98


def configurations(found: Analysis, count: int, seed: int = 1) -> list[Array]:
    """Random singular configurations of an arm, of its families of coranks 1 to 3 in turn; at most `count`."""
    families = [family for family in found.families if family.corank <= HIGHEST_CORANK]
    if not families:
        return []
    each = ceil(count / len(families))
    drawn = []
    for number, family in enumerate(families):
        points = members(found.robot, found.task, family, 4 * each, seed + number)[:each]
        drawn.append(points if len(points) else np.array([family.witness]))
    turns = [points[turn] for turn in range(each) for points in drawn if turn < len(points)]
    return turns[:count]


def faults(found: Analysis, q: Array) -> tuple[list[str], str]:
    """What is wrong with the summary of one configuration, and its first line."""
    lines = summary_lines(explain(found.robot, q, found.task))
    wrong = []
    if not PARTS.search(lines[0]):
        wrong.append("no part")
    if len(wrap(lines[0], WIDTH)) + sum(len(wrap(line, WIDTH - INDENT)) for line in lines[1:]) > LINES:
        wrong.append("long")
    if re.search(r"\bscrews?\b", " ".join(lines)):
        wrong.append("screws")
    return wrong, lines[0]


def main() -> None:
    """Print the configurations whose summary fails, then the shares."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--each", type=int, default=10, help="configurations per arm")
    parser.add_argument("--total", type=int, help="configurations in all, instead")
    parser.add_argument("--arms", default="", help="names, separated by commas; default: the whole catalogue")
    given = parser.parse_args()
    arms = given.arms.split(",") if given.arms else known_names()
    count = given.each
    if given.total:
        count = ceil(given.total / len(arms))
    tested, failed = 0, Counter[str]()
    for name in arms:
        found = shipped(name)
        for q in configurations(found, count):
            wrong, line = faults(found, q)
            tested += 1
            failed.update(wrong)
            if wrong:
                print(f"{name}: {', '.join(wrong)}: {line}  q = {np.round(q, 4).tolist()}")
    share = 1 - failed["no part"] / tested
    print(f"{tested:,} configurations of {len(arms)} arms: {share:.2%} name a part of the arm (at least {SHARE:.0%}), ")
    print(f"{failed['long']} summaries have more than {LINES} lines at {WIDTH} columns, {failed['screws']} say screws")
    raise SystemExit(share < SHARE or failed["long"] > 0 or failed["screws"] > 0)


if __name__ == "__main__":
    main()
