"""The tables of a report: one per corank, as AM print them (Tables 3–5)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape

from rankdrop.family import CorankSummary, Family
from rankdrop.results import Analysis, Conditions
from rankdrop.robot import Joint, Robot, witness_text
from rankdrop.sections import html
from rankdrop.text import (
    COUPLED,
    FREE,
    JOINT,
    NOTHING,
    WORDS,
    Column,
    at_witness,
    broken,
    columns,
    conditions_of,
    explained,
    legend,
    lines_of,
    near_overview,
    nothing_found,
    number_of,
    starts,
    title,
    within,
)

STANDING = {"": "", "inside": "", "outside": "outside the joint limits", "none found": "none found inside the limits"}
"""How a family stands to the joint limits, where that needs saying (`content.standing`)."""


def corank_tables(analysis: Analysis, derived: Conditions | None = None) -> str:
    """All tables, each with its title and what its starts did.

    Args:
        analysis: the families.
        derived: their exact conditions, where these do not stand in the analysis.
    """
    key = f'<p class="small">{escape(legend(analysis.robot, analysis.families))}</p>' if analysis.families else ""
    return "".join(_corank(analysis, derived, summary) for summary in analysis.coranks) + key + _near(analysis)


def _near(analysis: Analysis) -> str:
    """Shares of the joint space near families, where they were asked for."""
    return "" if analysis.near is None else html([near_overview(analysis.near, analysis.families)])


def _corank(analysis: Analysis, derived: Conditions | None, summary: CorankSummary) -> str:
    rows = analysis.of_corank(summary.corank)
    heading = f"<h3>{title(summary, analysis.generic_rank)}</h3>"
    ends = f'<p class="small">{starts(summary)}</p>'
    if not rows:
        return f"{heading}<p>{nothing_found(summary).capitalize()}.</p>{ends}"
    share = summary.completeness
    css = "good" if share.agree == share.tested else "bad"
    complete = f'<p>{number_of(rows)}, <span class="{css}">{explained(share)}</span>.</p>'
    body = "".join(_rows(analysis, derived, row) for row in rows)
    table = f"<table><thead>{_head(analysis.robot, summary)}</thead><tbody>{body}</tbody></table>"
    return f"{heading}{complete}{_SWIPE}{scrolled(table, f'families of corank {summary.corank}')}{ends}"


_SWIPE = '<p class="swipe small">The table is wider than the screen: swipe it sideways.</p>'


def scrolled(table: str, name: str) -> str:
    """A table in a box that scrolls sideways, by the keyboard too."""
    return f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(name)}">{table}</div>'


def _head(robot: Robot, summary: CorankSummary) -> str:
    joints = iter(robot.variables)
    return f"<tr>{''.join(_heading(one, joints) for one in columns(robot, summary.corank))}</tr>"


def _heading(column: Column, joints: Iterator[Joint]) -> str:
    if column.key == "id":
        return '<th><span class="hidden">id</span></th>'
    if column.holds == JOINT:
        return f'<th title="{escape(next(joints).name)}">{_subscript(column.title)}</th>'
    return f"<th{_WORDS * (column.holds == WORDS)}>{column.title}</th>"


_WORDS = ' class="words"'


def _rows(analysis: Analysis, derived: Conditions | None, row: Family) -> str:
    robot = analysis.robot
    conditions = conditions_of(row, analysis.exact, () if derived is None else derived.families)
    row, outside = within(row, robot, limits=analysis.settings.limits)
    every = columns(robot, row.corank)
    first = f"<tr>{''.join(_cell(one, row) for one in every)}</tr>"
    limits = [("limits", outside)] if outside else []
    notes = "".join(
        f'<tr class="note"><td></td><td class="words" colspan="{len(every) - 1}">{text}</td></tr>'
        for text in _notes(robot, row, [*limits, *conditions])
    )
    return first + notes


def _cell(column: Column, row: Family) -> str:
    if column.key == "id":
        button = f'<button data-go="{row.id}" data-far title="Show the arm at the witness">{row.id}</button>'
        return f"<td>{button}</td>"
    bad = " bad" * column.failed(row)
    if column.holds == JOINT:
        text = broken(column, row)
        css = {FREE: "free", COUPLED: "coupled", NOTHING: "free"}.get(text, "pinned")
        return f'<td class="{css}">{escape(text)}</td>'
    text = "<br>".join(map(escape, lines_of(column, row)))
    if column.key == "name":
        return f'<td class="words"><span class="{bad.strip()}">{text}</span></td>'
    return f'<td class="{"words lost" if column.holds == WORDS else "num" + bad}">{text}</td>'


def _notes(robot: Robot, row: Family, notes: Sequence[tuple[str, str]]) -> Iterator[str]:
    for label, text in notes:
        css = "bad" if label in (COUPLED, "limits") else "good"
        yield f'<i class="{css}">{label}</i>&ensp;{escape(text)}'
    if at_witness(row):
        yield f"witness {witness_text(robot, row.witness)}"


def _subscript(symbol: str) -> str:
    return f"{symbol[0]}<sub>{symbol[1:]}</sub>"
