"""A checked path in words, made from its facts: five lines first, then crossings, with `full` free stretches and notes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import degrees, isfinite, isnan
from typing import TYPE_CHECKING

import numpy as np

from rankdrop.local.block import generic_rank
from rankdrop.results.explanation.words import angle, fixed, minus, motion, short
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section
from rankdrop.units import counted_length

if TYPE_CHECKING:
    from rankdrop.motion.candidates import Parameter, Ranking
    from rankdrop.motion.record import PathCheck, Place, Stretch, ToolMotion, Violation
    from rankdrop.motion.remedies import Mending, Remedy

DESCRIBED, LISTED = 2, 12
"""Crossings that are described in some lines each; if there are more, so many get one line each."""
_CLOSEST = 3  # free stretches whose closest configuration is printed
_AT_ROW = 1e-6  # share of the way between two rows that is reported as the row
_SMALLEST = 1e-12  # of a width of a bracket that is printed [s]
_LEADS = 1e-6  # a distance below it is that of a stretch that ends at a singularity [rad]
_NAMED = 10  # crossings whose poses are noted

_EVIDENCE = {
    "covered": "enclosures cover all of it",
    "determinant": "the determinant changes its sign",
    "condition": "the condition {condition} = 0 changes its sign",
    "singular throughout": "σ{rank} ≤ {limit:g} at every point of it that was evaluated",
    "small sigma": "σ{rank} = {sigma:.1e}, within the tolerance {limit:g}, and no change of sign was detected",
    "no enclosure": "no enclosure proves it free, and the smallest σ{rank} is {sigma:.1e}",
    "unfinished": "the work ended before it was decided; the smallest σ{rank} that was evaluated is {sigma:.1e}",
}  # fmt: skip
_REMARKS = {
    "degrees": "{0}",
    "velocities": "velocities are given and not used: a controller that has them makes cubics of the samples",
    "lost": "lost motions are described for the first {0[0]} of {0[1]} crossings",
    "distances": "no families are known: distances are searched on {0[0]} of {0[1]} free stretches",
    "no distance": "no distance is searched: {0}",
    "distance open": "the distance to be kept could not be proven around row {0}",
}
_REASONS = {"singular": "the branch ends at a singularity", "stuck": "the solver does not converge there"}


def evidence_words(stretch: Stretch, check: PathCheck) -> str:
    """How the verdict of a stretch is known."""
    rank = str(generic_rank(check.robot, check.task)).translate(str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉"))
    return _EVIDENCE[stretch.evidence].format(
        condition=stretch.condition, rank=rank, sigma=stretch.closest.sigma, limit=check.tolerances.singular
    )


def branch_chosen(tool: ToolMotion) -> str:
    """Which branch of the inverse kinematics a tool path takes."""
    if not tool.solutions:
        return "of the start that was given"
    count = f"of {tool.solutions} found, and there are more" if tool.more else f"one of {tool.solutions} found"
    return f"nearest to q = 0 ({count})"


def why_ended(tool: ToolMotion, robot: Robot) -> str:
    """Why a tool path cannot be followed any further; "" where it can."""
    if tool.complete:
        return ""
    pose = f"at pose {tool.reached:.5g}"
    reason = f"{_REASONS[tool.reason]}, {pose} (σ = {tool.sigma:.1e})" if tool.reason in _REASONS else (
        f"{_joint(robot, tool.joint)} reaches its limit {pose}"
    )
    ahead = f"pose {int(min(np.floor(tool.reached + 1e-9) + 1, tool.poses))}"
    if tool.next_reachable:
        return f"{reason}; {ahead} is within reach, by other configurations"
    return f"{reason}; {ahead} is out of reach: no configuration within the joint limits was found for it"


def sentence(check: PathCheck) -> str:
    """The verdict: what the path does, worst first."""
    if check.holds:
        kept = f", and farther than {angle(check.options.min_distance)} from any" if check.margin == "kept" else ""
        limits = "; joint limits and rates kept" if check.curve.times is not None else ""
        return f"Free: proven for every point of the path{kept}{limits}."
    parts = [*_reached(check), *(_violation(one, check) for one in check.violations), *_open(check)]
    if check.clear:
        parts.append("free of singularities (proven)")
    words = "; ".join(parts)
    words = f"{words[0].upper()}{words[1:]}."
    if check.tool is not None and not check.tool.complete:
        beyond = f"Cannot be followed beyond pose {check.tool.reached:.5g} of {check.tool.poses}"
        return f"{beyond}: {why_ended(check.tool, check.robot)}." + (f" Up to there: {words}" if parts[1:] else "")
    return words


def _reached(check: PathCheck) -> Iterator[str]:
    """Singularities that the path reaches or comes near to; the end of a branch."""
    if check.tool is not None and not check.tool.complete:
        yield "the branch ends"
    for kind, words in (("crossing", "crosses a singularity {} (proven)"), ("touching", "touches a singularity {}")):
        part = [one for one in check.crossings if one.verdict == kind]
        if part:
            times = {1: "once", 2: "twice"}.get(len(part), f"{len(part)} times")
            yield f"{words.format(times)}, first {part[0].name or 'an unnamed family'}, {_when(part[0].closest.place)}"
    if check.margin == "violated" and not check.crossings:
        yield f"comes nearer than {angle(check.options.min_distance)} to a singularity"


def _violation(one: Violation, check: PathCheck) -> str:
    joint = check.robot.variables[one.joint - 1]
    if one.what == "rate":
        near = ""
        if isfinite(one.distance):
            near = f", {short(degrees(one.distance), 2)}° from a singularity ({one.name})"
        limit = f"{short(one.amount, 3)} times the limit of joint {one.joint} {_when(one.place)}{near}"
        return f"not possible at the programmed speed: {limit}" if one.proven else (
            f"the rate of joint {one.joint} could not be proven to keep its limit"
        )
    if not one.proven:
        return f"{_joint(check.robot, one.joint)} could not be proven to keep its limits"
    excess = motion(one.amount, joint.unit)
    rows = f" in {one.rows} row{'s' if one.rows > 1 else ''}, first" if one.rows else ""
    return f"{_joint(check.robot, one.joint)} is outside its limits{rows} {_when(one.place)}, by {excess} at most"


def _open(check: PathCheck) -> Iterator[str]:
    if check.margin == "not proven":
        yield f"a distance of {angle(check.options.min_distance)} could not be proven"
    if any(one.verdict == "undecided" for one in check.stretches):
        time = "" if check.undecided_time is None else f", {check.undecided_time:.3g} s"
        yield f"{check.undecided_length:.3g} rad of it{time} undecided"
    if not check.complete:
        yield "interrupted"


def summary(check: PathCheck) -> tuple[str, ...]:
    """Five lines: the verdict, the path, what to do, the nearest singularity, and how this is known."""
    times = check.curve.times
    lasts = "" if times is None else f", {times[-1] - times[0]:.6g} s"
    free = sum(one.verdict == "free" for one in check.stretches)
    lines = [
        sentence(check),
        f"Path: {check.rows} rows{lasts}, {check.options.interpolate} between them; {free_words(check)} of its length "
        f"is proven free, {free} stretch{'es' if free != 1 else ''}.",
    ]
    if not check.holds:
        lines.append(f"Next: {_advice(check)}.")
    near = min((one for one in check.stretches if isfinite(one.closest.distance)),
               key=lambda one: one.closest.distance, default=None)  # fmt: skip
    if near is not None:
        name, far = near.name or "a singularity", near.closest.distance
        where = f"{name}, at its end" if near.verdict == "free" and far < _LEADS else (
            f"{name}, {angle(far)} away, {_when(near.closest.place)}" if near.verdict == "free" else
            f"{name}, {_when(near.closest.place)}"
        )  # fmt: skip
        lines.append(f"Nearest singularity: {where}.")
    source = "none known, found on the spot" if check.source == "on the spot" else f"from the {check.source}"
    tip = ""
    if check.tool is not None:
        size = 1e3 / counted_length(check.robot)
        tip = f"; the tip stays within {_up(size * check.tool.off)} mm and {_up(1e3 * check.tool.turned)} mrad"
    cover = "1 enclosure covers" if check.evaluations == 1 else f"{check.evaluations:,} enclosures cover"
    lines.append(f"Verified: {cover} it{tip}; families {source}.")
    return tuple(lines)


def _advice(check: PathCheck) -> str:
    if not check.complete:
        return "run the same command again"
    if check.verdict == "too fast":
        worst = max(one.amount for one in check.violations if one.what == "rate")
        return f"run it at {short(1 / worst, 2)} of the speed, or let --remedies compute a new time law or path"
    if check.verdict == "undecided":
        return "a larger --evaluations may decide it"
    return "--remedies computes changes that avoid it; --full prints every stretch"


def free_words(check: PathCheck) -> str:
    """The share that is proven free in per cent, never rounded up to the whole: a crossing is a point of it."""
    words = f"{100 * check.free_share:.6g}"
    all_of_it = check.free_share == 1.0 and not check.crossings
    return "more than 99.9999 %" if words == "100" and not all_of_it else f"{words} %"


def notes(check: PathCheck) -> tuple[str, ...]:
    """Remarks; of a tool path its branch and the poses of its crossings."""
    lines = [_REMARKS[kind].format(values) for kind, values in check.remarks]
    if check.tool is not None:
        places = [one.closest.place for one in check.crossings][:_NAMED]
        lines += [f"branch: {branch_chosen(check.tool)}",
                  *(f"row {_row(place)} is pose {check.tool.pose_at(place):.6g}" for place in places)]  # fmt: skip
    return tuple(lines)


def path_sections(check: PathCheck, *, deg: bool = True, full: bool = False) -> tuple[Section, ...]:
    """The summary, crossings, with `full` the free stretches, and notes.

    Args:
        check: the path.
        deg: joint angles in degrees.
        full: every crossing and every free stretch.
    """
    tone = {"free": "good", "undecided": "warning", "too near": "warning"}.get(check.verdict, "bad")
    first, *others = summary(check)
    scale = f"σ with translation divided by {check.length_scale:.4g} m; distances in joint space"
    about = f"{check.robot.name}, {check.task.name}"
    sections = [Section(first, lines=tuple(others), tone=tone)]
    met = sorted((one for one in check.stretches if one.verdict != "free"), key=lambda one: one.start.position)
    if full or len(met) <= DESCRIBED:
        lines = [line for one in met for line in _crossing_lines(one, check, deg=deg, full=full)]
    else:
        lines = [f"{_crossed(one)}, {_when(one.closest.place)}" for one in met[:LISTED]]
        more = f"and {len(met) - LISTED} more; " if len(met) > LISTED else ""
        lines.append(f"{more}--full describes each of them")
    if lines:
        sections.append(Section("Singularities on the path", lines=tuple(lines)))
    free = [one for one in check.stretches if one.verdict == "free"]
    if full and free:
        sections.append(_free_section(free, check, deg=deg))
    if full or check.notes:
        sections.append(Section("Notes", lines=(*check.notes, *((f"{about}: {scale}",) if full else ()))))
    return tuple(sections)


def _crossing_lines(one: Stretch, check: PathCheck, *, deg: bool, full: bool) -> Iterable[str]:
    yield f"{_crossed(one)}, {_span(one)}" + (f", corank {one.corank}" if one.corank > 1 else "")
    yield f"    at {_joints(check.robot, one.closest.q, deg=deg)}"
    yield from (f"    the tool {words}" for words in (one.lost if full else one.lost[:1]))
    if not full:
        return
    yield f"    how: {evidence_words(one, check)}"
    if one.verdict == "undecided" and isfinite(one.closest.distance):
        yield f"    nearest singularity known: {angle(one.closest.distance)}"
    if not isnan(one.null_share):
        yield f"    {_percent(one.null_share)} of the joints' motion there does not move the tool"
    if one.speed_factor < 1.0:
        joint = check.robot.variables[one.slowest - 1]
        yield (f"    too fast for {joint.name}: {one.rates[one.slowest - 1]:.4g} {joint.unit}/s, its limit is "
               f"{joint.velocity:.4g}; {one.speed_factor:.3g} of the speed keeps it")  # fmt: skip


def _crossed(one: Stretch) -> str:
    verb = {"crossing": "crosses", "touching": "lies in" if one.lies else "touches"}.get(one.verdict, "undecided:")
    return f"{verb} {one.name or 'an unnamed family'}{f' [{one.family}]' if one.family else ''}"


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
        leads = one.closest.distance < _LEADS
        near = ("at its end", "→ 0") if leads else (_far(one.closest.distance), short(one.closest.sigma, 3))
        weak = "–" if isnan(one.closest.weak) else _percent(one.closest.weak)
        rows.append((name, f"{_row(one.start)} – {_row(one.end)}", *time, *near, weak, *speed))
    where = tuple(
        f"{_far(one.closest.distance)} at row {_row(one.closest.place)}{_way(one, check.robot)}: "
        f"{_joints(check.robot, one.closest.q, deg=deg)}"
        for one in free[:_CLOSEST] if one.closest.distance >= _LEADS
    )
    small: tuple[str, ...] = (
        "closest: joint-space distance to the nearest singular configuration known [rad]; weak: share of the tool's "
        "travel there along the direction that would be lost",
    )
    if limited:
        small += ("speed: factor that keeps the velocity limits",)
    return Section("Proven free", columns=tuple(columns), rows=tuple(rows), after=where, notes=small)


def _when(place: Place) -> str:
    if place.time is not None:
        return f"at {place.time:.4g} s"
    near = min(place.share, 1.0 - place.share) < _AT_ROW
    return f"at row {round(place.position)}" if near else f"between rows {place.row} and {place.row + 1}"


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
        return f"{rows}, at {stretch.closest.place.time:.6f} s (± {short(max(end.time - start.time, _SMALLEST), 2)} s)"
    return f"{rows}, {start.time:.6g} to {end.time:.6g} s"


def _row(place: Place) -> str:
    return f"{round(place.position, 2):.12g}"


def _far(distance: float) -> str:
    return short(distance, 3) if isfinite(distance) else "?"


def _up(value: float) -> str:
    """Two digits, rounded up: what is printed is proven as well."""
    return short(float(np.nextafter(value * 1.05, np.inf)), 2) if value > 0.0 else "0"


def _joint(robot: Robot, number: int) -> str:
    return f"joint {number} ({robot.variables[number - 1].name})"


def _way(stretch: Stretch, robot: Robot) -> str:
    """Which joints would have to move how far to the singular configuration; what is below 1 % of the most left out."""
    if not len(stretch.closest.foot):
        return ""
    ways = stretch.closest.foot - stretch.closest.q
    most = np.abs(ways).max()
    parts = [f"{joint.name} {motion(float(way), joint.unit)}" for joint, way in zip(robot.variables, ways, strict=True)
             if abs(way) >= 0.01 * most]  # fmt: skip
    return f" ({', '.join(parts)} away)"


def _percent(share: float) -> str:
    return "< 0.1 %" if 0.0 < share < 1e-3 else f"{short(100 * share, 3)} %"


def _joints(robot: Robot, q: Array, *, deg: bool) -> str:
    parts = []
    for joint, value in zip(robot.variables, q, strict=True):
        turns = joint.unit == "rad"
        shown = degrees(float(value)) if deg and turns else float(value)
        unit = ("°" if deg else " rad") if turns else " m"
        parts.append(f"{joint.name} {short(round(shown, 4 if not turns or not deg else 3) + 0.0, 6)}{unit}")
    return ", ".join(parts)


def joint_heads(robot: Robot, *, deg: bool) -> tuple[str, ...]:
    """Headings of columns of joint values."""
    return tuple(f"{one.name} [{'°' if deg and one.unit == 'rad' else one.unit}]" for one in robot.variables)


def joint_cells(robot: Robot, q: Array, *, deg: bool) -> Iterator[str]:
    """Joint values (n,) as cells of a table."""
    for joint, value in zip(robot.variables, q.tolist(), strict=True):
        yield minus(f"{degrees(value):.2f}" if deg and joint.unit == "rad" else f"{value:.4f}")


_GAINS = {"distance": "distance to the nearest singularity known", "speed": "speed that keeps the limits",
          "duration": "duration"}  # fmt: skip
_ENDED = {
    "singular": "end at a singularity", "limit": "end at a joint limit", "stuck": "cannot be followed",
    "start": "do not reach the first pose", "plan": "found no way when planned over all self-motions",
}  # fmt: skip


def not_found(ranking: Ranking, what: str) -> str:
    """What came of the candidates of a kind of remedy, none of which is one."""
    if not ranking.tried:
        return f"there is no {what}"
    if list(ranking.ended.values()) == [ranking.tried] and ranking.tried > 1 and not ranking.found:
        return f"all {ranking.tried} that were tried {_ENDED[next(iter(ranking.ended))]}"
    parts = [f"{count} {_ENDED[reason]}" for reason, count in sorted(ranking.ended.items())]
    if ranking.found:
        parts.append(f"{len(ranking.found)} run it as far as a first look tells, and none of them was proven free")
    return f"{ranking.tried} tried: {', '.join(parts)}"


def remedies_sentence(mending: Mending) -> str:
    """Which remedies were found."""
    if not mending.needed:
        return "Remedies: none is needed."
    stopped = "" if mending.complete else ", interrupted: not all kinds were tried"
    if not mending.remedies:
        return f"Remedies: none was found{stopped}; that is no proof that there is none."
    parts = [
        f"{', '.join(kinds)} ({what})" for clear, what in ((True, "checked again: free, proven"),
                                                          (False, "limits kept; it still meets a singularity"))
        if (kinds := [one.kind for one in mending.remedies if one.check.clear == clear])
    ]  # fmt: skip
    return f"Remedies: {'; '.join(parts)}{stopped}."


def remedy_sections(mending: Mending, *, deg: bool) -> tuple[Section, ...]:
    """The remedies, and the kinds of which none was found."""
    lines = tuple(line for one in mending.remedies for line in _remedy_lines(one, deg=deg))
    others = [Section("Remedies that were not found", lines=mending.notes)] if mending.notes else []
    return Section(mending.sentence, lines=lines), *others


def _remedy_lines(remedy: Remedy, *, deg: bool) -> list[str]:
    from rankdrop.schema.motion import GAIN_UNITS

    lines = [f"{remedy.kind}: {remedy.words}"]
    robot = remedy.check.robot
    lines += [f"    {parameter[0]}: {_value(parameter, robot, deg=deg)}" for parameter in remedy.parameters]
    for what, values in remedy.gains.items():
        name, unit = _GAINS[what], GAIN_UNITS[what]
        before, after = (short(value) if isfinite(value) else "not known" for value in values)
        if not np.isnan(values).all():
            lines.append(f"    {name}: {before} → {after}{' ' if unit else ''}{unit}")
    lines.append(f"    checked again: {remedy.check.sentence}")
    if remedy.usage is not None:
        retimed = "new time law; " if remedy.retimed and remedy.kind != "retime" else ""
        used = [f"{short(100 * share)} % of the {what} limits" for share, what in
                ((remedy.usage.rate, "rate"), (remedy.usage.acceleration, "acceleration")) if share > 0.0]  # fmt: skip
        lines.append(f"    {retimed}at most {' and '.join(used)} at every instant ({remedy.usage.how})")
    if remedy.off[0] > 0.0:
        turn = "" if isnan(remedy.off[1]) else f", {_small(degrees(remedy.off[1]))}°"
        where = "of its path between rows, measured in their middles" if turn else "of the old path where it leaves it"
        off = 1000 * remedy.off[0] / counted_length(robot)
        lines.append(f"    the tool is within {_small(off)} mm{turn} {where}")
    return lines


def _value(parameter: Parameter, robot: Robot, *, deg: bool) -> str:
    _, value, unit = parameter
    if unit == "rad, m" and isinstance(value, tuple):
        return ", ".join(
            f"{joint.name} {fixed(degrees(number), 2)}°" if joint.unit == "rad" and deg else
            f"{joint.name} {fixed(number)} {joint.unit}" for joint, number in zip(robot.variables, value, strict=True)
        )  # fmt: skip
    values = value if isinstance(value, tuple) else (value,)
    if unit == "rad" and deg:
        return f"{', '.join(short(degrees(number)) for number in values)}°"
    inside = ", ".join(short(number + 0.0) for number in values)
    return f"{f'({inside})' if isinstance(value, tuple) else inside} {unit}".rstrip()


def _small(value: float) -> str:
    """A deviation; what is below 1e-9 is rounding."""
    return short(value, 2) if value >= 1e-9 else "0"
