"""One verb: from a robot to every family of its singularities, with the exact conditions beside what was found."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from rankdrop.compare.comparison import (
    AGREES,
    ASKED,
    DIFFERS,
    INTERRUPTED,
    NOT_DERIVED,
    Comparison,
    ExactRow,
    Match,
    in_exact_terms,
    match,
)
from rankdrop.errors import OptionError, RankdropError
from rankdrop.exact.family import ExactFamily
from rankdrop.families.searching import check_numbers, search
from rankdrop.families.share import check_within, near_shares
from rankdrop.families.table import families, posed
from rankdrop.family.record import CorankFamilies, family_out_of_units
from rankdrop.kinematics import check_robot
from rankdrop.local.block import generic_rank
from rankdrop.problem import Problem
from rankdrop.results.analysis import Analysis, Settings
from rankdrop.results.conditions import Conditions
from rankdrop.results.known import known_conditions
from rankdrop.robot.model import Robot
from rankdrop.task import Task, resolve_task, task_names
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_units, task_in_units
from rankdrop.version import VERSION

SECONDS: Mapping[str, float] = {"auto": 30.0, "on": 120.0}
"""Limits on the processor's time, three times those on work: most arms of the catalogue need 0.02 to 4 s."""


def check_exact(exact: str) -> None:
    """Refuse what cannot be asked for.

    Raises:
        OptionError: neither auto, on nor off.
    """
    if exact not in ASKED:
        raise OptionError("there is no such choice", where="exact", got=repr(exact), allowed=", ".join(ASKED))


def join(
    robot: Robot,
    task: Task,
    generic_rank: int,
    found: Sequence[CorankFamilies],
    *,
    exact: str = "auto",
    limits: bool = False,
    seed: int = 0,
    fresh: bool = False,
    progress: Callable[[str, int, int], None] | None = None,
    tolerances: Tolerances = DEFAULT,
) -> tuple[list[CorankFamilies], Comparison | None]:
    """Derive the families of every corank by the rank tree, and match them with those found numerically.

    Rows that go together with exact families take their partition, ids and names (`partition`). The families of the
    catalogue's arms are shipped, and then taken from there.

    Args:
        robot, task, generic_rank: of the analysis.
        found: its families, of every corank that there is, of `in_units(robot)`.
        exact: "auto", where python-flint is installed, the arm can be treated, and time allows; "on", required; "off".
        limits: the families are those within the joint limits.
        seed: of every random choice.
        fresh: derive them even where the conditions of this arm are shipped; those have the same families.
        progress: called as progress(label, done, total).
        tolerances: of the analysis.

    Returns:
        The families of every corank, and Comparison, or None for "off". A derivation that was not finished leaves no
        families behind.

    Raises:
        OptionError: no such choice.
        MissingExtraError, RobotError: with "on", python-flint is not installed, or the arm cannot be treated.
    """
    check_exact(exact)
    rows = tuple(row for one in found for row in one.families)
    if exact == "off":
        return list(found), None
    seconds = SECONDS[exact]
    try:
        derived = None if fresh or seed else known_conditions(robot, task)
        if derived is None:
            from rankdrop.verbs.conditions import conditions  # with all of the exact side that derives

            derived = conditions(
                robot, task, method="tree", seconds=seconds, seed=seed, points=0, special=False, progress=progress
            )
    except RankdropError as error:
        if exact == "on":
            raise
        return list(found), Comparison(NOT_DERIVED, exact, seconds, str(error))
    except KeyboardInterrupt:
        return list(found), Comparison(NOT_DERIVED, exact, seconds, INTERRUPTED)
    if not derived.complete:
        out_of_time = derived.seconds >= seconds
        reason = f"the derivation takes more than {seconds:g} s" if out_of_time else "; ".join(derived.left)
        return list(found), Comparison(NOT_DERIVED, exact, seconds, reason)
    families = [family.in_units(robot) for family in derived.families]
    problem = Problem(in_units(robot), task_in_units(task, robot), tolerances=tolerances, limits=limits)
    agreement = match(problem, rows, families, seed=seed)
    parted: list[CorankFamilies] = []
    matches: list[Match] = []
    now: dict[str, str] = {}
    for one in found:
        corank = one.summary.corank
        exactly = [family for family in families if family.corank == corank]
        here, there, called = in_exact_terms(problem.at(corank), one, exactly, agreement, seed)
        parted.append(here)
        matches += there
        now |= called
    differences = [
        str(replace(one, family=now[one.family]) if one.side == "numeric" else one) for one in agreement.differences
    ]
    disagreements = (*_ranks(derived, generic_rank), *differences)
    return parted, Comparison(
        status=DIFFERS if disagreements else AGREES,
        asked=exact,
        seconds=seconds,
        letters=dict(derived.letters),
        shifts=derived.shifts,
        families=tuple(_row(family, robot) for family in derived.families),
        matches=tuple(matches),
        numeric=agreement.numeric,
        exact=agreement.exact,
        disagreements=disagreements,
        wider=agreement.wider,
    )


def _ranks(derived: Conditions, generic_rank: int) -> list[str]:
    """What ranks modulo a prime say against the derivation, or σ at random configurations."""
    said = list(derived.disagreements)
    if derived.generic_rank != generic_rank:
        said.append(f"the rank is {derived.generic_rank} almost everywhere exactly, {generic_rank} numerically")
    return said


def _row(family: ExactFamily, robot: Robot) -> ExactRow:
    return ExactRow(
        id=family.id,
        name=family.name,
        corank=family.corank,
        dimension=family.dimension,
        pinned=family.pinned(robot),
        conditions=family.texts,
        latex=family.latex,
        reality=family.reality,
    )


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
    comparison = near = None
    if unfinished is None:
        found, comparison = join(
            robot, resolved, rank, found, exact=exact, limits=limits, seed=seed, fresh=fresh, tolerances=tolerances,
            progress=_prefixed(progress, "exact"),
        )  # fmt: skip
    rows = tuple(family_out_of_units(family, robot) for one in found for family in one.families)
    rows = tuple(posed(robot, resolved, row, rows) for row in rows)
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
        exact=comparison,
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
