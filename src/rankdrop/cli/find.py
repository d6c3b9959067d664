"""`rankdrop find`: singular configurations of one corank."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Literal, TypedDict

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import NO_OPTIONS, ArmOptions, Whole
from rankdrop.errors import OptionError
from rankdrop.tolerances import TIE

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table

    from rankdrop.families import Search
    from rankdrop.robot import Robot
    from rankdrop.task import Task

_SHOWN = 5
_LINE = "line"


def find(
    robot: str,
    /,
    *,
    corank: Whole,
    method: Literal["lm", "gradient", "almarkhi", "reciprocal"] = "lm",
    arm: ArmOptions = NO_OPTIONS,
    limits: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    starts: Whole = 10_000,
    seed: Whole = 0,
    start: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    deg: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    step: str | None = None,
    tie: float = TIE,
    iterations: Whole | None = None,
    threads: Whole = 0,
    out: str | None = None,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    history: str | None = None,
    store: str | None = None,
    workers: Whole = 0,
    scheduler: str | None = None,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Find configurations in which the tool loses a given number of directions.

    For example:
        rankdrop find pa10 --corank 3
        rankdrop find ur5 --corank 2 --starts 1000 --out corank2.csv
        rankdrop find pa10 --corank 2 --method almarkhi --history figure.csv
        rankdrop find pa10 --corank 1 --method reciprocal --starts 100000 --out exact.npz
        rankdrop find pa10 --corank 3 --method gradient --seed 2 --start 269 --length-scale 1
        rankdrop find ur5 --corank 1 --starts 10_000_000 --store cloud

    Args:
        robot: Name in the catalogue (`rankdrop robots`) or file (.urdf, .xacro, .xml, .toml).
        corank: How many directions the tool loses: generic rank minus rank.
        method: Levenberg-Marquardt on the block; for comparison, steepest descent, or Almarkhi and Maciejewski's own;
            reciprocal: exact singular configurations of this corank or more by reciprocal wrenches, --starts of them.
        limits: Look within the joint limits only; otherwise in the whole joint space.
        starts: Random starts.
        seed: Of every random choice; the same seed gives the same result.
        start: One start in place of the random ones: a configuration (numbers as for explain --q) or, of the random
            ones, the number that --out and --json give it.
        deg: Angles of --start without a unit are in degrees.
        step: Of gradient and almarkhi: a number f up to 2, the share of the step at whose end σ would be zero, were it
            linear (default 0.5); or line, the length that brings σ lowest, which gets stuck more often.
        tie: Of almarkhi: relative gap below which singular values count as equal; 0 for no treatment of ties.
        iterations: Most iterations per start; else 200, with gradient and almarkhi 3000.
        threads: Processors to use; 0 means all. The result does not depend on it.
        out: Write every start's outcome, configuration and singular values to this file: .csv, .json or .npz.
        json: Write the same as JSON to this file; - writes it to stdout in place of the summary.
        history: Write the singular values of every iteration to this file: .csv or .npz.
        store: Keep the configurations as partitioned Parquet in this folder; no more than a part of them is in memory.
            After an interruption, of any kind, the same command goes on there.
        workers: Of --store: local processes; 0: one for every processor.
        scheduler: Of --store: address of a Dask scheduler, whose workers do the work (tcp://HOST:8786).
        quiet: No progress.
    """
    from rankdrop.cli.arm import open_arm
    from rankdrop.cli.terminal import check_targets, hand_over, reporter, write_json
    from rankdrop.families import refine, search
    from rankdrop.results import find_to_dict

    check_targets(
        {"--json": json, "--out": out, "--history": history},
        {"--out": (".csv", ".json", ".npz"), "--history": (".csv", ".npz")},
    )
    begun = monotonic()
    model, task = open_arm(robot, arm)
    if store is not None:
        _check_alone(method, {"--start": start, "--iterations": iterations, "--out": out, "--json": json,
                              "--history": history})  # fmt: skip
        return _stored(model, task, corank, store, starts, seed, limits, workers, scheduler, quiet)
    with reporter(quiet=quiet) as report:
        options: _Options = {
            "task": task, "seed": seed, "limits": limits, "method": method, "iterations": iterations,
            "step": _rule(step), "tie": tie, "history": history is not None, "threads": threads,
            "progress": lambda done, total: report(f"corank {corank}: search", done, total),
        }  # fmt: skip
        if start is not None and method == "reciprocal":
            raise OptionError("nothing is searched from a start with reciprocal wrenches", where="--start", got=start,
                              mend="leave it out")  # fmt: skip
        if start is None:
            found = search(model, corank, starts=starts, **options)
        else:
            q0, number = _one_start(start, model, task, seed, deg=deg, limits=limits)
            found = refine(model, [q0], corank, first=number, **options)
    seconds = monotonic() - begun
    hand_over(
        lambda: _print(found, task, start, seconds=seconds),
        (json, lambda target: write_json(find_to_dict(found), target)),
        (out, lambda target: _save(found, target)),
        (history, lambda target: _save_history(found, target)),
    )
    return exits.FINE if found.complete else exits.INTERRUPTED


def _check_alone(method: str, others: dict[str, object]) -> None:
    """What is kept in a folder is a search by the standard method from random starts."""
    if method != "lm":
        raise OptionError("a cloud is found by lm", where="--method", got=method, mend="leave --method or --store out")
    for option, value in others.items():
        if value is not None:
            raise OptionError("it does not go with --store", where=option, got=value, mend="leave one of them out")


def _stored(
    robot: Robot, task: Task, corank: int, folder: str, starts: int, seed: int, limits: bool, workers: int,
    scheduler: str | None, quiet: bool,
) -> int:  # fmt: skip
    from rankdrop.cli.terminal import reporter, write_text
    from rankdrop.results import store_cloud

    with reporter(quiet=quiet) as report:
        count = store_cloud(
            robot, corank, folder, task=task, starts=starts, seed=seed, limits=limits, workers=workers,
            scheduler=scheduler, report=lambda done, total: report(f"corank {corank}: parts", done, total),
        )  # fmt: skip
    write_text(f"{count:,} of {starts:,} starts ended at corank {corank} or more: {folder}/parts/*.parquet\n", "-")
    return exits.FINE


class _Options(TypedDict):
    task: Task
    seed: int
    limits: bool
    method: str
    iterations: int | None
    step: float | None
    tie: float
    history: bool
    threads: int
    progress: Callable[[int, int], None]


def _rule(step: str | None) -> float | None:
    """The rule of the steps: None for the method's own, 0 for a line search, else a share."""
    if step is None or step.strip().lower() == _LINE:
        return None if step is None else 0.0
    try:
        return float(step)
    except ValueError as error:
        raise OptionError(
            "this is no rule of the steps", where="--step", got=repr(step), allowed="line, or a number up to 2"
        ) from error


def _one_start(text: str, robot: Robot, task: Task, seed: int, *, deg: bool, limits: bool) -> tuple[list[float], int]:
    """A configuration, and its number from 0 among the random starts (0 for one that is given).

    Raises:
        ConfigurationError: neither one number per joint nor the number of a random start.
        OptionError: no random start has this number.
    """
    from rankdrop.cli.arm import parse_configuration
    from rankdrop.families import MOST_STARTS
    from rankdrop.local import sample
    from rankdrop.units import in_units, out_of_units, task_in_units

    if robot.n == 1 or not text.strip().isdecimal():
        return parse_configuration(text, robot, deg=deg, option="--start"), 0
    number = int(text) if len(text) < 12 else 0
    if not 1 <= number <= MOST_STARTS:
        raise OptionError("no random start has this number", where="--start", got=number, allowed=f"1 … {MOST_STARTS}")
    drawn = sample(in_units(robot), task_in_units(task, robot), number, seed, limits=limits)[-1]
    values: list[float] = out_of_units(robot, drawn).tolist()
    return values, number - 1


def _save(search: Search, out: str) -> None:
    from rankdrop.cli.terminal import write_bytes, write_json
    from rankdrop.results import find_to_csv, find_to_dict, find_to_npz

    if out.lower().endswith(".json"):
        write_json(find_to_dict(search), out)
    else:
        csv = out.lower().endswith(".csv")
        write_bytes(find_to_csv(search).encode() if csv else find_to_npz(search), out)


def _save_history(search: Search, history: str) -> None:
    from rankdrop.cli.terminal import write_bytes
    from rankdrop.results import history_to_csv, history_to_npz

    if search.history is not None:
        csv = history.lower().endswith(".csv")
        steps = search.history
        write_bytes(history_to_csv(steps).encode() if csv else history_to_npz(steps), history)


def _print(search: Search, task: Task, start: str | None, *, seconds: float) -> None:
    from rankdrop.cli.arm import arm_section
    from rankdrop.cli.terminal import results, show

    where = "within the joint limits" if search.limits else "in the whole joint space (limits ignored)"
    starts = f"{len(search.q):,} {where}, seed {search.seed}"
    if start is not None:
        starts = f"random start {start} {where}, seed {search.seed}" if start.strip().isdecimal() else f"one, {start}"
    lines = {"starts": starts, "method": _how(search)}
    show(results(), arm_section(search.robot, task, search.rank + search.corank, lines))
    show(results(), _outcome(search, seconds))


def _how(search: Search) -> str:
    """The method with what it was told."""
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


def _outcome(search: Search, seconds: float) -> Iterator[RenderableType]:
    import numpy as np
    from rich.text import Text

    from rankdrop.families import Outcome

    counts = {outcome: search.count(outcome) for outcome in Outcome}
    yield ""
    if search.stratum is not None:
        yield from _drawn(search, seconds)
        return
    title = f" (rank {search.rank} of {search.rank + search.corank}): "
    verdict = f"{counts[Outcome.CONVERGED]:,} of {len(search.q):,} starts converged"
    yield Text.assemble((f"Corank {search.corank}", "bold"), title, verdict)
    if counts[Outcome.CONVERGED]:
        yield _configurations(search)
        steps = search.iterations[search.outcome == Outcome.CONVERGED]
        largest = f"Largest σ{search.rank + 1} of a converged start: {search.residual():.2g}"
        yield f"{largest}; median {np.median(steps):.0f} iterations."
    elif len(search.q) == 1 and search.complete:
        left = ", ".join(f"{value:.4g}" for value in search.sigma[0, search.rank :])
        yield f"It ended at σ{search.rank + 1} … = {left} after {search.iterations[0]:,} iterations."
    stuck = f", {counts[Outcome.CREASE]:,} stuck on a crease (a tie, no minimum)" if counts[Outcome.CREASE] else ""
    rest = f"{counts[Outcome.NEAR_MISS]:,} near misses{stuck}, {counts[Outcome.SLOW]:,} slow."
    if search.smallest_near_miss is not None:
        rest += f" Smallest near miss: σ{search.rank + 1} = {search.smallest_near_miss:.4g}, not singular."
    if not counts[Outcome.CONVERGED]:
        rest += " Absence of a find is not a proof."
    if not search.complete:
        rest += f" Interrupted: {counts[Outcome.NOT_RUN]:,} starts were not run."
    yield f"{rest} Time taken: {seconds:.1f} s."


def _drawn(search: Search, seconds: float) -> Iterator[RenderableType]:
    """What reciprocal wrenches gave: how many from each stratum, how exact."""
    from collections import Counter

    from rich.text import Text

    from rankdrop.families import EXACT

    ratio = (search.sigma[:, search.rank] / search.sigma[:, 0]).max(initial=0.0)
    yield Text.assemble(
        (f"{len(search.q):,} exact singular configurations", "bold"), f", corank {search.corank} or more"
    )
    if len(search.q):
        yield _configurations(search)
    counts = (
        Counter(search.strata[k] for k in search.stratum.tolist()) if search.stratum is not None else Counter[str]()
    )
    yield "From " + "; ".join(f"{name}: {count:,}" for name, count in counts.items()) + "."
    yield f"Largest σ{search.rank + 1}/σ1: {ratio:.2g}, all at most {EXACT:g}. Time taken: {seconds:.1f} s."
    rest = "Families that none of these met are missing: it is no covering."
    yield rest if search.complete else f"{rest} Interrupted: fewer were drawn than were asked for."


def _configurations(search: Search) -> Table:
    """The first few converged configurations, rad above deg."""
    from math import degrees

    from rich import box
    from rich.table import Table

    from rankdrop.text import joint_symbol

    kinds = [str(joint.kind) for joint in search.robot.variables]
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
    table.add_column("")
    for number, kind in enumerate(kinds, start=1):
        table.add_column(joint_symbol(number, kind), justify="right")
    for q in search.converged[:_SHOWN]:
        in_degrees = ["" if kind == "prismatic" else _fixed(degrees(x), 2) for x, kind in zip(q, kinds, strict=True)]
        table.add_row("rad, m" if "prismatic" in kinds else "rad", *(_fixed(value, 4) for value in q))
        table.add_row("deg", *in_degrees, style="dim")
    return table


def _fixed(value: float, digits: int) -> str:
    """A number with a fixed number of digits, and no sign on a zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"
