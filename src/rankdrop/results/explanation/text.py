"""An explanation in words: the answer in five lines, then section by section in the order of use.

Last the parts that are shown on demand: joint rates, failures, ellipsoids, redundancy, coordinates of the orientation,
singular values and joint angles; and what has to hold on a family, one sentence each.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from math import degrees, isinf
from typing import TYPE_CHECKING

import numpy as np

from rankdrop.configuration import Cause
from rankdrop.family.record import Family
from rankdrop.local.directions import FramedDirections, constraint, in_short
from rankdrop.local.rates import DirectionRates, StraightMotion
from rankdrop.local.ways_out import Direction, JointEscape
from rankdrop.results.codec import Record
from rankdrop.results.conditions import values_in_degrees
from rankdrop.results.explanation.parts import IDLE, NO_RATE, SHARE, Summary, turned_task
from rankdrop.results.explanation.words import (
    LOST_TYPE,
    PROOF,
    angle,
    angle_below,
    avoidable_words,
    below,
    boundary_words,
    degrees_hint,
    failures_table,
    fixed,
    minus,
    motion,
    numbers,
    pitch_text,
    plural,
    power,
    raised,
    short,
    vector,
    wrench_text,
)
from rankdrop.results.known import shipped_conditions_record
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section
from rankdrop.task import BASE, TIP, Task
from rankdrop.text.families import symbols as joint_symbols
from rankdrop.units import counted_length

if TYPE_CHECKING:
    from rankdrop.results.explanation.explanation import Explanation


TONE = {"regular": "good", "near": "warning", "singular": "bad", "always-singular": "bad"}
"""How the verdict is coloured."""
_FEWER = "a task with fewer rows (planar, position, …) asks only for what the arm is made for"
_TWIST = "v [m/s], ω [rad/s]: velocity and turning of the tool"
_COUNTED = "nearly: turning by 1 rad counts as much as moving by 1 m"
_HUGE = 100.0  # an arm that reaches farther was hardly meant in m
_SHOWN = 3  # ways out and families
_AXIS = 1e-4  # components below it are not shown: the axis is X, Y or Z


def sentence_of(explanation: Explanation) -> str:
    """What may be claimed of one configuration; its word is `Explanation.verdict`."""
    differ = "; two methods disagree, see the end" if explanation.disagreements else ""
    return f"{explanation.robot.name}: {explanation.verdict.upper()}, {explanation.reason}{differ}."


def reason_of(explanation: Explanation) -> str:
    """What decides the verdict, in a sentence."""
    rank, far, cause = explanation.rank, explanation.far, explanation.cause
    r = rank.generic_rank
    lost = f"rank {rank.rank} of {r}"
    small = [f"σ{r} = {short(float(value), 3)}" for value in rank.sigma[r - 1 : r]]
    count = explanation.nearly_lost
    if cause == Cause.LOST:
        least = f", and σ{rank.rank} = {short(rank.sigma[rank.rank - 1], 3)} is nearly zero" if count else ""
        return f"{rank.corank} of {r} directions of the tool {'is' if rank.corank == 1 else 'are'} lost{least}"
    if cause == Cause.NEVER:
        return f"rank {r} here and at almost every configuration: the arm never does more"
    if cause == Cause.NEAR_MISS:
        assert far.near_miss is not None
        ends = f"a descent from here ends at σ{r} = {short(far.near_miss, 3)}, not at zero"
        return f"{lost}; near miss: {small[0]} is small, but {ends}"
    if cause == Cause.DISTANCE:
        assert far.nearest is not None
        first = rank.rank - count
        several = "" if count < 2 else (
            f"; {count} directions of the tool are nearly lost, σ{first + 1} = {short(rank.sigma[first], 3)}")
        return f"{lost}, but a singular configuration is {angle(far.nearest.distance)} away{several}"
    if cause == Cause.SMALL:
        return f"{lost}, but {small[0]} is at most {short(explanation.asked.options.small)}"
    if cause == Cause.SLOW:
        slow = " and ".join(_speed_words(one) for one in explanation.straight if one.speed < one.limit)
        return f"{lost}, but the tool is slow: at most {slow}"
    if far.nearest is None:
        proven = f"none lies within {angle_below(far.certificate.radius)}" if far.certificate else "that is no proof"
        return f"{lost}; no singular configuration was found, and {proven}"
    return f"{lost}; the nearest singular configuration found is {angle(far.nearest.distance)} away"


def summary_lines(explanation: Explanation) -> tuple[str, ...]:
    """The answer in five sentences: what it is, what is lost, what to do, what is next, how sure."""
    summary = explanation.summary
    return (
        f"{explanation.robot.name} is {_what_it_is(explanation, summary)}.",
        f"{_what_is_lost(explanation, summary)}.", f"{_what_to_do(explanation, summary)}.",
        f"Next: {_short_name(summary.next_family)}, {_degrees(summary.next_distance)} of joint motion away."
        if summary.next_distance is not None else "Next: no other singularity was found.",
        f"{_how_sure(explanation, summary)}.",
    )  # fmt: skip


def _what_it_is(explanation: Explanation, summary: Summary) -> str:
    rank = explanation.rank
    if summary.cause == Cause.NEVER:
        return f"singular at every configuration: rank {rank.generic_rank} of {explanation.task.m}"
    if summary.cause == Cause.NONE:
        return f"regular: rank {rank.rank} of {rank.generic_rank}, no direction of the tool is lost"
    if summary.cause == Cause.NEAR_MISS:
        return "near a singularity that it just misses: σ" + (
            f"{rank.generic_rank} does not vanish, {short(explanation.far.near_miss or 0.0, 3)} is its least nearby")
    name = summary.family or "family unknown"
    if summary.cause == Cause.LOST:
        units = explanation.robot.units
        at = [f"joint {number} at {_value_words(value, units[number - 1])}" for number, value in summary.pinned[:2]]
        held = f" ({', '.join(at)})" if at else ""
        return f"singular: {name}{held}"
    if not summary.ideal:
        return f"near a singularity: {name}, {_degrees(summary.distance or 0.0)} away"
    kept = [f"{short(1e3 * summary.length, 2)} mm"] * bool(summary.length)
    kept += [f"{short(degrees(summary.angle), 2)}°"] * bool(summary.angle)
    return f"near a singularity: {name}; offsets of {' and '.join(kept)} keep it from being exact"


def _value_words(value: float, unit: str) -> str:
    return f"{short(round(degrees(value), 3) + 0.0)}°" if unit == "rad" else f"{short(round(value, 6) + 0.0)} m"


def _short_name(name: str) -> str:
    """A family without the part that says which axes: "shoulder" of "shoulder: axes 1 and 3 aligned"."""
    return name.partition(":")[0].partition(" (")[0].partition(", with")[0]


def _what_is_lost(explanation: Explanation, summary: Summary) -> str:
    if summary.cause == Cause.NEVER:
        return f"Never possible: {_motions_words(explanation.lost.never.tolist())}"
    if summary.cause in (Cause.SLOW, Cause.NONE):
        if summary.slowest is None or isinf(summary.slowest.speed):
            return "Lost: nothing"
        word = "Slow" if summary.cause == Cause.SLOW else "Slowest straight motion"
        return f"{word}: at most {_speed_words(summary.slowest)}"
    lost = "Lost" if summary.cause == Cause.LOST else "Nearly lost"
    return f"{lost}: {_motions_words(summary.lost)}" if summary.lost else f"{lost}: see --full"


def _speed_words(slow: StraightMotion) -> str:
    """A straight motion: "2.2 mm/s along (0.1, …), limited by joint 4"."""
    along = f"{'along' if slow.unit == 'm/s' else 'about'} {_axis_words(slow.direction)}"
    return f"{speed_text(slow.speed, slow.unit)} {along}, limited by joint {slow.number}"


def speed_text(speed: float, unit: str) -> str:
    """A speed of the tool: "2.2 mm/s", "1.3 m/s", "4.1°/s"."""
    if unit == "rad/s":
        return f"{short(degrees(speed), 3 if speed > 1.0 else 2)}°/s"
    if speed >= 1.0:
        return f"{short(speed, 2)} m/s"
    return f"{short(1e3 * speed, 3 if speed >= 0.1 else 2)} mm/s"


def _motions_words(directions: Sequence[Sequence[float]]) -> str:
    """Lost directions in base axes: "motion along (−0.49, −0.20, 0.85); turning about Z"."""
    shown = "; ".join(_motion_words(np.array(row)) for row in directions[:2])
    return f"{shown}{f'; {len(directions) - 2} more' if len(directions) > 2 else ''} in base axes"


def _motion_words(direction: Array) -> str:
    moves, turns = (float(np.linalg.norm(part)) for part in (direction[:3], direction[3:]))
    along, about = f"motion along {_axis_words(direction[:3])}", f"turning about {_axis_words(direction[3:])}"
    least = _MIXED * np.hypot(moves, turns)
    return along if turns <= least else about if moves <= least else f"{along} with {about}"


_MIXED = 0.25  # below this share of a direction its smaller part is not named


def _axis_words(vector: Iterable[float]) -> str:
    unit = np.array(list(vector))
    unit = unit / max(float(np.linalg.norm(unit)), 1e-300)
    large = np.flatnonzero(np.abs(unit) > _AXIS)
    if len(large) == 1:
        return "XYZ"[int(large[0])]
    return f"({', '.join(minus(f'{round(x, 2) + 0.0:.2f}') for x in unit.tolist())})"


def _what_to_do(explanation: Explanation, summary: Summary) -> str:
    if summary.cause == Cause.NEVER:
        return "Get out: ask for a task with fewer rows (planar, position, …)"
    lead = "Get out" if summary.cause == Cause.LOST else "Get farther away"
    if not summary.way_out or summary.sigma_after is None:
        return f"{lead}: no small motion inside the joint limits does"
    units, r = explanation.robot.units, explanation.rank.generic_rank
    moves = [f"joint {number} by {motion(value, units[number - 1], 2)}" for number, value in summary.way_out]
    jog = f"{lead}: {'jog' if len(moves) == 1 else 'move together'} {', '.join(moves)}"
    if summary.cause == Cause.LOST:
        return f"{jog}. Cartesian jogging along the lost motion fails"
    return f"{jog}; σ{r} is {short(summary.sigma_after, 2)} then"


def _how_sure(explanation: Explanation, summary: Summary) -> str:
    rank = explanation.rank
    size = f"rank {rank.rank} computed to {power(rank.sigma_error)}"
    if summary.cause in (Cause.LOST, Cause.DISTANCE, Cause.SMALL):
        source = {"catalogue": "the catalogue", "analysis": "the analysis given"}.get(summary.source)
        told = "the exact conditions" if summary.exact else source or "singular points around it"
        return f"Verified: {size}; family from {told}"
    if summary.radius:
        return f"Verified: {size}; none within {short(below(degrees(summary.radius), 3))}° (proven)"
    return f"Verified: {size}"


def _degrees(distance: float) -> str:
    return f"{short(degrees(distance), 3)}°"


def sections_of(explanation: Explanation, *, full: bool = False, parts: Sequence[str] = ()) -> tuple[Section, ...]:
    """The parts in the order in which they are asked for.

    Args:
        full: every detail; else what an engineer at a stopped robot needs.
        parts: names out of `PARTS`; none: all of them, those in `DETAILS` only with `full`.
    """
    names = parts or [name for name in PARTS if full or name not in DETAILS]
    return tuple(section for name in names for section in PARTS[name](explanation, full))


def _summary(explanation: Explanation, full: bool) -> Iterator[Section]:
    hint = degrees_hint(explanation.q, explanation.robot)
    if hint is not None:
        yield Section("Degrees?", "", (f"{hint}; --deg reads them as degrees, np.radians in Python",))
    first, *lines = summary_lines(explanation)
    yield Section(first, "", (*lines, *_warnings(explanation, full)), tone=TONE[explanation.verdict])


def _numbers(explanation: Explanation, full: bool) -> Iterator[Section]:
    rank, robot = explanation.rank, explanation.robot
    joints, r = robot.variables, rank.generic_rank
    sigma = ", ".join(short(value) if value > rank.sigma_error else "0" for value in rank.sigma)
    lines = [
        f"rank {rank.rank} of {r}, corank {rank.corank}; {_null_motions_words(explanation)} (nullity {rank.nullity})",
        f"σ = {sigma}  (each ± {power(rank.sigma_error)}; at or below {short(rank.tolerance)} is zero)",
        f"task {explanation.task.name}; σ has translation divided by {short(explanation.asked.length_scale)} m",
    ]
    names = [joint.name for joint in joints]
    if not all(name.endswith(str(number)) for number, name in enumerate(names, start=1)):
        lines.append("joints " + ", ".join(f"{number} {name}" for number, name in enumerate(names, start=1)))
    rows = [("rad, m" if any(joint.unit == "m" for joint in joints) else "rad", *map(fixed, explanation.q))]
    if any(joint.unit == "rad" for joint in joints):
        turned = zip(np.degrees(explanation.q) + 0.0, joints, strict=True)
        rows.append(("deg", *("" if joint.unit == "m" else minus(f"{value:.2f}") for value, joint in turned)))
    columns = ("joint", *(str(number) for number in range(1, robot.n + 1)))
    yield Section("Numbers", "", tuple(lines), columns, tuple(rows), notes=robot.notes)


def _null_motions_words(explanation: Explanation) -> str:
    count = explanation.rank.nullity
    what = "move the tool" if explanation.task.m == 6 else "change what the task asks for"
    if not count:
        return f"every joint motion {what.replace(' ', 's ', 1)}"
    return f"{count} {plural('way', count)} to move the joints {'does' if count == 1 else 'do'} not {what}"


def _warnings(explanation: Explanation, full: bool) -> Iterator[str]:
    reach, outside = explanation.asked.length_scale, list[str]()
    if reach > _HUGE:
        yield f"lengths are divided by {short(reach)} m: are those of the robot file in mm?"
    for number, (joint, value) in enumerate(zip(explanation.robot.variables, explanation.q, strict=True), start=1):
        turns = joint.unit == "rad"
        at, low, high = (
            f"{short(degrees(x) if turns else x)}{'°' if turns else ' m'}" for x in (value, joint.lower, joint.upper)
        )
        if number in explanation.outside_limits:
            outside.append(f"joint {number} at {at} is outside its limits, {low} … {high}")
        elif number in explanation.at_limits:
            outside.append(f"joint {number} at {at} stands at a limit ({low} … {high})")
    if full or len(outside) < 2:
        yield from outside
    else:
        both = ((explanation.outside_limits, "outside the limits"), (explanation.at_limits, "at a limit"))
        yield "; ".join(f"{plural('joint', len(x))} {numbers(x)} {where}" for x, where in both if x)


def _which(explanation: Explanation, full: bool) -> Iterator[Section]:
    special = [relation.words for relation in explanation.relations if not relation.structural]
    always = [relation.words for relation in explanation.relations if relation.structural]
    if not explanation.met and not full:
        return
    own = [met for met in explanation.met if met.family.corank == explanation.met[0].family.corank]
    others = [met.family.name for met in explanation.met if met not in own]
    lines: list[str] = []
    for met in own[: None if full else 2]:
        conditions = "; ".join(condition_sentences(explanation.robot, explanation.task, met.family))
        of = f"  (corank {met.family.corank}, dimension {met.family.dimension}; {met.source})" if full else ""
        lines += [f"{met.family.name}{of}"] * (full or len(own) > 1) + [f"    {conditions}" if full else conditions]
    if others and full:
        lines.append(f"lies on: {'; '.join(others)}")
    if special and full:
        lines.append(f"here: {'; '.join(special)}")
    notes = (f"at every configuration: {'; '.join(always)}",) if always and full else ()
    if lines or notes:
        yield Section(
            "Which singularity" if explanation.met else "Axes", _focus(explanation), tuple(lines), notes=notes
        )


def _focus(explanation: Explanation) -> str:
    return "" if np.array_equal(explanation.focus, explanation.q) else "at the nearest singular configuration"


def _lost(explanation: Explanation, full: bool) -> Iterator[Section]:
    lost = explanation.lost
    if lost.framed is not None:
        miss = explanation.far.near_miss is not None and not explanation.rank.corank
        only = "can hardly move other than" if miss else "can only move"
        lines = [f"The tool {only} so that"]
        some = [seen for frame, seen in lost.seen.items() if full or frame != "link"] or lost.seen.values()
        told = [lost_text(explanation.robot, seen) for seen in some]
        for one in told:
            lines.append(f"  in {one['axes']}: {', '.join(one['constraints'])}")
            lines += [f"      {'; '.join(filter(None, one['short']))}"] * (full and any(one["short"]))
        if full:
            lines.append(f"In the {_frame_words(explanation)}:")
            for direction, twist, wrench in zip(
                lost.framed.directions, lost.twist_screws, lost.wrench_screws, strict=True
            ):
                lines.append(f"  lost twist {vector(direction)}: {pitch_text(twist.pitch)}")
                torque = "with hardly any joint torque" if miss else "without joint torque"
                lines.append(f"      carried {torque}: {wrench_text(wrench)}")
        title = "What is lost" if explanation.rank.corank else "What is nearly lost"
        nearly = full and any(text.startswith("nearly") for one in told for text in one["short"])
        notes = (_TWIST, *((_COUNTED,) if nearly else ()))
        yield Section(title, _focus(explanation), tuple(lines), notes=notes)
    if len(lost.never):
        rows = tuple(tuple(short(round(float(value), 4) + 0.0) for value in row) for row in lost.never)
        yield Section("Never possible", "twists that this arm makes nowhere around here",
                      columns=("vx", "vy", "vz", "ωx", "ωy", "ωz"), rows=rows, texts=(), notes=(_FEWER,))  # fmt: skip


def _frame_words(explanation: Explanation) -> str:
    assert explanation.lost.framed is not None
    frame, name = explanation.lost.framed.frame, explanation.lost.framed.name
    at_tip = frame.origin == TIP and not any(frame.point)
    return f"axes of {name}" + (", reference point at the tool" if at_tip else "")


def lost_text(robot: Robot, framed: FramedDirections) -> Record:
    """What is lost as it reads in one frame, with an entry for each direction.

    Returns:
        axes: as a heading: "base axes", "axes of link 5 (wrist_2_link) at its origin"; constraints: what all motions
        that remain obey: "0.63 vy + 0.7 vz + 0.098 m·ωx = 0"; short: what that comes to: "no motion along Y", or empty.
    """
    length = counted_length(robot)
    return {
        "axes": axes_text(robot, framed),
        "constraints": [constraint(one, length) for one in framed.directions],
        "short": [in_short(one) for one in framed.directions],
    }


def axes_text(robot: Robot, framed: FramedDirections) -> str:
    """Whose axes: "base axes", "tool axes", "axes of the tool at the origin of link 5 (wrist_2_link)"."""
    frame = framed.frame
    if frame.origin == TIP and frame.axes in (BASE, TIP):
        return f"{'base' if frame.axes == BASE else 'tool'} axes"
    text = framed.name
    number = frame.origin if frame.axes in (BASE, TIP) else frame.axes
    if number in (BASE, TIP):
        return f"axes of {text}"
    joint, link = robot.joints[number - 1], f"link {number}"
    known = joint.link or f"after {joint.name}"
    return f"axes of {text.replace(link, f'{link} ({known})', 1)}"


def _blame(explanation: Explanation, full: bool) -> Iterator[Section]:
    blame = explanation.blame
    lines = [circuit.words for circuit in blame.smallest]
    lines += [system.words for system in blame.systems if system.permanent or full]
    if blame.always:
        lines.append(f"deficient at every configuration: {blame.always}")
    if not blame.complete:
        lines.append("the chain is too long to list dependent sets of joints")
    if lines:
        yield Section("Joints to blame", _dependencies(explanation) if blame.smallest else "", tuple(lines))
    if full and blame.circuits:
        rows = tuple(
            (numbers(one.numbers), "always" if one.generic else "here", vector(one.coefficients), one.words)
            for one in blame.circuits
        )
        yield Section("Every circuit", "dependent sets of joints without a smaller one inside",
                      columns=("joints", "when", "joint rates that cancel", "in words"), rows=rows,
                      texts=(0, 1, 2, 3))  # fmt: skip
    if full and blame.ordered:
        runs = tuple(
            (f"{one.first}–{one.last}", str(one.dimension), str(one.loss), "yes" if one.msos else "no",
             "yes" if one.minimal else "no")
            for one in blame.ordered
        )  # fmt: skip
        yield Section("Singular runs of joints", "as Gallardo-Alvarado and Rico-Martínez look for them",
                      columns=("joints", "dimension", "loss", "their test", "minimal"), rows=runs)  # fmt: skip

    if full and blame.hunt is not None:
        found = tuple(
            (str(one.number), short(round(one.share, 4)), "yes" if one.named else "no",
             "yes" if one.actuator else "no", short(round(abs(one.rate), 4)) if one.tells else "no",
             "yes" if one.escapes else "no")
            for one in blame.hunt.joints
        )  # fmt: skip
        columns = ("joint", "column", "named", "GR's actuator", "leads out, rate", "by finite motion")
        yield Section("Hunt's cofactors beside GR's rules", "", (blame.hunt.words,), columns if found else (), found)


def _dependencies(explanation: Explanation) -> str:
    usual = explanation.robot.n - explanation.rank.generic_rank
    text = "smallest sets of joints with dependent screws"
    if usual:
        corank = explanation.met[0].family.corank if explanation.met else explanation.rank.corank
        text += f"; {usual + corank} dependencies here, {usual} almost everywhere"
    return text


def _escape(explanation: Explanation, full: bool) -> Iterator[Section]:
    """Joints that lead out, best first; then the best motions of several, and what is known of the end effector."""
    if explanation.rank.corank:
        yield _out(explanation, full)
    elif full or any(abs(one.rate) > NO_RATE for one in explanation.escape.single):
        yield _away(explanation, full)


def _out(explanation: Explanation, full: bool) -> Section:
    out, r = explanation.escape, explanation.rank.generic_rank
    helpful = [one for one in out.single if one.order is not None]
    rows = tuple(_joint_row(explanation, one) for one in (out.single if full else helpful[:_SHOWN]))
    after = [] if helpful else ["no single joint restores the full rank"]
    if out.best_pair is not None and full:
        after.append(f"best two joints: {_direction(explanation, out.best_pair)}")
    if full or not helpful:
        after.append(f"best direction: {_direction(explanation, out.best_direction)}")
    if full or out.avoidable is not None:
        after.append(_sentence(avoidable_words(out)))
    for kind in dict.fromkeys(one.type for one in out.types if full):
        which = [i for i, one in enumerate(out.types, start=1) if one.type == kind]
        one = LOST_TYPE[kind]
        if len(out.types) > 1:
            one = one.replace("the lost direction", _lost_numbered(which, len(out.types)))
        slowly = "it can be passed slowly: " if out.boundary is False and out.types[0].type == 1 else ""
        after.append(_sentence(f"{slowly}{one}"))
    if full or out.boundary is not None:
        after.append(_sentence(boundary_words(out)))
    columns: tuple[str, ...] = ("joint", "order", f"σ{r} grows by", "try", f"σ{r} then", "carries out")
    if not full:
        columns, rows = (columns[0], *columns[3:5]), tuple((row[0], *row[3:5]) for row in rows)
    notes = ("order p, rate c: σ grows as c·tᵖ; carries out: the screws that the motion takes out of the dependency",)
    return Section("How to get out", "one joint alone, best first" if rows else "", (), columns, rows,
                   (0, 5) if full else (0,), tuple(after), notes if rows and full else ())  # fmt: skip


def _proofs(explanation: Explanation, full: bool) -> Iterator[Section]:
    out = explanation.escape
    said: dict[str | int, str] = {out.avoidable_reason: avoidable_words(out)}
    said |= {one.type: LOST_TYPE[one.type] for one in out.types}
    said[out.boundary_reason] = boundary_words(out)
    lines = tuple(f"{_sentence(words)} {PROOF[reason]}" for reason, words in said.items() if reason in PROOF)
    if lines and explanation.rank.corank:
        yield Section("Why", "for ways out", lines)


def _sentence(words: str) -> str:
    return f"{words[0].upper()}{words[1:]}."


def _lost_numbered(which: list[int], count: int) -> str:
    if len(which) == count:
        return "each lost direction"
    return f"lost {plural('direction', len(which))} {numbers(which)}"


def _away(explanation: Explanation, full: bool) -> Section:
    out, r = explanation.escape, explanation.rank.generic_rank
    best = max((abs(one.rate) for one in out.single), default=0.0)
    helpful = [one for one in out.single if one.order is not None and abs(one.rate) > max(IDLE * best, NO_RATE)]
    rows = tuple(
        (f"{one.number} {one.joint}", *_rate_and_step(explanation, one))
        for one in (out.single if full else helpful[:_SHOWN])
    )
    now = f"one joint alone, best first; σ{r} = {short(explanation.rank.sigma[r - 1])} here" if r else ""
    after = (f"best direction: {_direction(explanation, out.best_direction)}",) if r else ()
    return Section("How to get away", now if rows else "", (),
                   ("joint", f"σ{r} changes by", "try", f"σ{r} then"), rows, (0,), after)  # fmt: skip


def _joint_row(explanation: Explanation, joint: JointEscape) -> tuple[str, ...]:
    name = f"{joint.number} {joint.joint}"
    if joint.order is None:
        return (name, "–", f"gains {joint.gain}, not all" if joint.gain else "no gain", "", "", "")
    return (
        name,
        str(joint.order),
        *_rate_and_step(explanation, joint),
        numbers(joint.receptors) if joint.receptors else "–",
    )


def _rate_and_step(explanation: Explanation, joint: JointEscape) -> tuple[str, str, str]:
    if joint.order is None:
        return "0", "", ""
    unit = explanation.robot.variables[joint.number - 1].unit
    per = unit if joint.order == 1 else f"{unit}{raised(joint.order)}"
    rate = f"{short(joint.rate) if abs(joint.rate) > NO_RATE else '0'} per {per}"
    if not joint.within_limits or abs(joint.step) < NO_RATE:
        return rate, "not within limits", ""
    return rate, motion(joint.step, unit), short(joint.sigma_after)


def _direction(explanation: Explanation, direction: Direction) -> str:
    """The joints that matter, in words, and what they reach."""
    joints = explanation.robot.variables
    scale = np.where([joint.unit == "m" for joint in joints], explanation.asked.length_scale, 1.0)
    size = np.abs(np.array(direction.delta)) / scale
    large = [number for number in direction.numbers if size[number - 1] >= SHARE * size.max()]
    parts = [
        f"joint {number} {motion(direction.delta[number - 1] * direction.step, joints[number - 1].unit)}"
        for number in large
    ]
    rest = ", the others far less" if len(large) < sum(size > 1e-9) else ""
    end = f"σ{explanation.rank.generic_rank} = {short(direction.sigma_after)}"
    if not direction.within_limits:
        end += ", outside the joint limits"
    return f"{', '.join(parts)}{rest}: {end}" + ("" if direction.restores else f", gains {direction.gain} only")


def _far(explanation: Explanation, full: bool) -> Iterator[Section]:
    far, lines, units = explanation.far, [], explanation.robot.units
    rows: list[tuple[str, ...]] = []
    if far.nearest is not None and (full or not far.families):
        name = "" if far.nearest_family is None else f" ({far.nearest_family.family.name})"
        limits = "" if far.nearest.within_limits else "; it is outside the joint limits"
        checked = f"; {far.nearest.agreeing} of {far.nearest.starts} searches agree; σ there at most "
        lines.append(f"nearest singular configuration found: {angle(far.nearest.distance)} away{name}"
                     f"{checked + power(far.nearest.sigma) if full else ''}{limits}")  # fmt: skip
        if full and not any(one.distance <= far.nearest.distance * (1 + 1e-9) for one in far.families):
            rows.append((angle(far.nearest.distance), "the nearest", *_deltas(far.nearest.delta, units)))
    radius = explanation.certified_radius
    if explanation.rank.always_singular:
        pass  # every configuration is deficient: nothing to certify
    elif far.certificate is not None and radius is not None:
        lines.append(
            f"certified: no singularity within {angle_below(radius)} (proven; {far.certificate.evaluations:,} "
            f"enclosures{'' if far.certificate.complete else '; interrupted'})"
        )
    elif far.uncertified and not explanation.rank.corank:
        lines.append(f"no certified radius: {far.uncertified}")
    for one in far.families[: None if full else 2]:
        moves = _deltas(one.delta, units) if full else ()
        rows.append((angle(one.distance), one.family.name + f" (corank {one.family.corank})" * full, *moves))
    if lines or rows:
        joints = tuple(f"{number}" for number in range(1, explanation.robot.n + 1)) if full else ()
        columns = ("distance", "family", *joints) if rows else ()
        yield Section("How far the next one is" if explanation.rank.corank else "How far", "", tuple(lines), columns,
                      tuple(rows), (0, 1), notes=("by joint: the motion to it",) if full and rows else ())  # fmt: skip


def _deltas(delta: Sequence[float], units: list[str]) -> tuple[str, ...]:
    return tuple(motion(value, unit, 4) for value, unit in zip(delta, units, strict=True))


def _rates(explanation: Explanation, full: bool) -> Iterator[Section]:
    rates, n = explanation.rates, explanation.robot.n
    losing = any(rates.lost_shares)
    rows: list[tuple[str, ...]] = []
    for axis, share, left in zip(rates.axes, rates.lost_shares, rates.remaining, strict=True):
        lost = (_percent(share),) if losing else ()
        if left is None:
            rows.append((axis.name, *lost, *(["–"] if full else []), "", "0", *([""] * n if full else [])))
        else:
            rows.append((axis.name, *lost, *_costs(left, axis.unit, full, brief=losing)))
    if rates.weakest is not None:
        rows.append((rates.weakest.name, *(("",) if losing else ()), *_costs(rates.weakest, "", full, brief=losing)))
    unlimited = [number for number, limit in enumerate(rates.limits, start=1) if isinf(limit)]
    held = "held back by" if len(unlimited) < n else "fastest"
    columns = ("unit speed", *(("lost",) if losing else ()), *(("joint rates",) if full or not losing else ()), held,
               "at most")  # fmt: skip
    none = f"; {plural('joint', len(unlimited))} {numbers(unlimited)} without one" if unlimited else ""
    notes = [f"at most: the largest speed within the velocity limits{none}" if len(unlimited) < n
             else "no velocity limits are known"]  # fmt: skip
    if "joint rates" in columns:
        notes.insert(0, "joint rates: the smallest for 1 m/s or 1 rad/s, as a norm [rad/s]")
    if losing:
        rest = (
            "lost: the share of this motion that cannot be made",
            "the other columns: the nearest motion that can be made, at 1 m/s or 1 rad/s along the axis",
        )
        notes = [*rest, *notes]
    if rates.weakest is not None:
        kept = f"σ{explanation.rank.rank}"
        notes.append(f"weakest direction: that of {kept}, the smallest that is not zero; 1 rad/s, or "
                     f"{short(rates.length_scale)} m/s")  # fmt: skip
    per_joint = tuple(f"{number}" for number in range(1, n + 1)) if full else ()
    texts = (0, columns.index(held), columns.index("at most"))
    axes = turned_task(explanation.task, explanation.asked.options.frame, explanation.lost).frame.axes
    whose = {BASE: "base axes", TIP: "tool axes"}.get(axes, f"axes of link {axes}")
    yield Section("What motion costs", whose, (), (*columns, *per_joint), tuple(rows), texts,
                  notes=tuple(notes))  # fmt: skip


def _percent(share: float) -> str:
    """A share in percent: never rounded to all or nothing."""
    if share in (0.0, 1.0):
        return f"{share:.0%}".replace("%", " %")
    return "< 0.1 %" if share < 1e-3 else "> 99.9 %" if share > 0.999 else f"{100 * share:.3g} %"


def _costs(rates: DirectionRates, unit: str, full: bool, *, brief: bool) -> tuple[str, ...]:
    """Joint rates (not where it is `brief`), the joint that holds back, the largest speed [`unit` or mixed]."""
    each = tuple(short(round(rate, 6)) for rate in rates.joint_rates) if full else ()
    most = _largest(rates) if not unit or isinf(rates.speed) else f"{short(rates.speed, 3)} {unit}"
    held = "" if rates.worst is None else f"{rates.worst} {rates.worst_joint}"
    return (held, most) if brief and not full else (short(rates.norm), held, most, *each)


def _largest(rates: DirectionRates) -> str:
    if isinf(rates.speed):
        return "no limit"
    if rates.unit != "1":
        return f"{short(rates.speed, 3)} {rates.unit}"
    parts = [(float(np.linalg.norm(part)) * rates.speed, unit)
             for part, unit in ((rates.direction[:3], "m/s"), (rates.direction[3:], "rad/s"))]  # fmt: skip
    return ", ".join(f"{short(value, 3)} {unit}" for value, unit in parts if value > 1e-9)


def _ellipsoids(explanation: Explanation, full: bool) -> Iterator[Section]:
    shapes = explanation.ellipsoids
    for group in (shapes.unit_rates, shapes.rate_limits):
        if group is None:
            continue
        parts = [part for part in (group.translation, group.rotation, group.task) if part is not None]
        rows = tuple(
            (part.name, _lengths(part.velocity.half_lengths), _lengths(part.force.half_lengths),
             *(short(index.value) for index in (part.sigma_min, part.condition, part.manipulability)))
            for part in parts
        )  # fmt: skip
        units = ", ".join(f"{part.name} {part.velocity.unit} and {part.force.unit}" for part in parts)
        yield Section(
            "Ellipsoids", group.ball, (),
            ("", "velocity half-axes", "force half-axes", "σ_min", "condition", "manipulability"), rows,
            texts=(0, 1, 2),
            notes=(f"units: {units}; the task as a whole takes {shapes.length_scale:.4g} m for 1 rad",),
        )  # fmt: skip


def _redundancy(explanation: Explanation, full: bool) -> Iterator[Section]:
    spare = explanation.redundancy
    lines = [
        f"rank {spare.check.rank} + nullity {spare.check.nullity} = {spare.check.n} joints: "
        + ("holds" if spare.check.holds else "DOES NOT HOLD"),
        f"projector I − J⁺J: ‖PP − P‖ ≤ {power(spare.idempotent)}, ‖JP‖ ≤ {power(spare.annihilates)}; "
        f"Jin's I − Jᵀ(JJᵀ)†J differs by at most {power(spare.difference)}",
    ]
    rows = tuple(tuple(fixed(value) for value in row) for row in spare.null_basis)
    columns = tuple(f"{number} {joint.name}" for number, joint in enumerate(explanation.robot.variables, start=1))
    title = "Joint motions that leave the task still"
    yield Section(title, "" if rows else "none", tuple(lines), columns if rows else (), rows, texts=(),
                  notes=("rows: joint rates [rad/s, m/s], to first order",) if rows else ())  # fmt: skip


def _representation(explanation: Explanation, full: bool) -> Iterator[Section]:
    every = explanation.representations
    rows = tuple(
        (one.name, ", ".join(f"{name} {short(value)}" for name, value in zip(one.names, one.coordinates, strict=True)),
         short(one.sigma_min), "none" if isinf(one.angle) else f"{degrees(one.angle):.3g}°",
         "SINGULAR" if one.singular else "near" if one.near else "")
        for one in every.every
    )  # fmt: skip
    yield Section("Coordinates of the orientation", every.words, (),
                  ("", "value [rad, 1]", "σ_min of E", "nearest singularity", ""), rows, texts=(0, 1, 4))  # fmt: skip


def _lengths(values: Iterable[float]) -> str:
    return " ".join(short(round(float(value), 6)) for value in values)


_MORE = "more with --full: joint rates, failures, σ and angles, circuits, redundancy, …"
PARTS: dict[str, Callable[[Explanation, bool], Iterator[Section]]] = {
    "summary": _summary,
    "which": _which,
    "lost": _lost,
    "escape": _escape,
    "far": _far,
    "blame": _blame,
    "proofs": _proofs,
    "rates": _rates,
    "failures": lambda explanation, _: iter((failures_table(explanation.failures, "If one joint fails"),)),
    "ellipsoids": _ellipsoids,
    "redundancy": _redundancy,
    "representation": _representation,
    "numbers": _numbers,
    "closing": lambda explanation, _: iter(
        (Section("Disagreement", "two methods differ; please report it", explanation.disagreements),)
        if explanation.disagreements else ()
    ),
    "more": lambda _, full: iter(() if full else (Section("", "", notes=(_MORE,)),)),
}
"""Every part by its name, in order."""
DETAILS = frozenset(
    ("blame", "proofs", "rates", "failures", "ellipsoids", "redundancy", "representation", "numbers", "more")
)
"""Parts that are shown only on demand."""


LONGEST = 120
"""Characters of a condition that is printed; of a longer one the joints are named."""
_SHIFTED = 1e-12  # an angle that conditions count from elsewhere than the joint does [rad]


def _written(robot: Robot, task: Task, family: Family) -> tuple[list[str], Record] | None:
    """Conditions, beyond pinned joints, and lengths shipped for this family; None for another arm or another family.

    Conditions that count an angle from elsewhere than the joint does are left out: they read as if they were of q.
    """
    record = shipped_conditions_record(robot, task)
    if record is None:
        return None
    for one in record["families"]:
        if (one["id"], one["name"], one["corank"]) == (family.id, family.name, family.corank):
            bound = {*one["coupled"], *(pin["number"] for pin in one["pinned"])}
            if any(abs(shift) > _SHIFTED for number, shift in enumerate(record["shifts"], 1) if number in bound):
                return None
            return one["conditions"][len(one["pinned"]) :], record["letters"]
    return None


def condition_sentences(robot: Robot, task: Task, family: Family) -> tuple[str, ...]:
    """What has to hold on a family, one sentence each.

    Joints at fixed values first: "θ4 = −26.76° or 153.24°". Then the exact conditions where they are shipped, with the
    lengths that stand in them; else the fitted ones. Long ones are not printed: they name their joints.

    Args:
        robot: the arm.
        task: its rows.
        family: of the catalogue, of an analysis, or found on the spot.
    """
    symbols = joint_symbols(robot)
    pins = [
        f"{symbols[one.number - 1]} = {values_in_degrees(robot, one.number, one.values)}" for one in family.pinned
    ]
    fixed = {one.number for one in family.pinned}
    written = _written(robot, task, family)
    letters: Record = {}
    if written is not None:
        rest, letters = written
        rest = [text for text in rest if not {*_joints([text])} <= fixed]
    else:
        rest = [f"{one} = 0" for one in family.equations if not set(one.joints) <= fixed]
        if not family.equations:
            return family.words or ("no condition found",)
    short = [text for text in rest if len(text) <= LONGEST]
    long = [text for text in rest if len(text) > LONGEST]
    told = [*pins, *short]
    if long:
        joints = _joints(long)
        where = "in the JSON" if written is None else "`rankdrop conditions` prints it"
        count = "a long condition" if len(long) == 1 else f"{len(long)} long conditions"
        told.append(f"{count} on joints {', '.join(map(str, joints))} ({where})")
    there = [name for name in letters if any(re.search(rf"\b{re.escape(name)}\b", one) for one in short)]
    if there:
        values = ", ".join(f"{name} = {letters[name]:.6g} m".replace("-", "−") for name in there)
        told[-1 - bool(long)] += f", {values}"
    return tuple(told)


def _joints(texts: Sequence[str]) -> list[int]:
    """Joints that conditions are about: θ3, q2, s3, c23 for the sum of two."""
    found: set[int] = set()
    for text in texts:
        found |= {int(number) for number in re.findall(r"[θq](\d+)", text)}
        for digits in re.findall(r"\b[sc](\d+)\b", text):
            found |= {int(digit) for digit in digits}
    return sorted(found)
