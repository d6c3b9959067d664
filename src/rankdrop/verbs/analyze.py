"""One verb: from a robot to every family of its singularities."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from rankdrop._handles import check_robot
from rankdrop.families.searching import check_numbers, search
from rankdrop.families.share import check_within, near_shares
from rankdrop.families.table import families
from rankdrop.family.record import CorankFamilies, family_out_of_units
from rankdrop.local.block import generic_rank
from rankdrop.results.analysis import Analysis, Settings
from rankdrop.robot.model import Robot
from rankdrop.task import Task, resolve_task, task_names
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_units, task_in_units
from rankdrop.verbs.join import check_exact, join
from rankdrop.version import VERSION

Progress = Callable[[str, int, int], None]
"""progress(label, done, total), label such as "corank 2: search"."""


def analyze(
    robot: Robot,
    task: str | Task | None = None,
    *,
    starts: int = 10_000,
    seed: int = 0,
    limits: bool = False,
    exact: str = "auto",
    fresh: bool = False,
    threads: int = 0,
    length_scale: float | None = None,
    within: float | None = None,
    progress: Progress | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Analysis:
    """Find every family of singular configurations of every corank.

    For corank k = 1, 2, …: drive `starts` random configurations into rank J ≤ generic rank − k (block
    Levenberg–Marquardt), then turn the cloud into families with their conditions, checked on fresh points. It ends
    with the first corank that no start reaches; that corank is reported too. Not finding is not a proof of absence.

    Beside it the families are derived exactly, where that is possible in the time allowed, and the two are compared:
    `Analysis.exact`. Both know nothing of each other.

    Ctrl-C does not lose the work: the coranks already done come back with `complete=False`.

    Args:
        robot: the arm.
        task: name, rows or Task; None is the task the arm is made for.
        starts: random starts for each corank.
        seed: of every random choice; same seed, same result, on any number of threads.
        limits: stay within the joint limits; otherwise the whole torus.
        exact: "auto", exact conditions where python-flint is installed and 10 s of work are enough; "on", required, 40
            s of work; "off". By the clock three times as long.
        fresh: derive them even where the exact conditions of this arm are shipped with rankdrop.
        threads: of the core; 0 uses every processor.
        length_scale: translation rows are divided by it [m]; None is that of the task, else the arm's reach.
        within: share of the joint space (inside the limits with `limits`) at most so far from each family [rad]:
            `Analysis.near`; None: not asked for.
        progress: called as progress(label, done, total).
        tolerances: thresholds, recorded in the result.

    Returns:
        Analysis with one summary per corank and all families.

    Raises:
        RobotError: not a Robot.
        TaskError: the task does not exist, or the length scale is not positive.
        OptionError: an option outside what is allowed.
        MissingExtraError: exact conditions are required, and python-flint is not installed.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = analyze(open_robot("planar3r"), starts=200)
        >>> [(family.corank, family.dimension) for family in found.families]
        [(1, 2)]
    """
    check_robot(robot)
    check_exact(exact)
    if within is not None:
        check_within(within)
    starts, seed, threads = check_numbers(starts, seed, threads)
    resolved = resolve_task(task, robot, length_scale=length_scale)
    own, task_here = in_units(robot), task_in_units(resolved, robot)  # in the unit of length that is the arm's own
    rank = generic_rank(own, task_here)
    found: list[CorankFamilies] = []
    unfinished: int | None = None
    for corank in range(1, rank + 1):
        try:
            cloud = search(
                own, corank, task=task_here, starts=starts, seed=seed, limits=limits, threads=threads,
                progress=_labelled(progress, f"corank {corank}: search"), tolerances=tolerances,
            )  # fmt: skip
            if not cloud.complete:
                raise KeyboardInterrupt  # the core met Ctrl-C and handed over what it had
            found.append(
                families(
                    cloud, seed=seed, tolerances=tolerances, threads=threads,
                    progress=_labelled(progress, f"corank {corank}: families"),
                )
            )
        except KeyboardInterrupt:
            unfinished = corank
            break
        if found[-1].summary.converged == 0:
            break
    joined = near = None
    if unfinished is None:
        found, joined = join(
            robot, resolved, rank, found, exact=exact, limits=limits, seed=seed, fresh=fresh, tolerances=tolerances,
            progress=_prefixed(progress, "exact"),
        )  # fmt: skip
    rows = tuple(family_out_of_units(family, robot) for one in found for family in one.families)
    if unfinished is None and within is not None:
        near = near_shares(rows, robot, resolved, within, limits=limits, seed=seed,
                           progress=_labelled(progress, "shares"))  # fmt: skip
    return Analysis(
        robot=robot,
        task=replace(resolved, length_scale=resolved.scale(robot)),
        generic_rank=rank,
        settings=Settings(seed, starts, limits, float(resolved.scale(robot)), tolerances, VERSION),
        coranks=tuple(one.summary for one in found),
        families=rows,
        complete=unfinished is None,
        unfinished=unfinished,
        notes=_rank_notes(robot, resolved, rank),
        exact=joined,
        near=near,
    )


def _labelled(progress: Progress | None, label: str) -> Callable[[int, int], None] | None:
    if progress is None:
        return None
    return lambda done, total: progress(label, done, total)


def _prefixed(progress: Progress | None, label: str) -> Progress | None:
    if progress is None:
        return None
    return lambda inner, done, total: progress(f"{label}: {inner}", done, total)


def _rank_notes(robot: Robot, task: Task, rank: int) -> tuple[str, ...]:
    """Say so when the arm is singular for the task at every configuration, or has too few joints for it."""
    if rank == task.m:
        return ()
    if rank < min(task.m, robot.n):
        note = (
            f"always singular for the task {task.name}: the rank is {rank} at every configuration, "
            f"{min(task.m, robot.n)} would be full"
        )
    else:
        joints = "1 joint" if robot.n == 1 else f"{robot.n} joints"
        note = f"the task {task.name} has {task.m} rows and the arm {joints}: the rank is {rank} at most"
    served = [name for name in task_names() if _serves(robot, name, task, rank)]
    tasks = f"; tasks it can do in full: {', '.join(served)}" if served else ""
    return (f"{note}; corank is counted from rank {rank}{tasks}",)


def _serves(robot: Robot, name: str, task: Task, rank: int) -> bool:
    other = resolve_task(name, robot, frame=task.frame, length_scale=task.length_scale)
    return other.m <= rank and generic_rank(robot, other) == other.m
