"""Checked paths in words, made from their facts.

A check: five lines first, then crossings, with `full` free stretches and notes. Records are those of `rankdrop.path`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from math import copysign, degrees, inf, isfinite, isnan
from operator import attrgetter
from typing import Any

import numpy as np

from rankdrop.local.block import generic_rank
from rankdrop.local.pointing import pointing_task, tool_stays_level, turn_follows
from rankdrop.options import advise
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section
from rankdrop.text.places import row_words, turn_far_words, when
from rankdrop.text.remedies import local_lines
from rankdrop.text.special import place_words
from rankdrop.text.words import (
    CHECKED_POINTING,
    NEVER_TILTS,
    NEVER_TURNS,
    above_limit,
    angle,
    minus,
    motion,
    plural,
    rounded_down,
    rounded_up,
    short,
)
from rankdrop.tolerances import NEAR
from rankdrop.units import counted_length

DESCRIBED, LISTED = 2, 12
"""Crossings that are described in some lines each; if there are more, so many get one line each."""
_CLOSEST = 3  # free stretches whose closest configuration is printed
_SMALLEST = 1e-12  # of a width of a bracket that is printed [s]
_LEADS = 1e-6  # a distance below it is that of a stretch that ends at a singularity [rad]
_TURNS = 1e-6  # a joint that turns less stands still [rad]
_MOVED = 1e-3  # a start that is nearer to the first pose counts as at it [rad]
_NAMED = 10  # crossings whose poses are noted
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
_REMARKS = {
    "degrees": "{0}",
    "velocities": "velocities are given and not used: a controller that has them makes cubics of the samples",
    "lost": "lost motions are described for the first {0[0]} of {0[1]} crossings",
    "distances": "no families are known: distances are searched on {0[0]} of {0[1]} free stretches",
    "no distance": "no distance is searched: {0}",
    "distance open": "the distance to be kept could not be proven around row {0}",
}
_FOLDS = "the branch folds back at a singularity"
_REASONS = {
    "singular": "the branch ends at a singularity",
    "stuck": "the solver does not converge there",
    "budget": "the steps and rows that one tool path may have are used up",
}

def evidence_words(stretch: Any, check: Any) -> str:
    """How the verdict of a stretch is known."""
    rank = str(generic_rank(check.robot, check.task)).translate(str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉"))
    return _EVIDENCE[stretch.evidence].format(
        condition=stretch.condition, rank=rank, sigma=stretch.closest.sigma, limit=check.tolerances.singular
    )


def _remedies() -> str:
    """What computes changes of a path."""
    return advise("remedies", python="rankdrop.path.mend_path")


def branch_chosen(tool: Any) -> str:
    """Which branch of the inverse kinematics a tool path takes."""
    if not tool.solutions:
        return "of the start that was given"
    if tool.more:
        count = f"of {tool.solutions} found, and there are more"
    else:
        count = f"one of {tool.solutions} found"
    if tool.more:
        return f"nearest to q = 0 ({count})"
    return f"the posture that people use ({count})"


def why_ended(tool: Any, robot: Robot) -> str:
    """Why a tool path cannot be followed any further; "" where it can."""
    if tool.complete:
        return ""
    pose = f"at pose {tool.reached:.5g}"
    if tool.turn is not None:
        return turn_words(tool.turn, robot)
    if tool.folds:
        place = f"{pose} (σ = {tool.sigma:.1e}), and no configuration near it leads on"
        reason = f"{_FOLDS}, {place}"
        return f"{reason}; {_pose_after_end_words(tool)}"
    if tool.reason in _REASONS:
        reason = f"{_REASONS[tool.reason]}, {pose} (σ = {tool.sigma:.1e})"
    else:
        reason = f"{_joint(robot, tool.joint)} reaches its limit {pose}"
    return f"{reason}; {_pose_after_end_words(tool)}"


def _pose_after_end_words(tool: Any) -> str:
    """Whether the pose after the end can be reached."""
    ahead = f"pose {int(min(np.floor(tool.reached + 1e-9) + 1, tool.poses))}"
    if tool.next_reachable:
        return f"{ahead} is within reach, by other configurations"
    return f"{ahead} is out of reach: no configuration within the joint limits was found for it"


def turn_words(turn: Any, robot: Robot, *, place: bool = True) -> str:
    """An internal turn: its joint that turns most, the others, and how far the path can be followed after it.

    Args:
        turn: the turn.
        robot: the arm.
        place: name the pose at which it is made, and how far the path can be followed after it.
    """
    first, *others = _turned_joints(turn, robot)
    with_it = ""
    if others:
        with_it = f", with {', '.join(_joint_turn(turn, robot, i) for i in sorted(others))}"
    words = f"turn {_joint_turn(turn, robot, first)} with the tool held still{with_it}"
    if not place:
        return words
    return f"{words}, at pose {turn.place:.5g}{_after_turn(turn)}"


def _turned_joints(turn: Any, robot: Robot) -> list[int]:
    """The joints that an internal turn turns, counted from 0, the one that turns most first; at least one joint."""
    moved = turn.to - turn.q
    turns = [i for i, joint in enumerate(robot.variables) if joint.unit == "rad" and abs(moved[i]) > _TURNS]
    if not turns:
        return [int(np.abs(moved).argmax())]
    return sorted(turns, key=lambda i: (-round(abs(moved[i]), 6), i))


def _joint_turn(turn: Any, robot: Robot, i: int) -> str:
    """Where a joint, counted from 0, begins and ends an internal turn."""
    unit = robot.variables[i].unit
    if unit == "rad":
        scale, sign = degrees(1.0), "°"
    else:
        scale, sign = 1.0, f" {unit}"
    ends = " to ".join(f"{short(round(scale * float(x), 6) + 0.0, 4)}{sign}" for x in (turn.q[i], turn.to[i]))
    return f"joint {i + 1} from {ends}"


def _after_turn(turn: Any) -> str:
    """How far the path can be followed after an internal turn; empty where nobody looked."""
    if turn.rest_complete is None:
        return ""
    if turn.rest_complete:
        return "; after it the path can be followed to its end"
    return f"; after it the path can be followed to pose {turn.rest_reached:.5g}"


def sentence(check: Any) -> str:
    """The verdict: what the path does, worst first."""
    if check.holds:
        if check.margin == "kept":
            kept = f", and farther than {angle(check.options.min_distance)} from any"
        else:
            kept = ""
        if check.curve.times is not None:
            limits = "; joint limits and rates kept"
        else:
            limits = _near_without_times(check)
        return f"Free: proven for every point of the path{kept}{limits}."
    parts = [*_reached_words(check), *(_violation(violation, check) for violation in check.violations), *_open(check)]
    if check.clear:
        parts.append("free of singularities (proven)")
    words = "; ".join(parts)
    words = f"{words[0].upper()}{words[1:]}."
    if check.tool is not None and not check.tool.complete:
        beyond = f"Cannot be followed beyond pose {check.tool.reached:.5g} of {check.tool.poses}"
        if check.tool.turn is not None:
            beyond += " without an internal turn"
        return f"{beyond}: {why_ended(check.tool, check.robot)}." + (f" Up to there: {words}" if parts[1:] else "")
    return words


def _near_without_times(check: Any) -> str:
    """How near a free path comes to a singularity where its joint rates are unknown; empty where it stays away."""
    least = min((stretch.closest.distance for stretch in check.stretches), default=inf)
    if check.margin == "kept" or least >= NEAR:
        return ""
    return f", but {angle(least)} from a singularity; without times joint rates are not checked"


def _reached_words(check: Any) -> Iterator[str]:
    """Singularities that the path reaches or comes near to; the end of a branch."""
    if check.tool is not None and not check.tool.complete:
        yield "the branch ends"
    for how, words in REACHED.items():
        part = [crossing for crossing in check.crossings if how_reached(crossing) == how]
        if part:
            yield f"{words.format(times(len(part)))}, first {stretch_place(check, part[0])}, {_stay_or_place(part[0])}"
    if check.tool is not None and check.tool.passed:
        yield passing_words(check.tool.passed)
    if check.margin == "violated" and not check.crossings:
        yield f"comes nearer than {angle(check.options.min_distance)} to a singularity"


def _stay_or_place(stretch: Any) -> str:
    """The place of a singularity; both ends of a stretch that lies in it, or at which the arm rests."""
    start, end = stretch.bracket
    if stretch.verdict == "touching" and end.position - start.position > _STAYS:
        return _span(stretch)
    return when(stretch.closest.place)


REACHED = {
    "crossing": "crosses a singularity {} (proven)",
    "lies": "lies in a singularity {}",
    "touching": "touches a singularity {}",
}
"""How a path reaches singularities, in the order of the first line; how often is put in."""


def how_reached(stretch: Any) -> str:
    """The key of `REACHED` of a stretch of a path; its verdict where it reaches no singularity for certain."""
    if stretch.verdict == "touching" and stretch.lies:
        return "lies"
    return str(stretch.verdict)


def times(count: int) -> str:
    """How often: "once", "twice", "3 times"."""
    return {1: "once", 2: "twice"}.get(count, f"{count} times")


def passing_words(passed: Sequence[Any]) -> str:
    """How the branch goes on at the singularities that it passes."""
    if all(not crossing.rest for crossing in passed):
        if len(passed) == 1:
            return "the branch goes on through it, at any speed"
        return "the branch goes on through each, at any speed"
    rests = list(dict.fromkeys(f"{crossing.place:.5g}" for crossing in passed if crossing.rest))
    if rests == ["1"]:
        return "the path leaves the singularity at its start, from rest"
    return f"the arm rests for an instant at pose {', '.join(rests[:_NAMED])}, where the branch goes on"


def _violation(violation: Any, check: Any) -> str:
    joint = check.robot.variables[violation.joint - 1]
    if violation.what == "rate":
        near = ""
        if isfinite(violation.distance):
            name = _place(check, violation.foot, violation.name)
            near = f", {short(degrees(violation.distance), 2)}° from a singularity ({name})"
        limit = f"{above_limit(violation.amount)} limit of joint {violation.joint} {when(violation.place)}{near}"
        if violation.proven:
            return f"not possible at the programmed speed: {limit}"
        return f"the rate of joint {violation.joint} could not be proven to keep its limit"
    if not violation.proven:
        return f"{_joint(check.robot, violation.joint)} could not be proven to keep its limits"
    excess = motion(violation.amount, joint.unit)
    if violation.rows:
        rows = f" in {violation.rows} row{'s' if violation.rows > 1 else ''}, first"
    else:
        rows = ""
    where = f"{rows} {when(violation.place)}"
    return f"{_joint(check.robot, violation.joint)} is outside its limits{where}, by {excess} at most"


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


def summary(check: Any, mending: Any = None) -> tuple[str, ...]:
    """Five lines: the verdict, the path, what to do, the nearest singularity, and how this is known."""
    lines = [sentence(check), _path_line(check), *_never_lines(check)]
    if check.tool is not None and len(check.tool.branches) > 1:
        lines.append(f"Branch: {_branches_words(check)}.")
    if not check.holds:
        lines.append(f"Next: {_advice(check)}.")
        if mending is not None:
            lines += local_lines(mending)
    near = min((stretch for stretch in check.stretches if isfinite(stretch.closest.distance)),
               key=lambda stretch: stretch.closest.distance, default=None)  # fmt: skip
    if near is not None:
        lines.append(f"Nearest singularity: {stretch_place(check, near)}, {_nearest_place_words(near)}.")
    return (*lines, _verified_line(check))


def _path_line(check: Any) -> str:
    """How long the path is, how it runs between its rows, and how much of it is proven free."""
    times = check.curve.times
    if times is None:
        lasts = ""
    else:
        lasts = f", {times[-1] - times[0]:.6g} s"
    free = sum(stretch.verdict == "free" for stretch in check.stretches)
    return (
        f"Path: {check.rows} rows{lasts}, {check.options.interpolate} between them; {free_words(check)} of its length "
        f"is proven free, {free} stretch{'es' if free != 1 else ''}."
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
        cover = "1 enclosure covers"
    else:
        cover = f"{check.evaluations:,} enclosures cover"
    return f"Verified: {cover} it{tip}; families {source}."


def _never_lines(check: Any) -> Iterator[str]:
    """What the arm can never do, and which task is checked because of it."""
    if turn_follows(check.robot, check.task):
        yield f"{NEVER_TURNS.format(check.robot.n)}. {CHECKED_POINTING}."
    elif tool_stays_level(check.robot, check.task):
        yield f"{NEVER_TILTS}."
    elif pointing_task(check.robot, check.task) is not None:
        yield f"{NEVER_TURNS.format(check.robot.n)}. {advise('task', 'tool-axis-free')} checks position and tool axis."


def _branches_words(check: Any) -> str:
    """Which branch the verdict is about, and how many of the others are free."""
    branches = check.tool.branches
    number = next(i for i, branch in enumerate(branches, start=1) if branch.chosen)
    posture = ", ".join(branches[number - 1].posture)
    others = [branch for branch in branches if not branch.chosen]
    free = sum(branch.free and branch.complete for branch in others)
    named = f" ({posture})" if posture else ""
    be = "is" if free == 1 else "are"
    this = f"{number} of {len(branches)}{named}; the verdict is about this one"
    return f"{this}. Of the others {free} {be} free to the end"


def _branch_verdict(branch: Any, robot: Robot) -> str:
    """A branch: "free", or where it ends and why, or where it is not proven free."""
    if branch.free:
        met = ""
    else:
        met = f"meets a singularity or is not decided at pose {branch.place:.5g}"
    if branch.complete:
        return met or "free"
    if branch.turn is not None:
        end = f"needs an internal turn at pose {branch.reached:.5g}"
    elif branch.reason == "limit":
        end = f"ends at pose {branch.reached:.5g}: limit of {_joint(robot, branch.joint)}"
    else:
        if branch.folds:
            reason = "folds back"
        else:
            reason = _ENDS.get(branch.reason, branch.reason)
        end = f"ends at pose {branch.reached:.5g}: {reason}"
    if met and branch.place < branch.reached:
        return f"{end}; {met}"
    return end


_ENDS = {"singular": "singularity", "stuck": "the solver does not converge", "budget": "the budget is spent",
         "start": "not reached"}  # fmt: skip


def _branches_section(check: Any, *, deg: bool) -> Section:
    robot = check.robot
    heads = tuple(
        f"{i} [{'°' if deg and joint.unit == 'rad' else joint.unit}]" for i, joint in enumerate(robot.variables, 1)
    )
    rows = []
    for number, branch in enumerate(check.tool.branches, start=1):
        values = (minus(f"{degrees(x):.2f}") if deg and joint.unit == "rad" else minus(f"{x:.4f}")
                  for x, joint in zip((branch.start + 0.0).tolist(), robot.variables, strict=True))  # fmt: skip
        if branch.chosen:
            taken = f"{number} (taken)"
        else:
            taken = str(number)
        rows.append((taken, _branch_verdict(branch, robot), ", ".join(branch.posture) or "–", *values))
    other = f"by the configuration at pose 1, those first that people use; {advise('start', '…')} takes another"
    return Section("Branches", other,
                   columns=("", "verdict", "posture", *heads), rows=tuple(rows), texts=(0, 1, 2))  # fmt: skip


def _nearest_place_words(near: Any) -> str:
    """Where a stretch is nearest to a singularity."""
    if near.verdict != "free":
        return when(near.closest.place)
    if near.closest.distance < _LEADS:
        return "at its end"
    return f"{angle(near.closest.distance)} away, {when(near.closest.place)}"


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
    number = _better_branch(tool.branches)
    if number is not None:
        start = ",".join(f"{x:.6g}" for x in tool.branches[number - 1].start.tolist())
        taken = advise("start", f'"{start}"', python=f"start=[{start}]")
        return f"branch {number} is free to the end: {taken} (rad)"
    if check.verdict == "undecided" and not tool.complete:
        tip, turn = advise("tip-tolerance", "…"), advise("turn-tolerance", "…")
        return f"a larger {tip} and {turn} need fewer rows; or begin another file at that pose"
    return None


def _better_branch(branches: Sequence[Any]) -> int | None:
    """The number of the first branch that is free to the end; None where there is none, or it is the one chosen."""
    free = [(number, branch) for number, branch in enumerate(branches, start=1) if branch.free and branch.complete]
    if not free or any(branch.chosen for _, branch in free):
        return None
    return free[0][0]


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


def half_turn_words(poses: Sequence[int]) -> str:
    """Poses from which the tool turns by exactly half a turn: which way it turns is a choice."""
    named = ", ".join(map(str, poses[:_NAMED]))
    more = ", …" if len(poses) > _NAMED else ""
    return (
        f"half a turn: from {plural('pose', len(poses))} {named}{more} the next one is 180° away, "
        "and the tool may turn either way round; one of the two was checked. "
        "A pose between them decides which one the controller takes"
    )


def notes(check: Any) -> tuple[str, ...]:
    """Remarks; of a tool path its branch and the poses of its crossings."""
    lines = [_remark(kind, values) for kind, values in check.remarks]
    if check.tool is not None:
        places = [crossing.closest.place for crossing in check.crossings][:_NAMED]
        poses = np.interp([place.position for place in places], np.arange(1, check.rows + 1), check.tool.place)
        if check.tool.moved > _MOVED:
            far = f"; it was moved by {angle(check.tool.moved)} to reach pose 1"
        else:
            far = ""
        lines.append(f"branch: {branch_chosen(check.tool)}{far}")
        if check.tool.half_turns:
            lines += [half_turn_words(check.tool.half_turns)]
        lines += [turn_far_words(turn) for turn in check.turns]
        lines += [f"row {row_words(place)} is pose {pose:.6g}" for place, pose in zip(places, poses, strict=True)]
    return tuple(lines)


def _remark(kind: str, values: Any) -> str:
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
    return _REMARKS[kind].format(values)


def path_sections(
    check: Any, *, deg: bool = True, full: bool = False, mending: Any = None
) -> tuple[Section, ...]:
    """The summary, crossings, with `full` the free stretches, and notes.

    Args:
        check: the path.
        deg: joint angles in degrees.
        full: every crossing and every free stretch.
        mending: local remedies that were looked for; None: none were.
    """
    tone = {"free": "good", "undecided": "warning", "too near": "warning"}.get(check.verdict, "bad")
    first, *others = summary(check, mending)
    sections = [Section(first, lines=tuple(others), tone=tone)]
    crossing_lines = _met_lines(check, deg=deg, full=full)
    if crossing_lines:
        sections.append(Section("Singularities on the path", lines=tuple(crossing_lines)))
    if check.tool is not None and len(check.tool.branches) > 1:
        sections.append(_branches_section(check, deg=deg))
    free = [stretch for stretch in check.stretches if stretch.verdict == "free"]
    if full and free:
        sections.append(_free_section(free, check, deg=deg))
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
    lines += (f"{_crossing_words(stretch, check)}, {when(stretch.closest.place)}" for stretch in met[:LISTED])
    if len(met) > LISTED:
        more = f"and {len(met) - LISTED} more; "
    else:
        more = ""
    return [*lines, f"{more}{advise('full')} describes each of them"]


def crossing_lines(stretch: Any, check: Any, *, deg: bool, full: bool) -> Iterable[str]:
    """A stretch that is not free: what it reaches, where, and what is lost."""
    crossing = f"{_crossing_words(stretch, check)}, {_span(stretch)}"
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
    return _place(check, q, stretch.name, stretch.corank)


def _place(check: Any, q: Array, name: str, corank: int = 0) -> str:
    """The part of the arm that is special at a singular configuration q (n,); the name without any, or without q."""
    if len(q):
        place = place_words(check.robot, check.task, q, max(corank, 1))
    else:
        place = ""
    return place or name or "an unnamed family"


_VERBS = {"crossing": "crosses", "lies": "lies in", "touching": "touches"}


def _crossing_words(stretch: Any, check: Any) -> str:
    verb = _VERBS.get(how_reached(stretch), "undecided:")
    return f"{verb} {stretch_place(check, stretch)}{_id(stretch)}"


def _free_section(free: list[Any], check: Any, *, deg: bool) -> Section:
    timed = check.curve.times is not None
    limited = any(not isnan(stretch.speed_factor) for stretch in free)
    columns = ["nearest family", "rows", "closest", "σ", "weak"]
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
        f"{_distance_words(stretch.closest.distance)} at row {row_words(stretch.closest.place)}"
        f"{_way(stretch, check.robot)}: {joints_words(check.robot, stretch.closest.q, deg=deg)}"
        for stretch in free[:_CLOSEST] if stretch.closest.distance >= _LEADS
    )
    return Section("Proven free", columns=tuple(columns), rows=tuple(rows), after=where, notes=tuple(notes))


def _closest_cells(closest: Any) -> tuple[str, str, str]:
    """The distance to the nearest singular configuration, σ there, and the share of travel along the weak direction."""
    if isnan(closest.weak):
        weak = "–"
    else:
        weak = _percent(closest.weak)
    if closest.distance < _LEADS:
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


def _span(stretch: Any) -> str:
    start, end = stretch.bracket
    if start.row == end.row or (end.share == 0.0 and end.row == start.row + 1):
        rows = f"between rows {start.row} and {start.row + 1}"
        if start.share == end.share == 0.0 and start.row == end.row:
            rows = f"at row {start.row}"
    else:
        rows = f"rows {row_words(start)} to {row_words(end)}"
    if start.time is None or end.time is None:
        return rows
    if end.time - start.time < 1e-4:
        return f"{rows}, at {stretch.closest.place.time:.6f} s (± {short(max(end.time - start.time, _SMALLEST), 2)} s)"
    return f"{rows}, {start.time:.6g} to {end.time:.6g} s"


def _distance_words(distance: float) -> str:
    if isfinite(distance):
        return short(distance, 3)
    return "?"


def _joint(robot: Robot, number: int) -> str:
    return f"joint {number} ({robot.variables[number - 1].name})"


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


def joints_words(robot: Robot, q: Array, *, deg: bool) -> str:
    """Joint values by name, with units."""
    parts = []
    for joint, value in zip(robot.variables, q, strict=True):
        turns = joint.unit == "rad"
        if deg and turns:
            shown = degrees(float(value))
        else:
            shown = float(value)
        unit = ("°" if deg else " rad") if turns else " m"
        parts.append(f"{joint.name} {short(round(shown, 4 if not turns or not deg else 3) + 0.0, 6)}{unit}")
    return ", ".join(parts)


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
