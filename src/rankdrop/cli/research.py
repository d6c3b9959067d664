"""The commands find, aspects, through and tolerant: configurations of a corank, changes of posture, paths, failures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from math import degrees
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from cyclopts import Parameter

from rankdrop import aspects as postures
from rankdrop import families, local, results, text, verbs
from rankdrop import path as paths
from rankdrop.cli import exits
from rankdrop.cli.command import DRAWN, OUTPUT, PROGRESS, Done, Output, command
from rankdrop.cli.opening import NO_OPTIONS, ROBOT, ArmOptions, arm_section, open_arm, starts_line
from rankdrop.cli.targets import write_text
from rankdrop.cli.terminal import STDOUT, say
from rankdrop.cli.values import Q, numbers_of, parse_configuration
from rankdrop.codec import record_of
from rankdrop.errors import OptionError
from rankdrop.options import Options, option
from rankdrop.questions import AspectsOptions, SearchOptions, TolerantOptions
from rankdrop.sections import Section

if TYPE_CHECKING:
    from rankdrop.cli.terminal import Block
    from rankdrop.robot import Robot
    from rankdrop.task import Task


_SHOWN = 5


@dataclass(frozen=True)
class Where(Options):
    """Which corank, where the search starts, and where its configurations go."""

    corank: Annotated[int, option("How many directions the tool loses: generic rank minus rank")]
    start: Annotated[
        str | None, option("One start in place of the random ones: a configuration (as for explain --q), or the number "
                    "that --out and --json give to a random one")
    ] = None  # fmt: skip
    deg: Annotated[bool, option("Angles of --start without a unit are in degrees")] = False
    out: Annotated[
        str | None, option("Write every start's outcome to this file: .csv, .json or .npz",
                           writes=(".csv", ".json", ".npz"))
    ] = None  # fmt: skip
    history: Annotated[
        str | None, option("Write the singular values of every iteration to this file: .csv or .npz",
                           writes=(".csv", ".npz"))
    ] = None  # fmt: skip
    store: Annotated[
        str | None, option("Keep the configurations as partitioned Parquet in this folder, a part in memory at a time; "
                    "after an interruption run the same command to continue")
    ] = None  # fmt: skip
    workers: Annotated[int, option("With --store: local processes; 0: one for every processor", ge=0)] = 0
    scheduler: Annotated[
        str | None, option("With --store: address of a Dask scheduler; its workers do the work (tcp://HOST:8786)")
    ] = None


@command
def find(
    robot: ROBOT,
    /,
    *,
    where: Where,
    options: SearchOptions = SearchOptions(),
    arm: ArmOptions = NO_OPTIONS,
    output: Output = OUTPUT,
    report: PROGRESS,
) -> Done | int:
    """Find singular configurations of one corank.

    For example:
        rankdrop find pa10 --corank 3
        rankdrop find ur5 --corank 2 --starts 1000 --out corank2.csv
        rankdrop find pa10 --corank 2 --method almarkhi --history figure.csv
        rankdrop find pa10 --corank 1 --method reciprocal --starts 100000 --out exact.npz
        rankdrop find pa10 --corank 3 --method gradient --seed 2 --start 269 --length-scale 1
        rankdrop find ur5 --corank 1 --starts 10_000_000 --store cloud
    """
    begun = monotonic()
    model, task = open_arm(robot, arm)
    if where.store is not None:
        return _store_rows(model, task, where.store, options, where, output, report)
    result = _search(model, task, options, where, report)
    seconds = monotonic() - begun

    def blocks() -> Iterator[Block]:
        yield [_answer(result)]
        yield arm_section(model, task, result.rank + result.corank, _starts(result, where.start) | _method(result))
        yield _outcome(result, seconds) if result.stratum is None else _draws_section(result, seconds)

    return Done(
        blocks,
        {"json": lambda: record_of("find", result), "out": lambda: _outcomes(result, str(where.out)),
         "history": lambda: _history(result, str(where.history))},
        complete=result.complete,
    )  # fmt: skip


def _answer(search: families.Search) -> str:
    """Whether there are configurations of this corank, as far as the search shows."""
    name, where = search.robot.name, f"corank {search.corank} (rank {search.rank} of {search.rank + search.corank})"
    if search.stratum is not None:
        return f"{name}: {len(search.q):,} singular configurations of {where} or lower were drawn exactly."
    converged, starts = search.count(families.Outcome.CONVERGED), len(search.q)
    if converged:
        return f"{name} has singular configurations of {where}: {converged:,} of {starts:,} searches end at one."
    return f"{name}: no configuration of {where} in {starts:,} searches. Not finding one proves nothing."


def _search(robot: Robot, task: Task, options: SearchOptions, where: Where, report: Any) -> families.Search:
    rest: dict[str, Any] = {"task": task, "history": where.history is not None,
                            "progress": partial(report, f"corank {where.corank}: search")}  # fmt: skip
    if where.start is None:
        return families.search(robot, where.corank, options, **rest)
    if options.method == "reciprocal":
        raise OptionError("nothing is searched from a start with reciprocal wrenches", where="--start",
                          got=where.start, mend="leave it out")  # fmt: skip
    q0, number = _one_start(where.start, robot, task, options, deg=where.deg)
    return families.refine(robot, [q0], where.corank, options, first=number, **rest)


def _store_rows(
    robot: Robot, task: Task, store: str, options: SearchOptions, where: Where, output: Output, report: Any
) -> int:
    if options.method != "lm":
        raise OptionError("a cloud is searched by lm", where="--method", got=options.method,
                          mend="leave --method or --store out")  # fmt: skip
    alone = {"--start": where.start, "--iterations": options.iterations, "--out": where.out, "--json": output.json,
             "--history": where.history}  # fmt: skip
    for name, value in alone.items():
        if value is not None:
            raise OptionError("it does not go with --store", where=name, got=value, mend="leave one of them out")
    count = results.store_cloud(
        robot, where.corank, store, task=task, starts=options.starts, seed=options.seed, limits=options.limits,
        workers=where.workers, scheduler=where.scheduler, report=partial(report, f"corank {where.corank}: parts"),
    )  # fmt: skip
    ended = f"{count:,} of {options.starts:,} starts ended at corank {where.corank} or more"
    write_text(f"{ended}: {store}/parts/*.parquet\n", STDOUT)
    return exits.FINE


def _one_start(typed: str, robot: Robot, task: Task, options: SearchOptions, *, deg: bool) -> tuple[list[float], int]:
    """A configuration, and its number from 0 among the random starts (0 for one that is given).

    Raises:
        ConfigurationError: neither one number per joint nor the number of a random start.
        OptionError: no random start has this number.
    """
    from rankdrop.units import in_units, out_of_units, task_in_units

    if robot.n == 1 or not typed.strip().isdecimal():
        return parse_configuration(typed, robot, deg=deg, option="--start"), 0
    number = int(typed) if len(typed) < 12 else 0
    if not 1 <= number <= families.MOST_STARTS:
        raise OptionError("no random start has this number", where="--start", got=number,
                          allowed=f"1 … {families.MOST_STARTS}")  # fmt: skip
    drawn = local.sample(in_units(robot), task_in_units(task, robot), number, options.seed, limits=options.limits)[-1]
    values: list[float] = out_of_units(robot, drawn).tolist()
    return values, number - 1


def _outcomes(search: families.Search, target: str) -> Any:
    """Every start's outcome, as the ending of the file says."""
    if target.lower().endswith(".json"):
        return record_of("find", search)
    if target.lower().endswith(".csv"):
        return results.find_to_csv(search)
    return results.find_to_npz(search)


def _history(search: families.Search, target: str) -> str | bytes | None:
    """Singular values of every iteration; None where the method has none."""
    if search.history is None:
        return None
    to_csv = target.lower().endswith(".csv")
    if to_csv:
        return results.history_to_csv(search.history)
    return results.history_to_npz(search.history)


def _starts(search: families.Search, start: str | None) -> dict[str, str]:
    if start is not None and not start.strip().isdecimal():
        return {"starts": f"one, {start}"}
    if start is None:
        which = f"{len(search.q):,}"
    else:
        which = f"random start {start}"
    return starts_line(which, search.seed, limits=search.limits)


def _method(search: families.Search) -> dict[str, str]:
    if search.method == "reciprocal":
        how = ("every joint in closed form, or some joints by Newton's method" if search.corank == 1
               else "some joints by Newton's method, the others drawn")  # fmt: skip
        return {"method": f"reciprocal wrenches: {how}"}
    words = [search.method]
    if search.method != "lm":
        words.append("line search" if not search.step else f"steps of {search.step:g} of that to linearised zero")
    if search.method == "almarkhi":
        words.append(f"ties below {search.tie:g}" if search.tie else "ties not treated")
    return {"method": ", ".join([*words, f"at most {search.most:,} iterations"])}


def _outcome(search: families.Search, seconds: float) -> Section:
    Outcome = families.Outcome
    counts = {outcome: search.count(outcome) for outcome in Outcome}
    lines = []
    if counts[Outcome.CONVERGED]:
        steps = np.median(search.iterations[search.outcome == Outcome.CONVERGED])
        largest = f"Largest σ{search.rank + 1} of a converged start: {search.residual():.2g}"
        lines.append(f"{largest}; median {steps:.0f} iterations.")
    elif len(search.q) == 1 and search.complete:
        ended = ", ".join(f"{value:.4g}" for value in search.sigma[0, search.rank :])
        lines.append(f"It ended at σ{search.rank + 1} … = {ended} after {search.iterations[0]:,} iterations.")
    if counts[Outcome.CREASE]:
        stuck = f", {counts[Outcome.CREASE]:,} stuck on a crease (a tie, no minimum)"
    else:
        stuck = ""
    rest = f"{counts[Outcome.NEAR_MISS]:,} near misses{stuck}, {counts[Outcome.SLOW]:,} slow."
    if search.smallest_near_miss is not None:
        rest += f" Smallest near miss: σ{search.rank + 1} = {search.smallest_near_miss:.4g}, not singular."
    if not search.complete:
        rest += f" Interrupted: {counts[Outcome.NOT_RUN]:,} starts were not run."
    title = f"Corank {search.corank} (rank {search.rank} of {search.rank + search.corank}): "
    converged = f"{counts[Outcome.CONVERGED]:,} of {len(search.q):,} starts converged"
    return _table(search, f"{title}{converged}", [*lines, f"{rest} Time taken: {seconds:.1f} s."])


def _draws_section(search: families.Search, seconds: float) -> Section:
    ratio = (search.sigma[:, search.rank] / search.sigma[:, 0]).max(initial=0.0)
    counts = Counter(search.strata[k] for k in (() if search.stratum is None else search.stratum.tolist()))
    rest = "Families that none of these lies on are missing: this is no covering."
    return _table(search, f"{len(search.q):,} exact singular configurations, corank {search.corank} or more", [
        "From " + "; ".join(f"{name}: {count:,}" for name, count in counts.items()) + ".",
        f"Largest σ{search.rank + 1}/σ1: {ratio:.2g}, all at most {families.EXACT:g}. Time taken: {seconds:.1f} s.",
        rest if search.complete else f"{rest} Interrupted: fewer were drawn than were asked for.",
    ])  # fmt: skip


def _table(search: families.Search, title: str, lines: list[str]) -> Section:
    kinds = [str(joint.kind) for joint in search.robot.variables]
    slides = [kind == "prismatic" for kind in kinds]
    rows: list[tuple[str, ...]] = []
    for q in search.converged[:_SHOWN]:
        rows.append(("rad, m" if any(slides) else "rad", *(_fixed_digits(value, 4) for value in q)))
        in_degrees = ("" if slide else _fixed_digits(degrees(x), 2) for x, slide in zip(q, slides, strict=True))
        rows.append(("deg", *in_degrees))
    columns = ("", *(text.joint_symbol(number, kind) for number, kind in enumerate(kinds, start=1)))
    return Section(title, columns=columns, rows=tuple(rows), after=tuple(lines))


def _fixed_digits(value: float, digits: int) -> str:
    return f"{round(value, digits) + 0.0:.{digits}f}"


@dataclass(frozen=True)
class MotionOutput(Output):
    """Where a result and its path go."""

    path: Annotated[
        str | None, option("Write the path to this file (.csv), as `rankdrop path` reads it; - writes it to stdout",
                           writes=(".csv", STDOUT))
    ] = None  # fmt: skip


@dataclass(frozen=True)
class AspectsOutput(MotionOutput):
    """Where aspects, a path and its proof go."""

    certificate: Annotated[
        str | None, option("Write the proof that the arm is cuspidal, or that it is not, to this file, for "
                    "`rankdrop verify`", writes=())
    ] = None  # fmt: skip
    figure: Annotated[
        str | None, option("Draw the regions in the joints that separate them: .svg, .png or .pdf", writes=DRAWN)
    ] = None  # fmt: skip


def _with_path(
    result: postures.Postures | paths.Through, output: MotionOutput, none: str, *, deg: bool, **ending: bool
) -> Done:
    """A motion with its path as a table, or why there is none."""
    csv = result.path_csv()
    return Done(
        lambda: result.sections(deg=deg), ({"path": lambda: csv} if csv else {}) | {"json": result.to_dict},
        last=None if csv or output.path is None else partial(say, f"{output.path} is not written: {none}"), **ending,
    )  # fmt: skip


@command
def aspects(
    robot: ROBOT,
    /,
    *,
    q: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    deg: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    arm: ArmOptions = NO_OPTIONS,
    search: AspectsOptions = AspectsOptions(),
    output: AspectsOutput = AspectsOutput(),
    report: PROGRESS,
) -> Done:
    """Count the aspects of an arm, and find changes of posture without a singularity.

    An aspect is a connected set of regular configurations; their number is printed
    first, joint limits ignored; with --limits also the number of regions within them.
    Of arms with as many joints as rows the inverse of a pose is solved, and its
    solutions are sorted by aspect. Cuspidal: two lie in one, shown by a path between them
    that is proven free, or by the proven number of aspects. Not cuspidal: proven
    from the arm's structure, or because no three solutions meet anywhere.

    For example:
        rankdrop aspects crx10ia
        rankdrop aspects crx10ia --deg --q 10,50,20,-30,50,0 --path change.csv
        rankdrop path crx10ia change.csv
        rankdrop aspects crx10ia --certificate cuspidal.json
        rankdrop verify cuspidal.json --robot crx10ia
        rankdrop aspects ur5e --certificate ur5e.json
        rankdrop aspects irb120 --limits
        rankdrop aspects ur5e --figure aspects.svg

    Exit code 0: a path was found, or it is proven that there is none; 3: no
    change of posture was found, which is no proof, or the number of aspects is not
    proven where only that is asked, or no certificate or figure could be written;
    2: bad input.

    Args:
        q: A configuration that gives the pose to solve: one number per joint [rad, m]. Default: poses of random ones.
        deg: Angles without a unit are in degrees, and so are those printed.
    """
    model, task = open_arm(robot, arm)
    if q is None:
        start = None
    else:
        start = parse_configuration(q, model, deg=deg)
    result = postures.aspects_of(model, task, q=start, options=search, progress=partial(report, "poses solved"))
    if result.verdict == postures.NOT_ASKED:
        decided = result.count.exact
    else:
        decided = result.verdict != postures.NOT_FOUND
    done = _with_path(result, output, "there is no path", deg=deg, complete=result.complete, holds=decided)
    if output.figure is not None:
        done = _with_figure(result, done, output.figure)
    if output.certificate is None:
        return done
    try:
        record = postures.posture_certificate(result)
    except OptionError as error:
        refused = partial(say, f"{output.certificate} is not written: {error.what}")
        return replace(done, holds=False, last=partial(_run_both, done.last, refused))
    return replace(done, files={**done.files, "certificate": lambda: record})


def _with_figure(result: postures.Postures, done: Done, path: str) -> Done:
    """Finished work with a picture of the aspects, or why there is none."""
    from rankdrop.report.aspects_figure import aspects_figure
    from rankdrop.report.figures import render

    try:
        drawn = aspects_figure(result)
    except OptionError as error:
        refused = partial(say, f"{path} is not written: {error.what}")
        return replace(done, holds=False, last=partial(_run_both, done.last, refused))
    return replace(done, files={**done.files, "figure": lambda: render(drawn, path.rpartition(".")[2].lower())})


def _run_both(first: Callable[[], object] | None, second: Callable[[], object]) -> None:
    if first is not None:
        first()
    second()


@command
def through(
    robot: ROBOT,
    /,
    *,
    q: Q,
    along: Annotated[str, Parameter(
        help="Direction of the path: one number per row of the task, in the base's axes [m, rad].",
        allow_leading_hyphen=True,
    )],
    bend: Annotated[str | None, Parameter(
        help="How the direction changes along the path, d²x/ds², likewise. Default: a straight path.",
        allow_leading_hyphen=True,
    )] = None,
    deg: Annotated[
        bool, Parameter(negative=(), help="Angles without a unit are in degrees, and so are those printed.")
    ] = False,
    arm: ArmOptions = NO_OPTIONS,
    output: MotionOutput = MotionOutput(),
) -> Done:  # fmt: skip
    """Check whether a path through a singularity can be tracked.

    A path in the lost direction may still lead through: with a time law s = c t^k that stands still at the singularity
    for an instant, joint rates stay finite. Others reach it from one side only. The joints are followed on the path
    itself.

    For example:
        rankdrop through planar2r --deg --q 0,180 --along 0,1
        rankdrop through puma560 --q 0.1,0.5,0.4,0.2,0,0.6 --along 1,0,0,0,0,0

    Exit code 0: trackable; 3: not, or undecided; 2: bad input.
    """
    model, task = open_arm(robot, arm)
    at, direction = parse_configuration(q, model, deg=deg), numbers_of(along, "--along")
    result = paths.through(model, at, direction, task, bend=None if bend is None else numbers_of(bend, "--bend"))
    return _with_path(result, output, "there is no motion", deg=deg, holds=result.trackable)


@command
def tolerant(
    robot: ROBOT,
    /,
    *,
    options: TolerantOptions = TolerantOptions(),
    deg: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    arm: ArmOptions = NO_OPTIONS,
    output: Output = OUTPUT,
    report: PROGRESS,
) -> Done:
    """Find configurations that tolerate a failed joint best.

    A joint that fails stands still: its column is gone from the Jacobian. What remains is measured by σ_r, r the rank
    of the whole arm; the worst case over all joints is made as large as it gets. Local maxima of many starts.

    For example:
        rankdrop tolerant panda --limits
        rankdrop tolerant almarkhi4 --relative --length-scale 1
        rankdrop tolerant panda --limits --self-motion --q 0,-0.7,0.3,-2.4,-0.2,1.6,0

    Exit code 0: a configuration tolerates every single failure; 3: none was found; 2: bad input.

    Args:
        deg: Angles of --q without a unit are in degrees.
    """
    model, task = open_arm(robot, arm)
    if isinstance(options.q, str):
        options = replace(options, q=tuple(parse_configuration(options.q, model, deg=deg)))
    result = verbs.most_tolerant(model, task, options, progress=partial(report, "climb"))
    lines = starts_line(f"{options.starts:,}", options.seed, limits=options.limits)
    return Done(
        lambda: [text.tolerant_lines(result), arm_section(model, task, result.generic_rank, lines),
                 *text.tolerant_sections(result)],
        {"json": lambda: record_of("tolerant", result)}, holds=bool(result.places), complete=result.complete,
    )  # fmt: skip
