"""One verb for the whole joint space: where may singular configurations be, and is that all known families?"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from contextlib import nullcontext
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from rankdrop.cover.box_matching import FamilyBoxes
from rankdrop.cover.covering import (
    BUDGET,
    SPLIT,
    Batch,
    BudgetSpent,
    Covering,
    CoveringEnd,
    batch_from_bytes,
    batch_to_bytes,
    chunk_of,
    chunks_of,
    classify_boxes,
    estimate,
    finished_leaves,
    load_covering,
    plan_of,
    put_together,
    write_covering,
)
from rankdrop.cover.spots import spots
from rankdrop.errors import OptionError
from rankdrop.families.record import Family
from rankdrop.jobs import Engine, Job, check_engine, finish, hold_lock, progress_of
from rankdrop.kinematics import check_robot
from rankdrop.local.block import joint_scale
from rankdrop.options import takes
from rankdrop.proof.boxes import Plan, plan_from_entries
from rankdrop.questions import CoverOptions
from rankdrop.results.analysis import Analysis, robot_from_dict, robot_to_dict, task_from_dict
from rankdrop.results.covered import Account, Covered
from rankdrop.results.known import known_families
from rankdrop.robot.model import Robot
from rankdrop.task import Task, resolve_task
from rankdrop.text.coverings import covering_label
from rankdrop.tolerances import DEFAULT
from rankdrop.verbs.analyze import analyze

Report = Callable[[str, int, int], None]
"""report(label, done, total)"""

_STARTS = 1_000  # of an analysis that is made here, for each corank
_FAR = 3  # times the budget that an estimate says: it is off by a tenth or so, at times by a half
_QUICK, _QUICK_BY_ENCLOSURES = 1 << 22, 1 << 16  # leaves below which processes take longer to begin than the work

Record = dict[str, Any]
HERE = Engine(here=True)


@takes(CoverOptions)
def cover(
    robot: Robot,
    task: str | Task | None = None,
    options: CoverOptions | None = None,
    *,
    analysis: Analysis | None = None,
    out: str | Path | None = None,
    scheduler: str | None = None,
    report: Report | None = None,
    **given: Any,
) -> Covered:
    """Boxes that hold every singular configuration, and whether known families explain all of them.

    Every box that is left out is proven free. Six turning joints and the full pose are covered by the determinant split
    in two tables, other arms by enclosures, which cost far more: take boxes of 0.2 rad there.

    Args:
        robot: the arm.
        task: name, rows or Task; None is the task the arm is made for.
        options: width, corank, limits, budget and threads; or its fields as keywords.
        analysis: these families; None: those shipped with the package, else an analysis made here.
        out: file the covering is kept in, with the folder `out`.parts beside it while it is made (`rankdrop.jobs`):
            after an interruption, of any kind, the same call goes on where it was. A file that holds this covering
            already is read.
        scheduler: address of a Dask scheduler, whose workers make the parts.
        report: report(label, done, total) of progress.
        given: fields of the options.

    Raises:
        OptionError: a corank, width or budget outside what is allowed, an arm or task that cannot be covered,
            an analysis of another arm.
        MissingExtraError: a scheduler, and Dask's distributed is not installed.
        ResultFileError: `out` cannot be written, is no covering, or its parts are those of another one.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = cover(open_robot("planar3r"), width=0.1)
        >>> found.covering.tree.leaves, found.holds
        (2, True)
    """
    check_robot(robot)
    how = CoverOptions.of(options, given)
    engine = Engine(how.threads, scheduler)
    check_engine(engine)
    resolved = resolve_task(task, robot)
    families, source = known_families(robot, resolved, analysis, DEFAULT)
    tell = report or (lambda label, done, total: None)
    plan = plan_of(robot, how.width, resolved, corank=how.corank, limits=how.limits)
    file = None if out is None else Path(out)
    with nullcontext() if file is None else hold_lock(file):
        finished = _read_or_make(robot, resolved, plan, file, how.budget, engine, tell)
    if not finished.complete or not how.explain:
        return Covered(robot, resolved, finished, None)
    if source == "on the spot":
        analysed = analyze(robot, resolved, starts=_STARTS, limits=False, threads=how.threads)
        families, source = analysed.families, "made here"
    families = tuple(family for family in families if family.corank >= finished.plan.corank)
    account = _account(finished, robot, resolved, families, source, how.threads, tell)
    return Covered(robot, resolved, finished, account)


def how_far(out: str | Path) -> str:
    """How far the covering of a file is, as a sentence, read from what is on the disk alone.

    Raises:
        ResultFileError: nothing of a covering is there.
    """
    file, folder = Path(out), _parts_of(Path(out))
    if file.is_file() and not folder.is_dir():
        return f"finished: {finished_leaves(file):,} boxes in {file}"
    return progress_of(file if file.is_dir() else folder).sentence


def _parts_of(out: Path) -> Path:
    return out.with_name(f"{out.name}.parts")


def _read_or_make(
    robot: Robot, task: Task, plan: Plan, out: Path | None, budget: int, engine: Engine, tell: Report
) -> Covering:
    """The covering of a plan: that of the file, where one is finished there; else made, and written there."""
    kept = None if out is None else _finished_covering(out, plan)
    if kept is not None:
        return kept
    folder = None if out is None else _parts_of(out)
    if _is_quick(plan) and engine.scheduler is None:
        engine = HERE
    result = covering(robot, task, plan, folder, budget, engine, tell)
    if result.complete and out is not None and folder is not None:
        write_covering(out, result)
        shutil.rmtree(folder, ignore_errors=True)
    return result


def _finished_covering(out: Path, plan: Plan) -> Covering | None:
    """The finished covering of a file; None where the file is missing or empty, or of another plan."""
    if not out.is_file() or not out.stat().st_size:
        return None
    return load_covering(out, plan)


def _is_quick(plan: Plan) -> bool:
    """Whether a covering takes less time than processes take to begin."""
    most = _QUICK if plan.method == SPLIT else _QUICK_BY_ENCLOSURES
    return plan.shape.leaves <= most


def covering(
    robot: Robot, task: Task, plan: Plan, folder: Path | None = None, budget: int = BUDGET,
    engine: Engine = HERE, tell: Report = lambda label, done, total: None,
) -> Covering:  # fmt: skip
    """The covering of a plan, chunk by chunk.

    Ended by Ctrl-C, or where the budget is spent: the chunks that are there then, of a budget as many as it pays. Not
    begun where the budget is far too small, by an estimate of the work.
    """
    batches: dict[int, Batch] = {}
    count, shape, spent = chunks_of(plan), plan.shape, 0
    needed = 0
    if not _is_quick(plan):
        needed = estimate(robot, task, plan)
    if needed > _FAR * budget:
        return put_together(plan, batches, CoveringEnd.BUDGET_TOO_SMALL, needed)
    label = covering_label(needed)

    def each(chunk: int, content: bytes) -> None:
        nonlocal spent
        batches[chunk] = batch_from_bytes(content, shape)
        spent += _cost(plan, batches[chunk])
        if spent > budget:
            raise BudgetSpent

    record = robot_to_dict(robot, task, plan.rank)
    job_plan = {"robot": record, "length_scale": task.length_scale, "covering": plan.entries()}
    job = Job("covering", "rankdrop.verbs.covering:part", job_plan, count, shape.trees, ".boxes")
    try:
        for _ in finish(job, engine, folder=folder, each=each, report=lambda done, total: tell(label, done, total)):
            pass
    except KeyboardInterrupt:
        return put_together(plan, batches, CoveringEnd.INTERRUPTED, needed)
    except BudgetSpent:
        return put_together(plan, _paid(job, batches, plan, budget), CoveringEnd.BUDGET_SPENT, needed)
    return put_together(plan, batches, needed=needed)


def _cost(plan: Plan, batch: Batch) -> int:
    if plan.method == SPLIT:
        return 0
    return batch[2]


def _paid(job: Job, batches: dict[int, Batch], plan: Plan, budget: int) -> dict[int, Batch]:
    """The first chunks that a budget pays for, whichever of them happened to be made before it was spent."""
    paid: dict[int, Batch] = {}
    for chunk in range(job.chunks):
        if chunk in batches:
            batch = batches[chunk]
        else:
            batch = batch_from_bytes(part(job.plan, chunk), plan.shape)
        budget -= _cost(plan, batch)
        if budget < 0:
            break
        paid[chunk] = batch
    return paid


def part(plan: Record, chunk: int) -> bytes:
    """One chunk of a covering, as workers make it.

    Raises:
        OptionError: it alone takes more than `BUDGET` enclosures.
    """
    robot, task = _decode_question(json.dumps([plan["robot"], plan["length_scale"]]))
    try:
        return batch_to_bytes(chunk_of(robot, task, plan_from_entries(plan["covering"]), chunk, threads=1))
    except BudgetSpent as error:
        raise OptionError("a part of the covering takes too many enclosures", where="width",
                          got=plan["covering"]["width"], allowed=f"at most {BUDGET:,}",
                          mend="take a larger width") from error  # fmt: skip


@lru_cache(1)
def _decode_question(text: str) -> tuple[Robot, Task]:
    record, length_scale = json.loads(text)
    return robot_from_dict(record), task_from_dict(record, length_scale)


def _account(
    covering: Covering, robot: Robot, task: Task, families: tuple[Family, ...], source: str, threads: int, tell: Report
) -> Account:
    scale = joint_scale(robot, task)
    explainer = FamilyBoxes(covering, robot, families, scale)
    by_families, left, proven = explainer.families_of_all(lambda done, total: tell("boxes explained", done, total))
    open_ = np.flatnonzero(~proven)
    judged, by = classify_boxes(
        robot, task, covering, left[open_], threads=threads,
        near=lambda parts, halvings: FamilyBoxes(covering, robot, families, scale, halvings).families_of(parts),
    )  # fmt: skip
    proven = proven.copy()
    proven[open_] = judged == 1
    stays = np.ones(len(left), dtype=np.bool_)
    stays[open_] = (judged == 1) | (judged == 2)
    explained = by_families + np.bincount(by[judged == 3], minlength=len(families))
    groups = spots(covering, robot, task, left[stays], proven[stays])
    return Account(families, source, explained, int((judged == 0).sum()), groups, explainer.diagonal)
