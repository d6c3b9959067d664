"""One verb: from a robot to every family of its singularities, derived exactly where that can be done, and sampled."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import starmap
from typing import TYPE_CHECKING, Any

from rankdrop.distance.share import JointSpaceShares, SlowShare, check_within, near_shares, slower_than
from rankdrop.errors import OptionError, RankdropError
from rankdrop.exact.family import derived_in_units
from rankdrop.families.contradiction import Contradiction, ContradictionKind
from rankdrop.families.corank_families import CorankFamilies
from rankdrop.families.derivation import AGREES, DIFFERS, NOT_DERIVED, Derivation
from rankdrop.families.descent import DIGITS, FOLLOWED
from rankdrop.families.not_derived import NotDerived, NotDerivedKind
from rankdrop.families.pictured import pose_witness
from rankdrop.families.record import Family
from rankdrop.families.rescaling import family_out_of_units
from rankdrop.families.searching import search
from rankdrop.families.speed_distance import SpeedDistances
from rankdrop.families.table import families
from rankdrop.kinematics import check_robot
from rankdrop.lists import flat_map
from rankdrop.local.block import generic_rank
from rankdrop.options import takes
from rankdrop.problem import Problem
from rankdrop.questions import AnalyzeOptions
from rankdrop.results.analysis import Analysis, Settings
from rankdrop.results.aspect_summary import AspectSummary
from rankdrop.results.conditions import Conditions
from rankdrop.results.known import known_aspects
from rankdrop.results.stored_conditions import known_conditions
from rankdrop.robot.model import Robot
from rankdrop.task import WORLD_ALIGNED, Task, resolve_task, task_names
from rankdrop.text.derivation import mistaken_text
from rankdrop.text.families import SPEEDS_INTERRUPTED
from rankdrop.text.tested import rank_note
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_units, task_in_units
from rankdrop.version import VERSION

if TYPE_CHECKING:
    from rankdrop.cover.speed import SpeedRegion

SECONDS: Mapping[str, float] = {"auto": 30.0, "on": 120.0}
"""Limits as `--time-limit` has them, counted in work: most arms of the catalogue need 0.02 to 4 s."""
SAMPLED, TESTED = 10_000, 2_000
"""Random starts for each corank where nothing was derived, and where they test derived families."""
_TOO_LONG = (NotDerivedKind.TIME, NotDerivedKind.UNDIVIDED, NotDerivedKind.UNFINISHED)

Progress = Callable[[str, int, int], None]
"""progress(label, done, total), label such as "corank 2: search"."""


def derive(
    robot: Robot, task: Task, *, exact: str, seed: int, fresh: bool, progress: Progress | None
) -> tuple[Conditions | None, Derivation | None]:
    """Derive the families of every corank by the rank tree; those of the catalogue's arms are shipped, and taken.

    Args:
        robot, task: the arm.
        exact: "auto", where python-flint is installed, the arm can be treated, and time allows; "on", required; "off".
        seed: of every random choice.
        fresh: derive them even where the conditions of this arm are shipped; those have the same families.
        progress: called as progress(label, done, total).

    Returns:
        What was derived completely, or None; and the record of the derivation, not tested yet, or None for "off".

    Raises:
        MissingExtraError, RobotError: with "on", python-flint is not installed, or the arm cannot be treated.
    """
    if exact == "off":
        return None, None
    seconds = SECONDS[exact]
    derived, reason = _derive(robot, task, exact, seconds, seed=seed, fresh=fresh, progress=progress)
    if derived is None:
        return None, Derivation(NOT_DERIVED, exact, seconds, reason)
    return derived, Derivation(
        AGREES, exact, seconds, letters=dict(derived.letters), shifts=derived.shifts,
    )  # fmt: skip


def _derive(
    robot: Robot, task: Task, exact: str, seconds: float, *, seed: int, fresh: bool, progress: Progress | None
) -> tuple[Conditions | None, NotDerived | None]:
    """The complete derivation, shipped or made now; else None and why there is none."""
    try:
        derived = _shipped_or_made(robot, task, seconds, seed=seed, fresh=fresh, progress=progress)
    except RankdropError as error:
        if exact == "on":
            raise
        return None, NotDerived(NotDerivedKind.ERROR, message=str(error))
    except KeyboardInterrupt:
        return None, NotDerived(NotDerivedKind.INTERRUPTED)
    except Exception as error:  # the sampled result does not depend on the derivation
        return None, NotDerived(NotDerivedKind.ERROR, error=type(error).__name__, message=str(error))
    if derived.interrupted:
        return None, NotDerived(NotDerivedKind.INTERRUPTED)
    if derived.in_families:
        return derived, None
    return None, _why_incomplete(derived, seconds)


def _why_incomplete(derived: Conditions, seconds: float) -> NotDerived:
    """Why not all singular configurations are on derived families."""
    if derived.undivided:
        return NotDerived(NotDerivedKind.UNDIVIDED, number=len(derived.undivided))
    if derived.limited:
        return NotDerived(NotDerivedKind.TIME, seconds=seconds)
    return NotDerived(NotDerivedKind.UNFINISHED, unfinished=derived.left)


def _shipped_or_made(
    robot: Robot, task: Task, seconds: float, *, seed: int, fresh: bool, progress: Progress | None
) -> Conditions:
    """The conditions that are shipped; else, or where they are wanted anew, by the rank tree alone, untested."""
    if not (fresh or seed):
        shipped = known_conditions(robot, task, any_tip=True)
        if shipped is not None:
            return shipped
    from rankdrop.verbs.conditions import conditions  # with all of the exact side that derives

    return conditions(
        robot, task, method="tree", seconds=seconds, seed=seed, points=0, special=False, progress=progress
    )  # fmt: skip


def _compare_with_tables(
    derivation: Derivation | None, derived: Conditions | None, rank: int, tables: Sequence[CorankFamilies], *,
    limits: bool,
) -> Derivation | None:  # fmt: skip
    """The derivation tested against the tables, where anything was derived."""
    if derivation is None or derived is None:
        return derivation
    return _test_derivation(derivation, derived, rank, tables, limits=limits)


def _test_derivation(
    derivation: Derivation, derived: Conditions, rank: int, tables: Sequence[CorankFamilies], *, limits: bool
) -> Derivation:
    contradictions = list(derived.disagreements)
    if derived.generic_rank != rank:
        contradictions.append(Contradiction(ContradictionKind.GENERIC_RANK, full_rank=derived.generic_rank, rank=rank))
    contradictions += starmap(_by_points, flat_map(lambda table: table.contradictions, tables))
    listed = {family.id for family in flat_map(lambda table: table.families, tables)}
    if not limits:  # within them a family without a point is no family
        contradictions += (_not_listed(family, rank) for family in derived.families if family.id not in listed)
    if contradictions:
        return replace(derivation, status=DIFFERS, disagreements=tuple(contradictions))
    return replace(derivation, status=AGREES, disagreements=())


def _by_points(family: Family, dimension: int | None) -> Contradiction:
    """A derived family that points solved on it contradict; `dimension` is None where no point has its corank."""
    if dimension is None:
        return Contradiction(ContradictionKind.NO_POINT, family=family.id, called=family.called)
    return Contradiction(
        ContradictionKind.DIMENSION, family=family.id, called=family.called, dimension=dimension
    )  # fmt: skip


def _not_listed(family: Family, rank: int) -> Contradiction:
    """A derived family of a corank that the search does not reach; `rank` is the generic rank that it found."""
    return Contradiction(
        ContradictionKind.NOT_LISTED, family=family.id, called=family.called, corank=family.corank, rank=rank
    )  # fmt: skip


@takes(AnalyzeOptions)
def analyze(
    robot: Robot,
    task: str | Task | None = None,
    options: AnalyzeOptions | None = None,
    *,
    length_scale: float | None = None,
    progress: Progress | None = None,
    tolerances: Tolerances = DEFAULT,
    **given: Any,
) -> Analysis:
    """Find every family of singular configurations of every corank.

    Where it can be done in the time allowed, the families are derived exactly: `Analysis.exact`; where it cannot, those
    of corank 1 are, from det J, if that can be done. For corank k = 1, 2, …
    random configurations are driven into rank J ≤ generic rank − k (block Levenberg–Marquardt), and test the
    families in both directions: points solved on a family are singular, fresh singular points lie on a family. Where
    nothing was derived, conditions are fitted to the points. It ends with the first corank that no start and no family
    reaches; that corank is reported too. Without a derivation not finding is not a proof of absence.

    Ctrl-C does not lose the work: the coranks already done come back with `complete=False`.

    Args:
        robot: the arm.
        task: name, rows or Task; None is the task the arm is made for.
        options: starts, seed, limits, exact, fresh, threads and within; or its fields as keywords.
        length_scale: translation rows are divided by it [m]; None is that of the task, else the arm's reach.
        progress: called as progress(label, done, total).
        tolerances: thresholds, recorded in the result.
        given: fields of the options.

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
    how = AnalyzeOptions.of(options, given)
    if how.within is not None:
        check_within(how.within)
    resolved = resolve_task(task, robot, length_scale=length_scale)
    region = _region(robot, resolved, how)
    report = progress or _silent
    scaled = in_units(robot), task_in_units(resolved, robot)  # in the unit of length that is the arm's own
    rank = generic_rank(*scaled)
    derived, derivation, known = _derived_families(robot, resolved, how, report)
    starts = _starts(how, derived)
    tables: list[CorankFamilies] = []
    complete = derivation is None or not derivation.interrupted
    if complete:
        tables, complete = _finish_tables(_tables(*scaled, rank, known, how, starts, tolerances, report))
    rows = _list_families(robot, resolved, tables)
    near = None
    if complete:
        problem = Problem(robot, resolved, limits=how.limits)
        derivation = _compare_with_tables(derivation, derived, rank, tables, limits=how.limits)
        near = _shares_near(problem, rows, how, report)
    else:
        rows = _without_exact(rows)  # nothing is said about the derivation
    speeds, slow, unmade = _speeds(region, rows, how.seed, report, complete=complete)
    return Analysis(
        robot=robot,
        task=replace(resolved, length_scale=resolved.scale(robot)),
        generic_rank=rank,
        settings=Settings(how.seed, starts, how.limits, float(resolved.scale(robot)), tolerances, VERSION),
        coranks=tuple(table.summary for table in tables),
        families=rows,
        complete=complete,
        unfinished=None if complete else len(tables) + 1,
        notes=(*_rank_notes(robot, resolved, rank), *_mistakes(tables), *unmade),
        exact=derivation if complete else None,
        near=near,
        speeds=speeds,
        slow=slow,
        aspects=_aspects(robot, resolved, asked=how.aspects),
    )


def _without_exact(families: Sequence[Family]) -> tuple[Family, ...]:
    return tuple(replace(family, exact=None) for family in families)


def _shares_near(
    problem: Problem, families: Sequence[Family], how: AnalyzeOptions, report: Progress
) -> JointSpaceShares | None:
    """Shares of the joint space near the families, where they are asked for."""
    if how.within is None:
        return None
    return near_shares(families, problem, how.within, seed=how.seed, progress=partial(report, "shares"))


def _derived_families(
    robot: Robot, task: Task, how: AnalyzeOptions, report: Progress
) -> tuple[Conditions | None, Derivation | None, dict[int, list[Family]]]:
    """What was derived of all coranks, the record of it, and the families of each corank that was derived."""
    derived, derivation = derive(
        robot, task, exact=how.exact, seed=how.seed, fresh=how.fresh,
        progress=lambda label, done, total: report(f"exact: {label}", done, total),
    )  # fmt: skip
    if derived is not None:
        return derived, derivation, _families_by_corank(derived, robot, task)
    first = _first_corank(robot, task, how, derivation)
    if first is None or derivation is None:
        return None, derivation, {}
    tested = [replace(derived_in_units(family, robot), exact=None) for family in first.families]
    return None, replace(derivation, first_derived=True), {1: tested}


def _families_by_corank(derived: Conditions, robot: Robot, task: Task) -> dict[int, list[Family]]:
    """The derived families of every corank, in the arm's own unit of length."""
    by_corank: dict[int, list[Family]] = {corank: [] for corank in range(1, task.m + 1)}
    for family in derived.families:
        by_corank.setdefault(family.corank, []).append(derived_in_units(family, robot))
    return by_corank


def _first_corank(
    robot: Robot, task: Task, how: AnalyzeOptions, derivation: Derivation | None
) -> Conditions | None:  # fmt: skip
    """The conditions of corank 1, where those of higher coranks take too long: det J says more of them than a fit."""
    if derivation is None or derivation.reason is None or derivation.reason.kind not in _TOO_LONG:
        return None
    from rankdrop.verbs.conditions import conditions  # with all of the exact side that derives

    try:
        first = conditions(
            robot, task, method="tree", coranks=1, seconds=SECONDS[how.exact], seed=how.seed, points=0, special=False
        )  # fmt: skip
    except RankdropError:
        return None
    if first.in_families and not first.disagreements:
        return first
    return None


def _starts(how: AnalyzeOptions, derived: Conditions | None) -> int:
    """Random starts for each corank: as many as were asked for, else fewer where they only test derived families."""
    if how.starts is not None:
        return how.starts
    if derived is None:
        return SAMPLED
    return TESTED


def _finish_tables(tables: Iterator[CorankFamilies]) -> tuple[list[CorankFamilies], bool]:
    """The tables of the coranks that were done, and whether Ctrl-C let all of them be done."""
    done: list[CorankFamilies] = []
    try:
        for table in tables:
            done.append(table)
    except KeyboardInterrupt:
        return done, False
    return done, True


def _list_families(robot: Robot, task: Task, tables: Sequence[CorankFamilies]) -> tuple[Family, ...]:
    """All families as the analysis lists them, in the arm's own unit of length."""
    listed = flat_map(lambda table: table.families, tables)
    rows = tuple(family_out_of_units(family, robot) for family in listed)
    return tuple(pose_witness(robot, task, row, rows) for row in rows)


def _aspects(robot: Robot, task: Task, *, asked: bool) -> AspectSummary | None:
    """The number of aspects with the verdict: stored for arms of the catalogue, else found where it is asked for."""
    known = known_aspects(robot, task)
    if known is None and asked:
        from rankdrop.aspects.verdict import judged_summary  # half a second that most analyses do not need

        return judged_summary(robot, task)
    return known


def _region(robot: Robot, task: Task, how: AnalyzeOptions) -> SpeedRegion | None:
    """Where a speed is to be kept; None where none is asked for.

    Raises:
        OptionError: the posture is a text, which only the command line reads; or no speed can be kept.
    """
    if how.speed is None:
        return None
    from rankdrop.cover.speed import SpeedRegion  # with the enclosures, which no other analysis needs

    if isinstance(how.around, str):
        raise OptionError("a posture is a list of joint values", where="around", got=how.around,
                          allowed="[q1, q2, …] [rad, m]")  # fmt: skip
    return SpeedRegion(robot, task, how.speed, around=how.around, span=how.span)


def _speeds(
    region: SpeedRegion | None, families: Sequence[Family], seed: int, report: Progress, *, complete: bool
) -> tuple[SpeedDistances | None, SlowShare | None, tuple[str, ...]]:
    """The distances that keep a speed, the share of slower configurations, and a note where Ctrl-C ended that work."""
    if region is None or not complete:
        return None, None, ()
    try:
        slow = slower_than(Problem(region.robot, region.task), region.speed, seed=seed)
        return speed_distances(region, families, progress=partial(report, "speeds")), slow, ()
    except KeyboardInterrupt:
        return None, None, (SPEEDS_INTERRUPTED,)


def speed_distances(
    region: SpeedRegion, families: Sequence[Family], progress: Callable[[int, int], None] | None = None
) -> SpeedDistances:
    """How far from each family of the smallest corank a speed is kept, in the measure of the family.

    Families without a measure (several conditions on several joints, slides) are listed by their ids.
    """
    smallest = min((family.corank for family in families), default=0)
    distances, others = [], []
    largest = [family for family in families if family.corank == smallest]
    for done, family in enumerate(largest):
        if progress is not None:
            progress(done, len(largest))
        distance = region.distance_from(family)
        if distance is None:
            others.append(family.id)
        else:
            distances.append(distance)
    return SpeedDistances(
        region.speed, tuple(map(float, region.given)), region.span, region.free, tuple(distances), tuple(others)
    )


def _tables(
    robot: Robot, task: Task, rank: int, known: Mapping[int, Sequence[Family]], how: AnalyzeOptions, starts: int,
    tolerances: Tolerances, report: Progress,
) -> Iterator[CorankFamilies]:  # fmt: skip
    """The families of each corank, tested by a search, down to the first corank that no start and no family reaches.

    Args:
        known: corank -> its derived families; those of a corank that is not in it are fitted to points.
        robot, task, rank, how, starts, tolerances, report: as in `analyze`.

    Raises:
        KeyboardInterrupt: Ctrl-C during a search, or between two.
    """
    for corank in range(1, rank + 1):
        cloud = search(
            robot, corank, task=task, starts=starts, seed=how.seed, limits=how.limits, threads=how.threads,
            progress=partial(report, f"corank {corank}: search"), tolerances=tolerances,
        )  # fmt: skip
        if not cloud.complete:
            raise KeyboardInterrupt  # the core met Ctrl-C and handed over what it had
        found = families(
            cloud, known=known.get(corank), seed=how.seed, threads=how.threads,
            progress=partial(report, f"corank {corank}: families"),
        )  # fmt: skip
        yield found
        if found.summary.converged == 0 and not any(families_of for at, families_of in known.items() if at > corank):
            return


def _mistakes(tables: Sequence[CorankFamilies]) -> tuple[str, ...]:
    return tuple(
        mistaken_text(table.summary.corank, table.mistaken, min(table.mistaken, FOLLOWED), table.lowest, DIGITS)
        for table in tables if table.mistaken
    )  # fmt: skip


def _silent(label: str, done: int, total: int) -> None:
    """Progress that nobody asked for."""


def _rank_notes(robot: Robot, task: Task, rank: int) -> tuple[str, ...]:
    if rank == task.m:
        return ()
    served = [name for name in task_names() if _serves(robot, name, task, rank)]
    return (rank_note(task, robot.n, rank, served),)


def _serves(robot: Robot, name: str, task: Task, rank: int) -> bool:
    plain = resolve_task(name, robot)
    other = replace(plain, frame=task.frame, length_scale=task.length_scale)
    return plain.frame == WORLD_ALIGNED and other.m <= rank and generic_rank(robot, other) == other.m
