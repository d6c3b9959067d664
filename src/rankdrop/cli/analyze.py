"""`rankdrop analyze`: every family of singularities of an arm."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import NO_OPTIONS, ArmOptions
from rankdrop.cli.whole import Whole

if TYPE_CHECKING:
    from rankdrop.result import Analysis
    from rankdrop.task import Task


def analyze(
    robot: str,
    /,
    *,
    arm: ArmOptions = NO_OPTIONS,
    limits: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    exact: Literal["auto", "on", "off"] = "auto",
    fresh: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    starts: Whole = 10_000,
    seed: Whole = 0,
    threads: Whole = 0,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Find every family of singular configurations of an arm, of every corank.

    Per family: the values of its pinned joints, × for a free joint, c for a
    coupled one (the condition follows the table), its dimension, the
    directions lost, the share of points solved from its conditions that are
    singular, and the share of fresh singular points that it explains.

    For example:
        rankdrop analyze pa10
        rankdrop analyze arm.urdf --tip flange --json arm.json

    Exit code 3: something found is not explained or not sound, or exact
    conditions say otherwise; all codes are in `rankdrop --help`.

    Args:
        robot: Name in the catalogue (`rankdrop robots`) or file (.urdf, .xacro, .xml, .toml).
        limits: Look within the joint limits only; otherwise in the whole joint space.
        exact: Derive the conditions exactly as well, and compare: auto within 5 s, on within 60 s, off.
        fresh: Derive exact conditions anew where they are shipped (the catalogue's arms).
        starts: Random starts for each corank.
        seed: Of every random choice; the same seed gives the same result.
        threads: Processors to use; 0 means all. The result does not depend on it.
        json: Write the analysis to this file as well; - writes it to stdout in place of the tables.
        quiet: No progress.
    """
    from rankdrop.analyze import analyze as run
    from rankdrop.cli.arm import open_arm
    from rankdrop.cli.files import STDOUT, check_target, do_all, write_json
    from rankdrop.cli.progress import reporter

    check_target(json, "--json")
    begun = monotonic()
    model, task = open_arm(robot, arm)
    with reporter(quiet=quiet) as report:
        analysis = run(
            model, task, starts=starts, seed=seed, limits=limits, exact=exact, fresh=fresh, threads=threads,
            progress=report,
        )
    seconds = monotonic() - begun
    steps: list[Callable[[], None]] = []
    if json != STDOUT:
        steps.append(lambda: _print(analysis, task, seconds=seconds))
    if json is not None:
        steps.append(lambda: write_json(analysis.to_dict(), json))
    do_all(steps)
    return _exit_code(analysis)


def _print(analysis: Analysis, task: Task, *, seconds: float) -> None:
    from rich.text import Text

    from rankdrop.atlas.cells import legend
    from rankdrop.checks import sampled, unseen
    from rankdrop.cli.arm import arm_section
    from rankdrop.cli.exact_text import exact_section
    from rankdrop.cli.table import corank_section
    from rankdrop.cli.terminal import results, show, verdict_line

    console, settings = results(), analysis.settings
    where = "within the joint limits" if settings.limits else "in the whole joint space (limits ignored)"
    starts = {"starts": f"{settings.starts:,} per corank {where}, seed {settings.seed}"}
    verdict = verdict_line(analysis.verdict)
    show(console, [verdict, ""])
    show(console, arm_section(analysis.robot, task, analysis.generic_rank, starts))
    show(console, [Text(f"\n{note}", style="bold yellow") for note in analysis.notes])
    for summary in analysis.coranks:
        show(console, corank_section(console, analysis, summary))
    key = [Text(f"\n{legend(analysis.robot)}", style="dim")] if analysis.families else []
    told = list(exact_section(analysis))
    checked = " ".join(filter(None, (sampled(analysis), unseen(analysis), f"Time taken: {seconds:.1f} s.")))
    show(console, [*key, *([""] if told else []), *told, "", checked, "", verdict])


def _exit_code(analysis: Analysis) -> int:
    if not analysis.complete:
        return exits.INTERRUPTED
    return exits.FINE if analysis.verdict.holds else exits.UNEXPLAINED
