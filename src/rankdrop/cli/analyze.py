"""`rankdrop analyze`: every family of singularities of an arm.

The tables, one per corank, are laid out like Tables 3–5 of AM. The layout gives way as the window narrows: lost
directions in the row, then under the table; columns two blanks apart, then one; and where even that is too wide, a
list.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from math import radians
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Any, Literal

from rich import box
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from rankdrop import results, text
from rankdrop.cli.command import PROGRESS, Done, Output, command
from rankdrop.cli.opening import (
    NO_IDEAL,
    ROBOT,
    IdealOptions,
    arm_section,
    ideal_sections,
    near_line,
    of_ideal,
    open_ideal,
    starts_line,
    subject,
)
from rankdrop.cli.terminal import BAD, answer_lines, fit_to_console, screen
from rankdrop.cli.values import parse_configuration
from rankdrop.options import option
from rankdrop.questions import AnalyzeOptions
from rankdrop.sections import Section

if TYPE_CHECKING:
    from rich.console import Console, RenderableType

    from rankdrop.cli.terminal import Block
    from rankdrop.families import CorankSummary, Family
    from rankdrop.robot import Robot
    from rankdrop.task import Task

_NAME_COLUMN = 28
_LOST_COLUMN = 30  # a lost direction in words wraps well from this width on
_BOUNDLESS = 10_000
_LONGEST_UNBROKEN = 6  # "0, π" and "±π/2" stay on one line
OWN = "--ideal off analyses it alone"


@dataclass(frozen=True)
class Tables(Output):
    """Which rows of the tables are shown, and where they go."""

    full: Annotated[bool, option("Print all tables: every joint, conditions, lost motions, tests")] = False
    all: Annotated[bool, option("As --full, with every row of calibrated arms, not a few of each kind")] = False
    latex: Annotated[str | None, option("Write the tables as LaTeX to this file; - for stdout", writes=())] = None


@command
def analyze(
    robot: ROBOT,
    /,
    *,
    options: AnalyzeOptions = AnalyzeOptions(),
    arm: IdealOptions = NO_IDEAL,
    output: Tables = Tables(),
    report: PROGRESS,
) -> Done:
    """Find every family of singularities of an arm.

    Per family: the rank on it, its name, and what it asks of the joints; then the motions lost on the largest families.
    With --full also: × for a free joint, c for a coupled one (the condition follows the table), the dimension, the
    directions lost, the share of points solved from its conditions that are singular, and the share of test points
    (singular points not used to find the families) that it explains.

    For example:
        rankdrop analyze pa10
        rankdrop analyze pa10 --full
        rankdrop analyze arm.urdf --tip flange --json arm.json
        rankdrop analyze ur5e --speed 250mm/s
        rankdrop analyze pa10 --latex pa10.tex

    Exit code 3: a singular point is not explained, a family is not sound, or the exact conditions differ.
    """
    from rankdrop import analyze as run

    begun = monotonic()
    model, task, idealised = open_ideal(robot, arm, intended=True)
    options = _for_arm(options, model)
    analysis = run(model, task, options, progress=report)
    alone = idealised is not None and arm.ideal is None and not idealised.tolerance.angle
    if idealised is not None and alone:
        as_written = run(idealised.real, task, options, progress=report)
    else:
        as_written = None
    nearby, *about_ideal = ideal_sections(idealised, analysis.task, analysis.families, options.seed)
    seconds = monotonic() - begun

    def record() -> dict[str, Any]:
        if idealised is None:
            return analysis.to_dict()
        verdict = of_ideal(analysis.verdict, idealised).to_dict()
        return analysis.to_dict() | verdict | {"ideal": idealised.to_dict(analysis.task, nearby)}

    def blocks() -> Iterable[Block]:
        if output.full or output.all:
            return _blocks(analysis, task, idealised, about_ideal, as_written, seconds=seconds, every=output.all)
        return _brief(analysis, task, idealised, as_written, seconds=seconds)

    return Done(
        blocks,
        {"json": record, "latex": analysis.latex}, holds=analysis.verdict.holds,
        complete=analysis.complete and not (analysis.exact is not None and analysis.exact.interrupted),
    )  # fmt: skip


def _for_arm(options: AnalyzeOptions, robot: Robot) -> AnalyzeOptions:
    """The options with a configuration in place of its text, and 5° where shares inside the limits are asked for."""
    within, around = options.within, options.around
    if within is None and options.limits:
        within = radians(5.0)
    if isinstance(around, str):
        around = tuple(parse_configuration(around, robot, deg=False, option="--around"))
    return replace(options, within=within or None, around=around)


def _speed_and_aspects(analysis: results.Analysis) -> Iterator[Block]:
    """How far joints stay from slow configurations, and the aspects, where they were asked for."""
    speeds = text.speed_section(analysis)
    if speeds is not None:
        yield speeds
    aspects = text.aspects_line(analysis.aspects)
    if aspects:
        yield [aspects]


def _brief(
    analysis: results.Analysis, task: Task, idealised: results.Idealised | None, as_written: results.Analysis | None, *,
    seconds: float,
) -> list[Block]:  # fmt: skip
    """The answer, one row per family, and what the largest families lose, in at most 40 lines."""
    near = near_line(analysis.robot, idealised).get("near", "")
    about = [text.arm_line(analysis.robot, task, analysis.generic_rank, limits=analysis.settings.limits)]
    about += [f"Near: {near}"] if near else []
    if idealised is not None and not idealised.changes:
        about += [f"{idealised.moved}."]
    blocks: list[Block] = [
        answer_lines(analysis.answer, of_ideal(analysis.verdict, idealised), subject(analysis.robot, idealised)),
        [*about, *(Text(note, style="bold yellow") for note in analysis.notes)],
    ]
    table = text.analysis_table(analysis)
    lost = text.lost_section(analysis.robot, analysis.task, analysis.generic_rank, analysis.families)
    blocks += [table] if table.rows else []
    blocks += [lost] if lost is not None else []
    if as_written is not None:
        blocks.append([f"The arm with the file's own numbers ({OWN}): {as_written.answer}"])
    blocks += _speed_and_aspects(analysis)
    blocks.append([text.more_line(seconds)])
    return fit_to_console(blocks, optional=[lost] if lost is not None else [], cut=[table] if table.rows else [])


def _blocks(
    analysis: results.Analysis, task: Task, idealised: results.Idealised | None,
    about_ideal: Sequence[Sequence[Section]], as_written: results.Analysis | None, *, seconds: float, every: bool,
) -> Iterator[Block]:  # fmt: skip
    console, settings, (moved, there) = screen(), analysis.settings, about_ideal
    answer = answer_lines(analysis.answer, of_ideal(analysis.verdict, idealised), subject(analysis.robot, idealised))
    starts = starts_line(f"{settings.starts:,} per corank", settings.seed, limits=settings.limits)
    yield answer
    yield arm_section(analysis.robot, task, analysis.generic_rank, starts | near_line(analysis.robot, idealised))
    yield from ([Text(note, style="bold yellow")] for note in analysis.notes)
    yield from moved
    yield from (corank_section(console, analysis, summary, every=every) for summary in analysis.coranks)
    yield from there
    if as_written is not None:
        yield [Text(f"The arm with the file's own numbers ({OWN})", style="bold")]
        yield from (corank_section(console, as_written, summary, every=every) for summary in as_written.coranks)
    if analysis.near is not None and analysis.families:
        yield text.near_overview(analysis.near, analysis.families)
    yield from _speed_and_aspects(analysis)
    if analysis.families:
        yield [Text(text.legend(analysis.robot, analysis.families), style="dim")]
    if analysis.exact is not None:
        compared = text.agreement(analysis.exact, analysis.robot, analysis.families)
        yield [Text(line, style=BAD if differs else "") for line, differs in compared]
    checked = (text.sampled(analysis), text.unseen(analysis), f"Time taken: {seconds:.1f} s.")
    yield [" ".join(filter(None, checked))]
    yield answer


def corank_section(
    console: Console, analysis: results.Analysis, summary: CorankSummary, *, every: bool = False
) -> Iterator[RenderableType]:
    """One corank: title, table with its footnotes, and what the starts did.

    Of very many rows, those of calibrated arms, a few are shown and the others counted by their kind, unless `every`
    one is asked for.
    """
    rows, robot, limits = analysis.of_corank(summary.corank), analysis.robot, analysis.settings.limits
    if every:
        shown = dict(enumerate(rows, start=1))
    else:
        shown = text.examples(rows)
    title = Text.assemble((f"Corank {summary.corank}", "bold"), f" (rank {summary.rank} of {analysis.generic_rank}): ")
    if not rows:
        yield title.append(text.nothing_found(summary))
    else:
        share = summary.completeness
        if share.agree == share.tested:
            failed = ""
        else:
            failed = BAD
        yield title.append(f"{text.number_of(rows)}, ").append(text.explained(share), failed)
        kept = {i: text.restrict_to_limits(row, robot, limits=limits) for i, row in shown.items()}
        yield from _rows(console, robot, kept, lost=len(shown) == len(rows))
    if len(shown) < len(rows):
        others = [row for number, row in enumerate(rows, start=1) if number not in shown]
        yield Text(text.hidden_rows_words(robot, others), style="dim")
    yield Text(text.starts(summary), style="dim")


def _rows(
    console: Console, robot: Robot, kept: Mapping[int, tuple[Family, str]], *, lost: bool
) -> Iterator[RenderableType]:
    """The table as the window has room for it; each row comes with what of it lies outside the limits."""
    shown = {number: row for number, (row, _) in kept.items()}
    roomy, tight = _family_table(robot, shown, gap=1), _family_table(robot, shown, gap=0)
    boundless = console.options.update(max_width=_BOUNDLESS)
    wide = lost and console.width - Measurement.get(console, boundless, roomy).maximum > _LOST_COLUMN
    fitting = [table for table in (roomy, tight) if Measurement.get(console, boundless, table).minimum <= console.width]
    if wide:
        yield _family_table(robot, shown, gap=1, lost=True)
    else:
        yield fitting[0] if fitting else _family_list(robot, shown)
    notes = _grid("right", "left", "left", fixed=2)
    for index, (row, outside) in kept.items():
        for place, (label, line) in enumerate(text.footnotes(robot, row, outside, lost=lost and not wide)):
            notes.add_row(str(index) if place == 0 else "", label, line)
    if notes.row_count:
        yield from ("", notes)


def _grid(*sides: Literal["left", "right"], fixed: int) -> Table:
    """A table without lines, the first `fixed` columns not wrapped."""
    grid = Table.grid(padding=(0, 1, 0, 0))
    for number, side in enumerate(sides):
        grid.add_column(justify=side, no_wrap=number < fixed)
    return grid


def _family_table(robot: Robot, shown: Mapping[int, Family], *, gap: int, lost: bool = False) -> Table:
    rows = tuple(shown.values())
    table = Table(box=box.SIMPLE_HEAD, padding=(0, gap, 0, 0), pad_edge=False, show_edge=False)
    every = [column for column in text.columns(robot, rows[0].corank) if lost or column.key != "lost"]
    for column in every:
        _add_column(table, column, rows)
    for index, row in shown.items():
        table.add_row(*(str(index) if column.key == "id" else _cell(column, row) for column in every))
    return table


def _add_column(table: Table, column: text.Column, rows: Sequence[Family]) -> None:
    """The head of a column, as wide as what stands in it needs."""
    if column.key == "lost":
        table.add_column(column.title, ratio=1)
    elif column.holds == text.WORDS:
        widest = max(len(line) for line in chain.from_iterable(text.lines_of(column, row) for row in rows))
        table.add_column(column.title, min_width=min(14, widest), max_width=_NAME_COLUMN)
    elif column.holds == text.JOINT:
        widest = max(_unbroken(text.broken(column, row)) for row in rows)
        table.add_column(column.title, justify="center", min_width=widest)
    else:
        table.add_column(column.title, justify="right", no_wrap=True, min_width=len(column.title))


def _cell(column: text.Column, row: Family) -> Text:
    return Text(text.broken(column, row), style=BAD if column.failed(row) else "")


def _family_list(robot: Robot, shown: Mapping[int, Family]) -> Table:
    grid = _grid("right", "left", fixed=1)
    for index, row in shown.items():
        cells = {column.key: column for column in text.columns(robot, row.corank)}
        line = Text.assemble(_cell(cells["name"], row), f": {text.asked(robot, row)}")
        numbers = [column for column in cells.values() if column.holds == text.NUMBER and column.key != "id"]
        for number, column in enumerate(numbers):
            line.append(f"{', ' if number else '; '}{column.title} ").append_text(_cell(column, row))
        grid.add_row(str(index), line)
    return grid


def _unbroken(cell: str) -> int:
    if len(cell) <= _LONGEST_UNBROKEN:
        return len(cell)
    return max(map(len, cell.split()))
