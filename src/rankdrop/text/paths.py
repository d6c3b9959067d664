"""Checked paths in words, made from their facts.

A check: five lines first, then crossings, with `full` free stretches and notes. Records are those of `rankdrop.path`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import copysign, degrees, inf, isfinite
from operator import attrgetter
from typing import Any

import numpy as np

from rankdrop.local.pointing import place_alone, pointing_task, tool_stays_level, turn_follows
from rankdrop.options import advise
from rankdrop.robot.model import Robot
from rankdrop.sections import Section
from rankdrop.text.inverse import missed_words
from rankdrop.text.places import fastest_words, overrun_words, seconds, turn_far_words, when
from rankdrop.text.remedies import local_lines, tool_off_words
from rankdrop.text.stretches import (
    REACHED,
    crossing_lines,
    crossing_words,
    free_section,
    how_reached,
    nearest_place_words,
    place_or_family,
    stay_or_place,
    stretch_place,
)
from rankdrop.text.tool_paths import (
    MOST_NAMED,
    branch_chosen,
    branches_section,
    branches_words,
    first_free_branch,
    half_turn_words,
    joint_label,
    passing_words,
    why_ended,
)
from rankdrop.text.words import (
    CHECKED_POINTING,
    NEVER_TILTS,
    NEVER_TURNS,
    PLACES_ALONE,
    above_limit,
    angle,
    minus,
    motion,
    rounded_down,
    rounded_up,
    short,
)
from rankdrop.tolerances import NEAR
from rankdrop.units import counted_length

DESCRIBED, LISTED = 2, 12
"""Crossings that are described in some lines each; if there are more, so many get one line each."""
_MOVED = 1e-3  # a start that is nearer to the first pose counts as at it [rad]
_REMARKS = {
    "degrees": "{0}",
    "velocities": "velocities are given and not used: a controller that has them makes cubics of the samples",
    "lost": "lost motions are described for the first {0[0]} of {0[1]} crossings",
    "distances": "no families are known: distances are searched on {0[0]} of {0[1]} free stretches",
    "no distance": "no distance is searched: {0}",
    "distance open": "the distance to be kept could not be proven around row {0}",
}


def _remedies() -> str:
    """What computes changes of a path."""
    return advise("remedies", python="rankdrop.path.mend_path")


def sentence(check: Any) -> str:
    """The verdict: what the path does, worst first."""
    if check.holds:
        if check.margin == "kept":
            margin_words = f", and farther than {angle(check.options.min_distance)} from any"
        else:
            margin_words = ""
        if check.curve.times is not None:
            limits = "; joint limits and rates kept"
        else:
            limits = _near_without_times(check)
        return f"Free: proven for every point of the path{margin_words}{limits}."
    parts = [*_reached_words(check), *(_violation(violation, check) for violation in check.violations), *_open(check)]
    if check.clear:
        parts.append("free of singularities (proven)")
    words = "; ".join(parts)
    if check.tool is None or check.tool.complete:
        return f"{words[:1].upper()}{words[1:]}."
    beyond = f"Cannot be followed beyond pose {check.tool.reached:.5g} of {check.tool.poses}"
    if check.tool.turn is not None:
        beyond += " without an internal turn"
    beyond = f"{beyond}: {why_ended(check.tool, check.robot)}."
    if not parts:
        return beyond
    return f"{beyond} Up to there: {words}."


def _near_without_times(check: Any) -> str:
    """How near a free path comes to a singularity where its joint rates are unknown; empty where it stays away."""
    least = min((stretch.closest.distance for stretch in check.stretches), default=inf)
    if check.margin == "kept" or least >= NEAR:
        return ""
    return f", but {angle(least)} from a singularity; without times joint rates are not checked"


def _reached_words(check: Any) -> Iterator[str]:
    """Singularities that the path reaches or comes near to."""
    for how, words in REACHED.items():
        part = [crossing for crossing in check.crossings if how_reached(crossing) == how]
        if part:
            yield f"{words.format(times(len(part)))}, first {stretch_place(check, part[0])}, {stay_or_place(part[0])}"
    if check.tool is not None and check.tool.passed:
        yield passing_words(check.tool.passed)
    if check.margin == "violated" and not check.crossings:
        yield f"comes nearer than {angle(check.options.min_distance)} to a singularity"


def times(count: int) -> str:
    """How often: "once", "twice", "3 times"."""
    return {1: "once", 2: "twice"}.get(count, f"{count} times")


def _violation(violation: Any, check: Any) -> str:
    joint = check.robot.variables[violation.joint - 1]
    if violation.what == "rate":
        near = ""
        if isfinite(violation.distance):
            name = place_or_family(check, violation.foot, violation.name)
            near = f", {short(degrees(violation.distance), 2)}° from a singularity ({name})"
        limit = f"{above_limit(violation.amount)} limit of joint {violation.joint} {when(violation.place)}{near}"
        if violation.proven:
            return f"not possible at the programmed speed: {limit}"
        return f"the rate of joint {violation.joint} could not be proven to keep its limit"
    if not violation.proven:
        return f"{joint_label(check.robot, violation.joint)} could not be proven to keep its limits"
    excess = motion(violation.amount, joint.unit)
    if violation.rows:
        rows = f" in {violation.rows} row{'s' if violation.rows > 1 else ''}, first"
    else:
        rows = ""
    where = f"{rows} {when(violation.place)}"
    return f"{joint_label(check.robot, violation.joint)} is outside its limits{where}, by {excess} at most"


def _open(check: Any) -> Iterator[str]:
    if check.margin == "not proven":
        yield f"a distance of {angle(check.options.min_distance)} could not be proven"
    if any(stretch.verdict == "undecided" for stretch in check.stretches):
        if check.undecided_time is None:
            time = ""
        else:
            time = f", {check.undecided_time:.3g} s"
        yield f"{check.undecided_length:.3g} rad of it{time} undecided"
    if not check.complete:
        yield "interrupted"


def summary(check: Any, mending: Any = None, *, listed: bool = False, target: str | None = None) -> tuple[str, ...]:
    """Five lines: the verdict, the path, what to do, the nearest singularity, and how this is known."""
    lines = [sentence(check), _path_line(check), *_never_lines(check)]
    if check.tool is not None and len(check.tool.branches) > 1:
        lines.append(f"Branch: {branches_words(check)}.")
    lines += _rate_lines(check)
    if not check.holds:
        lines.append(f"Next: {_next_step(check, mending, listed=listed, target=target)}.")
        if mending is not None and not listed:
            lines += local_lines(mending)
    near = min((stretch for stretch in check.stretches if isfinite(stretch.closest.distance)),
               key=lambda stretch: stretch.closest.distance, default=None)  # fmt: skip
    if near is not None:
        lines.append(f"Nearest singularity: {stretch_place(check, near)}, {nearest_place_words(near)}.")
    return (*lines, _verified_line(check))


def _rate_lines(check: Any) -> Iterator[str]:
    """Joints above their rate limits; of a path that keeps them and passes near a singularity, its fastest joint."""
    if check.overruns:
        yield f"Too fast: {overrun_words(check.overruns, check.robot)}."
        return
    near = min((stretch.closest.distance for stretch in check.stretches), default=inf)
    if near < NEAR and check.holds and check.fastest is not None:
        yield f"Fastest: {fastest_words(check.fastest, check.robot)}."


def _path_line(check: Any) -> str:
    """How long the path is, how it runs between its rows, and how much of it is proven free."""
    times = check.curve.times
    if times is None:
        lasts = ""
    else:
        lasts = f", {times[-1] - times[0]:.6g} s"
    if check.rows == 1:
        return "Path: one row; its configuration is checked."
    if check.tool is None:
        given = f"{check.rows} rows{lasts}, {check.options.interpolate} between them"
    else:
        given = f"{check.tool.poses} poses{lasts}, {check.rows} rows of joint values along them"
    if check.tool is None or check.tool.complete:
        length = "its length"
    else:
        length = "the part that is followed"
    free = sum(stretch.verdict == "free" for stretch in check.stretches)
    return (
        f"Path: {given}; {free_words(check)} of {length} is proven free, {free} stretch{'es' if free != 1 else ''}."
    )


def _verified_line(check: Any) -> str:
    """How many enclosures cover the path, how far the tip strays from it, and whence the families are."""
    if check.source == "on the spot":
        source = "none known, found on the spot"
    else:
        source = f"from the {check.source}"
    tip = ""
    if check.tool is not None:
        size = 1e3 / counted_length(check.robot)
        off, turned = rounded_up(size * check.tool.off), rounded_up(1e3 * check.tool.turned)
        tip = f"; the tip stays within {off} mm and {turned} mrad"
    if check.evaluations == 1:
        cover = "1 enclosure covers it"
    elif check.evaluations == 0:
        cover = "at its rows alone, without enclosures"
    else:
        cover = f"{check.evaluations:,} enclosures cover it"
    return f"Verified: {cover}{tip}; families {source}."


def _never_lines(check: Any) -> Iterator[str]:
    """What the arm can never do, and which task is checked because of it."""
    if turn_follows(check.robot, check.task):
        yield f"{NEVER_TURNS.format(check.robot.n)}. {CHECKED_POINTING}."
    elif tool_stays_level(check.robot, check.task):
        yield f"{NEVER_TILTS}."
    elif place_alone(check.robot, check.task):
        yield f"{PLACES_ALONE.format(check.robot.n)}."
    elif pointing_task(check.robot, check.task) is not None:
        yield f"{NEVER_TURNS.format(check.robot.n)}. {advise('task', 'tool-axis-free')} checks position and tool axis."


def _next_step(check: Any, mending: Any, *, listed: bool, target: str | None) -> str:
    """What to do about a path that does not hold, once its remedies are known."""
    if mending is None or not mending.needed:
        return _advice(check)
    remedy = mending.written
    if remedy is None and listed:
        return _after_no_remedy(check)
    if remedy is None:
        return _advice(check)
    if target is not None:
        return f"run {target}, the path mended by {remedy.kind}: {_state_of_remedy(remedy)}"
    if listed:
        file = advise("fixed", "FILE", python="mending.written.trajectory")
        return f"{file} writes the path mended by {remedy.kind}: {_state_of_remedy(remedy)}"
    if check.verdict == "crossing" and check.tool is None:
        return f"{_joint_move(check)}; for a tool move take the remedy below, or let {_remedies()} compute others"
    return f"take the remedy below, or let {_remedies()} compute others"


def _state_of_remedy(remedy: Any) -> str:
    """What the new check of a mended path proved."""
    if remedy.check.clear:
        return "free (proven)"
    return "limits kept, and it still meets a singularity"


def _after_no_remedy(check: Any) -> str:
    """What to do where no kind of remedy was found: another question to the tool, or wider bounds."""
    if check.tool is not None:
        advice = _tool_advice(check)
        if advice is not None:
            return advice
    bounds = f"{advise('tool-tilt', '…')}, {advise('base-shift', '…')} or larger {advise('bump', '…')} and "
    wider = f"no remedy was found; {bounds}{advise('detour', '…')} allow more"
    if check.verdict == "crossing" and check.tool is None:
        return f"{_joint_move(check)}. For a tool move {wider}"
    return wider


def _advice(check: Any) -> str:
    """What to do about a path that does not hold."""
    if not check.complete:
        return "run the same command again"
    if check.verdict == "too fast":
        worst = max(violation.amount for violation in check.violations if violation.what == "rate")
        return f"run it at {rounded_down(1 / worst)} of the speed, or let {_remedies()} compute a new time law or path"
    if check.tool is not None:
        advice = _tool_advice(check)
        if advice is not None:
            return advice
    if check.verdict == "undecided":
        return f"a larger {advise('evaluations', '…')} may decide it"
    if check.verdict == "crossing" and check.tool is None:
        return f"{_joint_move(check)}; {_remedies()} computes changes for a tool move"
    return f"{_remedies()} computes changes that avoid it; {advise('full')} prints every stretch"


def _tool_advice(check: Any) -> str | None:
    """What to do about a move of the tool: ask for less, turn first, take another branch, allow a wider tube."""
    tool = check.tool
    if not tool.complete and turn_follows(check.robot, check.task):
        axis, place = advise("task", "tool-axis-free"), advise("task", "position")
        far = advise("pose", "…", python="rankdrop.inverse(arm, pose)")
        return (f"{check.robot.n} joints reach few poses: {axis} or {place} leave free what they cannot do; "
                f"explain with {far} says how far a pose is out of reach")  # fmt: skip
    if tool.turn is not None and tool.turn.place == 1.0:
        return f"make the turn first, then check the path again with {advise('start', '…')} at its end"
    number = first_free_branch(tool.branches)
    if number is not None:
        start = ",".join(f"{x:.6g}" for x in tool.branches[number - 1].start.tolist())
        taken = advise("start", f'"{start}"', python=f"start=[{start}]")
        return f"branch {number} is free to the end: {taken} (rad)"
    if tool.reason == "limit":
        return "move the part or the base of the arm, or turn the tool, so that the joint stays inside its limits"
    if check.verdict == "undecided" and not tool.complete:
        tip, turn = advise("tip-tolerance", "…"), advise("turn-tolerance", "…")
        return f"a larger {tip} and {turn} need fewer rows; or begin another file at that pose"
    return None


def _joint_move(check: Any) -> str:
    """What a joint path that crosses needs: nothing, where the controller moves the joints and not the tool."""
    shares = check.profile.rates[np.isfinite(check.profile.rates)]
    if not len(shares):
        return "a joint move may cross; its rates are not known"
    return f"as a joint move nothing needs to be done: it keeps its rates (largest: {100 * shares.max():.2g} %)"


def free_words(check: Any) -> str:
    """The share that is proven free in per cent, never rounded up to the whole: a crossing is a point of it."""
    words = f"{100 * check.free_share:.6g}"
    all_of_it = check.free_share == 1.0 and not check.crossings
    if words == "100" and not all_of_it:
        return "more than 99.9999 %"
    return f"{words} %"


def notes(check: Any) -> tuple[str, ...]:
    """Remarks; of a tool path its branch, and with times the poses of its crossings."""
    lines = [_remark(kind, values, check.robot) for kind, values in check.remarks]
    if check.tool is not None:
        if check.tool.moved > _MOVED:
            far = f"; it was moved by {angle(check.tool.moved)} to reach pose 1"
        else:
            far = ""
        lines.append(f"branch: {branch_chosen(check.tool)}{far}")
        if check.tool.half_turns:
            lines += [half_turn_words(check.tool.half_turns)]
        lines += [turn_far_words(turn) for turn in check.turns]
        places = [crossing.closest.place for crossing in check.crossings][:MOST_NAMED]
        lines += [f"{seconds(place.time)} s is pose {place.pose:.6g}" for place in places if place.time is not None]
    return tuple(lines)


def _remark(kind: str, values: Any, robot: Robot) -> str:
    """What a reader should know besides the verdict."""
    if kind == "jump":
        joint, row, before, after = values
        turn = minus(f"{degrees(after - before):+.3g}°")
        ends = f"{short(degrees(before), 4)}° to {short(degrees(after), 4)}°"
        other = minus(f"{degrees(after - before) - copysign(360.0, after - before):+.3g}°")
        return (
            f"joint {joint} turns by {turn} from row {row - 1} to row {row} ({ends}), as the rows say; if these angles "
            f"start anew after a whole turn, it went {other}: add whole turns to the rows"
        )
    if kind == "missed":
        return missed_words(robot, *values)
    if kind == "edge":
        off = tool_off_words(values, robot)
        return f"pose 1 lies beyond the edge of reach by {off}, which is rounding; the arm begins at the edge"
    return _REMARKS[kind].format(values)


def path_sections(
    check: Any, *, deg: bool = True, full: bool = False, mending: Any = None, listed: bool = False,
    target: str | None = None,
) -> tuple[Section, ...]:  # fmt: skip
    """The summary, crossings, with `full` the free stretches, and notes.

    Args:
        check: the path.
        deg: joint angles in degrees.
        full: every crossing and every free stretch.
        mending: remedies that were looked for; None: none were.
        listed: the remedies have sections of their own.
        target: file that the best remedy is written to; None: none.
    """
    tone = {"free": "good", "undecided": "warning", "too near": "warning"}.get(check.verdict, "bad")
    first, *others = summary(check, mending, listed=listed, target=target)
    sections = [Section(first, lines=tuple(others), tone=tone)]
    crossing_lines = _met_lines(check, deg=deg, full=full)
    if crossing_lines:
        sections.append(Section("Singularities on the path", lines=tuple(crossing_lines)))
    if check.tool is not None and len(check.tool.branches) > 1:
        sections.append(branches_section(check, deg=deg))
    free = [stretch for stretch in check.stretches if stretch.verdict == "free"]
    if full and free:
        sections.append(free_section(free, check, deg=deg))
    notes = list(check.notes)
    if full:
        scale = f"σ with translation divided by {check.length_scale:.4g} m; distances in joint space"
        notes.append(f"{check.robot.name}, {check.task.name}: {scale}")
    if notes:
        sections.append(Section("Notes", lines=tuple(notes)))
    return tuple(sections)


def _met_lines(check: Any, *, deg: bool, full: bool) -> list[str]:
    """The stretches that are not free, in their order: each described, or where there are many the first ones named."""
    met = sorted((stretch for stretch in check.stretches if stretch.verdict != "free"), key=attrgetter("start"))
    lines: list[str] = []
    if full or len(met) <= DESCRIBED:
        for stretch in met:
            lines += crossing_lines(stretch, check, deg=deg, full=full)
        return lines
    lines += (f"{crossing_words(stretch, check)}, {when(stretch.closest.place)}" for stretch in met[:LISTED])
    if len(met) > LISTED:
        more = f"and {len(met) - LISTED} more; "
    else:
        more = ""
    return [*lines, f"{more}{advise('full')} describes each of them"]


def many_section(many: Sequence[dict[str, Any]]) -> Section:
    """Several paths in short, as a table.

    Args:
        many: from `check_files`.
    """
    rows = []
    for record in many:
        if record["met"] or record["nearest_rad"] is None:
            near = ""
        else:
            near = short(record["nearest_rad"], 3)
        cells = ("" if x is None else str(x) for x in (record["rows"], record["met"]))
        rows.append((record["file"], record["verdict"], *cells, near, record["name"]))
    holds = sum(record["verdict"] == "free" for record in many)
    return Section(
        f"{holds} of {len(many)} paths proven free",
        columns=("file", "verdict", "rows", "reached", "nearest [rad]", "family"), rows=tuple(rows), texts=(0, 1, 5),
        after=tuple(record["sentence"] for record in many if record["verdict"] == "bad input"),
    )  # fmt: skip
