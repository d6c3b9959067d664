"""The tables of an analysis, one per corank, laid out like Tables 3–5 of AM.

The layout gives way as the window narrows: lost directions in the row, then under the table; columns two blanks apart,
then one; and where even that is too wide, a list.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from rich import box
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from rankdrop.cli.terminal import BAD
from rankdrop.robot import witness_text
from rankdrop.text import (
    JOINT,
    NUMBER,
    WORDS,
    asked,
    at_witness,
    broken,
    columns,
    conditions_of,
    examples,
    explained,
    folded,
    lines_of,
    nothing_found,
    number_of,
    starts,
    title,
    within,
)

if TYPE_CHECKING:
    from rich.console import Console, RenderableType

    from rankdrop.family import CorankSummary, Derivation, Family
    from rankdrop.results import Analysis
    from rankdrop.robot import Robot
    from rankdrop.text import Column

_NAME_COLUMN = 28
_LOST_COLUMN = 30  # a lost direction in words wraps well from this width on
_BOUNDLESS = 10_000
_LONGEST_UNBROKEN = 6  # "0, π" and "±π/2" stay on one line


def corank_section(
    console: Console, analysis: Analysis, summary: CorankSummary, *, every: bool = False
) -> Iterator[RenderableType]:
    """One corank: title, table with its footnotes, and what the starts did.

    Of very many rows, those of calibrated arms, a few are shown and the others counted by their kind, unless `every`
    one is asked for.
    """
    rows = analysis.of_corank(summary.corank)
    shown = dict(enumerate(rows, start=1)) if every else examples(rows)
    yield ""
    yield _title(analysis, summary, rows)
    if rows:
        kept = {i: within(row, analysis.robot, limits=analysis.settings.limits) for i, row in shown.items()}
        yield from _rows(console, analysis.robot, kept, analysis.exact, lost=len(shown) == len(rows))
    if len(shown) < len(rows):
        others = [row for number, row in enumerate(rows, start=1) if number not in shown]
        yield Text(folded(analysis.robot, others), style="dim")
    yield Text(starts(summary), style="dim")


def _title(analysis: Analysis, summary: CorankSummary, rows: Sequence[Family]) -> Text:
    head, where = title(summary, analysis.generic_rank).split(" (")
    line = Text.assemble((head, "bold"), f" ({where}: ")
    if not rows:
        return line.append(nothing_found(summary))
    share = summary.completeness
    return line.append(f"{number_of(rows)}, ").append(explained(share), "" if share.agree == share.tested else BAD)


def _rows(
    console: Console, robot: Robot, kept: Mapping[int, tuple[Family, str]], exact: Derivation | None, *, lost: bool
) -> Iterator[RenderableType]:
    """The table as the window has room for it; each row comes with what of it lies outside the limits."""
    shown = {number: row for number, (row, _) in kept.items()}
    roomy, tight = _family_table(robot, shown, gap=1), _family_table(robot, shown, gap=0)
    boundless = console.options.update(max_width=_BOUNDLESS)
    if lost and console.width - Measurement.get(console, boundless, roomy).maximum > _LOST_COLUMN:
        yield _family_table(robot, shown, gap=1, lost=True)
        yield from _footnotes(robot, kept, exact, lost=False)
        return
    fitting = [
        table for table in (roomy, tight) if Measurement.get(console, boundless, table).minimum <= console.width
    ]
    yield fitting[0] if fitting else _family_list(robot, shown)
    yield from _footnotes(robot, kept, exact, lost=lost)


def _family_table(robot: Robot, shown: Mapping[int, Family], *, gap: int, lost: bool = False) -> Table:
    rows = tuple(shown.values())
    table = Table(box=box.SIMPLE_HEAD, padding=(0, gap, 0, 0), pad_edge=False, show_edge=False)
    every = [one for one in columns(robot, rows[0].corank) if lost or one.key != "lost"]
    for one in every:
        if one.key == "lost":
            table.add_column(one.title, ratio=1)
        elif one.holds == WORDS:
            widest = max(len(line) for row in rows for line in lines_of(one, row))
            table.add_column(one.title, min_width=min(14, widest), max_width=_NAME_COLUMN)
        elif one.holds == JOINT:
            table.add_column(one.title, justify="center", min_width=max(_unbroken(broken(one, row)) for row in rows))
        else:
            table.add_column(one.title, justify="right", no_wrap=True, min_width=len(one.title))
    for index, row in shown.items():
        table.add_row(*(str(index) if one.key == "id" else _cell(one, row) for one in every))
    return table


def _cell(column: Column, row: Family) -> Text:
    return Text(broken(column, row), style=BAD if column.failed(row) else "")


def _family_list(robot: Robot, shown: Mapping[int, Family]) -> Table:
    grid = Table.grid(padding=(0, 1, 0, 0))
    grid.add_column(justify="right", no_wrap=True)
    grid.add_column()
    for index, row in shown.items():
        cells = {one.key: one for one in columns(robot, row.corank)}
        text = Text.assemble(_cell(cells["name"], row), f": {asked(robot, row)}")
        for number, one in enumerate(one for one in cells.values() if one.holds == NUMBER and one.key != "id"):
            text.append(f"{', ' if number else '; '}{one.title} ").append_text(_cell(one, row))
        grid.add_row(str(index), text)
    return grid


def _unbroken(cell: str) -> int:
    return len(cell) if len(cell) <= _LONGEST_UNBROKEN else max(map(len, cell.split()))


def _footnotes(
    robot: Robot, kept: Mapping[int, tuple[Family, str]], exact: Derivation | None, *, lost: bool
) -> Iterator[RenderableType]:
    grid = Table.grid(padding=(0, 1, 0, 0))
    grid.add_column(justify="right", no_wrap=True)
    grid.add_column(no_wrap=True)
    grid.add_column()
    for index, (row, outside) in kept.items():
        notes = [*((("limits", outside),) if outside else ()), *conditions_of(row, exact)]
        if lost:
            notes += [("lost", text) for text in row.lost_words]
        if any("witness" in text for _, text in notes) or at_witness(row):
            notes.append(("at", f"witness {witness_text(robot, row.witness)}"))
        for place, (label, text) in enumerate(notes):
            grid.add_row(str(index) if place == 0 else "", label, text)
    if grid.row_count:
        yield ""
        yield grid
