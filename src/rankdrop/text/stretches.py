"""Stretches of a checked path in words: the singularities that the path reaches, and what is proven free."""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite, isnan
from operator import attrgetter
from typing import Any

import numpy as np

from rankdrop.local.block import generic_rank
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section
from rankdrop.text.places import joints_words, row_noun, row_words, when
from rankdrop.text.special import place_words
from rankdrop.text.words import angle, motion, rounded_down, short

_CLOSEST = 3  # free stretches whose closest configuration is printed
_SMALLEST = 1e-12  # of a width of a bracket that is printed [s]
_AT_SINGULARITY = 1e-6  # a distance below it is that of a stretch that ends at a singularity [rad]
_STAYS = 1e-3  # share of the way between two rows; a longer stretch in a singularity is reported by both of its ends
_EVIDENCE = {
    "covered": "enclosures cover all of it",
    "determinant": "the determinant changes its sign",
    "condition": "the condition {condition} = 0 changes its sign",
    "singular throughout": "σ{rank} ≤ {limit:g} at every point of it that was evaluated",
    "small sigma": "σ{rank} = {sigma:.1e}, within the tolerance {limit:g}, and no change of sign was detected",
    "no enclosure": "no enclosure proves it free, and the smallest σ{rank} is {sigma:.1e}",
    "unfinished": "the work ended before it was decided; the smallest σ{rank} that was evaluated is {sigma:.1e}",
}  # fmt: skip

REACHED = {
    "crossing": "crosses a singularity {} (proven)",
    "lies": "lies in a singularity {}",
    "touching": "touches a singularity {}",
}
"""How a path reaches singularities, in the order of the first line; how often is put in."""

_VERBS = {"crossing": "crosses", "lies": "lies in", "touching": "touches"}


def evidence_words(stretch: Any, check: Any) -> str:
    """How the verdict of a stretch is known."""
    rank = str(generic_rank(check.robot, check.task)).translate(str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉"))
    return _EVIDENCE[stretch.evidence].format(
        condition=stretch.condition, rank=rank, sigma=stretch.closest.sigma, limit=check.tolerances.singular
    )


def stay_or_place(stretch: Any) -> str:
    """The place of a singularity; both ends of a stretch that lies in it, or at which the arm rests."""
    start, end = stretch.bracket
    if stretch.verdict == "touching" and end.position - start.position > _STAYS:
        return span_words(stretch)
    return when(stretch.closest.place)


def how_reached(stretch: Any) -> str:
    """The key of `REACHED` of a stretch of a path; its verdict where it reaches no singularity for certain."""
    if stretch.verdict == "touching" and stretch.lies:
        return "lies"
    return str(stretch.verdict)


def nearest_place_words(near: Any) -> str:
    """Where a stretch is nearest to a singularity."""
    if near.verdict != "free":
        return when(near.closest.place)
    if near.closest.distance < _AT_SINGULARITY:
        return "at its end"
    return f"{angle(near.closest.distance)} away, {when(near.closest.place)}"


def crossing_lines(stretch: Any, check: Any, *, deg: bool, full: bool) -> Iterable[str]:
    """A stretch that is not free: what it reaches, where, and what is lost."""
    crossing = f"{crossing_words(stretch, check)}, {span_words(stretch)}"
    if stretch.corank > 1:
        crossing += f", corank {stretch.corank}"
    yield crossing
    yield f"    at {joints_words(check.robot, stretch.closest.q, deg=deg)}"
    yield from (f"    the tool {words}" for words in (stretch.lost if full else stretch.lost[:1]))
    if not full:
        return
    yield f"    how: {evidence_words(stretch, check)}"
    if stretch.verdict == "undecided" and isfinite(stretch.closest.distance):
        yield f"    nearest singularity known: {angle(stretch.closest.distance)}"
    if not isnan(stretch.null_share):
        yield f"    {_percent(stretch.null_share)} of the joints' motion there does not move the tool"
    if stretch.speed_factor < 1.0:
        joint = check.robot.variables[stretch.slowest - 1]
        yield (f"    too fast for {joint.name}: {stretch.rates[stretch.slowest - 1]:.4g} {joint.unit}/s, its limit is "
               f"{joint.velocity:.4g}; {rounded_down(stretch.speed_factor)} of the speed keeps it")  # fmt: skip


def stretch_place(check: Any, stretch: Any) -> str:
    """The part of the arm that is special where a stretch reaches a singularity, or comes nearest to one.

    The name of the family where no part is special there, or no singular configuration is known.
    """
    if stretch.corank:
        q = stretch.closest.q
    else:
        q = stretch.closest.foot
    return place_or_family(check, q, stretch.name, stretch.corank)


def place_or_family(check: Any, q: Array, name: str, corank: int = 0) -> str:
    """The part of the arm that is special at a singular configuration q (n,); the name without any, or without q."""
    if len(q):
        place = place_words(check.robot, check.task, q, max(corank, 1))
    else:
        place = ""
    return place or name or "an unnamed family"


def crossing_words(stretch: Any, check: Any) -> str:
    """How a stretch reaches a singularity, and which: "crosses wrist [k1.f1]"."""
    verb = _VERBS.get(how_reached(stretch), "undecided:")
    return f"{verb} {stretch_place(check, stretch)}{_id(stretch)}"


def free_section(free: list[Any], check: Any, *, deg: bool) -> Section:
    """Table of the stretches that are proven free, each with its closest configuration."""
    timed = check.curve.times is not None
    limited = any(not isnan(stretch.speed_factor) for stretch in free)
    noun = row_noun(free[0].start)
    columns = ["nearest family", f"{noun}s", "closest", "σ", "weak"]
    notes = ["closest: joint-space distance to the nearest singular configuration known [rad]; weak: share of the "
             "tool's travel there along the direction that would be lost"]  # fmt: skip
    if timed:
        columns.insert(2, "time [s]")
    if limited:
        columns.append("speed")
        notes.append("speed: factor that keeps the velocity limits")
    rows = []
    for stretch in sorted(free, key=attrgetter("start")):
        rows_of = f"{row_words(stretch.start)} – {row_words(stretch.end)}"
        row = [f"{stretch_place(check, stretch)}{_id(stretch)}", rows_of]
        if timed:
            row.append(f"{stretch.start.time:.4g} – {stretch.end.time:.4g}")
        row += _closest_cells(stretch.closest)
        if limited:
            row.append(_speed_cell(stretch))
        rows.append(tuple(row))
    where = tuple(
        f"{_distance_words(stretch.closest.distance)} at {noun} {row_words(stretch.closest.place)}"
        f"{_way(stretch, check.robot)}: {joints_words(check.robot, stretch.closest.q, deg=deg)}"
        for stretch in free[:_CLOSEST] if stretch.closest.distance >= _AT_SINGULARITY
    )
    return Section("Proven free", columns=tuple(columns), rows=tuple(rows), after=where, notes=tuple(notes))


def _closest_cells(closest: Any) -> tuple[str, str, str]:
    """The distance to the nearest singular configuration, σ there, and the share of travel along the weak direction."""
    if isnan(closest.weak):
        weak = "–"
    else:
        weak = _percent(closest.weak)
    if closest.distance < _AT_SINGULARITY:
        return "at its end", "→ 0", weak
    return _distance_words(closest.distance), short(closest.sigma, 3), weak


def _speed_cell(stretch: Any) -> str:
    """The factor of the speed that keeps the velocity limits on a stretch."""
    if isnan(stretch.speed_factor):
        return "–"
    if stretch.speed_factor < 1.0:
        return f"× {rounded_down(stretch.speed_factor)}"
    return f"× {stretch.speed_factor:.3g}"


def _id(stretch: Any) -> str:
    if stretch.family:
        return f" [{stretch.family}]"
    return ""


def span_words(stretch: Any) -> str:
    """Rows and times between which a stretch reaches a singularity."""
    start, end = stretch.bracket
    if start.pose is None:
        rows = _row_span(start, end)
    else:
        rows = _pose_span(start, end)
    if start.time is None or end.time is None:
        return rows
    if end.time - start.time < 1e-4:
        return f"{rows}, at {stretch.closest.place.time:.6f} s (± {short(max(end.time - start.time, _SMALLEST), 2)} s)"
    return f"{rows}, {start.time:.6g} to {end.time:.6g} s"


def _row_span(start: Any, end: Any) -> str:
    """Rows of a joint path between which a stretch reaches a singularity."""
    if start.row == end.row and start.share == end.share == 0.0:
        return f"at row {start.row}"
    if start.row == end.row or (end.share == 0.0 and end.row == start.row + 1):
        return f"between rows {start.row} and {start.row + 1}"
    if row_words(start) == row_words(end):
        return f"at row {row_words(start)}"
    return f"rows {row_words(start)} to {row_words(end)}"


def _pose_span(start: Any, end: Any) -> str:
    """Poses of a tool path between which a stretch reaches a singularity."""
    if row_words(start) == row_words(end):
        return f"at pose {row_words(start)}"
    return f"poses {row_words(start)} to {row_words(end)}"


def _distance_words(distance: float) -> str:
    if isfinite(distance):
        return short(distance, 3)
    return "?"


def _way(stretch: Any, robot: Robot) -> str:
    """Which joints would have to move how far to the singular configuration; what is below 1 % of the most left out."""
    if not len(stretch.closest.foot):
        return ""
    ways = stretch.closest.foot - stretch.closest.q
    most = np.abs(ways).max()
    parts = [f"{joint.name} {motion(float(way), joint.unit)}" for joint, way in zip(robot.variables, ways, strict=True)
             if abs(way) >= 0.01 * most]  # fmt: skip
    return f" ({', '.join(parts)} away)"


def _percent(share: float) -> str:
    if 0.0 < share < 1e-3:
        return "< 0.1 %"
    return f"{short(100 * share, 3)} %"
