"""The lower sections of the page: joint space, workspace, σ along lines, verification.

How the numbers were checked is told in sentences with counts, seeds and tolerances.

The charts of a report as SVG: slices, sets in three joints, workspace, σ along lines.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape
from math import degrees, pi

import numpy as np

from rankdrop.families import Slice, Solid, Sweep, Workspace
from rankdrop.report.content import Content, pieces
from rankdrop.report.svg import Chart, angle_ticks, axis_name, plain_ticks
from rankdrop.report.tables import scrolled
from rankdrop.results import sampled, unseen
from rankdrop.robot import Array, Robot, count
from rankdrop.text import joint_symbol

COLOURS = 8
_SMALL = 130.0


def colour(index: int) -> str:
    """The style of one family: its colour, the same everywhere on the page."""
    return f"stroke:var(--f{1 + index % COLOURS})"


def names_of(robot: Robot) -> list[str]:
    """θ1 … of every joint."""
    return [joint_symbol(number, str(joint.kind)) for number, joint in enumerate(robot.variables, start=1)]


def slice_chart(robot: Robot, plane: Slice, colours: dict[str, int]) -> str:
    """σ_r as a grey map (dark: small), the families as curves and dots."""
    chart = Chart((plane.x[0], plane.x[-1]), (plane.y[0], plane.y[-1]))
    units = [robot.variables[number - 1].unit for number in plane.joints]
    ranges = ((plane.x[0], plane.x[-1]), (plane.y[0], plane.y[-1]))
    ticks = [(angle_ticks if unit == "rad" else plain_ticks)(*ends) for unit, ends in zip(units, ranges, strict=True)]
    top = max(float(plane.sigma.max()), 1e-12)
    parts = [chart.image(0.75 * (1 - plane.sigma[::2, ::2] / top) ** 3)]
    names = names_of(robot)
    labels = tuple(axis_name(names[number - 1], unit) for number, unit in zip(plane.joints, units, strict=True))
    parts.append(chart.axes((labels[0], labels[1]), (ticks[0], ticks[1])))
    for trace in plane.traces:
        style = colour(colours[trace.family])
        parts.append(chart.path(trace.curves, "curve", style))
        parts.append(chart.dots(trace.points, "", 4.0, style))
    seen = ", ".join(trace.family for trace in plane.traces) or "no family"
    return chart.svg(parts, f"Slice of joint space, {labels[0]} across and {labels[1]} up: curves or dots of {seen}")


def projections(robot: Robot, solid: Solid, index: int) -> list[str]:
    """Curves in the cube of three joints seen along each axis (AM Figure 5a)."""
    names = [names_of(robot)[number - 1] for number in solid.joints]
    found = []
    for a, b in ((0, 1), (1, 2), (0, 2)):
        ends = (-pi * 1.04, pi * 1.04)
        chart = Chart(ends, ends, width=250, height=250)
        lines = [piece[:, [a, b]] for line in solid.curves for piece in pieces(line)]
        parts = [chart.axes((names[a], names[b]), (angle_ticks(*ends), angle_ticks(*ends)))]
        parts.append(chart.path(lines, "curve", colour(index)))
        seen = f"{solid.family}: the curves seen along the third joint, {names[a]} across and {names[b]} up"
        found.append(chart.svg(parts, seen))
    return found


def workspace_chart(section: Workspace, size: float, marks: Sequence[tuple[Array, str, float, str]], seen: str) -> str:
    """Where the tip can be (grey), under dots: (points, class, radius, style) of each kind."""
    chart = _map_chart(section, size)
    few = [max(2, round(side / 70)) for side in (chart.width, chart.height)]
    axes = chart.axes(section.section.labels, (plain_ticks(*chart.x, few[0]), plain_ticks(*chart.y, few[1])))
    parts = [_tips(chart, section), axes, *(chart.dots(*mark) for mark in marks)]
    return chart.svg(parts, f"Workspace in section: {seen}")


def spread(section: Workspace, points: Array) -> float:
    """Share of the workspace's cells in which a family has a tip, of as many as it could have met."""
    cells = len(
        np.unique(np.stack([np.digitize(points[:, 0], section.x), np.digitize(points[:, 1], section.y)]), axis=1).T
    )
    return cells / max(1, min(len(points), int((section.tips > 0).sum())))


def _map_chart(section: Workspace, size: float) -> Chart:
    x, y = ((float(edges[0]), float(edges[-1])) for edges in (section.x, section.y))
    longer = max(x[1] - x[0], y[1] - y[0])
    return Chart(x, y, width=size * (x[1] - x[0]) / longer, height=size * (y[1] - y[0]) / longer)


def _tips(chart: Chart, section: Workspace) -> str:
    kept = section.tips
    most = max(float(np.quantile(kept[kept > 0], 0.95)) if (kept > 0).any() else 1.0, 1.0)
    dark = np.where(kept > 0, 0.12 + 0.33 * np.minimum(kept / most, 1.0) ** 0.5, 0.0)
    return chart.image(dark)


def sweep_chart(robot: Robot, sweep: Sweep, corank: int) -> str:
    """σ_r (bold) and the next ones as one joint moves; the dashed line is the witness."""
    shown = sweep.sigma[:, ::-1][:, : corank + 1 if corank > 1 else 2]
    high = max(float(shown.max()) * 1.05, 1e-9)
    chart = Chart(
        (float(sweep.values[0]), float(sweep.values[-1])), (0.0, high), width=_SMALL, height=0.62 * _SMALL, left=36,
        bottom=20, top=16, right=6,
    )  # fmt: skip
    name = names_of(robot)[sweep.number - 1]
    parts = [f'<text class="name" x="{chart.left}" y="11">{name}</text>']
    parts.append(
        f'<rect class="frame" x="{chart.left}" y="{chart.top}" width="{chart.width}" height="{chart.height}"/>'
    )
    ends = ("−180°", "180°") if robot.periodic[sweep.number - 1] else tuple(f"{x:.2g}" for x in chart.x)
    base = chart.top + chart.height + 14
    parts.append(f'<text x="{chart.left}" y="{base}">{ends[0]}</text>')
    parts.append(f'<text x="{chart.left + chart.width}" y="{base}" text-anchor="end">{ends[1]}</text>')
    parts.append(f'<text x="{chart.left - 3}" y="{chart.top + 9}" text-anchor="end">{high:.2g}</text>')
    parts.append(chart.upright(sweep.at, "here"))
    for k in range(shown.shape[1] - 1, -1, -1):
        lost = k < corank
        parts.append(chart.path([np.stack([sweep.values, shown[:, k]], axis=1)], "s0" if lost else "s1"))
    return chart.svg(parts, f"Singular values as {name} moves through the witness")


_WIDE = 0.5  # a family whose tips are in more than this share of the cells that they could meet fills a region


def slice_section(content: Content) -> str:
    """Planes of joint space."""
    robot = content.analysis.robot
    figures = "".join(
        f"<figure>{slice_chart(robot, plane, content.colours)}<figcaption>{_slice_words(content, plane)}</figcaption>"
        "</figure>"
        for plane in content.slices
    )
    if not figures:
        told = '<section id="slices"><h2>Joint space</h2><p>No family with conditions to draw.</p></section>'
        return told if content.analysis.families else ""
    rank = content.analysis.generic_rank
    return (
        f'<section id="slices"><h2>Joint space</h2><p>Two joints move, the others are held. Shade: σ<sub>{rank}</sub>, '
        "stronger where it is small. Curves and dots: the families, solved from their conditions; every point drawn "
        f'was checked in the Jacobian.</p><div class="figures">{figures}</div></section>'
    )


def _slice_words(content: Content, plane: Slice) -> str:
    robot = content.analysis.robot
    keys = " ".join(_key(content, trace.family) for trace in plane.traces)
    held = _held(robot, plane.q, plane.joints)
    filled = "".join(f" The whole slice lies in {one}." for one in plane.filled)
    return f"{keys} Through a point of <b>{plane.family}</b>{': ' + held if held else ''}.{filled}"


def _held(robot: Robot, q: Iterable[float], moving: Sequence[int]) -> str:
    """Values of the joints that stand still: "θ2 = 30°, q3 = 0.2 m"."""
    parts = []
    for number, (joint, name, value) in enumerate(zip(robot.variables, names_of(robot), q, strict=True), start=1):
        if number not in moving:
            parts.append(f"{name} = {degrees(value):.4g}°" if joint.unit == "rad" else f"{name} = {value:.4g} m")
    return ", ".join(parts).replace("-", "−")


def _key(content: Content, family: str) -> str:
    index = content.colours[family] % COLOURS
    return f'<span class="dot" style="background:var(--f{1 + index})"></span><b>{family}</b>'


def solid_section(content: Content) -> str:
    """Families that tie three joints together."""
    if not content.solids:
        return ""
    robot, figures = content.analysis.robot, []
    names = names_of(robot)
    for number, one in enumerate(content.solids, start=1):
        axes = ", ".join(names[joint - 1] for joint in one.joints)
        held = _held(robot, one.q, one.joints)
        curves = count(len(one.curves), "closed curve" if one.closed == len(one.curves) else "curve")
        curves += f", {one.closed} of them closed" * (one.closed < len(one.curves))
        what = curves if one.curves else f"a surface, {len(one.triangles):,} triangles"
        figures.append(
            f'<figure><canvas id="solid{number}" role="img" tabindex="0" aria-label="The set of {one.family} in the '
            f'cube of {axes}: {what}. Arrow keys turn it."></canvas>'
            f"<figcaption>{_key(content, one.family)} in ({axes}): {what}, up to whole turns"
            f"{'; held: ' + escape(held) if held else ''}.<span class='screen'> Drag to turn.</span></figcaption>"
            "</figure>"
        )
        for text in projections(robot, one, content.colours[one.family]) if one.curves else []:
            figures.append(f"<figure>{text}<figcaption>{_key(content, one.family)} projected.</figcaption></figure>")
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
        passed, barred = section.walls[~section.one_sided], section.walls[section.one_sided]
        seen = "where the tip can be; walls, dark where not crossed, orange where passed by posture"
        chart = workspace_chart(section, 440.0, [(passed, "pass", 0.9, ""), (barred, "wall", 1.1, "")], seen)
        figures.append(
            f"<figure>{chart}<figcaption>Grey: where the tip can be ({section.count:,} random "
            "configurations). Dots: postures in which the position of the tip loses a direction. <b>Dark</b>: to "
            f"second order no motion from that posture crosses the wall ({share}): boundaries of the workspace and of "
            'voids, barriers inside. <b class="bad">Orange</b>: the arm passes by changing its posture.'
            "</figcaption>"
            "</figure>"
        )
    names = {family.id: family.name for family in content.analysis.families}
    for family, points in section.images:
        if not len(points):
            continue
        fills = spread(section, points) > _WIDE
        words = "can occur wherever there are dots, it depends on the posture" if fills else "occurs at these places"
        image = [(points, "", 1.0, colour(content.colours[family]))]
        chart = workspace_chart(section, 320.0, image, "where the tip is while the arm is in this family")
        figures.append(
            f"<figure>{chart}<figcaption>{_key(content, family)} "
            f"{escape(names[family])}: {words} ({len(points):,} members).</figcaption></figure>"
        )
    if not figures:
        return ""
    about = "in its plane" if section.section.planar else "in section: distance from axis 1, and height along it"
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
        charts = "".join(sweep_chart(analysis.robot, one, family.corank) for one in swept)
        parts.append(f"<h3>{family.id}&ensp;<small>{escape(family.name)}</small></h3><div class='lines'>{charts}</div>")
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
        f"<details><summary>tolerances</summary>{scrolled(f'<table>{tolerances}</table>', 'tolerances')}</details>"
        f"<p class='{'good' if content.verdict.holds else 'bad'}'>{escape(content.verdict.sentence)}</p>"
        "</section>"
    )


def checks(content: Content) -> Iterator[str]:
    """One sentence for each check; the residuals are evaluated anew while the report is made."""
    analysis = content.analysis
    settings, again = analysis.settings, analysis.residual()
    where = "within the joint limits" if settings.limits else "in the whole joint space, joint limits ignored"
    yield f"Search: {settings.starts:,} random starts for each corank {where}; seed {settings.seed}."
    if analysis.families:
        yield sampled(analysis)
        yield (
            f"Evaluated again for this report: at the witnesses the equations leave {again.equation:.1e} at most, the "
            f"singular values that have to vanish {again.sigma:.1e} at most."
        )
    if missed := unseen(analysis):
        yield missed
    last = analysis.coranks[-1] if analysis.coranks else None
    if last is not None and not last.converged:
        met = "" if last.smallest_near_miss is None else f"; the smallest σ met was {last.smallest_near_miss:.4g}"
        yield f"Corank {last.corank}: none found of {last.starts:,} starts{met}. That is no proof of absence."
    yield from _drawn(content)
    yield f"Singular values have no unit: translations are divided by {settings.length_scale:.4g} m."


def _drawn(content: Content) -> Iterator[str]:
    curves = sum(len(line) for plane in content.slices for trace in plane.traces for line in trace.curves)
    points = sum(len(trace.points) for plane in content.slices for trace in plane.traces)
    solid = sum(len(one.vertices) + sum(map(len, one.curves)) for one in content.solids)
    images = sum(len(points) for _, points in content.workspace.images)
    singular = content.analysis.settings.tolerances.singular
    yield (
        f"Drawn: {curves + points:,} points of slices, {solid:,} of sets in three joints and {images:,} members of "
        f"families in the workspace, each with σ ≤ {singular:g} in the Jacobian (seed {content.workspace.seed})."
    )
    if content.exact is not None and content.exact.families:
        ranks = [family.rank_check for family in content.exact.families]
        agree, tested = sum(one.agree for one in ranks), sum(one.tested for one in ranks)
        word = "nothing was left unfinished" if content.exact.complete else "not finished within its time limit"
        yield (
            f"Exact conditions: the rank modulo a prime is as claimed at {agree:,} of {tested:,} random points, and "
            f"{content.exact.explained.agree:,} of {content.exact.explained.tested:,} singular configurations lie on a "
            f"family; {word}."
        )
