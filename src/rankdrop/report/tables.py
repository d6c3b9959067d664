"""The tables of a report: one per corank, as AM print them (Tables 3–5)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from math import degrees

import numpy as np

from rankdrop.compare import EXACTLY, conditions_of, readable
from rankdrop.families import (
    COUPLED,
    FREE,
    MET,
    NOTHING,
    TESTED,
    Inside,
    inside_limits,
    joint_cell,
    joint_symbol,
    legend,
    near_overview,
    outside_text,
    rounded_share,
    share_text,
)
from rankdrop.family import CorankSummary, Family
from rankdrop.results import Analysis, Conditions
from rankdrop.robot import Robot
from rankdrop.sections import html

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
    heading = f"Corank {summary.corank} <small>rank {summary.rank} of {analysis.generic_rank}</small>"
    starts = (
        f"Of {summary.starts:,} starts: {summary.converged:,} converged, {summary.near_misses:,} near misses, "
        f"{summary.slow:,} slow."
    )
    if not rows:
        smallest = summary.smallest_near_miss
        met = "" if smallest is None else f", smallest σ<sub>{summary.rank + 1}</sub> met {smallest:.4g}"
        return (
            f"<h3>{heading}</h3><p>None found of {summary.starts:,} starts{met}; absence of a find is not a proof.</p>"
            f'<p class="small">{starts}</p>'
        )
    share = summary.completeness
    count = f"{len(rows)} {'family' if len(rows) == 1 else 'families'}"
    css = "good" if share.agree == share.tested else "bad"
    complete = (
        f'<p>{count}, <span class="{css}">{share.agree:,} of {share.tested:,} fresh points explained'
        "</span>.</p>"
    )
    body = "".join(_rows(analysis, derived, row) for row in rows)
    table = f"<table><thead>{_head(analysis.robot, summary)}</thead><tbody>{body}</tbody></table>"
    return (
        f"<h3>{heading}</h3>{complete}{_SWIPE}"
        f"{scrolled(table, f'families of corank {summary.corank}')}<p class='small'>{starts}</p>"
    )


_SWIPE = '<p class="swipe small">The table is wider than the screen: swipe it sideways.</p>'


def scrolled(table: str, name: str) -> str:
    """A table in a box that scrolls sideways, by the keyboard too."""
    return f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(name)}">{table}</div>'


def _head(robot: Robot, summary: CorankSummary) -> str:
    joints = "".join(
        f'<th title="{escape(joint.name)}">{_subscript(joint_symbol(number, str(joint.kind)))}</th>'
        for number, joint in enumerate(robot.variables, start=1)
    )
    lost = "lost direction" if summary.corank == 1 else "lost directions"
    return (
        f'<tr><th><span class="hidden">id</span></th><th class="words">family</th>{joints}<th>dim</th>'
        f'<th class="words">{lost}</th><th>{TESTED}</th><th>{MET}</th></tr>'
    )


def _rows(analysis: Analysis, derived: Conditions | None, row: Family) -> str:
    robot = analysis.robot
    told = row_conditions(analysis, derived, row)
    inside = inside_limits(row, robot) if analysis.settings.limits else None
    row = row if inside is None else inside.shown(row)
    cells = "".join(_cell(row, number, str(joint.kind)) for number, joint in enumerate(robot.variables, start=1))
    lost = "<br>".join(escape(words) for words in row.lost_words)
    sound, share = share_text(row.soundness.agree, row.soundness.tested), rounded_share(row.explained)
    css = "num" if row.soundness.holds else "num bad"
    name = f'<span class="{"" if row.named else "bad"}">{escape(row.name)}</span>'
    button = f'<button data-go="{row.id}" data-far title="Show the arm at the witness">{row.id}</button>'
    first = (
        f'<tr><td>{button}</td><td class="words">{name}</td>{cells}<td class="num">{row.dimension}</td>'
        f'<td class="words lost">{lost}</td><td class="{css}">{sound}</td><td class="num">{share}</td></tr>'
    )
    span = robot.n + 5
    notes = "".join(
        f'<tr class="note"><td></td><td class="words" colspan="{span}">{text}</td></tr>'
        for text in (*_limits(inside, robot), *_notes(robot, row, told))
    )
    return first + notes


def _limits(inside: Inside | None, robot: Robot) -> Iterator[str]:
    if inside is not None and inside.outside:
        yield f'<i class="bad">limits</i>&ensp;{escape(outside_text(inside, robot))}'


def row_conditions(analysis: Analysis, derived: Conditions | None, row: Family) -> list[tuple[str, str]]:
    """(label, text) of the conditions of a row that its cells do not say: the exact ones where they are known."""
    held = {one.number for one in row.pinned}
    for one in () if derived is None else derived.families:
        if (one.id, one.name, one.corank) == (row.id, row.name, row.corank):
            own = [text for (joint, _), text in zip(one.pins, one.texts, strict=False) if joint not in held]
            return [(EXACTLY, readable(text)) for text in (*own, *one.texts[len(one.pins) :])]
    return conditions_of(row, analysis.exact)


def _notes(robot: Robot, row: Family, told: Sequence[tuple[str, str]]) -> Iterator[str]:
    for label, text in told:
        css = "bad" if label == COUPLED else "good"
        yield f'<i class="{css}">{label}</i>&ensp;{escape(text)}'
    if any("witness" in text for text in row.lost_words):
        yield f"witness q = {degrees_text(robot, row.witness)}"


def degrees_text(robot: Robot, q: Sequence[float]) -> str:
    """A configuration as people set it: "(0°, −30.5°, 0.1 m)"."""
    parts = (
        f"{degrees(value):.4g}°" if joint.unit == "rad" else f"{value:.4g} m"
        for joint, value in zip(robot.variables, np.array(q) + 0.0, strict=True)
    )
    return f"({', '.join(parts)})".replace("-", "−")


def _cell(row: Family, number: int, kind: str) -> str:
    text = joint_cell(row, number, kind)
    css = {FREE: "free", COUPLED: "coupled", NOTHING: "free"}.get(text, "pinned")
    return f'<td class="{css}">{escape(text)}</td>'


def _subscript(symbol: str) -> str:
    return f"{symbol[0]}<sub>{symbol[1:]}</sub>"
