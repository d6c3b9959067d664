"""The tables of an analysis, one per corank, laid out like Tables 3–5 of AM.

The layout gives way as the window narrows: lost directions in the row, then under the table; columns two blanks apart,
then one; and where even that is too wide, a list.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from rich import box
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from rankdrop.compare import conditions_of
from rankdrop.families import (
    MET,
    TESTED,
    inside_limits,
    joint_cell,
    joint_symbol,
    outside_text,
    rounded_share,
    share_text,
    values_text,
)

if TYPE_CHECKING:
    from rich.console import Console, RenderableType

    from rankdrop.compare import Comparison
    from rankdrop.family import CorankSummary, Family
    from rankdrop.results import Analysis
    from rankdrop.robot import Robot

_NAME_COLUMN = 28
_LOST_COLUMN = 30  # a lost direction in words wraps well from this width on
_BOUNDLESS = 10_000
_MANY = 24  # rows of one corank: of more, those of calibrated arms, some stand for all
_SHOWN = 3
_KINDS = 3  # kinds of rows that are told apart when they are counted
_LONGEST_UNBROKEN = 6  # "0, π" and "±π/2" stay on one line
_BAD = "bold red"


def corank_section(
    console: Console, analysis: Analysis, summary: CorankSummary, *, every: bool = False
) -> Iterator[RenderableType]:
    """One corank: title, table with its footnotes, and what the starts did.

    Of very many rows, those of calibrated arms, a few are shown and the others counted by their kind, unless `every`
    one is asked for.
    """
    rows = analysis.of_corank(summary.corank)
    shown = dict(enumerate(rows, start=1)) if every else _examples(rows)
    yield ""
    yield _title(analysis, summary, len(rows))
    if rows:
        kept, outside = _inside(analysis, shown)
        yield from _rows(console, analysis.robot, kept, analysis.exact, outside, lost=len(shown) == len(rows))
    if len(shown) < len(rows):
        others = [row for number, row in enumerate(rows, start=1) if number not in shown]
        yield Text(_folded(analysis.robot, others), style="dim")
    yield Text(_starts_line(summary), style="dim")


def _inside(analysis: Analysis, shown: Mapping[int, Family]) -> tuple[dict[int, Family], dict[int, str]]:
    """The rows with their values inside the limits, where these were asked for, and what of them lies outside."""
    if not analysis.settings.limits:
        return dict(shown), {}
    inside = {number: inside_limits(row, analysis.robot) for number, row in shown.items()}
    outside = {number: outside_text(one, analysis.robot) for number, one in inside.items() if one.outside}
    return {number: inside[number].shown(row) for number, row in shown.items()}, outside


def _title(analysis: Analysis, summary: CorankSummary, rows: int) -> Text:
    title = Text.assemble((f"Corank {summary.corank}", "bold"), f" (rank {summary.rank} of {analysis.generic_rank}): ")
    if not rows:
        title.append(f"none found of {_count(summary.starts, 'start')}")
        if summary.smallest_near_miss is not None:
            title.append(f", smallest σ{summary.rank + 1} met {summary.smallest_near_miss:.4g}")
        return title.append("; absence of a find is not a proof")
    share = summary.completeness
    title.append(f"{_count(rows, 'family', 'families')}, ")
    counts = f"{share.agree:,} of {share.tested:,} fresh points explained"
    style = "" if share.agree == share.tested else _BAD
    return title.append(counts, style)


def _examples(rows: tuple[Family, ...]) -> dict[int, Family]:
    """The rows to show, by their number: all, or of very many those of the largest shares, unsound ones first."""
    numbered = enumerate(rows, start=1)
    if len(rows) <= _MANY:
        return dict(numbered)
    told = sorted(numbered, key=lambda one: (not _unsound(one[1]), not one[1].named, -one[1].explained.agree))
    return dict(sorted(told[:_SHOWN]))


def _folded(robot: Robot, rows: list[Family]) -> str:
    """Rows that are not shown, counted by their kind."""
    kinds = Counter(_kind(robot, row) for row in rows).most_common()
    parts = [f"{count:,} {words}" for words, count in kinds[:_KINDS]]
    rest = sum(count for _, count in kinds[_KINDS:])
    parts += [f"{rest:,} of other kinds"] * (rest > 0)
    unsound = sum(map(_unsound, rows))
    sound = f"{unsound:,} of them failed their test" if unsound else "all passed their test"
    return f"and {len(rows):,} more rows, {sound}: {'; '.join(parts)}. All of them with --all."


def _kind(robot: Robot, row: Family) -> str:
    """What rows have in common: which joints are fixed, which coupled, and of what dimension they are."""
    if not row.named:
        return f"without a condition, of dimension {row.dimension} at most"
    kinds = [str(joint.kind) for joint in robot.variables]
    parts = []
    for numbers, word in (([one.number for one in row.pinned], "fixed"), (row.coupled, "coupled")):
        if numbers:
            parts.append(f"{', '.join(joint_symbol(number, kinds[number - 1]) for number in numbers)} {word}")
    return f"with {' and '.join(parts)}, of dimension {row.dimension}"


def _rows(
    console: Console, robot: Robot, shown: Mapping[int, Family], exact: Comparison | None, outside: Mapping[int, str],
    *, lost: bool,
) -> Iterator[RenderableType]:
    roomy, tight = _family_table(robot, shown, gap=1), _family_table(robot, shown, gap=0)
    boundless = console.options.update(max_width=_BOUNDLESS)
    if lost and console.width - Measurement.get(console, boundless, roomy).maximum > _LOST_COLUMN:
        yield _family_table(robot, shown, gap=1, lost=True)
        yield from _footnotes(shown, exact, outside, lost=False)
        return
    fitting = [
        table for table in (roomy, tight) if Measurement.get(console, boundless, table).minimum <= console.width
    ]
    yield fitting[0] if fitting else _family_list(robot, shown)
    yield from _footnotes(shown, exact, outside, lost=lost)


def _family_table(robot: Robot, shown: Mapping[int, Family], *, gap: int, lost: bool = False) -> Table:
    rows = tuple(shown.values())
    table = Table(box=box.SIMPLE_HEAD, padding=(0, gap, 0, 0), pad_edge=False, show_edge=False)
    table.add_column("", justify="right", no_wrap=True)
    table.add_column("family", min_width=min(14, max(len(row.name) for row in rows)), max_width=_NAME_COLUMN)
    for number, joint in enumerate(robot.variables, start=1):
        cells = [joint_cell(row, number, str(joint.kind)) for row in rows]
        table.add_column(joint_symbol(number, str(joint.kind)), justify="center", min_width=max(map(_unbroken, cells)))
    table.add_column("dim", justify="right", no_wrap=True, min_width=3)
    if lost:
        table.add_column("lost direction" if rows[0].corank == 1 else "lost directions", ratio=1)
    table.add_column(TESTED, justify="right", no_wrap=True, min_width=5)
    table.add_column(MET, justify="right", no_wrap=True, min_width=5)
    for index, row in shown.items():
        joints = [joint_cell(row, number, str(joint.kind)) for number, joint in enumerate(robot.variables, start=1)]
        words = ["\n".join(row.lost_words)] if lost else []
        share = rounded_share(row.explained)
        table.add_row(str(index), _name(row), *joints, str(row.dimension), *words, _sound(row), share)
    return table


def _family_list(robot: Robot, shown: Mapping[int, Family]) -> Table:
    """For windows too narrow for a table: one paragraph per family."""
    grid = Table.grid(padding=(0, 1, 0, 0))
    grid.add_column(justify="right", no_wrap=True)
    grid.add_column()
    kinds = [str(joint.kind) for joint in robot.variables]
    for index, row in shown.items():
        parts = [
            f"{joint_symbol(one.number, kinds[one.number - 1])} = {values_text(one.values, kinds[one.number - 1])}"
            for one in row.pinned
        ]
        for numbers, word in ((row.coupled, "coupled"), (row.free, "free")):
            if numbers:
                parts.append(f"{', '.join(joint_symbol(number, kinds[number - 1]) for number in numbers)} {word}")
        share = rounded_share(row.explained)
        text = Text.assemble(_name(row), f": {'; '.join(parts)}; dim {row.dimension}, {TESTED} ", _sound(row))
        grid.add_row(str(index), text.append(f", {MET} {share}"))
    return grid


def _name(row: Family) -> Text:
    return Text(row.name, style="" if row.named else _BAD)


def _sound(row: Family) -> Text:
    return Text(share_text(row.soundness.agree, row.soundness.tested), style="" if row.soundness.holds else _BAD)


def _unsound(row: Family) -> bool:
    return row.soundness.agree < row.soundness.tested


def _unbroken(cell: str) -> int:
    return len(cell) if len(cell) <= _LONGEST_UNBROKEN else max(map(len, cell.split()))


def _footnotes(
    shown: Mapping[int, Family], exact: Comparison | None, outside: Mapping[int, str], *, lost: bool
) -> Iterator[RenderableType]:
    grid = Table.grid(padding=(0, 1, 0, 0))
    grid.add_column(justify="right", no_wrap=True)
    grid.add_column(no_wrap=True)
    grid.add_column()
    for index, row in shown.items():
        notes = [*(("limits", text) for text in (outside.get(index),) if text), *conditions_of(row, exact)]
        if lost:
            notes += [("lost", text) for text in row.lost_words]
        if any("witness" in text for _, text in notes) or any("witness" in text for text in row.lost_words):
            notes.append(("at", _witness(row)))
        for place, (label, text) in enumerate(notes):
            grid.add_row(str(index) if place == 0 else "", label, text)
    if grid.row_count:
        yield ""
        yield grid


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
