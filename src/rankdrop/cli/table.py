"""The tables of an analysis, one per corank, laid out like Tables 3–5 of AM.

The layout gives way as the window narrows: lost directions in the row, then under the table; columns two blanks apart,
then one; and where even that is too wide, a list.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rich import box
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from rankdrop.atlas.cells import (
    joint_cell,
    joint_symbol,
    rounded_share,
    share_text,
    values_text,
)
from rankdrop.atlas.inside import Inside, inside_limits, outside_text
from rankdrop.exactly import conditions_of

if TYPE_CHECKING:
    from rich.console import Console, RenderableType

    from rankdrop.atlas.family import CorankSummary, Family
    from rankdrop.joined import Joined
    from rankdrop.result import Analysis
    from rankdrop.robot.model import Robot

_NAME_COLUMN = 28
_LOST_COLUMN = 30  # a lost direction in words wraps well from this width on
_BOUNDLESS = 10_000
_MANY = 24  # rows of one corank: of more, those of calibrated arms, lost motions are told of the largest alone
_LARGEST = 8
_LONGEST_UNBROKEN = 6  # "0, π" and "±π/2" stay on one line
_BAD = "bold red"


def corank_section(console: Console, analysis: Analysis, summary: CorankSummary) -> Iterator[RenderableType]:
    """One corank: title, table with its footnotes, and what the starts did."""
    rows = analysis.of_corank(summary.corank)
    yield ""
    yield _title(analysis, summary, len(rows))
    if rows:
        inside = {row.id: inside_limits(row, analysis.robot) for row in rows if analysis.settings.limits}
        shown = tuple(inside[row.id].shown(row) if row.id in inside else row for row in rows)
        yield from _rows(console, analysis.robot, shown, analysis.exact, inside)
    yield Text(_starts_line(summary), style="dim")


def _title(analysis: Analysis, summary: CorankSummary, rows: int) -> Text:
    title = Text.assemble((f"Corank {summary.corank}", "bold"), f" (rank {summary.rank} of {analysis.generic_rank}): ")
    if not rows:
        title.append(f"none found of {_count(summary.starts, 'start')}")
        if summary.smallest_near_miss is not None:
            title.append(f", smallest σ{summary.rank + 1} met {summary.smallest_near_miss:.4g}")
        return title.append("; absence of a find is not a proof")
    share = summary.completeness
    title.append(f"{_count(rows, 'family', 'families')}, ")
    counts = f"({share.explained:,} of {share.tested:,} fresh points)"
    style = "" if share.explained == share.tested else _BAD
    return title.append(f"completeness {share_text(share.explained, share.tested)} {counts}", style)


def _rows(
    console: Console, robot: Robot, rows: tuple[Family, ...], exact: Joined | None, inside: dict[str, Inside]
) -> Iterator[RenderableType]:
    roomy, tight = _family_table(robot, rows, gap=1), _family_table(robot, rows, gap=0)
    boundless = console.options.update(max_width=_BOUNDLESS)
    if console.width - Measurement.get(console, boundless, roomy).maximum > _LOST_COLUMN:
        yield _family_table(robot, rows, gap=1, lost=True)
        yield from _footnotes(robot, rows, exact, inside, lost=False)
        return
    fitting = [
        table for table in (roomy, tight) if Measurement.get(console, boundless, table).minimum <= console.width
    ]
    yield fitting[0] if fitting else _family_list(robot, rows)
    yield from _footnotes(robot, rows, exact, inside, lost=True)


def _family_table(robot: Robot, rows: tuple[Family, ...], *, gap: int, lost: bool = False) -> Table:
    table = Table(box=box.SIMPLE_HEAD, padding=(0, gap, 0, 0), pad_edge=False, show_edge=False)
    table.add_column("", justify="right", no_wrap=True)
    table.add_column("family", min_width=min(14, max(len(row.name) for row in rows)), max_width=_NAME_COLUMN)
    for number, joint in enumerate(robot.variables, start=1):
        cells = [joint_cell(row, number, str(joint.kind)) for row in rows]
        table.add_column(joint_symbol(number, str(joint.kind)), justify="center", min_width=max(map(_unbroken, cells)))
    table.add_column("dim", justify="right", no_wrap=True, min_width=3)
    if lost:
        table.add_column("lost direction" if rows[0].corank == 1 else "lost directions", ratio=1)
    table.add_column("sound", justify="right", no_wrap=True, min_width=5)
    table.add_column("share", justify="right", no_wrap=True, min_width=5)
    for index, row in enumerate(rows, start=1):
        joints = [joint_cell(row, number, str(joint.kind)) for number, joint in enumerate(robot.variables, start=1)]
        words = ["\n".join(row.lost_words)] if lost else []
        share = rounded_share(row.explained)
        table.add_row(str(index), _name(row), *joints, str(row.dimension), *words, _sound(row), share)
    return table


def _family_list(robot: Robot, rows: tuple[Family, ...]) -> Table:
    """For windows too narrow for a table: one paragraph per family."""
    grid = Table.grid(padding=(0, 1, 0, 0))
    grid.add_column(justify="right", no_wrap=True)
    grid.add_column()
    kinds = [str(joint.kind) for joint in robot.variables]
    for index, row in enumerate(rows, start=1):
        parts = [
            f"{joint_symbol(one.number, kinds[one.number - 1])} = {values_text(one.values, kinds[one.number - 1])}"
            for one in row.pinned
        ]
        for numbers, word in ((row.coupled, "coupled"), (row.free, "free")):
            if numbers:
                parts.append(f"{', '.join(joint_symbol(number, kinds[number - 1]) for number in numbers)} {word}")
        share = rounded_share(row.explained)
        text = Text.assemble(_name(row), f": {'; '.join(parts)}; dim {row.dimension}, sound ", _sound(row))
        grid.add_row(str(index), text.append(f", share {share}"))
    return grid


def _name(row: Family) -> Text:
    return Text(row.name, style="" if row.named else _BAD)


def _sound(row: Family) -> Text:
    return Text(share_text(row.soundness.singular, row.soundness.tested), style="" if row.soundness.holds else _BAD)


def _unbroken(cell: str) -> int:
    return len(cell) if len(cell) <= _LONGEST_UNBROKEN else max(map(len, cell.split()))


def _footnotes(
    robot: Robot, rows: tuple[Family, ...], exact: Joined | None, inside: dict[str, Inside], *, lost: bool
) -> Iterator[RenderableType]:
    grid = Table.grid(padding=(0, 1, 0, 0))
    grid.add_column(justify="right", no_wrap=True)
    grid.add_column(no_wrap=True)
    grid.add_column()
    told = _told(rows)
    for index, row in enumerate(rows, start=1):
        notes = conditions_of(row, exact)
        if row.id in inside and inside[row.id].outside:
            notes = [("limits", outside_text(inside[row.id], robot)), *notes]
        if not notes and row.id not in told:
            continue
        if lost and row.id in told:
            notes += [("lost", text) for text in row.lost_words]
        if any("witness" in text for _, text in notes) or any("witness" in text for text in row.lost_words):
            notes.append(("at", _witness(row)))
        for place, (label, text) in enumerate(notes):
            grid.add_row(str(index) if place == 0 else "", label, text)
    if grid.row_count:
        yield ""
        yield grid
    if len(told) < len(rows) and lost:
        others = len(rows) - len(told)
        yield Text(f"What is lost on the other {others} rows, which have smaller shares: with --json", style="dim")


def _told(rows: tuple[Family, ...]) -> set[str]:
    """Ids of the rows whose lost motions are told: all of them, or those of the largest shares."""
    by_share = sorted(rows, key=lambda row: -row.explained.explained)
    return {row.id for row in (by_share[:_LARGEST] if len(rows) > _MANY else rows)}


def _witness(row: Family) -> str:
    return f"witness q = ({', '.join(f'{value:.4g}' for value in row.witness)}) [rad, m]".replace("-", "−")


def _starts_line(summary: CorankSummary) -> str:
    near = _count(summary.near_misses, "near miss", "near misses")
    line = f"Of {_count(summary.starts, 'start')}: {summary.converged:,} converged, {near}, {summary.slow:,} slow."
    if summary.converged and summary.smallest_near_miss is not None:
        line += f" Smallest near miss: σ{summary.rank + 1} = {summary.smallest_near_miss:.4g}, not singular."
    return line


def _count(number: int, one: str, many: str = "") -> str:
    return f"{number:,} {one if number == 1 else many or one + 's'}"
