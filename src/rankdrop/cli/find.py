"""`rankdrop find`: singular configurations of one corank."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import NO_OPTIONS, ArmOptions
from rankdrop.cli.whole import Whole

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table

    from rankdrop.families import Search
    from rankdrop.task import Task

_SHOWN = 5


def find(
    robot: str,
    /,
    *,
    corank: Whole,
    method: Literal["lm", "gradient", "almarkhi"] = "lm",
    arm: ArmOptions = NO_OPTIONS,
    limits: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    starts: Whole = 10_000,
    seed: Whole = 0,
    threads: Whole = 0,
    out: str | None = None,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    history: str | None = None,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Find configurations in which an arm loses a given number of task freedoms.

    For example:
        rankdrop find pa10 --corank 3
        rankdrop find ur5 --corank 2 --starts 1000 --out corank2.csv
        rankdrop find pa10 --corank 2 --method almarkhi --history figure.csv

    Args:
        robot: Name in the catalogue (`rankdrop robots`) or file (.urdf, .xacro, .xml, .toml).
        corank: Number of task freedoms to lose: generic rank minus rank.
        method: Levenberg-Marquardt on the block; for comparison, steepest descent, or Almarkhi and Maciejewski's own.
        limits: Look within the joint limits only; otherwise in the whole joint space.
        starts: Random starts.
        seed: Of every random choice; the same seed gives the same result.
        threads: Processors to use; 0 means all. The result does not depend on it.
        out: Write every start's outcome, configuration and singular values to this file: .csv, .json or .npz.
        json: Write the same as JSON to this file; - writes it to stdout in place of the summary.
        history: Write the singular values of every iteration to this file: .csv or .npz.
        quiet: No progress.
    """
    from rankdrop.cli.arm import open_arm
    from rankdrop.cli.files import STDOUT, check_different, check_target, do_all, write_json
    from rankdrop.cli.progress import reporter
    from rankdrop.families import search
    from rankdrop.results import find_to_dict

    check_target(json, "--json")
    check_target(out, "--out", (".csv", ".json", ".npz"))
    check_target(history, "--history", (".csv", ".npz"))
    check_different({"--json": json, "--out": out, "--history": history})
    begun = monotonic()
    model, task = open_arm(robot, arm)
    with reporter(quiet=quiet) as report:
        found = search(
            model, corank, task=task, starts=starts, seed=seed, limits=limits, method=method, threads=threads,
            history=history is not None, progress=lambda done, total: report(f"corank {corank}: search", done, total),
        )  # fmt: skip
    seconds = monotonic() - begun
    steps: list[Callable[[], None]] = []
    if json != STDOUT:
        steps.append(lambda: _print(found, task, seconds=seconds))
    if json is not None:
        steps.append(lambda: write_json(find_to_dict(found), json))
    if out is not None:
        steps.append(lambda: _save(found, out))
    if history is not None:
        steps.append(lambda: _save_history(found, history))
    do_all(steps)
    return exits.FINE if found.complete else exits.INTERRUPTED


def _save(found: Search, out: str) -> None:
    from rankdrop.cli.files import write_bytes, write_json
    from rankdrop.results import find_to_csv, find_to_dict, find_to_npz

    if out.lower().endswith(".json"):
        write_json(find_to_dict(found), out)
    else:
        csv = out.lower().endswith(".csv")
        write_bytes(find_to_csv(found).encode() if csv else find_to_npz(found), out)


def _save_history(found: Search, history: str) -> None:
    from rankdrop.cli.files import write_bytes
    from rankdrop.results import history_to_csv, history_to_npz

    if found.history is not None:
        csv = history.lower().endswith(".csv")
        steps = found.history
        write_bytes(history_to_csv(steps).encode() if csv else history_to_npz(steps), history)


def _print(found: Search, task: Task, *, seconds: float) -> None:
    from rankdrop.cli.arm import arm_section
    from rankdrop.cli.terminal import results, show

    where = "within the joint limits" if found.limits else "in the whole joint space (limits ignored)"
    lines = {"starts": f"{len(found.q):,} {where}, seed {found.seed}", "method": found.method}
    show(results(), arm_section(found.robot, task, found.rank + found.corank, lines))
    show(results(), _outcome(found, seconds))


def _outcome(found: Search, seconds: float) -> Iterator[RenderableType]:
    import numpy as np
    from rich.text import Text

    from rankdrop.families import Outcome

    counts = {outcome: found.count(outcome) for outcome in Outcome}
    yield ""
    title = f" (rank {found.rank} of {found.rank + found.corank}): "
    verdict = f"{counts[Outcome.CONVERGED]:,} of {len(found.q):,} starts converged"
    yield Text.assemble((f"Corank {found.corank}", "bold"), title, verdict)
    if counts[Outcome.CONVERGED]:
        yield _configurations(found)
        steps = found.iterations[found.outcome == Outcome.CONVERGED]
        largest = f"Largest σ{found.rank + 1} of a converged start: {found.residual():.2g}"
        yield f"{largest}; median {np.median(steps):.0f} iterations."
    rest = f"{counts[Outcome.NEAR_MISS]:,} near misses, {counts[Outcome.SLOW]:,} slow."
    if found.smallest_near_miss is not None:
        rest += f" Smallest near miss: σ{found.rank + 1} = {found.smallest_near_miss:.4g}, not singular."
    if not counts[Outcome.CONVERGED]:
        rest += " Absence of a find is not a proof."
    if not found.complete:
        rest += f" Interrupted: {counts[Outcome.NOT_RUN]:,} starts were not run."
    yield f"{rest} Time taken: {seconds:.1f} s."


def _configurations(found: Search) -> Table:
    """The first few converged configurations, rad above deg."""
    from math import degrees

    from rich import box
    from rich.table import Table

    from rankdrop.families import joint_symbol

    kinds = [str(joint.kind) for joint in found.robot.variables]
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
    table.add_column("")
    for number, kind in enumerate(kinds, start=1):
        table.add_column(joint_symbol(number, kind), justify="right")
    for q in found.converged[:_SHOWN]:
        in_degrees = ["" if kind == "prismatic" else _fixed(degrees(x), 2) for x, kind in zip(q, kinds, strict=True)]
        table.add_row("rad, m" if "prismatic" in kinds else "rad", *(_fixed(value, 4) for value in q))
        table.add_row("deg", *in_degrees, style="dim")
    return table


def _fixed(value: float, digits: int) -> str:
    """A number with a fixed number of digits, and no sign on a zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"
