"""Checked robot programs in words, with the lines of the program. Records: `rankdrop.path.check.program`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from math import degrees, isfinite
from typing import Any

import numpy as np

from rankdrop.lists import flat_map
from rankdrop.options import advise
from rankdrop.robot.model import Robot
from rankdrop.sections import Section
from rankdrop.text.inverse import tool_place
from rankdrop.text.paths import free_words, times
from rankdrop.text.places import joints_words, overrun_words
from rankdrop.text.remedies import joint_moves, tool_off_words
from rankdrop.text.stretches import REACHED, crossing_lines, how_reached, stretch_place
from rankdrop.text.tool_paths import turn_words
from rankdrop.text.words import above_limit, angle, motion, plural, rounded_down, rounded_up, short
from rankdrop.tolerances import NEAR
from rankdrop.units import counted_length

_NAMED = 10  # lines that are named in a sentence
_LISTED = 30  # moves and unread lines that are listed without --full
_FAR_TURN = 90.0  # degrees that a joint turns in one linear move from which on it is reported
_REASONS = {
    "variable": "target is a variable, a register, or not in this file",
    "changed": "target is assigned more than once, or changed",
    "expression": "target is an expression",
    "incomplete": "target does not have all of its values, and the move before it does not give the others",
    "pulses": "target is in pulses: pulses per degree are not in the file",
    "circle": "this circular move is not read: an angle, a mode, or a turn of the tool on it that is not known",
    "spline": "splines are not read",
    "relative": "relative moves are not read: where the move before ended is not known from the file",
    "after joint values": "the move is relative to a target of joint values: write its pose, or make it absolute",
    "after a pose": "joint values are added to a target that is a pose: write its joint values",
    "relative turn": "turns relative to the base frame are not read: add #TOOL, or write the pose",
    "offset": "the values of the offset are not numbers of the file",
    "ends early": "the move may end before its target, at a signal or a contact",
    "shifted": "a shift or a program displacement is active: its values are not evaluated",
    "other move": "moves of this kind are not read",
    "base frame": "target is in a user frame, base or work object without its numbers in the move",
    "routine": "another routine begins; from where it is called is not known",
    "branch": "branches and jumps are not followed; each line is read once",
    "loop": "loops are read once; the way back to their beginning is not checked",
    "call": "calls are not followed; they are taken not to move the arm",
    "tool frame": "a tool frame that is not in the file",
    "override": "overrides are not read; speeds are those of the moves",
    "other": "not a move",
}
_ASSUMED = {
    "tool": "the tool of {} is not in the file, and the tip of the arm is taken",
    "external axes": "external axes or another group move or are away from zero in {}, and are taken not to carry the "
        "arm",
    "turns": "$ORI_TYPE is not known, or lets the tool turn otherwise in {}, and a turn about one axis is taken",
    "wrist": "SingArea lets the tool turn off its line in {}, and it is taken to stay on it",
    "configuration": "CONFIG states another posture than N U T in {}, and is not read",
    "arrival": "{} ends in another configuration than its target states: with ConfL \\On the controller may stop",
    "half a turn": "the tool turns by half a turn in {}, and one of the two ways round is taken",
}  # fmt: skip
"""Assumptions on moves, with their lines."""
_CAUSES = {
    "out of reach": "no configuration within the joint limits was found for its target",
    "no such posture": "no solution within the joint limits has the configuration that its target states",
    "no circle": "the place before it, the place on the way and its target lie on one line",
}
_ENDS = {
    "singular": "the branch ends at a singularity", "stuck": "the solver does not converge",
    "few joints": "the arm has too few joints for the poses ahead",
    "budget": "the steps and rows that one tool path may have are used up", "start": "its beginning is not reached",
    "turn": "the arm needs an internal turn first, with the tool held still",
}  # fmt: skip
_SAME_DISTANCE = 1.001  # a stretch that is as near as its move, to this factor, is the nearest one
_FAST = 3  # lines of which joints above their rate limits are described
_SLOW = 0.1  # of the programmed speed, below which a joint move is the better advice
_KINDS = {"joint": "joint move", "line": "straight line", "arc": "circular arc"}

_CONFIGURATIONS = 12  # that are printed


def sentence(check: Any) -> str:
    """The verdict: what the program does, worst first, with its lines; and assumptions on its moves."""
    assumed = [_ASSUMED[assumption].format(_lines_words(lines)) for assumption, lines in check.assumptions.items()]
    found = _found_sentence(check)
    if not assumed:
        return found
    if check.verdict == "undecided":
        return f"Undecided: {'; '.join(assumed)}. As it was read: {found[0].lower()}{found[1:]}"
    return f"{found} Not certain: {'; '.join(assumed)}."


def _found_sentence(check: Any) -> str:
    """What the program does as it was read."""
    parts = [*_reached_words(check), *_end_lines(check), *_broken(check), *_open(check)]
    unread = len(check.unread)
    if not parts:
        timed = all(part.untimed is None for part in check.parts)
        if timed:
            limits = "; joint limits and rates kept"
        else:
            limits = f"; joint limits kept{_near_without_speed(check)}"
        moves = plural("move", len(check.program.moves))
        if not unread:
            return f"Free: proven for every point of {len(check.program.moves)} {moves}{limits}."
        parts = [f"undecided: {_unread(unread)}; all others are free (proven{limits})"]
    elif unread:
        parts.append(_unread(unread))
    words = "; ".join(parts)
    return f"{words[0].upper()}{words[1:]}."


def _near_without_speed(check: Any) -> str:
    """The move of unknown speed that comes nearest to a singularity; empty where all stay away."""
    near = [move for move in check.moves if move.seconds is None and move.distance < NEAR]
    if not near:
        return ""
    nearest = min(near, key=lambda move: float(move.distance))
    return f"; {angle(nearest.distance)} from a singularity in line {nearest.line}, where joint rates are not known"


def _unread(count: int) -> str:
    return f"{count} {plural('move', count)} of the program {'was' if count == 1 else 'were'} not read"


def _in_line(line: int, text: str) -> str:
    return f"in line {line}: {text}"


def _reached_words(check: Any) -> Iterator[str]:
    for how, words in REACHED.items():
        part = [crossing for crossing in check.met if how_reached(crossing.stretch) == how]
        if part:
            first = part[0]
            name = stretch_place(_path_of(first.stretch, check), first.stretch)
            yield f"{words.format(times(len(part)))}: {name}, {_in_line(first.line, first.text)}"
    passed = next((part.moves[part.passed[0]] for part in check.parts if part.passed), None)
    if passed is not None:
        yield f"goes through a singularity {_in_line(passed.line, passed.text)}"


def _path_of(stretch: Any, check: Any) -> Any:
    """The checked path of a program that has this stretch."""
    return next(path for path in check.checks if any(part is stretch for part in path.stretches))


def _end_lines(check: Any) -> Iterator[str]:
    for part in check.parts:
        if part.ended is not None:
            move = part.ended.move
            yield f"cannot be followed {_in_line(move.line, move.text)} ({_why(part.ended, check.robot)})"


def _other_configurations(ended: Any) -> str:
    """The configuration data of a robtarget that no solution has, and those of the solutions."""
    others = "; ".join(map(_quarters, ended.available[:_CONFIGURATIONS]))
    more = ""
    if len(ended.available) > _CONFIGURATIONS:
        more = f" and {len(ended.available) - _CONFIGURATIONS} more"
    return (f"no solution within the joint limits has cf1, cf4, cf6 = {_quarters(ended.move.target.posture.quarters)} "
            f"of its target; available: {others}{more}")  # fmt: skip


def _quarters(numbers: Sequence[int]) -> str:
    """Configuration data as numbers: "0, −1, 0"."""
    return ", ".join(map(str, numbers)).replace("-", "−")


def _why(ended: Any, robot: Robot) -> str:
    """Why a move cannot be followed."""
    if ended.available:
        return _other_configurations(ended)
    if ended.branch is None:
        return _CAUSES[ended.cause]
    branch = ended.branch
    share = f"after {100 * max(0.0, branch.reached - 1.0):.3g} % of the way"
    if branch.reason == "limit":
        return f"joint {branch.joint} ({robot.variables[branch.joint - 1].name}) reaches its limit {share}"
    if branch.folds:
        reason = "the branch folds back at a singularity"
    else:
        reason = _ENDS[branch.reason]
    return f"{reason} {share}"


def _broken(check: Any) -> Iterator[str]:
    for part in check.parts:
        for violation in () if part.check is None else part.check.violations:
            move = part.moves[part.move_at(violation.place)]
            joint = f"joint {violation.joint} ({check.robot.variables[violation.joint - 1].name})"
            where = _in_line(move.line, move.text)
            if violation.what == "rate" and violation.proven:
                times = f"{above_limit(violation.amount)} limit of {joint}"
                yield f"not possible at the programmed speed: {times} {where}{_other_fast_lines(part, move)}"
            elif violation.what == "rate":
                yield f"the rate of {joint} could not be proven to keep its limit {where}"
            elif violation.proven:
                excess = motion(violation.amount, check.robot.variables[violation.joint - 1].unit)
                yield f"{joint} is outside its limits by {excess} {where}"
            else:
                yield f"{joint} could not be proven to keep its limits {where}"


def _other_fast_lines(part: Any, worst: Any) -> str:
    """The other lines of a part in which a joint exceeds its rate limit."""
    others = [line for line, _ in _overruns_of_part(part) if line != worst.line]
    if not others:
        return ""
    return f" (and less in {_lines_words(others)})"


def _open(check: Any) -> Iterator[str]:
    """The open points of a program: undecided stretches, a distance that is not kept, an interrupted check."""
    undecided = sum(checked.undecided_length for checked in check.checks)
    if any(stretch.verdict == "undecided" for stretch in check.stretches):
        yield f"{undecided:.3g} rad of it undecided"
    if check.checks:
        far = angle(check.checks[0].options.min_distance)
    else:
        far = ""
    if any(path.margin == "violated" for path in check.checks):
        yield f"comes nearer than {far} to a singularity"
    elif any(path.margin == "not proven" for path in check.checks):
        yield f"a distance of {far} could not be proven"
    if not check.complete:
        yield "interrupted"


def summary(check: Any) -> tuple[str, ...]:
    """The verdict, what was read, corners, frames, where parts begin, turns, the nearest singularity, how it is known.
    """
    parts = (_next_lines, _read_lines, _begin_lines, _fast_lines, _turn_lines, _near_lines, _verified_lines)
    return (sentence(check), *flat_map(lambda part: part(check), parts))


def _next_lines(check: Any) -> Iterator[str]:
    """Of a program that meets singularities in joint moves alone: nothing needs to be done."""
    meets = {"crossing": "cross", "touching": "touch one"}.get(check.verdict)
    passed = any(part.passed for part in check.parts)
    if meets and check.met and not passed and all(crossing.kind == "joint" for crossing in check.met):
        lines = _lines_words([crossing.line for crossing in check.met])
        yield f"Next: the joint moves of {lines} {meets}, and a joint move may: nothing needs to be done there."


def _read_lines(check: Any) -> Iterator[str]:
    """What was read of a program, and what of it is not checked: corners, tool frames, the base, rates."""
    moves = check.program.moves
    yield _read_line(check)
    blends = [move.line for move in moves if move.blend]
    if blends:
        yield (f"Corners: checked as exact stops. The controller rounds those of {_lines_words(blends)}: it leaves the "
               "checked path there, and what it does instead is not checked.")  # fmt: skip
    yield from _tool_lines(check)
    if check.raised and any(move.target.pose is not None for move in moves):
        size = 1e3 / counted_length(check.robot)
        yield f"Base frame: at the height of axis 2, {short(size * check.raised, 4)} mm above the base of the arm."
    untimed = [part.untimed.line for part in check.parts if part.untimed is not None]
    if untimed:
        yield f"Rates: not checked, no speed is known for {_lines_words(untimed)}."


def _tool_lines(check: Any) -> Iterator[str]:
    """The tool that a program states, and the lines of tools that are not evaluated."""
    program = check.program
    if check.tool is None and program.tool is not None and not np.array_equal(program.tool, np.eye(4)):
        yield (f"Tool: the tip of the arm as it was given. The program states {tool_place(check.robot, program.tool)}, "
               "which is not added.")  # fmt: skip
    if check.tool is not None:
        yield (f"Tool: {tool_place(check.robot, program.tool)}, at the arm's tip, as the program states it; "
               f"{advise('tcp', '…', python='at_tool_point=True')} sets another.")  # fmt: skip
    if check.tool is None and program.tool is None:
        yield from _own_tools_lines(program)
    tools = check.assumptions.get("tool", ())
    if tools:
        yield (f"Tool: that of {_lines_words(tools)} is not in this file. Poses are read "
               f"as those of the tip of the arm; {advise('tcp', '…', python='the tip of the robot')} sets it.")


def _own_tools_lines(program: Any) -> Iterator[str]:
    """How many tools a program states, where they are several."""
    own = {move.tool.tobytes() for move in program.moves if move.needs_tool and move.tool is not None}
    if len(own) > 1:
        yield (f"Tool: {len(own)} tools, each as the program states it for its moves; "
               f"{advise('tcp', '…', python='at_tool_point=True')} sets one for all.")  # fmt: skip


def _read_line(check: Any) -> str:
    """The language of a program and how many moves of each kind were read."""
    moves = check.program.moves
    counts = Counter(move.kind for move in moves)
    arcs = ""
    if counts["arc"]:
        arcs = f", {counts['arc']} circular"
    unread = parts = ""
    if check.unread:
        unread = f"; {len(check.unread)} not read"
    if len(check.parts) > 1:
        parts = f", in {len(check.parts)} parts"
    read = f"{counts['joint']} joint, {counts['line']} straight{arcs}"
    return (f"Program: {check.program.language}; {len(moves)} {plural('move', len(moves))} read: {read}"
            f"{unread}{parts}.")  # fmt: skip


def _begin_lines(check: Any) -> Iterator[str]:
    for part in check.parts:
        if part.check is None or part.begins in ("joints", "start"):
            continue
        posed = f"Start: line {part.moves[0].line} is a pose."
        if part.begins == "posture":
            yield f"{posed} The posture that people use is taken; {advise('start', '…')} takes another."
        elif part.begins == "stated":
            yield f"{posed} Of its solutions one in the posture that it states is taken."
        else:
            yield f"{posed} The solution nearest to the configuration before it is taken."


def _overruns_of_part(part: Any) -> Iterator[tuple[int, Sequence[Any]]]:
    """The lines of a part in which joints exceed their rate limits, each with these joints, the worst first."""
    for index, move in enumerate(part.moves):
        overruns = part.overruns(index)
        if overruns:
            yield move.line, overruns


def _fast_lines(check: Any) -> Iterator[str]:
    """Joints above their rate limits, and for how long, in the lines that exceed a limit most."""
    found = sorted(flat_map(_overruns_of_part, check.parts), key=lambda fast: -fast[1][0].rate / fast[1][0].limit)
    for line, overruns in found[:_FAST]:
        yield f"Too fast in line {line}: {overrun_words(overruns, check.robot, where=False)}."
    if len(found) > _FAST:
        yield f"Too fast as well: {_lines_words([line for line, _ in found[_FAST:]])}."


def _turn_lines(check: Any) -> Iterator[str]:
    """The linear move in which a joint turns far, and by how much."""
    lines = [move for move in check.moves if move.kind != "joint" and degrees(move.turn) >= _FAR_TURN]
    if lines:
        most = max(lines, key=lambda move: move.turn)
        turn = _far_turn(check, most)
        if turn is not None:
            lasts = f" within {turn.end.time - turn.start.time:.3g} s"
            yield f"Turns: joint {turn.joint} turns {abs(degrees(turn.angle)):.0f}°{lasts} in line {most.line}."
            return
        if most.seconds is None:
            lasts = ""
        else:
            lasts = f" in {most.seconds:.3g} s"
        yield f"Turns: joint {most.joint} turns {degrees(most.turn):.0f}°{lasts} in line {most.line}."


def _far_turn(check: Any, move: Any) -> Any | None:
    """The largest turn within a short part of a move whose time is known; None where there is none."""
    for part in check.parts:
        for index, other in enumerate(part.moves):
            turns = part.turns(index) if other.line == move.line and move.seconds is not None else ()
            if turns:
                return max(turns, key=lambda turn: abs(turn.angle))
    return None


def _near_lines(check: Any) -> Iterator[str]:
    near = min((move for move in check.moves if isfinite(move.distance)), key=lambda move: move.distance, default=None)
    if near is not None:
        if near.distance < 1e-6:
            far = "on it"
        else:
            far = f"{angle(near.distance)} away"
        yield f"Nearest singularity: {_place_of(near, check)}, {far}, {_in_line(near.line, near.text)}."


def _place_of(move: Any, check: Any) -> str:
    """The part of the arm that is special where a move is nearest to a singularity, as the other lines name it.

    The name of the family where the nearest place is not in a stretch of that move.
    """
    for part in check.parts:
        for stretch in () if part.check is None else part.check.stretches:
            there = part.moves[part.move_at(stretch.closest.place)].line == move.line
            if there and stretch.family == move.family and stretch.closest.distance <= move.distance * _SAME_DISTANCE:
                return stretch_place(part.check, stretch)
    return move.name or "a singularity"


def _verified_lines(check: Any) -> Iterator[str]:
    spent = sum(checked.evaluations for checked in check.checks)
    size = 1e3 / counted_length(check.robot)
    off = max((part.off for part in check.parts), default=0.0)
    turned = max((part.turned for part in check.parts), default=0.0)
    if off > 0.0:
        tip = f"; the tip stays within {rounded_up(size * off)} mm and {rounded_up(1e3 * turned)} mrad of its lines"
    else:
        tip = ""
    shares = ", ".join(dict.fromkeys(free_words(checked) for checked in check.checks))
    if len(check.checks) == 1:
        free = f"; {shares} of the joint path is proven free"
    else:
        free = ""
    yield f"Verified: {spent:,} {plural('enclosure', spent)}{tip}{free}."


def _lines_words(lines: Sequence[int]) -> str:
    """Line numbers, runs of them in short.

    Example:
        >>> _lines_words([3, 4, 5, 9])
        'lines 3–5, 9'
    """
    runs: list[list[int]] = []
    for line in sorted(set(lines)):
        if runs and line == runs[-1][1] + 1:
            runs[-1][1] = line
        else:
            runs.append([line, line])
    named = ", ".join(str(a) if a == b else f"{a}–{b}" for a, b in runs[:_NAMED])
    more = ", …" if len(runs) > _NAMED else ""
    return f"{'line' if len(set(lines)) == 1 else 'lines'} {named}{more}"


def sections(check: Any, *, full: bool, remedies: Sequence[Any] = ()) -> tuple[Section, ...]:
    """The summary, remedies, singularities, moves, and the lines that were not read."""
    tone = {"free": "good", "undecided": "warning", "too near": "warning"}.get(check.verdict, "bad")
    first, *others = summary(check)
    sections_so_far = [Section(first, lines=tuple(others), tone=tone)]
    if remedies:
        words = [f"line {remedy.move.line}: {remedy_words(remedy, check.robot)}" for remedy in remedies]
        more = [] if full or len(words) <= _LISTED else [f"{advise('full')} prints all {len(words)}"]
        sections_so_far.append(Section("Remedies, computed on the literal targets; programs are not written",
                             lines=tuple(words if full else words[:_LISTED]), notes=tuple(more)))  # fmt: skip
    lines = []
    for crossing in check.met if full else check.met[:_NAMED]:
        path = _path_of(crossing.stretch, check)
        head, *rest = crossing_lines(crossing.stretch, path, deg=True, full=full)
        lines += [f"line {crossing.line}: {head}", *rest]
    if lines:
        sections_so_far.append(Section("Singularities on the way", lines=tuple(lines)))
    sections_so_far.extend(_moves_sections(check, full=full))
    if check.program.skipped:
        sections_so_far.append(_skipped_section(check, full=full))
    return tuple(sections_so_far)


def _moves_sections(check: Any, *, full: bool) -> Iterator[Section]:
    """The table of moves; none where no move begins at a known configuration."""
    moves = check.moves
    if not moves:
        return
    if full or len(moves) <= _LISTED:
        shown = moves
    else:
        shown = [move for move in moves if move.verdict not in (None, "free")][:_LISTED]
    notes = []
    if len(shown) < len(moves):
        notes = [f"{len(moves) - len(shown)} more moves; {advise('full')} prints all"]
    yield Section(
        "Moves", columns=("line", "kind", "verdict", "nearest singularity", "largest turn", "time [s]", "text"),
        rows=tuple(_move_row(move) for move in shown), texts=(1, 2, 6), notes=tuple(notes),
    )  # fmt: skip


def _move_row(move: Any) -> tuple[str, ...]:
    """The cells of a move."""
    verdict = "begins here"
    nearest = turn = seconds = "–"
    if move.verdict is not None:
        verdict = ", ".join([str(move.verdict), *["assumed"] * bool(move.assumed)])
    if isfinite(move.distance):
        nearest = angle(move.distance)
    if move.joint:
        turn = f"{move.joint}: {degrees(move.turn):.0f}°"
    if move.seconds is not None:
        seconds = f"{move.seconds:.3g}"
    return str(move.line), _KINDS[move.kind], verdict, nearest, turn, seconds, move.text


def _skipped_section(check: Any, *, full: bool) -> Section:
    """Lines that were not read, by reason."""
    reasons = [key for key in _REASONS if any(skipped.reason == key for skipped in check.program.skipped)]
    lines = []
    for key in reasons:
        part = [skipped for skipped in check.program.skipped if skipped.reason == key]
        lines.append(f"{_lines_words([skipped.line for skipped in part])}: {_REASONS[key]}")
        if full:
            lines += [f"    {skipped.line}: {skipped.text}" for skipped in part]
    return Section("Not read", lines=tuple(lines), notes=() if full else (f"{advise('full')} prints these lines",))


def remedy_words(remedy: Any, robot: Robot) -> str:
    """What to change in a line of a program."""
    if remedy.advice == "turn":
        return f"before it {turn_words(remedy.turn, robot, place=False)}; write the turn as a joint move"
    if remedy.advice == "joint move":
        goal = joints_words(robot, remedy.goal, deg=True)
        return f"make it a joint move: its target is within reach in another posture ({goal})"
    if remedy.advice == "slower":
        other = "; or make it a joint move" if remedy.move.kind != "joint" and remedy.factor < _SLOW else ""
        share = rounded_down(remedy.factor, 3)
        return f"at {share} of its speed{_speed_words(remedy)} it keeps the joint limits{other}"
    if remedy.advice == "out of reach":
        return "no configuration within the joint limits was found for its target: move the target"
    if remedy.advice == "none":
        return f"no bump and no detour was found: {'; '.join(remedy.notes)}"
    where = f"between {100 * remedy.span[0]:.3g} % and {100 * remedy.span[1]:.3g} % of its way"
    if remedy.advice == "bump":
        off = tool_off_words(remedy.change.off, robot)
        moves = joint_moves(remedy.change.way, robot)
        return f"bump: {moves} {where} is free (proven), the tool within {off} of the line; insert targets there"
    off = tool_off_words(remedy.change.off, robot)
    branch = ""
    if remedy.change.at_end.any():
        branch = f"; after it the arm is in another posture: {joint_moves(remedy.change.at_end, robot)}"
    return f"detour: the tool led around by {off} {where} is free (proven){branch}; insert targets there"


def _speed_words(remedy: Any) -> str:
    """The speed that a line states, and the one that keeps the limits."""
    speed = remedy.move.speed
    if speed.linear is not None:
        allowed = 1e3 * speed.linear * remedy.factor
        return f", {rounded_down(allowed, 3)} mm/s for {short(1e3 * speed.linear, 4)} mm/s,"
    if speed.share is not None:
        return f", {rounded_down(100 * speed.share * remedy.factor, 3)} % for {short(100 * speed.share, 4)} %,"
    if speed.time is not None:
        return f", in {rounded_up(speed.time / remedy.factor, 3)} s for {short(speed.time, 4)} s,"
    return ""


def why_skipped(reason: str) -> str:
    """Why a line was not read."""
    return _REASONS[reason]


def why_move_ended(ended: Any, robot: Robot) -> str:
    """Why a move could not be followed."""
    return _why(ended, robot)
