"""A judged path for people: the verdict first and last, the stretches between, worst first."""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees, isfinite, isnan
from typing import TYPE_CHECKING

import numpy as np

from rankdrop.motion.data import CROSSING, FREE, LEADS, TOUCHING, UNDECIDED, Place, Stretch
from rankdrop.results.explanation.words import angle, motion, short
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section

if TYPE_CHECKING:
    from rankdrop.motion.result import PathCheck

SHOWN = 10
"""Stretches that are printed unless all are asked for."""


def path_sections(check: PathCheck, *, deg: bool = True, full: bool = False) -> tuple[Section, ...]:
    """The verdict, what is met, the other stretches, notes, and the verdict again.

    Args:
        check: the path.
        deg: joint angles in degrees.
        full: every stretch, not the ten worst.
    """
    shown = check.stretches if full else check.stretches[:SHOWN]
    tone = {FREE: "good", CROSSING: "bad", TOUCHING: "bad"}.get(check.verdict, "warning")
    sections = [Section(check.sentence, tone=tone), _about(check)]
    met = [one for one in shown if one.verdict != FREE]
    if met:
        sections.append(Section("Where it meets a singularity", lines=tuple(_met_lines(met, check, deg=deg))))
    free = [one for one in shown if one.verdict == FREE]
    if free:
        sections.append(_free_section(free, check, deg=deg))
    left = len(check.stretches) - len(shown)
    notes = tuple(check.notes)
    if left:
        notes += (f"{left} more stretch{'es' if left > 1 else ''}: with --full, or in the JSON",)
    if notes:
        sections.append(Section("Notes", lines=notes))
    return (*sections, Section(check.sentence, tone=tone))


def _about(check: PathCheck) -> Section:
    times = check.curve.times
    lasts = "" if times is None else f", {times[-1] - times[0]:.6g} s"
    lines = [
        f"{check.rows} rows{lasts}, {check.settings.interpolate} between them; {check.free_words} of its length is "
        f"proven free",
        f"families: {'none known, found on the spot' if check.source == 'on the spot' else f'from the {check.source}'};"
        f" distances in joint space [rad], σ with translation divided by {check.settings.length_scale:.4g} m",
    ]
    return Section(f"{check.robot.name}, {check.task.name}", lines=tuple(lines))


def _met_lines(met: Iterable[Stretch], check: PathCheck, *, deg: bool) -> Iterable[str]:
    for one in met:
        verb = {"crossing": "crosses", "touching": "lies in" if one.lies else "touches"}.get(one.verdict, "undecided:")
        name = f"{one.name or 'an unnamed family'}{f' [{one.family}]' if one.family else ''}"
        yield f"{verb} {name}, {_span(one)}" + (f", corank {one.corank}" if one.corank > 1 else "")
        yield f"    at {_joints(check.robot, one.closest.q, deg=deg)}"
        yield f"    how: {one.how}"
        if one.verdict == UNDECIDED and isfinite(one.closest.distance):
            yield f"    nearest singularity known: {angle(one.closest.distance)}"
        for sentence in one.lost:
            yield f"    the tool {sentence}"
        if not isnan(one.null_share):
            yield f"    {_percent(one.null_share)} of the joints' motion there does not move the tool"
        if one.speed_factor < 1.0:
            yield f"    {_slow(one, check.robot)}"


def _free_section(free: list[Stretch], check: PathCheck, *, deg: bool) -> Section:
    timed = check.curve.times is not None
    limited = any(not isnan(one.speed_factor) for one in free)
    columns = ["nearest family", "rows", *(["time [s]"] if timed else []), "closest", "σ", "weak",
               *(["speed"] if limited else [])]  # fmt: skip
    rows = []
    for one in sorted(free, key=lambda one: (one.start.row, one.start.share)):
        name = f"{one.name or '(not known)'}{f' [{one.family}]' if one.family else ''}"
        time = [f"{one.start.time:.4g} – {one.end.time:.4g}"] if timed else []
        speed = ["–" if isnan(one.speed_factor) else f"× {one.speed_factor:.3g}"] if limited else []
        rows.append((
            name, f"{_row(one.start)} – {_row(one.end)}", *time, *_near(one),
            "–" if isnan(one.closest.weak) else _percent(one.closest.weak), *speed,
        ))  # fmt: skip
    where = tuple(
        f"{_far(one.closest.distance)} at row {_row(one.closest.place)}{_way(one, check.robot)}: "
        f"{_joints(check.robot, one.closest.q, deg=deg)}"
        for one in free[:3] if one.closest.distance >= LEADS
    )
    notes: tuple[str, ...] = (
        "closest: joint-space distance to the nearest singular configuration known [rad]; weak: share of the tool's "
        "travel there along the direction that would be lost",
    )
    if limited:
        notes += ("speed: factor that keeps the velocity limits",)
    return Section("Proven free", columns=tuple(columns), rows=tuple(rows), after=where, notes=notes)


def _span(stretch: Stretch) -> str:
    start, end = stretch.bracket
    if start.row == end.row or (end.share == 0.0 and end.row == start.row + 1):
        rows = f"between rows {start.row} and {start.row + 1}"
        if start.share == end.share == 0.0 and start.row == end.row:
            rows = f"at row {start.row}"
    else:
        rows = f"rows {_row(start)} to {_row(end)}"
    if start.time is None or end.time is None:
        return rows
    if end.time - start.time < 1e-4:
        return f"{rows}, at {stretch.closest.place.time:.6f} s (± {short(max(end.time - start.time, 1e-12), 2)} s)"
    return f"{rows}, {start.time:.6g} to {end.time:.6g} s"


def _row(place: Place) -> str:
    return f"{round(place.row + place.share, 2):.12g}"


def _far(distance: float) -> str:
    return short(distance, 3) if isfinite(distance) else "?"


def _way(stretch: Stretch, robot: Robot) -> str:
    """Which joints would have to move how far to the singular configuration; what is below 1 % of the most left out."""
    if not len(stretch.closest.foot):
        return ""
    ways = stretch.closest.foot - stretch.closest.q
    most = np.abs(ways).max()
    parts = [f"{joint.name} {motion(float(way), joint.unit)}" for joint, way in zip(robot.variables, ways, strict=True)
             if abs(way) >= 0.01 * most]  # fmt: skip
    return f" ({', '.join(parts)} away)"


def _near(stretch: Stretch) -> tuple[str, str]:
    """How near it comes and σ there; a stretch that ends at a singularity comes as near as one likes."""
    if stretch.closest.distance < LEADS:
        return "at its end", "→ 0"
    return _far(stretch.closest.distance), short(stretch.closest.sigma, 3)


def _percent(share: float) -> str:
    return "< 0.1 %" if 0.0 < share < 1e-3 else f"{short(100 * share, 3)} %"


def _slow(stretch: Stretch, robot: Robot) -> str:
    joint = robot.variables[stretch.slowest - 1]
    return (
        f"too fast for {joint.name}: {stretch.rates[stretch.slowest - 1]:.4g} {joint.unit}/s against "
        f"{joint.velocity:.4g}; {stretch.speed_factor:.3g} of the speed keeps the limit"
    )


def _joints(robot: Robot, q: Array, *, deg: bool) -> str:
    parts = []
    for joint, value in zip(robot.variables, q, strict=True):
        turns = joint.unit == "rad"
        shown = degrees(float(value)) if deg and turns else float(value)
        unit = ("°" if deg else " rad") if turns else " m"
        parts.append(f"{joint.name} {short(round(shown, 4 if not turns or not deg else 3) + 0.0, 6)}{unit}")
    return ", ".join(parts)
