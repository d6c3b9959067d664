"""The sections of the page: tables of families, exact conditions, joint space, workspace, σ along lines, verification.

There is a table for each corank, as AM print them (Tables 3–5). Sentences say how the numbers were checked, with
counts, seeds and tolerances.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape
from math import degrees

import numpy as np

from rankdrop.distance import Workspace
from rankdrop.families import CorankSummary, Family, Slice, exact_of
from rankdrop.formula import typeset
from rankdrop.lists import flat_map
from rankdrop.report.chart import look_of, projections, slice_chart, sweep_chart, workspace_chart
from rankdrop.report.content import Content
from rankdrop.results import Analysis, Conditions
from rankdrop.robot import Array, Joint, Robot, count
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
    joint_symbol,
    legend,
    letters_text,
    lines_of,
    near_overview,
    nothing_found,
    number_of,
    restrict_to_limits,
    sampled,
    starts,
    title,
    unseen,
    witness_text,
)

_SHORT = 70  # characters of LaTeX; conditions up to this stand side by side
_LONG = 420  # a longer one is folded
_LINES = 3  # of what was left unfinished
_NO_SHIFT = 1e-12  # [rad]

STANDING = {"": "", "inside": "", "outside": "outside the joint limits", "none found": "none found inside the limits"}
"""How a family stands to the joint limits, where that needs saying (`content.standing`)."""

_SWIPE = '<p class="swipe small">The table is wider than the screen: swipe it sideways.</p>'

_WORDS = ' class="words"'

_WIDE = 0.5  # a family whose tips are in more than this share of the cells that they could meet fills a region


def exact_section(content: Content) -> str:
    """The conditions, exactly, typeset."""
    head = '<section id="exact"><h2>Exact conditions</h2>'
    joined, derived = content.analysis.exact, content.exact
    shown = [_exact_family(family) for family in content.analysis.families if family.exact is not None]
    if joined is not None and shown:
        letters = letters_text(joined.letters)
        lengths = escape(f" Lengths: {letters}." if letters else "")
        summary = _paragraphs([f"The families are derived exactly.{lengths}"])
        contradicted = [f"Disagreement: {_cut(str(contradiction))}" for contradiction in joined.disagreements]
        after = _paragraphs(contradicted, "bad")
    elif derived is None:
        return f"{head}<p>Not derived: {escape(content.exact_missing)}</p></section>"
    else:
        shown = [_exact_family(family) for family in derived.families]
        after = _open_ends(derived)
        summary = _paragraphs(_derivation(derived))
    return f'{head}{summary}<div class="exacts">{"".join(shown)}</div>{after}</section>'


def _paragraphs(texts: Iterable[str], css: str = "") -> str:
    """Paragraphs of HTML; empty ones are left out."""
    kind = f' class="{css}"' if css else ""
    return "".join(f"<p{kind}>{text}</p>" for text in texts if text)


def _derivation(derived: Conditions) -> Iterator[str]:
    """How the conditions were derived and checked, as HTML."""
    yield (
        f"Derived over the rational numbers with lengths as letters, by the method “{escape(derived.method)}”. "
        "s<sub>i</sub> is sin θ<sub>i</sub>, c<sub>23</sub> is cos(θ<sub>2</sub> + θ<sub>3</sub>)."
    )
    numbers = letters_text(derived.letters)
    shifts = ", ".join(f"θ{i} = q{i} {'−' if x < 0 else '+'} {abs(x):.4g}"
                       for i, x in enumerate(derived.shifts, start=1) if abs(x) > _NO_SHIFT)  # fmt: skip
    yield escape(f"Lengths: {numbers}.") if numbers else ""
    yield escape(f"Offsets: {shifts}.") if shifts else ""
    if derived.families:
        yield (
            f"The rank was checked modulo a prime at random points of every family, and {derived.explained.agree:,} of "
            f"{derived.explained.tested:,} singular configurations found numerically lie on one (seed "
            f"{derived.settings.seed})."
        )
    elif derived.undivided:
        yield derived.answer
    elif derived.verified:
        yield f"No family: the rank is {derived.generic_rank} at every configuration."
    else:
        yield "No family was derived."


def _open_ends(derived: Conditions) -> str:
    """What was left unfinished, disagrees, is remarked, or has no real point, as HTML."""
    unfinished = [f"Not finished: {_cut(str(left))}" for left in derived.left[:_LINES]]
    if len(derived.left) > _LINES:
        unfinished.append(f"… and {len(derived.left) - _LINES} more.")
    if derived.complete:  # a point on none of the families says nothing about an unfinished derivation
        unfinished += [f"Disagreement: {_cut(str(contradiction))}" for contradiction in derived.disagreements]
    remarks = _paragraphs((escape(str(remark)) for remark in derived.remarks), "small")
    open_ends = _paragraphs(unfinished, "bad") + remarks
    if not derived.not_real:
        return open_ends
    unreal = _paragraphs((escape(str(unreal_set)) for unreal_set in derived.not_real), "small")
    return f"{open_ends}<details><summary>{len(derived.not_real)} sets without a real point</summary>{unreal}</details>"


def _cut(text: str) -> str:
    return escape(text if len(text) < _LONG else text[:_LONG] + " …")


def _exact_family(family: Family) -> str:
    exact = exact_of(family)
    side_by_side = [f"<span>{typeset(formula)}</span>" for formula in exact.latex if len(formula) <= _SHORT]
    short = '<span class="comma">,</span> '.join(side_by_side)
    if short:
        lines = f'<div class="condition">{short}</div>'
    else:
        lines = ""
    for formula in exact.latex:
        text = f'<div class="condition longer">{typeset(formula)}</div>'
        folded = f"<details><summary>a condition of {len(formula):,} characters</summary>{text}</details>"
        if len(formula) > _LONG:
            lines += folded
        elif len(formula) > _SHORT:
            lines += text
    if exact.reality:
        real = f'<p class="small">{escape(exact.reality)}</p>'
    else:
        real = ""
    return (
        f'<div class="exact"><h3>{family.id}&ensp;{escape(family.name)} <small>dimension {family.dimension}</small>'
        f"</h3>{lines}{real}</div>"
    )


def corank_tables(analysis: Analysis) -> str:
    """All tables, each with its title and what its starts did."""
    if analysis.families:
        key = f'<p class="small">{escape(legend(analysis.robot, analysis.families))}</p>'
    else:
        key = ""
    if analysis.near is None:
        near = ""
    else:
        near = html([near_overview(analysis.near, analysis.families)])
    return "".join(_corank(analysis, summary) for summary in analysis.coranks) + key + near


def _corank(analysis: Analysis, summary: CorankSummary) -> str:
    rows = analysis.of_corank(summary.corank)
    heading = f"<h3>{title(summary, analysis.generic_rank)}</h3>"
    ends = f'<p class="small">{starts(summary)}</p>'
    if not rows:
        return f"{heading}<p>{nothing_found(summary).capitalize()}.</p>{ends}"
    share = summary.completeness
    if share.agree == share.tested:
        css = "good"
    else:
        css = "bad"
    complete = f'<p>{number_of(rows)}, <span class="{css}">{explained(share)}</span>.</p>'
    body = "".join(_rows(analysis, row) for row in rows)
    joints = iter(analysis.robot.variables)
    head = "".join(_heading(column, joints) for column in columns(analysis.robot, summary.corank))
    table = f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    return f"{heading}{complete}{_SWIPE}{scroll_box(table, f'families of corank {summary.corank}')}{ends}"


def scroll_box(table: str, name: str) -> str:
    """A table in a box that scrolls sideways, by the keyboard too."""
    return f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(name)}">{table}</div>'


def _heading(column: Column, joints: Iterator[Joint]) -> str:
    if column.key == "id":
        return '<th><span class="hidden">id</span></th>'
    if column.holds == JOINT:
        return f'<th title="{escape(next(joints).name)}">{column.title[0]}<sub>{column.title[1:]}</sub></th>'
    return f"<th{_WORDS * (column.holds == WORDS)}>{column.title}</th>"


def _rows(analysis: Analysis, row: Family) -> str:
    robot = analysis.robot
    conditions = conditions_of(row)
    row, outside = restrict_to_limits(row, robot, limits=analysis.settings.limits)
    every = columns(robot, row.corank)
    first = f"<tr>{''.join(_cell(column, row) for column in every)}</tr>"
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


def names_of(robot: Robot) -> list[str]:
    """θ1 … of every joint."""
    return [joint_symbol(number, str(joint.kind)) for number, joint in enumerate(robot.variables, start=1)]


def spread(section: Workspace, points: Array) -> float:
    """Share of the workspace's cells in which a family has a tip, of as many as it could have met."""
    cells = np.unique([np.digitize(points[:, 0], section.x), np.digitize(points[:, 1], section.y)], axis=1)
    return float(cells.shape[1] / max(1, min(len(points), int((section.tips > 0).sum()))))


def slice_section(content: Content) -> str:
    """Planes of joint space."""
    figures = "".join(
        f"<figure>{_slice_svg(content, plane)}<figcaption>{_slice_words(content, plane)}</figcaption>"
        "</figure>"
        for plane in content.slices
    )
    if not figures:
        section = '<section id="slices"><h2>Joint space</h2><p>No family with conditions to draw.</p></section>'
        if content.analysis.families:
            return section
        return ""
    rank = content.analysis.generic_rank
    return (
        f'<section id="slices"><h2>Joint space</h2><p>Two joints move, the others are held. Shade: σ<sub>{rank}</sub>, '
        "stronger where it is small. Curves and dots: the families, solved from their conditions; every point drawn "
        f'was checked in the Jacobian.</p><div class="figures">{figures}</div></section>'
    )


def _slice_svg(content: Content, plane: Slice) -> str:
    chart = slice_chart(content.analysis.robot, plane, content.colours, content.labels)
    seen = ", ".join(trace.family for trace in plane.traces) or "no family"
    return chart.svg(f"Slice of joint space, {chart.names[0]} across and {chart.names[1]} up: curves or dots of {seen}")


def _slice_words(content: Content, plane: Slice) -> str:
    robot = content.analysis.robot
    keys = ", ".join(f"{_key(content, trace.family)} {escape(content.labels[trace.family])}" for trace in plane.traces)
    keys = f"{keys}." if keys else ""
    held = _held_joints(robot, plane.q, plane.joints)
    filled = "".join(f" The whole slice lies in {name}." for name in plane.filled)
    return f"{keys} Through a point of <b>{plane.family}</b>{': ' + held if held else ''}.{filled}"


def _held_joints(robot: Robot, q: Iterable[float], moving: Sequence[int]) -> str:
    """Values of the joints that stand still: "θ2 = 30°, q3 = 0.2 m"."""
    parts = []
    for number, (joint, name, value) in enumerate(zip(robot.variables, names_of(robot), q, strict=True), start=1):
        if number not in moving:
            parts.append(f"{name} = {degrees(value):.4g}°" if joint.unit == "rad" else f"{name} = {value:.4g} m")
    return ", ".join(parts).replace("-", "−")


def _key(content: Content, family: str) -> str:
    return f'<span class="dot" style="background:var(--{look_of(content.colours[family])})"></span><b>{family}</b>'


def solid_section(content: Content) -> str:
    """Families that tie three joints together."""
    if not content.solids:
        return ""
    robot, figures = content.analysis.robot, []
    names = names_of(robot)
    for number, solid in enumerate(content.solids, start=1):
        axes = ", ".join(names[joint - 1] for joint in solid.joints)
        held = _held_joints(robot, solid.q, solid.joints)
        curves = count(len(solid.curves), "closed curve" if solid.closed == len(solid.curves) else "curve")
        curves += f", {solid.closed} of them closed" * (solid.closed < len(solid.curves))
        if solid.curves:
            what = curves
        else:
            what = f"a surface, {len(solid.triangles):,} triangles"
        figures.append(
            f'<figure><canvas id="solid{number}" role="img" tabindex="0" aria-label="The set of {solid.family} in the '
            f'cube of {axes}: {what}. Arrow keys turn it."></canvas>'
            f"<figcaption>{_key(content, solid.family)} {escape(content.labels[solid.family])}, in ({axes}): {what}, "
            "up to whole turns"
            f"{'; held: ' + escape(held) if held else ''}.<span class='screen'> Drag to turn.</span></figcaption>"
            "</figure>"
        )
        for chart in projections(robot, solid, content.colours[solid.family]) if solid.curves else []:
            across, up = chart.names
            seen = f"{solid.family}: the curves seen along the third joint, {across} across and {up} up"
            text = f"<figcaption>{_key(content, solid.family)} projected.</figcaption>"
            figures.append(f"<figure>{chart.svg(seen)}{text}</figure>")
    return (
        '<section id="solids"><h3>In three joints</h3><p>Families that tie three joints together, as curves '
        'or surfaces in the cube of these joints, −180° … 180°.</p>'
        f'<div class="figures">{"".join(figures)}</div></section>'
    )


def workspace_section(content: Content) -> str:
    """The workspace with the images of the families."""
    section = content.workspace
    figures = []
    if len(section.walls):
        share = f"{int(section.one_sided.sum()):,} of {len(section.walls):,}"
        seen = "where the tip can be; walls, dark where not crossed, orange where passed by posture"
        chart = workspace_chart(section, 440.0).svg(f"Workspace in section: {seen}")
        figures.append(
            f"<figure>{chart}<figcaption>Grey: where the tip can be ({section.count:,} random "
            "configurations). Dots: postures in which the position of the tip loses a direction. <b>Dark</b>: to "
            f"second order no motion from that posture crosses the wall ({share}): boundaries of the workspace and of "
            'voids, barriers inside. <b class="bad">Orange</b>: the arm passes by changing its posture.'
            "</figcaption>"
            "</figure>"
        )
    for family, points in section.images:
        if not len(points):
            continue
        fills = spread(section, points) > _WIDE
        if fills:
            words = "can occur wherever there are dots, it depends on the posture"
        else:
            words = "occurs at these places"
        chart = workspace_chart(section, 320.0, family, content.colours[family]).svg(
            "Workspace in section: where the tip is while the arm is in this family"
        )
        figures.append(
            f"<figure>{chart}<figcaption>{_key(content, family)} "
            f"{escape(content.labels[family])}: {words} ({len(points):,} members).</figcaption></figure>"
        )
    if not figures:
        return ""
    if section.section.planar:
        about = "in its plane"
    else:
        about = "in section: distance from axis 1, and height along it"
    return (
        f'<section id="workspace"><h2>Workspace</h2><p>The tip {about}. Limits of turning joints are ignored, as they '
        f'are for the families.</p><div class="figures">{"".join(figures)}</div></section>'
    )


def line_section(content: Content) -> str:
    """Each joint swept through each witness."""
    analysis = content.analysis
    rank = analysis.generic_rank
    if not analysis.families:
        return ""
    parts = []
    for family, swept in zip(analysis.families, content.sweeps, strict=True):
        drawn = [sweep_chart(analysis.robot, sweep, family.corank) for sweep in swept]
        charts = "".join(chart.svg(f"Singular values as {chart.title} moves through the witness") for chart in drawn)
        title = escape(content.titles[family.id])
        parts.append(f"<h3>{family.id}&ensp;<small>{title}</small></h3><div class='lines'>{charts}</div>")
    return (
        '<section id="lines"><h2>σ along lines</h2><p>Each joint turns in full, or slides its travel, through the '
        f'witness of a family (dashed line). <b class="bad">Bold</b>: the singular values that vanish there, '
        f"σ<sub>{rank}</sub> and up; thin: the next one. Where the bold line stays at zero, that joint does not lead "
        f"out.</p>{''.join(parts)}</section>"
    )


def verification_section(content: Content) -> str:
    """What was checked, how often, with which tolerances and seeds."""
    items = "".join(f"<li>{escape(text)}</li>" for text in checks(content))
    tolerances = "".join(
        f"<tr><td class='words'>{name}</td><td class='num'>{value:g}</td></tr>"
        for name, value in content.analysis.settings.tolerances.to_dict().items()
    )
    return (
        f'<section id="checks"><h2>How this was checked</h2><ul class="checks">{items}</ul>'
        "<p>These are tests on samples, not proofs. A corank that was not found is not thereby shown to be absent.</p>"
        f"<details><summary>tolerances</summary>{scroll_box(f'<table>{tolerances}</table>', 'tolerances')}</details>"
        f"<p class='{'good' if content.verdict.holds else 'bad'}'>{escape(content.verdict.sentence)}</p>"
        "</section>"
    )


def checks(content: Content) -> Iterator[str]:
    """One sentence for each check; the residuals are evaluated anew while the report is made."""
    analysis = content.analysis
    settings, left = analysis.settings, analysis.residual()
    if settings.limits:
        where = "within the joint limits"
    else:
        where = "in the whole joint space, joint limits ignored"
    yield f"Search: {settings.starts:,} random starts for each corank {where}; seed {settings.seed}."
    if analysis.families:
        yield sampled(analysis)
        yield (
            f"Evaluated again for this report: at the witnesses the equations leave {left.equation:.1e} at most, the "
            f"singular values that have to vanish {left.sigma:.1e} at most."
        )
    if missed := unseen(analysis):
        yield missed
    if analysis.coranks:
        last = analysis.coranks[-1]
    else:
        last = None
    if last is not None and not last.converged:
        if last.smallest_near_miss is None:
            met = ""
        else:
            met = f"; the smallest σ found was {last.smallest_near_miss:.4g}"
        yield f"Corank {last.corank}: none found of {last.starts:,} starts{met}. That is no proof of absence."
    yield from _draw_content(content)
    yield f"Singular values have no unit: translations are divided by {settings.length_scale:.4g} m."


def _draw_content(content: Content) -> Iterator[str]:
    traces = flat_map(lambda plane: plane.traces, content.slices)
    curves = sum(map(len, flat_map(lambda trace: (*trace.curves, trace.points), traces)))
    solid = sum(len(solid.vertices) + sum(map(len, solid.curves)) for solid in content.solids)
    images = sum(len(points) for _, points in content.workspace.images)
    singular = content.analysis.settings.tolerances.singular
    yield (
        f"Drawn: {curves:,} points of slices, {solid:,} of sets in three joints and {images:,} members of "
        f"families in the workspace, each with σ ≤ {singular:g} in the Jacobian (seed {content.workspace.seed})."
    )
    if content.exact is not None and content.exact.families:
        yield _rank_checks(content.exact)


def _rank_checks(derived: Conditions) -> str:
    checks = [exact_of(family).rank_check for family in derived.families]
    agree, tested = sum(check.agree for check in checks), sum(check.tested for check in checks)
    if derived.in_families:
        word = "nothing was left unfinished"
    else:
        word = "not finished within its time limit"
    return (
        f"Exact conditions: the rank modulo a prime is as claimed at {agree:,} of {tested:,} random points, and "
        f"{derived.explained.agree:,} of {derived.explained.tested:,} singular configurations lie on a family; {word}."
    )
