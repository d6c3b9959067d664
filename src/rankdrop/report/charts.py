"""The charts of a report as SVG: slices, sets in three joints, workspace, σ along lines."""

from __future__ import annotations

from math import pi

import numpy as np

from rankdrop.families import Slice, Solid, Sweep, Workspace
from rankdrop.report.data import pieces
from rankdrop.report.svg import Chart, angle_ticks, plain_ticks
from rankdrop.robot import Array, Robot
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
    kinds = [robot.periodic[number - 1] for number in plane.joints]
    ranges = ((plane.x[0], plane.x[-1]), (plane.y[0], plane.y[-1]))
    ticks = [angle_ticks(*ends) if turns else plain_ticks(*ends) for turns, ends in zip(kinds, ranges, strict=True)]
    top = max(float(plane.sigma.max()), 1e-12)
    parts = [chart.image(0.75 * (1 - plane.sigma[::2, ::2] / top) ** 3)]
    names = names_of(robot)
    labels = tuple(f"{names[number - 1]} [{robot.variables[number - 1].unit}]" for number in plane.joints)
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
        parts = [chart.axes((f"{names[a]} [rad]", f"{names[b]} [rad]"), (angle_ticks(*ends), angle_ticks(*ends)))]
        parts.append(chart.path(lines, "curve", colour(index)))
        seen = f"{solid.family}: the curves seen along the third joint, {names[a]} across and {names[b]} up"
        found.append(chart.svg(parts, seen))
    return found


def workspace_chart(section: Workspace) -> str:
    """Where the tip can be (grey), with the walls: dark where they bound, orange where another posture passes."""
    chart = _map_chart(section, 440.0)
    parts = [_tips(chart, section), _axes(chart, section)]
    parts.append(chart.dots(section.walls[~section.one_sided], "pass", 0.9))
    parts.append(chart.dots(section.walls[section.one_sided], "wall", 1.1))
    seen = "Workspace in section: where the tip can be; walls, dark where not crossed, orange where passed by posture"
    return chart.svg(parts, seen)


def image_chart(section: Workspace, points: Array, index: int) -> str:
    """The image of one family over the workspace."""
    chart = _map_chart(section, 320.0)
    parts = [_tips(chart, section), _axes(chart, section), chart.dots(points, "", 1.0, colour(index))]
    return chart.svg(parts, "Workspace in section: where the tip is while the arm is in this family")


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


def _axes(chart: Chart, section: Workspace) -> str:
    few = [max(2, round(side / 70)) for side in (chart.width, chart.height)]
    return chart.axes(section.section.labels, (plain_ticks(*chart.x, few[0]), plain_ticks(*chart.y, few[1])))


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
    ends = ("−π", "π") if robot.periodic[sweep.number - 1] else tuple(f"{x:.2g}" for x in chart.x)
    base = chart.top + chart.height + 14
    parts.append(f'<text x="{chart.left}" y="{base}">{ends[0]}</text>')
    parts.append(f'<text x="{chart.left + chart.width}" y="{base}" text-anchor="end">{ends[1]}</text>')
    parts.append(f'<text x="{chart.left - 3}" y="{chart.top + 9}" text-anchor="end">{high:.2g}</text>')
    parts.append(chart.upright(sweep.at, "here"))
    for k in range(shown.shape[1] - 1, -1, -1):
        lost = k < corank
        parts.append(chart.path([np.stack([sweep.values, shown[:, k]], axis=1)], "s0" if lost else "s1"))
    return chart.svg(parts, f"Singular values as {name} moves through the witness")
