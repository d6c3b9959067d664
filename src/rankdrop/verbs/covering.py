"""One verb for the whole joint space: where may singular configurations be, and is that all known families?"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rankdrop._handles import check_robot
from rankdrop.certify.bittree import Cells
from rankdrop.certify.coverfile import load, write_covering
from rankdrop.certify.covering import BUDGET, Covering, covering, looked_into, plan_of
from rankdrop.compare.covered import Explainer, spots
from rankdrop.family.record import Family
from rankdrop.local.block import joint_scale
from rankdrop.results.analysis import Analysis
from rankdrop.results.covered import Account, Covered
from rankdrop.results.explanation.parts import known_families
from rankdrop.robot.model import Robot
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT
from rankdrop.verbs.analyze import analyze

Report = Callable[[str, int, int], None]
"""report(label, done, total)"""

_STARTS = 1_000  # of an analysis that is made here, for each corank


def cover(
    robot: Robot,
    task: str | Task | None = None,
    *,
    width: float = 0.05,
    corank: int = 1,
    limits: bool = False,
    explain: bool = True,
    analysis: Analysis | None = None,
    out: str | Path | None = None,
    budget: int = BUDGET,
    threads: int = 0,
    report: Report | None = None,
) -> Covered:
    """Boxes that hold every singular configuration, and whether known families explain all of them.

    Every box that is left out is proven free. Six turning joints and the full pose are covered by the determinant split
    in two tables, other arms by enclosures, which cost far more: take boxes of 0.2 rad there.

    Args:
        robot: the arm.
        task: name, rows or Task; None is the task the arm is made for.
        width: of the boxes, at most [rad; slides divided by the length scale].
        corank: the boxes hold every configuration of this corank or more; above 1 by enclosures.
        limits: within the joint limits only.
        explain: hold the boxes against families.
        analysis: these families; None: those shipped with the package, else an analysis made here.
        out: file the covering is kept in, with `out`.journal beside it while it is made: after an interruption, of any
            kind, the same call goes on where it was. A file that holds this covering already is read.
        budget: enclosures, at most (about 1.5 µs each); arms of six turning joints need none.
        threads: 0 for all cores; the result does not depend on it.
        report: report(label, done, total) of progress.

    Raises:
        OptionError: a corank, width or budget outside what is allowed, an arm or task that cannot be covered,
            an analysis of another arm.
        ResultFileError: `out` cannot be written, is no covering, or its journal is that of another one.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = cover(open_robot("planar3r"), width=0.1)
        >>> found.covering.tree.leaves, found.holds
        (2, True)
    """
    check_robot(robot)
    resolved = resolve_task(task, robot)
    families, source = known_families(robot, resolved, analysis, DEFAULT)
    tell = report if report is not None else _silent
    found = _made(robot, resolved, width, corank, limits, out, budget, threads, tell)
    if not found.complete or not explain:
        return Covered(robot, resolved, found, None)
    if source == "on the spot":
        made = analyze(robot, resolved, starts=_STARTS, limits=False, threads=threads)
        families, source = made.families, "made here"
    families = tuple(one for one in families if one.corank >= found.plan.corank)
    return Covered(robot, resolved, found, _account(found, robot, resolved, families, source, threads, tell))


def _silent(label: str, done: int, total: int) -> None:
    return None


def _made(
    robot: Robot, task: Task, width: float, corank: int, limits: bool, out: str | Path | None, budget: int,
    threads: int, tell: Report,
) -> Covering:  # fmt: skip
    def progress(done: int, total: int) -> None:
        tell("parts covered", done, total)

    if out is None:
        return covering(
            robot, width, task, corank=corank, limits=limits, budget=budget, threads=threads, progress=progress
        )
    path = Path(out)
    journal = path.with_name(f"{path.name}.journal")
    plan = plan_of(robot, width, task, corank=corank, limits=limits)
    if path.is_file() and path.stat().st_size:
        there = Covering(*load(path))
        if there.plan.line() == plan.line():
            return there
    found = covering(
        robot, width, task, corank=corank, limits=limits, budget=budget, journal=journal, threads=threads,
        progress=progress,
    )
    if found.complete:
        write_covering(path, found.plan, found.tree, found.tested, found.freed)
        journal.unlink(missing_ok=True)
    return found


def _account(
    found: Covering, robot: Robot, task: Task, families: tuple[Family, ...], source: str, threads: int, tell: Report
) -> Account:
    scale = joint_scale(robot, task)
    explainer = Explainer(found, robot, families, scale)
    told = explainer.all(lambda done, total: tell("boxes explained", done, total))
    left, proven = told.left, told.proven
    open_ = np.flatnonzero(~proven)
    judged, by = looked_into(
        robot, task, found, left[open_], threads=threads,
        near=lambda parts, halvings: Explainer(found, robot, families, scale, halvings).by(parts),
    )  # fmt: skip
    proven = proven.copy()
    proven[open_] = judged == 1
    stays = np.ones(len(left), dtype=np.bool_)
    stays[open_] = (judged == 1) | (judged == 2)
    explained = told.families + np.bincount(by[judged == 3], minlength=len(families))
    groups = spots(found, robot, task, *_those(left, proven, stays))
    return Account(families, source, explained, int((judged == 0).sum()), groups, explainer.diagonal)


def _those(left: Cells, proven: NDArray[np.bool_], stays: NDArray[np.bool_]) -> tuple[Cells, NDArray[np.bool_]]:
    return left[stays], proven[stays]
