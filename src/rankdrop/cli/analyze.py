"""`rankdrop analyze`: every family of singularities of an arm."""

from __future__ import annotations

from collections.abc import Sequence
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import IDEAL, NO_OPTIONS, ArmOptions, Whole

if TYPE_CHECKING:
    from rankdrop.results import Analysis, Record
    from rankdrop.sections import Section
    from rankdrop.task import Task
    from rankdrop.verbs import Idealised

_WITHIN = "5deg"


def analyze(
    robot: str,
    /,
    *,
    arm: ArmOptions = NO_OPTIONS,
    ideal: IDEAL = None,
    limits: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    within: str | None = None,
    exact: Literal["auto", "on", "off"] = "auto",
    fresh: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    starts: Whole = 10_000,
    seed: Whole = 0,
    threads: Whole = 0,
    all: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    latex: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Find the families of singular configurations of an arm, of every corank.

    Per family: the values of its pinned joints, × for a free joint, c for a
    coupled one (the condition follows the table), its dimension, the
    directions lost, the share of points solved from its conditions that are
    singular, and the share of fresh singular points that it explains.

    For example:
        rankdrop analyze pa10
        rankdrop analyze arm.urdf --tip flange --json arm.json
        rankdrop analyze pa10 --latex pa10.tex

    Exit code 3: something found is not explained or not sound, or exact
    conditions say otherwise; all codes are in `rankdrop --help`.

    Args:
        robot: Name in the catalogue (`rankdrop robots`) or file (.urdf, .xacro, .xml, .toml).
        ideal: The nearest arm whose axes are exactly parallel, square and meeting, to a tolerance such as 1mm,0.5deg.
            What the arm itself does on the families of the ideal one is told.
        limits: Look within the joint limits only; otherwise in the whole joint space.
        within: Tell the share of the joint space within this distance of each family, such as 5deg or 0.1 (rad); 5deg
            with --limits; 0 for none.
        exact: Derive the conditions exactly as well, and compare: auto within 30 s, on within 120 s, off.
        fresh: Derive exact conditions anew where they are shipped (the catalogue's arms).
        starts: Random starts for each corank.
        seed: Of every random choice; the same seed gives the same result.
        threads: Processors to use; 0 means all. The result does not depend on it.
        all: Show every row. Otherwise of more than 24 of one corank, those of calibrated arms, a few stand for all.
        json: Write the analysis to this file as well; - writes it to stdout in place of the tables.
        latex: Write the tables as LaTeX to this file as well (needs amsmath); - writes them to stdout in place of the
            tables.
        quiet: No progress.
    """
    from rankdrop import analyze as run
    from rankdrop.cli.arm import ideal_sections, of_ideal, open_ideal
    from rankdrop.cli.terminal import check_targets, hand_over, reporter, write_json, write_text

    check_targets({"--json": json, "--latex": latex})
    begun = monotonic()
    model, task, made = open_ideal(robot, arm, ideal)
    with reporter(quiet=quiet) as report:
        analysis = run(
            model, task, starts=starts, seed=seed, limits=limits, exact=exact, fresh=fresh, threads=threads,
            within=_within(within, limits), progress=report,
        )
    there, moved, beside = ideal_sections(made, analysis.task, analysis.families, seed)
    seconds = monotonic() - begun

    def record() -> Record:
        if made is None:
            return analysis.to_dict()
        verdict = of_ideal(analysis.verdict, made).to_dict()
        return analysis.to_dict() | verdict | {"ideal": made.to_dict(analysis.task, there)}

    hand_over(
        lambda: _print(analysis, task, made, moved, beside, seconds=seconds, every=all),
        (json, lambda target: write_json(record(), target)),
        (latex, lambda target: write_text(analysis.latex(), target)),
    )
    return _exit_code(analysis)


def _print(
    analysis: Analysis, task: Task, made: Idealised | None, moved: Sequence[Section], beside: Sequence[Section],
    *, seconds: float, every: bool,
) -> None:  # fmt: skip
    from rich.text import Text

    from rankdrop.cli.arm import arm_section, near_line, of_ideal
    from rankdrop.cli.table import corank_section
    from rankdrop.cli.terminal import BAD, print_sections, results, show, verdict_line
    from rankdrop.results import sampled, unseen
    from rankdrop.text import agreement, legend, near_overview

    console, settings = results(), analysis.settings
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
    print_sections(beside, first=False)
    key = [Text(f"\n{legend(analysis.robot, analysis.families)}", style="dim")] if analysis.families else []
    compared = agreement(analysis.exact, analysis.robot, analysis.families)
    told = [Text(line, style=BAD if differs else "") for line, differs in compared]
    if analysis.near is not None and analysis.families:
        print_sections([near_overview(analysis.near, analysis.families)], first=False)
    checked = " ".join(filter(None, (sampled(analysis), unseen(analysis), f"Time taken: {seconds:.1f} s.")))
    show(console, [*key, *([""] if told else []), *told, "", checked, "", verdict])


def _within(text: str | None, limits: bool) -> float | None:
    """The distance asked for [rad]; None for none."""
    from rankdrop.robot import quantity

    distance = quantity(text or (_WITHIN if limits else "0"), "angle", where="--within")
    return distance or None


def _exit_code(analysis: Analysis) -> int:
    if not analysis.complete or (analysis.exact is not None and analysis.exact.interrupted):
        return exits.INTERRUPTED
    return exits.FINE if analysis.verdict.holds else exits.UNEXPLAINED
