"""The commands find, aspects, through and tolerant: configurations of a corank, changes of posture, paths, failures."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from math import degrees
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import (
    NO_OPTIONS,
    OUTPUT,
    ROBOT,
    ArmOptions,
    Output,
    Q,
    arm_section,
    command,
    numbers_of,
    open_arm,
    parse_configuration,
    whole,
)
from rankdrop.cli.terminal import (
    check_targets,
    hand_over,
    print_sections,
    reporter,
    results,
    say,
    show,
    write_bytes,
    write_json,
    write_text,
)
from rankdrop.errors import OptionError
from rankdrop.motion import AspectsOptions
from rankdrop.options import Options, option
from rankdrop.questions import SearchOptions, TolerantOptions
from rankdrop.sections import Section

if TYPE_CHECKING:
    from rankdrop.families import Search
    from rankdrop.motion import Postures, Through
    from rankdrop.robot import Robot
    from rankdrop.task import Task


_SHOWN = 5
_LINE = "line"


@dataclass(frozen=True)
class Where(Options):
    """Where the search starts, and where its configurations go."""

    start: Annotated[
        str | None, option("One start in place of the random ones: a configuration (as for explain --q), or the number "
                    "that --out and --json give to a random one")
    ] = None  # fmt: skip
    deg: Annotated[bool, option("Angles of --start without a unit are in degrees")] = False
    step: Annotated[
        str | None, option("With gradient and almarkhi: a number up to 2, share of the step at whose end a linear σ is "
                    "zero (default 0.5); or line, the length that brings σ lowest, which gets stuck more often")
    ] = None  # fmt: skip
    out: Annotated[str | None, option("Write every start's outcome to this file: .csv, .json or .npz")] = None
    history: Annotated[
        str | None, option("Write the singular values of every iteration to this file: .csv or .npz")
    ] = None
    store: Annotated[
        str | None, option("Keep the configurations as partitioned Parquet in this folder, a part in memory at a time; "
                    "after an interruption run the same command to continue")
    ] = None  # fmt: skip
    workers: Annotated[int, option("With --store: local processes; 0: one for every processor", ge=0)] = 0
    scheduler: Annotated[
        str | None, option("With --store: address of a Dask scheduler whose workers do the work (tcp://HOST:8786)")
    ] = None


@command
def find(
    robot: ROBOT,
    /,
    *,
    corank: Annotated[int, Parameter(
        help="How many directions the tool loses: generic rank minus rank.", converter=whole
    )],
    options: SearchOptions = SearchOptions(),
    where: Where = Where(),
    arm: ArmOptions = NO_OPTIONS,
    output: Output = OUTPUT,
) -> int:  # fmt: skip
    """Find singular configurations of one corank.

    For example:
        rankdrop find pa10 --corank 3
        rankdrop find ur5 --corank 2 --starts 1000 --out corank2.csv
        rankdrop find pa10 --corank 2 --method almarkhi --history figure.csv
        rankdrop find pa10 --corank 1 --method reciprocal --starts 100000 --out exact.npz
        rankdrop find pa10 --corank 3 --method gradient --seed 2 --start 269 --length-scale 1
        rankdrop find ur5 --corank 1 --starts 10_000_000 --store cloud
    """
    from rankdrop.codec import record_of

    check_targets(
        {"--json": output.json, "--out": where.out, "--history": where.history},
        {"--out": (".csv", ".json", ".npz"), "--history": (".csv", ".npz")},
    )
    begun = monotonic()
    model, task = open_arm(robot, arm)
    with reporter(quiet=output.quiet) as report:
        if where.store is not None:
            return _stored(model, task, corank, options, where, output, report)
        found = _search(model, task, corank, options, where, report)
    seconds = monotonic() - begun

    def to_stdout() -> None:
        lines = {"starts": _starts(found, where.start), "method": _method(found)}
        show(results(), arm_section(model, task, found.rank + found.corank, lines))
        print_sections([_outcome(found, seconds) if found.stratum is None else _drawn(found, seconds)], first=False)

    hand_over(
        to_stdout,
        (output.json, lambda target: write_json(record_of("find", found), target)),
        (where.out, lambda target: _save(found, target, history=False)),
        (where.history, lambda target: _save(found, target, history=True)),
    )
    return exits.FINE if found.complete else exits.INTERRUPTED


def _search(robot: Robot, task: Task, corank: int, options: SearchOptions, where: Where, report: Any) -> Search:
    from rankdrop.families import refine, search

    rest: dict[str, Any] = {
        "task": task, "step": _rule(where.step), "history": where.history is not None,
        "progress": lambda done, total: report(f"corank {corank}: search", done, total),
    }  # fmt: skip
    if where.start is None:
        return search(robot, corank, options, **rest)
    if options.method == "reciprocal":
        raise OptionError("nothing is searched from a start with reciprocal wrenches", where="--start",
                          got=where.start, mend="leave it out")  # fmt: skip
    q0, number = _one_start(where.start, robot, task, options, deg=where.deg)
    return refine(robot, [q0], corank, options, first=number, **rest)


def _stored(
    robot: Robot, task: Task, corank: int, options: SearchOptions, where: Where, output: Output, report: Any
) -> int:
    from rankdrop.results import store_cloud

    if options.method != "lm":
        raise OptionError("a cloud is searched by lm", where="--method", got=options.method,
                          mend="leave --method or --store out")  # fmt: skip
    alone = {"--start": where.start, "--iterations": options.iterations, "--out": where.out, "--json": output.json,
             "--history": where.history}  # fmt: skip
    for name, value in alone.items():
        if value is not None:
            raise OptionError("it does not go with --store", where=name, got=value, mend="leave one of them out")
    assert where.store is not None
    count = store_cloud(
        robot, corank, where.store, task=task, starts=options.starts, seed=options.seed, limits=options.limits,
        workers=where.workers, scheduler=where.scheduler,
        report=lambda done, total: report(f"corank {corank}: parts", done, total),
    )  # fmt: skip
    line = f"{count:,} of {options.starts:,} starts ended at corank {corank} or more: {where.store}/parts/*.parquet\n"
    write_text(line, "-")
    return exits.FINE


def _rule(step: str | None) -> float | None:
    if step is None or step.strip().lower() == _LINE:
        return None if step is None else 0.0
    try:
        return float(step)
    except ValueError as error:
        raise OptionError(
            "this is no rule of the steps", where="--step", got=repr(step), allowed="line, or a number up to 2"
        ) from error


def _one_start(text: str, robot: Robot, task: Task, options: SearchOptions, *, deg: bool) -> tuple[list[float], int]:
    """A configuration, and its number from 0 among the random starts (0 for one that is given).

    Raises:
        ConfigurationError: neither one number per joint nor the number of a random start.
        OptionError: no random start has this number.
    """
    from rankdrop.families import MOST_STARTS
    from rankdrop.local import sample
    from rankdrop.units import in_units, out_of_units, task_in_units

    if robot.n == 1 or not text.strip().isdecimal():
        return parse_configuration(text, robot, deg=deg, option="--start"), 0
    number = int(text) if len(text) < 12 else 0
    if not 1 <= number <= MOST_STARTS:
        raise OptionError("no random start has this number", where="--start", got=number, allowed=f"1 … {MOST_STARTS}")
    drawn = sample(in_units(robot), task_in_units(task, robot), number, options.seed, limits=options.limits)[-1]
    values: list[float] = out_of_units(robot, drawn).tolist()
    return values, number - 1


def _save(search: Search, target: str, *, history: bool) -> None:
    from rankdrop.codec import record_of
    from rankdrop.results import find_to_csv, find_to_npz, history_to_csv, history_to_npz

    csv = target.lower().endswith(".csv")
    if history:
        if search.history is not None:
            write_bytes(history_to_csv(search.history).encode() if csv else history_to_npz(search.history), target)
    elif target.lower().endswith(".json"):
        write_json(record_of("find", search), target)
    else:
        write_bytes(find_to_csv(search).encode() if csv else find_to_npz(search), target)


def _starts(search: Search, start: str | None) -> str:
    where = "within the joint limits" if search.limits else "in the whole joint space (limits ignored)"
    if start is None:
        return f"{len(search.q):,} {where}, seed {search.seed}"
    return f"random start {start} {where}, seed {search.seed}" if start.strip().isdecimal() else f"one, {start}"


def _method(search: Search) -> str:
    words = [search.method]
    if search.method == "reciprocal":
        if search.corank == 1:
            return "reciprocal wrenches: every joint in closed form, or some joints by Newton's method"
        return "reciprocal wrenches: some joints by Newton's method, the others drawn"
    if search.method != "lm":
        words.append("line search" if not search.step else f"steps of {search.step:g} of that to linearised zero")
    if search.method == "almarkhi":
        words.append(f"ties below {search.tie:g}" if search.tie else "ties not treated")
    return ", ".join([*words, f"at most {search.most:,} iterations"])


def _outcome(search: Search, seconds: float) -> Section:
    import numpy as np

    from rankdrop.families import Outcome

    counts = {outcome: search.count(outcome) for outcome in Outcome}
    lines = []
    if counts[Outcome.CONVERGED]:
        steps = np.median(search.iterations[search.outcome == Outcome.CONVERGED])
        largest = f"Largest σ{search.rank + 1} of a converged start: {search.residual():.2g}"
        lines.append(f"{largest}; median {steps:.0f} iterations.")
    elif len(search.q) == 1 and search.complete:
        ended = ", ".join(f"{value:.4g}" for value in search.sigma[0, search.rank :])
        lines.append(f"It ended at σ{search.rank + 1} … = {ended} after {search.iterations[0]:,} iterations.")
    stuck = f", {counts[Outcome.CREASE]:,} stuck on a crease (a tie, no minimum)" if counts[Outcome.CREASE] else ""
    rest = f"{counts[Outcome.NEAR_MISS]:,} near misses{stuck}, {counts[Outcome.SLOW]:,} slow."
    if search.smallest_near_miss is not None:
        rest += f" Smallest near miss: σ{search.rank + 1} = {search.smallest_near_miss:.4g}, not singular."
    if not counts[Outcome.CONVERGED]:
        rest += " Not finding one proves nothing."
    if not search.complete:
        rest += f" Interrupted: {counts[Outcome.NOT_RUN]:,} starts were not run."
    title = f"Corank {search.corank} (rank {search.rank} of {search.rank + search.corank}): "
    converged = f"{counts[Outcome.CONVERGED]:,} of {len(search.q):,} starts converged"
    return _table(search, f"{title}{converged}", [*lines, f"{rest} Time taken: {seconds:.1f} s."])


def _drawn(search: Search, seconds: float) -> Section:
    from rankdrop.families import EXACT

    ratio = (search.sigma[:, search.rank] / search.sigma[:, 0]).max(initial=0.0)
    counts = Counter(search.strata[k] for k in (() if search.stratum is None else search.stratum.tolist()))
    rest = "Families that none of these lies on are missing: this is no covering."
    return _table(search, f"{len(search.q):,} exact singular configurations, corank {search.corank} or more", [
        "From " + "; ".join(f"{name}: {count:,}" for name, count in counts.items()) + ".",
        f"Largest σ{search.rank + 1}/σ1: {ratio:.2g}, all at most {EXACT:g}. Time taken: {seconds:.1f} s.",
        rest if search.complete else f"{rest} Interrupted: fewer were drawn than were asked for.",
    ])  # fmt: skip


def _table(search: Search, title: str, lines: list[str]) -> Section:
    from rankdrop.text import joint_symbol

    kinds = [str(joint.kind) for joint in search.robot.variables]
    slides = [kind == "prismatic" for kind in kinds]
    rows: list[tuple[str, ...]] = []
    for q in search.converged[:_SHOWN]:
        rows.append(("rad, m" if any(slides) else "rad", *(_fixed(value, 4) for value in q)))
        in_degrees = ("" if slide else _fixed(degrees(x), 2) for x, slide in zip(q, slides, strict=True))
        rows.append(("deg", *in_degrees))
    columns = ("", *(joint_symbol(number, kind) for number, kind in enumerate(kinds, start=1)))
    return Section(title, columns=columns, rows=tuple(rows), after=tuple(lines))


def _fixed(value: float, digits: int) -> str:
    return f"{round(value, digits) + 0.0:.{digits}f}"


def _hand_over_path(found: Postures | Through, path: str | None, output: Output, none: str, *, deg: bool) -> None:
    csv = found.path_csv()
    hand_over(
        lambda: print_sections(found.sections(deg=deg)),
        (path if csv else None, lambda target: write_text(csv, target)),
        (output.json, lambda target: write_json(found.to_dict(), target)),
    )
    if path is not None and not csv:
        say(f"{path} is not written: {none}")


@command
def aspects(
    robot: str,
    /,
    *,
    q: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    deg: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    arm: ArmOptions = NO_OPTIONS,
    search: AspectsOptions = AspectsOptions(),
    path: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    output: Output = OUTPUT,
) -> int:
    """Find changes of posture without a singularity.

    An aspect is a connected set of regular configurations. The inverse of a pose
    is solved, and its solutions are sorted by aspect. Cuspidal: two lie in one,
    shown by a path between them that is proven free. Not cuspidal: proven from
    the arm's structure, or because no three solutions meet anywhere.

    For example:
        rankdrop aspects crx10ia
        rankdrop aspects crx10ia --deg --q 10,50,20,-30,50,0 --path change.csv
        rankdrop path crx10ia change.csv

    Exit code 0: a path was found, or it is proven that there is none; 3: no
    change of posture was found, which is no proof; 2: bad input.

    Args:
        robot: Name in the catalogue (`rankdrop robots`) or file (.urdf, .xacro, .xml, .toml).
        q: A configuration whose pose is solved: one number per joint [rad, m]. Default: poses of random ones.
        deg: Angles without a unit are in degrees, and so are those printed.
        path: Write the path to this file (.csv), as `rankdrop path` reads it; - writes it to stdout.
    """
    from rankdrop.motion import NOT_FOUND, aspects_of

    check_targets({"--json": output.json, "--path": path}, {"--path": (".csv",)})
    model, task = open_arm(robot, arm)
    start = None if q is None else parse_configuration(q, model, deg=deg)
    with reporter(quiet=output.quiet) as report:
        found = aspects_of(
            model, task, q=start, options=search,
            progress=lambda done, total: report("poses solved", done, total),
        )  # fmt: skip
    _hand_over_path(found, path, output, "there is no path", deg=deg)
    if not found.complete:
        return exits.INTERRUPTED
    return exits.UNEXPLAINED if found.verdict == NOT_FOUND else exits.FINE


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
    path: Annotated[str | None, Parameter(
        help="Write the motion with its times to this file (.csv); - writes it to stdout.", allow_leading_hyphen=True
    )] = None,
    arm: ArmOptions = NO_OPTIONS,
    output: Output = OUTPUT,
) -> int:  # fmt: skip
    """Check whether a path through a singularity can be tracked.

    A path in the lost direction may still lead through: with a time law s = c t^k that stands still at the singularity
    for an instant, joint rates stay finite. Others reach it from one side only. The joints are followed on the path
    itself.

    For example:
        rankdrop through planar2r --deg --q 0,180 --along 0,1
        rankdrop through puma560 --q 0.1,0.5,0.4,0.2,0,0.6 --along 1,0,0,0,0,0

    Exit code 0: trackable; 3: not, or undecided; 2: bad input.
    """
    from rankdrop.motion import through as judge

    check_targets({"--json": output.json, "--path": path}, {"--path": (".csv",)})
    model, task = open_arm(robot, arm)
    at = parse_configuration(q, model, deg=deg)
    direction = numbers_of(along, "--along")
    found = judge(model, at, direction, task, bend=None if bend is None else numbers_of(bend, "--bend"))
    _hand_over_path(found, path, output, "there is no motion", deg=deg)
    return exits.FINE if found.trackable else exits.UNEXPLAINED


@command
def tolerant(
    robot: ROBOT,
    /,
    *,
    options: TolerantOptions = TolerantOptions(),
    arm: ArmOptions = NO_OPTIONS,
    output: Output = OUTPUT,
) -> int:
    """Find configurations that tolerate a failed joint best.

    A joint that fails stands still: its column is gone from the Jacobian. What remains is measured by σ_r, r the rank
    of the whole arm; the worst case over all joints is made as large as it gets. Local maxima of many starts.

    For example:
        rankdrop tolerant panda --limits
        rankdrop tolerant almarkhi4 --relative --length-scale 1

    Exit code 0: a configuration tolerates every single failure; 3: none was found; 2: bad input.
    """
    from rankdrop.codec import record_of
    from rankdrop.families import most_tolerant
    from rankdrop.results import tolerant_sections

    check_targets({"--json": output.json})
    model, task = open_arm(robot, arm)
    with reporter(quiet=output.quiet) as report:
        found = most_tolerant(model, task, options, progress=lambda done, total: report("climb", done, total))
    where = "within the joint limits" if options.limits else "in the whole joint space (limits ignored)"
    lines = {"starts": f"{options.starts:,} {where}, seed {options.seed}"}

    def to_stdout() -> None:
        show(results(), arm_section(model, task, found.generic_rank, lines))
        print_sections(tolerant_sections(found), first=False)

    hand_over(to_stdout, (output.json, lambda target: write_json(record_of("tolerant", found), target)))
    if not found.complete:
        return exits.INTERRUPTED
    return exits.FINE if found.places else exits.UNEXPLAINED
