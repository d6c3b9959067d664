"""Write docs/arms.md: how every arm of the catalogue, and every skeleton of tests/data/arms, fares at default settings.

    .venv/bin/python tools/make_arms_page.py                 # what is not measured yet, two processes, then the page
    .venv/bin/python tools/make_arms_page.py --all           # everything anew
    .venv/bin/python tools/make_arms_page.py --page          # the page from what is there
    .venv/bin/python tools/make_arms_page.py kr16 m1509_blue # these anew, then the page

Each skeleton is analysed and its conditions are derived from nothing, as `rankdrop analyze` and `rankdrop conditions`
do; arms of the catalogue are read from what is shipped, where exact conditions are. What was measured is kept in
build/arms, so that the run can be stopped and started again.
"""

from __future__ import annotations

import csv
import json
import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from multiprocessing import Pool
from pathlib import Path
from time import process_time

from rankdrop.cli import exits
from rankdrop.disk import replace_file
from rankdrop.exact.arm.structure import structure_of
from rankdrop.families.derivation import AGREES, NOT_DERIVED
from rankdrop.results.analysis import Analysis
from rankdrop.results.aspect_summary import CUSPIDAL
from rankdrop.results.conditions import Conditions
from rankdrop.results.known import catalogue_aspects, conditions_names, shipped
from rankdrop.results.stored_conditions import shipped_conditions
from rankdrop.robot.model import Robot
from rankdrop.robot.open import catalog_entries, open_robot
from rankdrop.text.aspects import aspects_cell
from rankdrop.text.families import share_text
from rankdrop.verbs.analyze import analyze
from rankdrop.verbs.conditions import conditions

ROOT = Path(__file__).resolve().parents[1]
ARMS = ROOT / "tests" / "data" / "arms"
PAGE = ROOT / "docs" / "arms.md"
KEPT = ROOT / "build" / "arms"
PROCESSES = 2
_REASON = 160  # characters of a reason that a cell of a table may have
USUAL = {"explained": "100 %", "exact": "letters", "near": "–"}
"""What holds for nearly every arm: the page lists the others."""

INTRODUCTION = """# Arms

How every arm of the catalogue fares at default settings, and how {count} arms of many makers do that are read from
their own files. Written by `tools/make_arms_page.py`; tests compare the page with the results.

- **families per corank**: 3/4/1 means three families of corank 1, four of corank 2, one of corank 3.
- **explained**: the lowest share, of all coranks, of test points on these families, rounded down.
- **exact**: whether the conditions of every corank were derived exactly, with letters for the lengths or with numbers,
  and agree with the search; else the reason.
- **aspects**: their number, joint limits ignored; c: the arm is cuspidal, it can change its posture without a
  singularity (proven); no mark: it cannot (proven), or has more or fewer joints than rows, so that postures are not
  compared.
- **near**: structure that the arm misses by little.

Unless a list of exceptions names the arm: explained 100 %, exact with letters, near to no special structure.
"""


@dataclass(frozen=True)
class Row:
    """One arm, as both commands left it."""

    name: str
    about: str
    families: str
    explained: str
    exact: str
    near: str
    analyze_exit: int
    conditions_exit: int
    reason: str
    analyze_cpu: float
    conditions_cpu: float

    @property
    def fine(self) -> bool:
        """Whether both commands ended with exit code 0."""
        return self.analyze_exit == self.conditions_exit == exits.FINE

    @property
    def remarks(self) -> dict[str, str]:
        """Heading of a list of exceptions -> what it has of this arm."""
        said = {"explained": self.explained, "exact": self.exact, "near": self.near}
        if not self.fine:
            said["exact"] += f"; exit codes {self.analyze_exit}, {self.conditions_exit}: {self.reason}"
        return {name: text for name, text in said.items() if text != USUAL[name]}

    @property
    def joints(self) -> str:
        """The number of joints of a maker's file."""
        return self.about.split()[0]


def row_of(name: str, about: str, robot: Robot) -> Row:
    """Analyse an arm and derive its conditions, both at default settings and from nothing."""
    begun = process_time()
    found = analyze(robot, fresh=True)
    between = process_time()
    derived = conditions(robot, fresh=True)
    return _row(name, about, found, derived, between - begun, process_time() - between)


def _row(name: str, about: str, found: Analysis, derived: Conditions, one: float, two: float) -> Row:
    """The row of two results, and of the processor seconds they took; 0 where they were read."""
    return Row(
        name=name,
        about=about,
        families=families_per_corank(found),
        explained=explained(found),
        exact=exactness(found, derived),
        near=", ".join(one.text for one in structure_of(derived.chain).near) or "–",
        analyze_exit=exits.FINE if found.complete and found.verified else exits.UNEXPLAINED,
        conditions_exit=exits.FINE if derived.verified else exits.UNEXPLAINED,
        reason=_short(_reasons(found, derived)),
        analyze_cpu=one,
        conditions_cpu=two,
    )


def families_per_corank(found: Analysis) -> str:
    """ "3/4/1"; "none" where the rank never drops."""
    counts = [len(found.of_corank(one.corank)) for one in found.coranks if one.converged]
    return "/".join(map(str, counts)) or "none"


def explained(found: Analysis) -> str:
    """The lowest share of fresh points explained, in percent, rounded down as in the tables: 100 % means all."""
    shares = [one.completeness for one in found.coranks if one.completeness.tested]
    if not shares:
        return "–"
    least = min(shares, key=lambda one: one.agree / one.tested)
    return share_text(least.agree, least.tested)


def exactness(found: Analysis, derived: Conditions) -> str:
    """Whether and how the exact conditions are known, and whether the analysis agrees."""
    how = "letters" if derived.letters else "numbers"
    if not derived.complete:
        return "not complete"
    if not derived.verified:
        return f"{how}, not verified"
    status = found.exact.status if found.exact is not None else AGREES
    told = {AGREES: "", NOT_DERIVED: " (not within analyze's time)"}
    return how + told.get(status, ", differs")


def _reasons(found: Analysis, derived: Conditions) -> Iterable[str]:
    """Why one of the two did not end well."""
    for one in found.coranks:
        if one.completeness.agree < one.completeness.tested:
            yield f"corank {one.corank}: {one.completeness.agree} of {one.completeness.tested} points explained"
    yield from (f"row {row.id} has no name" for row in found.families if not row.named)
    for row in found.families:
        if row.soundness.agree < row.soundness.tested:
            yield f"row {row.id}: {row.soundness.agree} of {row.soundness.tested} solutions singular"
    if found.exact is not None and not found.exact.holds:
        yield from map(str, found.exact.disagreements or (found.exact.reason,))
    yield from map(str, (*derived.left, *derived.disagreements))


def _short(reasons: Iterable[str]) -> str:
    text = "; ".join(reasons).replace("|", "∣")
    return text if len(text) <= _REASON else text[: _REASON - 2] + " …"


def skeletons() -> list[dict[str, str]]:
    """The list of tests/data/arms: name, source, base, tip, joints."""
    with (ARMS / "arms.csv").open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def catalogue_row(name: str) -> Row:
    """The row of an arm of the catalogue, from what is shipped; without exact conditions there, from nothing."""
    about = next(entry.about for entry in catalog_entries() if entry.name == name)
    if name in conditions_names():
        return _row(name, about, shipped(name), shipped_conditions(name), 0.0, 0.0)
    return row_of(name, about, open_robot(name))


def skeleton_row(name: str) -> Row:
    """The row of a skeleton."""
    one = next(one for one in skeletons() if one["name"] == name)
    robot = open_robot(ARMS / f"{name}.urdf", base=one["base"], tip=one["tip"])
    return row_of(name, f"{one['joints']} joints, {one['source'].split('/')[0].replace('+', '/')}", robot)


def measure(task: tuple[str, str]) -> str:
    """Measure one arm, keep its row, and say how it went."""
    kind, name = task
    row = catalogue_row(name) if kind == "catalogue" else skeleton_row(name)
    folder = KEPT / kind
    folder.mkdir(parents=True, exist_ok=True)
    replace_file(folder / f"{name}.json", json.dumps(asdict(row), ensure_ascii=False, indent=1).encode())
    spent = f"{row.analyze_cpu:.1f} + {row.conditions_cpu:.1f} s CPU"
    return f"{name}: {row.families} {row.remarks} | {spent}"


def kept(kind: str, name: str) -> Row | None:
    """What was measured of an arm, if it was."""
    path = KEPT / kind / f"{name}.json"
    return Row(**json.loads(path.read_text(encoding="utf-8"))) if path.is_file() else None


def tasks() -> list[tuple[str, str]]:
    """(which list, name) of every arm on the page."""
    own = [("catalogue", entry.name) for entry in catalog_entries()]
    return own + [("skeletons", one["name"]) for one in skeletons()]


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """The cells of rows in Markdown."""
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    return lines + [f"| {' | '.join(row)} |" for row in rows]


def aspects_of_row(name: str) -> str:
    """The stored number of aspects of an arm of the catalogue, with the mark of a cuspidal arm."""
    found = catalogue_aspects()[name]
    number = aspects_cell(found)
    if found.posture_change == CUSPIDAL:
        return f"{number} c"
    return number


def exceptions(rows: Sequence[Row]) -> list[str]:
    """A list of what is not as usual, each with its arms."""
    arms: dict[str, list[str]] = {}
    for name in USUAL:
        for row in rows:
            if name in row.remarks:
                arms.setdefault(f"{name}: {row.remarks[name]}", []).append(f"`{row.name}`")
    return ["Exceptions:", "", *(f"- {text}: {', '.join(names)}" for text, names in arms.items())]


def alike(arms: Iterable[tuple[str, str, str]]) -> Iterator[tuple[str, str, str]]:
    """Of (name, and two cells that arms may have in common): both cells and the names, the commonest first."""
    groups: dict[tuple[str, str], list[str]] = {}
    for name, one, other in arms:
        groups.setdefault((one, other), []).append(name)
    for (one, other), names in sorted(groups.items(), key=lambda group: -len(group[1])):
        yield one, other, ", ".join(names)


def page() -> str:
    """The whole page, from what was measured."""
    found = {task: kept(*task) for task in tasks()}
    missing = [name for (_, name), row in found.items() if row is None]
    if missing:
        raise SystemExit(f"not measured: {', '.join(missing)}")
    rows = {kind: [row for (k, _), row in found.items() if k == kind and row] for kind in ("catalogue", "skeletons")}
    own = alike((f"`{row.name}`", row.families, aspects_of_row(row.name)) for row in rows["catalogue"])
    parts = [INTRODUCTION.format(count=len(rows["skeletons"])), "## The catalogue", "",
             "`rankdrop robots` describes each arm.", "", *exceptions(rows["catalogue"]), "",
             *table(("families per corank", "aspects", "arms"), own), ""]  # fmt: skip
    theirs = alike((f"`{row.name}`", row.joints, row.families) for row in rows["skeletons"])
    fine = sum(row.fine for row in rows["skeletons"])
    parts += ["## Arms from their makers' files", "",
              f"{fine} of {len(rows['skeletons'])} end with exit code 0 from both commands. The files and their "
              "sources are in `tests/data/arms`, reduced to joints and links, their numbers word for word.", "",
              *exceptions(rows["skeletons"]), "",
              *table(("joints", "families per corank", "arms"), theirs)]  # fmt: skip
    return "\n".join(parts) + "\n"


def main(arguments: list[str]) -> int:
    """Measure, tell how far it is, write the page."""
    named = {one for one in arguments if not one.startswith("--")}
    wanted = [task for task in tasks() if task[1] in named]
    if not named and "--page" not in arguments:
        wanted = [task for task in tasks() if "--all" in arguments or kept(*task) is None]
    with Pool(PROCESSES, os.nice, (5,), maxtasksperchild=8) as pool:
        for done, told in enumerate(pool.imap_unordered(measure, wanted), 1):
            print(f"{done}/{len(wanted)} {told}", flush=True)
    replace_file(PAGE, page().encode())
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
