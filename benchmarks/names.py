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
import time
from collections import Counter
from math import ceil
from textwrap import wrap

import measure  # first: sets the number of threads
import numpy as np

from rankdrop.families.points import members
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import known_names, shipped
from rankdrop.robot.model import Array
from rankdrop.text.verdict import summary_lines
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


def judged(name: str, count: int) -> tuple[measure.Row, list[str]]:
    """The row of an arm, and a line for each summary that fails."""
    found = shipped(name)
    failed: Counter[str] = Counter()
    lines = []
    begun = time.process_time()
    chosen = configurations(found, count)
    for q in chosen:
        wrong, line = faults(found, q)
        failed.update(wrong)
        if wrong:
            lines.append(f"{name}: {', '.join(wrong)}: {line}  q = {np.round(q, 4).tolist()}")
    return row_of(name, len(chosen), failed, time.process_time() - begun), lines


def row_of(arm: str, tested: int, failed: Counter[str], seconds: float, *, claimed: bool = False) -> measure.Row:
    """Numbers of one arm, or of all."""
    named = 1.0 - failed["no part"] / tested if tested else 1.0
    return {"arm": arm, "configurations": tested, "share": named, "too long": failed["long"],
            "screws": failed["screws"], "CPU s": seconds, "claimed": claimed}  # fmt: skip


def main() -> None:
    """Print the share of every arm and of all, and the summaries that fail."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--each", type=int, default=1 if measure.quick() else 10, help="configurations per arm (10)")
    parser.add_argument("--total", type=int, help="configurations in all, instead")
    parser.add_argument("--arms", default="", help="names, separated by commas; default: the whole catalogue")
    measure.options(parser)
    given = parser.parse_args()
    arms = given.arms.split(",") if given.arms else known_names()
    count = given.each
    if given.total:
        count = ceil(given.total / len(arms))
    rows, lines = [], []
    for name in arms:
        row, failing = judged(name, count)
        rows.append(row)
        lines += failing
    failed = Counter({"long": sum(row["too long"] for row in rows), "screws": sum(row["screws"] for row in rows)})
    tested = sum(row["configurations"] for row in rows)
    failed["no part"] = round(sum((1.0 - row["share"]) * row["configurations"] for row in rows))
    whole = row_of("all", tested, failed, sum(row["CPU s"] for row in rows), claimed=True)
    if not given.json:
        print(*lines, sep="\n")
    measure.report(
        f"the first line of `explain` names a part of the arm; no summary has more than {LINES} lines at {WIDTH} "
        "columns or says screws", [*rows, whole], ratio="share", target=SHARE, arguments=given,
    )  # fmt: skip
    raise SystemExit(whole["share"] < SHARE or whole["too long"] > 0 or whole["screws"] > 0)


if __name__ == "__main__":
    main()
