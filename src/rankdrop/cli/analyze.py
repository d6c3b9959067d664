"""`rankdrop analyze`: every family of singularities of an arm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import radians
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import (
    NO_IDEAL,
    OUTPUT,
    ROBOT,
    IdealOptions,
    Output,
    arm_section,
    command,
    ideal_sections,
    near_line,
    of_ideal,
    open_ideal,
)
from rankdrop.cli.terminal import (
    BAD,
    check_targets,
    hand_over,
    print_sections,
    reporter,
    results,
    show,
    verdict_line,
    write_json,
    write_text,
)
from rankdrop.questions import AnalyzeOptions
from rankdrop.sections import Section

if TYPE_CHECKING:
    from rankdrop.results import Analysis
    from rankdrop.task import Task
    from rankdrop.verbs import Idealised

OWN = "--ideal off analyses it alone"


@command
def analyze(
    robot: ROBOT,
    /,
    *,
    options: AnalyzeOptions = AnalyzeOptions(),
    all: Annotated[
        bool, Parameter(negative=(), help="Show every row of calibrated arms, not a few of each kind.")
    ] = False,
    latex: Annotated[str | None, Parameter(help="Write the tables as LaTeX to this file; - for stdout.")] = None,
    arm: IdealOptions = NO_IDEAL,
    output: Output = OUTPUT,
) -> int:
    """Find every family of singularities of an arm.

    Per family: the values of its pinned joints, × for a free joint, c for a coupled one (the condition follows the
    table), its dimension, the directions lost, the share of points solved from its conditions that are singular, and
    the share of fresh singular points that it explains.

    For example:
        rankdrop analyze pa10
        rankdrop analyze arm.urdf --tip flange --json arm.json
        rankdrop analyze pa10 --latex pa10.tex

    Exit code 3: a singular point is not explained, a family is not sound, or the exact conditions differ.
    """
    from rankdrop import analyze as run

    check_targets({"--json": output.json, "--latex": latex})
    begun = monotonic()
    model, task, made = open_ideal(robot, arm, arm.ideal, intended=True)
    within = radians(5.0) if options.within is None and options.limits else options.within
    options = replace(options, within=within or None)
    offsets = arm.ideal is None and made is not None and not made.tolerance.angle
    with reporter(quiet=output.quiet) as report:
        analysis = run(model, task, options, progress=report)
        own = run(made.real, task, options, progress=report) if made is not None and offsets else None
    nearby, *about_ideal = ideal_sections(made, analysis.task, analysis.families, options.seed)
    seconds = monotonic() - begun

    def record() -> dict[str, Any]:
        if made is None:
            return analysis.to_dict()
        verdict = of_ideal(analysis.verdict, made).to_dict()
        return analysis.to_dict() | verdict | {"ideal": made.to_dict(analysis.task, nearby)}

    hand_over(
        lambda: _print(analysis, task, made, about_ideal, own, seconds=seconds, every=all),
        (output.json, lambda target: write_json(record(), target)),
        (latex, lambda target: write_text(analysis.latex(), target)),
    )
    if not analysis.complete or (analysis.exact is not None and analysis.exact.interrupted):
        return exits.INTERRUPTED
    return exits.FINE if analysis.verdict.holds else exits.UNEXPLAINED


def _print(
    analysis: Analysis, task: Task, made: Idealised | None, about_ideal: Sequence[Sequence[Section]],
    own: Analysis | None, *, seconds: float, every: bool,
) -> None:  # fmt: skip
    from rich.text import Text

    from rankdrop.cli.table import corank_section
    from rankdrop.results import sampled, unseen
    from rankdrop.text import agreement, legend, near_overview

    console, settings, (moved, there) = results(), analysis.settings, about_ideal
    where = "within the joint limits" if settings.limits else "in the whole joint space (limits ignored)"
    starts = {"starts": f"{settings.starts:,} per corank {where}, seed {settings.seed}"}
    starts |= near_line(analysis.robot, made)
    verdict = verdict_line(of_ideal(analysis.verdict, made))
    show(console, [verdict, ""])
    show(console, arm_section(analysis.robot, task, analysis.generic_rank, starts))
    show(console, [Text(f"\n{note}", style="bold yellow") for note in analysis.notes])
    print_sections(moved, first=False)
    for summary in analysis.coranks:
        show(console, corank_section(console, analysis, summary, every=every))
    print_sections(there, first=False)
    if own is not None:
        show(console, [Text(f"\nThe arm with the file's own numbers ({OWN})", style="bold")])
        for summary in own.coranks:
            show(console, corank_section(console, own, summary, every=every))
    key = [Text(f"\n{legend(analysis.robot, analysis.families)}", style="dim")] if analysis.families else []
    compared = agreement(analysis.exact, analysis.robot, analysis.families)
    lines = [Text(line, style=BAD if differs else "") for line, differs in compared]
    if analysis.near is not None and analysis.families:
        print_sections([near_overview(analysis.near, analysis.families)], first=False)
    checked = " ".join(filter(None, (sampled(analysis), unseen(analysis), f"Time taken: {seconds:.1f} s.")))
    show(console, [*key, *([""] if lines else []), *lines, "", checked, "", verdict])
