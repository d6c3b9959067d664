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
    MET,
    TESTED,
    asked,
    at_witness,
    columns,
    conditions_of,
    examples,
    explained,
    folded,
    joint_cells,
    nothing_found,
    number_of,
    row_cells,
    starts,
    title,
    within,
)

if TYPE_CHECKING:
    from rich.console import Console, RenderableType

    from rankdrop.family import CorankSummary, Derivation, Family
    from rankdrop.results import Analysis
    from rankdrop.robot import Robot

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
    number, name, *joints, dimension, direction, tested, met = columns(robot, rows[0].corank)
    table.add_column(number, justify="right", no_wrap=True)
    table.add_column(name, min_width=min(14, max(len(row.name) for row in rows)), max_width=_NAME_COLUMN)
    for joint, asks in zip(joints, zip(*(joint_cells(robot, row) for row in rows), strict=True), strict=True):
        table.add_column(joint, justify="center", min_width=max(map(_unbroken, asks)))
    table.add_column(dimension, justify="right", no_wrap=True, min_width=3)
    if lost:
        table.add_column(direction, ratio=1)
    table.add_column(tested, justify="right", no_wrap=True, min_width=5)
    table.add_column(met, justify="right", no_wrap=True, min_width=5)
    for index, row in shown.items():
        _, _, *middle, words, _, share = row_cells(robot, row)
        table.add_row(str(index), _name(row), *middle, *([words] if lost else []), _sound(robot, row), share)
    return table


def _family_list(robot: Robot, shown: Mapping[int, Family]) -> Table:
    """For windows too narrow for a table: one paragraph per family."""
    grid = Table.grid(padding=(0, 1, 0, 0))
    grid.add_column(justify="right", no_wrap=True)
    grid.add_column()
    for index, row in shown.items():
        told = f": {asked(robot, row)}; dim {row.dimension}, {TESTED} "
        text = Text.assemble(_name(row), told, _sound(robot, row))
        grid.add_row(str(index), text.append(f", {MET} {row_cells(robot, row)[-1]}"))
    return grid


def _name(row: Family) -> Text:
    return Text(row.name, style="" if row.named else BAD)


def _sound(robot: Robot, row: Family) -> Text:
    return Text(row_cells(robot, row)[-2], style="" if row.soundness.holds else BAD)


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
