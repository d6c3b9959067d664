"""The tables of a report: one per corank, as AM print them (Tables 3–5).

The exact conditions, typeset.
"""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

from rankdrop.exact import ExactFamily, typeset
from rankdrop.family import CorankSummary, ExactRow, Family
from rankdrop.report.content import Content
from rankdrop.results import Analysis, Conditions
from rankdrop.robot import Joint, witness_text
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
    letters_text,
    lines_of,
    near_overview,
    nothing_found,
    number_of,
    starts,
    title,
    within,
)

_SHORT = 70  # characters of LaTeX; conditions up to this stand side by side
_LONG = 420  # a longer one is folded
_LINES = 3  # of what was left unfinished
_NO_SHIFT = 1e-12  # [rad]


def exact_section(content: Content) -> str:
    """The conditions, exactly, typeset."""
    head = '<section id="exact"><h2>Exact conditions</h2>'
    joined = content.analysis.exact
    if joined is not None and joined.families:
        letters = letters_text(joined.letters)
        wrong = "".join(f'<p class="bad">Disagreement: {_cut(one)}</p>' for one in joined.disagreements)
        told = f"<p>The families are derived exactly.{escape(f' Lengths: {letters}.') if letters else ''}</p>"
        return f'{head}{told}<div class="exacts">{"".join(map(_exact_family, joined.families))}</div>{wrong}</section>'
    found = content.exact
    if found is None:
        return f"{head}<p>Not derived: {escape(content.exact_missing)}</p></section>"
    numbers = letters_text(found.letters)
    shifts = [
        f"θ{i} = q{i} {'−' if x < 0 else '+'} {abs(x):.4g}"
        for i, x in enumerate(found.shifts, start=1)
        if abs(x) > _NO_SHIFT
    ]
    words = [
        f"Derived over the rational numbers with lengths as letters, by the method “{escape(found.method)}”. "
        "s<sub>i</sub> is sin θ<sub>i</sub>, c<sub>23</sub> is cos(θ<sub>2</sub> + θ<sub>3</sub>).",
        escape(f"Lengths: {numbers}." if numbers else ""),
        escape(f"Offsets: {', '.join(shifts)}." if shifts else ""),
    ]
    if not found.families:
        same = f"No family: the rank is {found.generic_rank} at every configuration."
        words.append(same if found.verified else "No family was derived.")
    else:
        words.append(
            f"The rank was checked modulo a prime at random points of every family, and {found.explained.agree:,} of "
            f"{found.explained.tested:,} singular configurations found numerically lie on one (seed "
            f"{found.settings.seed})."
        )
    told = "".join(f"<p>{one}</p>" for one in words if one)
    left = "".join(f'<p class="bad">Not finished: {_cut(one)}</p>' for one in found.left[:_LINES])
    if len(found.left) > _LINES:
        left += f'<p class="bad">… and {len(found.left) - _LINES} more.</p>'
    if found.complete:  # of an unfinished derivation it says nothing that a point lies on none of its families
        left += "".join(f'<p class="bad">Disagreement: {_cut(one)}</p>' for one in found.disagreements)
    left += "".join(f'<p class="small">{escape(one)}</p>' for one in found.remarks)
    if found.not_real:
        unreal = "".join(f'<p class="small">{escape(one)}</p>' for one in found.not_real)
        left += f"<details><summary>{len(found.not_real)} sets without a real point</summary>{unreal}</details>"
    return f'{head}{told}<div class="exacts">{"".join(map(_exact_family, found.families))}</div>{left}</section>'


def _cut(text: str) -> str:
    return escape(text if len(text) < _LONG else text[:_LONG] + " …")


def _exact_family(family: ExactFamily | ExactRow) -> str:
    side_by_side = [f"<span>{typeset(one)}</span>" for one in family.latex if len(one) <= _SHORT]
    short = '<span class="comma">,</span> '.join(side_by_side)
    lines = f'<div class="condition">{short}</div>' if short else ""
    for one in family.latex:
        text = f'<div class="condition longer">{typeset(one)}</div>'
        folded = f"<details><summary>a condition of {len(one):,} characters</summary>{text}</details>"
        lines += folded if len(one) > _LONG else text if len(one) > _SHORT else ""
    real = f'<p class="small">{escape(family.reality)}</p>' if family.reality else ""
    return (
        f'<div class="exact"><h3>{family.id}&ensp;{escape(family.name)} <small>dimension {family.dimension}</small>'
        f"</h3>{lines}{real}</div>"
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
    near = "" if analysis.near is None else html([near_overview(analysis.near, analysis.families)])
    return "".join(_corank(analysis, derived, summary) for summary in analysis.coranks) + key + near


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
    joints = iter(analysis.robot.variables)
    head = "".join(_heading(one, joints) for one in columns(analysis.robot, summary.corank))
    table = f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    return f"{heading}{complete}{_SWIPE}{scrolled(table, f'families of corank {summary.corank}')}{ends}"


_SWIPE = '<p class="swipe small">The table is wider than the screen: swipe it sideways.</p>'


def scrolled(table: str, name: str) -> str:
    """A table in a box that scrolls sideways, by the keyboard too."""
    return f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(name)}">{table}</div>'


def _heading(column: Column, joints: Iterator[Joint]) -> str:
    if column.key == "id":
        return '<th><span class="hidden">id</span></th>'
    if column.holds == JOINT:
        return f'<th title="{escape(next(joints).name)}">{column.title[0]}<sub>{column.title[1:]}</sub></th>'
    return f"<th{_WORDS * (column.holds == WORDS)}>{column.title}</th>"


_WORDS = ' class="words"'


def _rows(analysis: Analysis, derived: Conditions | None, row: Family) -> str:
    robot = analysis.robot
    conditions = conditions_of(row, analysis.exact, () if derived is None else derived.families)
    row, outside = within(row, robot, limits=analysis.settings.limits)
    every = columns(robot, row.corank)
    first = f"<tr>{''.join(_cell(one, row) for one in every)}</tr>"
    notes = [
        f'<i class="{"bad" if label in (COUPLED, "limits") else "good"}">{label}</i>&ensp;{escape(text)}'
        for label, text in (*([("limits", outside)] if outside else []), *conditions)
    ]
    notes += [f"witness {witness_text(robot, row.witness)}"] * at_witness(row)
    return first + "".join(
        f'<tr class="note"><td></td><td class="words" colspan="{len(every) - 1}">{text}</td></tr>' for text in notes
    )


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
