"""An explanation in words: the answer in five lines, then section by section in the order of use.

Last the parts that are shown on demand: joint rates, failures, ellipsoids, redundancy, coordinates of the orientation,
singular values and joint angles; and what has to hold on a family, one sentence each.

The sentences of the answer stand in tables, one row for each cause of the verdict; columns of a table of records stand
in tables as well, heading and cell.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from itertools import chain
from math import degrees, isinf
from operator import attrgetter
from textwrap import wrap
from typing import Any, NamedTuple

import numpy as np

from rankdrop.codec import Record
from rankdrop.configuration import Cause, at
from rankdrop.distance.distance import FamilyDistance
from rankdrop.families.record import Family, Incidence
from rankdrop.kinematics import pose
from rankdrop.lists import flat_map
from rankdrop.local.directions import FramedDirections, constraint, in_short, is_nearly_pure
from rankdrop.local.jog import WORTH
from rankdrop.local.nearest import Nearest
from rankdrop.local.pointing import pointing_task, tool_stays_level, turn_follows
from rankdrop.local.rates import DirectionRates, StraightMotion
from rankdrop.local.ways_out import Direction, Escape, JointEscape
from rankdrop.options import advised
from rankdrop.results.explanation import Blame, Difference, DifferenceKind, Explanation, Summary
from rankdrop.results.known import shipped_conditions_record
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Formula, Section
from rankdrop.task import BASE, TIP, Task
from rankdrop.text.conditions import values_in_degrees
from rankdrop.text.families import symbols as joint_symbols
from rankdrop.text.inverse import tool_sentence
from rankdrop.text.procedure import hunt_words
from rankdrop.text.special import family_title, parts_words, special_words
from rankdrop.text.words import (
    CHECKED_POINTING,
    MORE_NEAREST,
    MOTION_TO_IT,
    NEVER_HERE,
    NEVER_TILTS,
    NEVER_TURNS,
    NO_JOG,
    NOT_SEARCHED,
    POINTING_HERE,
    PROOF,
    after_jog,
    angle,
    angle_below,
    avoidable_words,
    below,
    boundary_words,
    degrees_hint,
    failures_table,
    fixed,
    jog_step,
    joint_word,
    lost_count,
    lost_type,
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
from rankdrop.units import counted_length

TONE = {"regular": "good", "near": "warning", "singular": "bad", "always-singular": "bad"}
"""How the verdict is coloured."""
_FEWER = "a task with fewer rows (planar, position, …) asks only for what the arm is made for"
_TWIST = "v [m/s], ω [rad/s]: velocity and turning of the tool"
_COUNTED = "nearly: turning by 1 rad counts as much as moving by 1 m"
_HUGE = 100.0  # an arm that reaches farther was hardly meant in m
_SHOWN = 3  # ways out and families
IDLE = 0.01
"""Away from a singularity: a joint whose rate is below this share of the best does not help."""
NO_RATE = 1e-12
"""A rate or a step below it is rounding."""
SHARE = 0.02
"""A joint that moves less than this share of the fastest is left out of a direction."""
_AXIS = 1e-4  # components below it are not shown: the axis is X, Y or Z


def sentence_of(explanation: Explanation) -> str:
    """What may be claimed of one configuration; its word is `Explanation.verdict`."""
    if explanation.disagreements:
        differ = "; two methods disagree, see the end"
    else:
        differ = ""
    return f"{explanation.robot.name}: {explanation.verdict.upper()}, {explanation.reason}{differ}."


_REASONS = {
    Cause.LOST: "{corank} of {r} directions of the tool {are} lost{nearly}",
    Cause.NEVER: "rank {r} here and at almost every configuration: the arm never does more",
    Cause.NEAR_MISS: "rank {rank} of {r}; near miss: σ{r} = {sigma} is small, but a descent from here ends at σ{r} = "
    "{miss}, not at zero",
    Cause.DISTANCE: "rank {rank} of {r}, but a singular configuration is {away} away{several}",
    Cause.SMALL: "rank {rank} of {r}, but σ{r} = {sigma} is at most {small}",
    Cause.SLOW: "rank {rank} of {r}, but the tool is slow: at most {slow}",
    Cause.NONE: "rank {rank} of {r}; the nearest singular configuration found is {away} away",
}
_NONE_FOUND = "rank {rank} of {r}; no singular configuration was found, and {proven}"


def reason_of(explanation: Explanation) -> str:
    """What decides the verdict, in a sentence."""
    facts, far = _measured(explanation), explanation.far
    if explanation.cause == Cause.NONE and far.nearest is None:
        near = far.certificate
        if near:
            proven = f"none lies within {angle_below(near.radius)}"
        else:
            proven = "that is no proof"
        return _NONE_FOUND.format_map({**facts, "proven": proven})
    return _REASONS[explanation.cause].format_map(facts)


def _measured(explanation: Explanation) -> dict[str, object]:
    """What the sentences on rank, singular values and distance are filled with."""
    rank, far, count = explanation.rank, explanation.far, explanation.nearly_lost
    r, first, sigma = rank.generic_rank, rank.rank - count, [short(float(value), 3) for value in rank.sigma]
    return {
        "r": r, "rank": rank.rank, "corank": rank.corank, "m": explanation.task.m, "sigma": sigma[r - 1],
        "are": "is" if rank.corank == 1 else "are",
        "nearly": f", and σ{rank.rank} = {sigma[rank.rank - 1]} is nearly zero" if count else "",
        "several": "" if count < 2 else (
            f"; {count} directions of the tool are nearly lost, σ{first + 1} = {sigma[first]}"),
        "small": short(explanation.options.small),
        "miss": short(far.near_miss or 0.0, 3),
        "away": "" if far.nearest is None else angle(far.nearest.distance),
        "slow": " and ".join(_speed_words(one) for one in explanation.straight if one.speed < one.limit),
    }  # fmt: skip


SINGULAR_HERE = "the configuration is singular"
"""Why no radius is certified at a singular configuration."""
_DIFFERENCES = {
    DifferenceKind.GAIN: "joint {number} alone: a rank gain of {predicted} was predicted, finite motion gains "
    "{measured}",
    DifferenceKind.RADIUS: "certified radius {radius} beyond a singularity at {distance}",
    DifferenceKind.SEARCH_MISSED: "the search missed a nearer point of family {family}",
    DifferenceKind.FAMILIES_MISSED: "the search found a singularity nearer than every family",
}


def difference_sentence(one: Difference) -> str:
    """Two methods that give two answers."""
    if one.family is None:
        family = ""
    else:
        family = f"{one.family.id} ({one.family.name})"
    return _DIFFERENCES[one.kind].format(
        number=one.number, predicted=one.predicted, measured=one.measured, radius=f"{one.radius:.6g}",
        distance=f"{one.distance:.6g}", family=family,
    )  # fmt: skip


_NEAR = "near a singularity: {name}{place}"
_OUT, _FARTHER = "Get out: {jog}. Cartesian jogging fails", "Get farther away: {jog}"
_NO_JOG = {_OUT: f"Get out: {NO_JOG}", _FARTHER: f"Get farther away: {NO_JOG}"}
"""What to do -> the same where no jog was found."""
_NO_BETTER = "Get farther away: no small jog of one joint raises σ{r} by 1 %"
"""The same from a regular configuration."""
_SLOW, _SLOWEST = "Slow: at most {slowest}", "Slowest straight motion: at most {slowest}"
_FAMILY, _PROVEN = "; family from {source}", "{proven}"
_SUMMARY = {
    Cause.LOST: ("singular: {name}{pinned}", "Lost: {lost}",
                 _OUT, _FAMILY),
    Cause.NEVER: ("singular at every configuration: rank {r} of {m}", "Never possible: {never}",
                  "Get out: ask for a task with fewer rows (planar, position, …)", _PROVEN),
    Cause.NEAR_MISS: ("near a singularity that it just misses: σ{r} does not vanish, {miss} is its least nearby",
                      "Nearly lost: {lost}", _FARTHER, _PROVEN),
    Cause.DISTANCE: (_NEAR, "Nearly lost: {lost}", _FARTHER, _FAMILY),
    Cause.SMALL: (_NEAR, "Nearly lost: {lost}", _FARTHER, _FAMILY),
    Cause.SLOW: (_NEAR, _SLOW, _FARTHER, _PROVEN),
    Cause.NONE: ("regular: rank {rank} of {r}, no direction of the tool is lost",
                 _SLOWEST, _FARTHER, _PROVEN),
}  # fmt: skip
"""Cause -> what the configuration is, what is lost, what to do, and how sure that is."""
_REGULAR_BUT_NEVER = "regular: rank {rank} of {r}, no direction is lost in addition to those it never has"
_SOURCES = {"catalogue": "the catalogue", "analysis": "the analysis given", "on the spot": "singular points around it"}


def summary_lines(explanation: Explanation) -> tuple[str, ...]:
    """The answer in five sentences: what it is, what is lost, what to do, what is next, how sure."""
    summary, rank = explanation.summary, explanation.rank
    templates, following = _templates(explanation), _next_words(explanation)
    facts = _summarised(explanation, summary)
    size = f"rank {rank.rank} computed to {power(rank.sigma_error)}"
    name, parts = facts["name"], parts_words(summary.place)
    for shown, here in ((2, name), (1, name), (0, name), (0, parts or name)):
        facts["name"] = here
        if summary.lost:
            facts["lost"] = _motions_words(summary.lost, shown)
        else:
            facts["lost"] = f"see {advised('full')}"
        words = [text.format_map(facts) for text in templates]
        lines = (f"{explanation.robot.name} is {words[0]}.", f"{words[1]}.", f"{words[2]}.", following,
                 f"Verified: {size}{words[3]}.")  # fmt: skip
        if sum(len(wrap(line, _COLUMNS)) for line in lines) <= _LINES:
            break
    return lines


def _templates(explanation: Explanation) -> tuple[str, str, str, str]:
    """Verdict, loss, advice and evidence as texts to be filled with facts, by the cause of the verdict."""
    summary = explanation.summary
    what, lost, way, sure = _SUMMARY[summary.cause]
    if lost in (_SLOW, _SLOWEST) and (summary.slowest is None or isinf(summary.slowest.speed)):
        lost = "Lost: nothing"
    if summary.cause == Cause.NONE and explanation.task.m > explanation.rank.generic_rank:
        what = _REGULAR_BUT_NEVER
    if not summary.way_out and summary.cause == Cause.NONE:
        way = _NO_BETTER
    elif not summary.way_out:
        way = _NO_JOG.get(way, way)
    return what, lost, way, sure


def _next_words(explanation: Explanation) -> str:
    """The nearest other singularity, or that none was found, or that nobody looked."""
    summary = explanation.summary
    if summary.next_distance is not None:
        other = parts_words(summary.next_place)
        if not other and explanation.next.family is not None:
            other = explanation.next.family.called.short
        return f"Next: {other}, {_degrees(summary.next_distance)} of joint motion away."
    if summary.next_searches:
        return f"Next: none found by {summary.next_searches} searches."
    return NOT_SEARCHED


_COLUMNS, _LINES = 78, 6  # of the answer on a terminal of 80 columns, indented by two


def _summarised(explanation: Explanation, summary: Summary) -> dict[str, object]:
    """What the sentences of the summary are filled with."""
    names = [one.name for one in explanation.robot.variables]
    if summary.ideal:
        place = f"; offsets of {_offset_words(summary)} keep it from being exact"
    else:
        place = f", {_degrees(summary.distance or 0.0)} away"
    slowest = proven = ""
    if summary.slowest is not None:
        slowest = _speed_words(summary.slowest)
    if summary.radius:
        proven = f"; none within {short(below(degrees(summary.radius), 3))}° (proven)"
    return _measured(explanation) | {
        "name": special_words(summary.place, names) or summary.family or "family unknown",
        "pinned": _pinned_words(explanation.robot, summary),
        "place": place,
        "never": _motions_words(explanation.lost.never.tolist()),
        "slowest": slowest,
        "jog": _jog_words(explanation),
        "source": "the exact conditions" if summary.exact else _SOURCES[summary.source],
        "proven": proven,
    }


def _pinned_words(robot: Robot, summary: Summary) -> str:
    """The first two joints that the family pins, with their values, in brackets; empty where the parts are named."""
    if summary.place or not summary.pinned:
        return ""
    joints = robot.variables
    pinned = ", ".join(
        f"{joint_word(i, joints[i - 1].name)} at {_value_words(value, joints[i - 1].unit)}"
        for i, value in summary.pinned[:2]
    )
    return f" ({pinned})"


def _jog_words(explanation: Explanation) -> str:
    """The way out as joints to jog one after the other, and what holds after it."""
    summary, rank, joints = explanation.summary, explanation.rank, explanation.robot.variables
    jog = ", then ".join(
        f"{joint_word(i, joints[i - 1].name)} by {jog_step(value, joints[i - 1].unit)}" for i, value in summary.way_out
    )
    if summary.cause == Cause.NONE:
        before, after = float(rank.sigma[rank.generic_rank - 1]), summary.sigma_after or 0.0
        return f"jog {jog}; σ{rank.generic_rank} rises from {short(before, 2)} to {short(after, 2)}"
    return f"jog {jog}{after_jog(rank.generic_rank, regular=summary.regular_after, deficient=rank.always_singular)}"


def _offset_words(summary: Summary) -> str:
    """What keeps an arm from being the ideal one: "12 mm and 0.5°"."""
    lengths = [f"{short(1e3 * summary.length, 2)} mm"] * bool(summary.length)
    return " and ".join([*lengths, *[f"{short(degrees(summary.angle), 2)}°"] * bool(summary.angle)])


def _value_words(value: float, unit: str) -> str:
    if unit == "rad":
        return f"{short(round(degrees(value), 3) + 0.0)}°"
    return f"{short(round(value, 6) + 0.0)} m"


def _speed_words(slow: StraightMotion) -> str:
    """A straight motion: "2.2 mm/s along (0.1, …), limited by joint 4"."""
    along = f"{'along' if slow.unit == 'm/s' else 'about'} {_axis_words(slow.direction)}"
    return f"{speed_text(slow.speed, slow.unit)} {along}, limited by {joint_word(slow.number, slow.joint)}"


def speed_text(speed: float, unit: str) -> str:
    """A speed of the tool: "2.2 mm/s", "1.3 m/s", "4.1°/s"."""
    if unit == "rad/s":
        return f"{short(degrees(speed), 3 if speed > 1.0 else 2)}°/s"
    if speed >= 1.0:
        return f"{short(speed, 2)} m/s"
    return f"{short(1e3 * speed, 3 if speed >= 0.1 else 2)} mm/s"


def _motions_words(directions: Sequence[Sequence[float]], most: int = 2) -> str:
    """Lost directions in base axes: "motion along (−0.49, −0.20, 0.85); turning about Z"; their number for none."""
    if not most:
        return lost_count(len(directions))
    shown = "; ".join(_motion_words(np.array(row)) for row in directions[:most])
    return f"{shown}{f'; {len(directions) - most} more' if len(directions) > most else ''} in base axes"


def _motion_words(direction: Array) -> str:
    moves, turns = (float(np.linalg.norm(part)) for part in (direction[:3], direction[3:]))
    along, about = f"motion along {_axis_words(direction[:3])}", f"turning about {_axis_words(direction[3:])}"
    least = _MIXED * np.hypot(moves, turns)
    if turns <= least:
        return along
    if moves <= least:
        return about
    return f"{along} with {about}"


_MIXED = 0.25  # below this share of a direction its smaller part is not named


def _axis_words(vector: Iterable[float]) -> str:
    unit = np.array(list(vector))
    unit = unit / max(float(np.linalg.norm(unit)), 1e-300)
    large = np.flatnonzero(np.abs(unit) > _AXIS)
    if len(large) == 1:
        return "XYZ"[int(large[0])]
    return f"({', '.join(minus(f'{round(x, 2) + 0.0:.2f}') for x in unit.tolist())})"


def _degrees(distance: float) -> str:
    return f"{short(degrees(distance), 3)}°"


def sections_of(explanation: Explanation, *, full: bool = False, parts: Sequence[str] = ()) -> tuple[Section, ...]:
    """The parts in the order in which they are asked for.

    Args:
        full: every detail; else what an engineer at a stopped robot needs.
        parts: names out of `PARTS`; none: all of them, those in `DETAILS` only with `full`.
    """
    names = parts or [name for name in PARTS if full or name not in DETAILS]
    return tuple(flat_map(lambda name: PARTS[name](explanation, full), names))


def _summary(explanation: Explanation, full: bool) -> Iterator[Section]:
    hint = degrees_hint(explanation.q, explanation.robot)
    if hint is not None:
        yield Section("Degrees?", "", (f"{hint}; {advised('deg', python='np.radians(q)')} reads them as degrees",))
    first, *lines = summary_lines(explanation)
    what = (*_never_lines(explanation), *_warnings(explanation, full))
    yield Section(first, "", (*lines, *what), tone=TONE[explanation.verdict])


def _never_lines(explanation: Explanation) -> Iterator[str]:
    """What the arm can never do, whatever its configuration."""
    robot, task, rank = explanation.robot, explanation.task, explanation.rank
    if turn_follows(robot, task):
        yield f"{NEVER_TURNS.format(robot.n)}. {CHECKED_POINTING}."
        return
    if tool_stays_level(robot, task):
        yield f"{NEVER_TILTS}."
        return
    other = pointing_task(robot, task)
    if other is not None:
        here = at(robot, explanation.q, other, explanation.here.tolerances).measured
        if here.corank:
            verdict = "singular"
        else:
            verdict = "regular"
        asked = advised("task", other.name)
        words = POINTING_HERE.format(task=asked, verdict=verdict, rank=here.rank, r=here.generic_rank)
        yield f"{NEVER_TURNS.format(robot.n)}. {words}."
    elif len(explanation.lost.never) and explanation.cause != Cause.NEVER:
        motions = _motions_words(explanation.lost.never.tolist())
        yield f"{NEVER_HERE.format(motions=motions, r=rank.generic_rank, m=task.m)}."


def _numbers(explanation: Explanation, full: bool) -> Iterator[Section]:
    rank, robot = explanation.rank, explanation.robot
    joints, r = robot.variables, rank.generic_rank
    sigma = ", ".join(short(value) if value > rank.sigma_error else "0" for value in rank.sigma)
    lines = [
        f"rank {rank.rank} of {r}, corank {rank.corank}; {_null_motions_words(explanation)} (nullity {rank.nullity})",
        Formula(f"σ = {sigma}  (each ± {power(rank.sigma_error)}; at or below {short(rank.tolerance)} is zero)"),
        f"task {explanation.task.name}; σ has translation divided by {short(explanation.length_scale)} m",
    ]
    names = [joint.name for joint in joints]
    if not all(name.endswith(str(number)) for number, name in enumerate(names, start=1)):
        numbered = ", ".join(f"{number} {name}" for number, name in enumerate(names, start=1))
        lines.append(Formula(f"joints {numbered}"))
    columns = ("joint", *(str(number) for number in range(1, robot.n + 1)))
    yield Section("Numbers", "", tuple(lines), columns, _joint_values(robot, explanation.q), notes=robot.notes)


def _joint_values(robot: Robot, q: Array) -> tuple[tuple[str, ...], ...]:
    """The joint values as a row of a table, and those of revolute joints in degrees as a second one."""
    joints = robot.variables
    unit = "rad"
    if any(joint.unit == "m" for joint in joints):
        unit = "rad, m"
    first = (unit, *map(fixed, q))
    if not any(joint.unit == "rad" for joint in joints):
        return (first,)
    second = ["deg"]
    for joint, value in zip(joints, np.degrees(q) + 0.0, strict=True):
        if joint.unit == "m":
            second.append("")
        else:
            second.append(minus(f"{value:.2f}"))
    return first, tuple(second)


def _null_motions_words(explanation: Explanation) -> str:
    count = explanation.rank.nullity
    if explanation.task.m == 6:
        what = "move the tool"
    else:
        what = "change what the task asks for"
    if not count:
        return f"every joint motion {what.replace(' ', 's ', 1)}"
    return f"{count} {plural('way', count)} to move the joints {'does' if count == 1 else 'do'} not {what}"


def _warnings(explanation: Explanation, full: bool) -> Iterator[str]:
    reach = explanation.length_scale
    if reach > _HUGE:
        yield f"lengths are divided by {short(reach)} m: are those of the robot file in mm?"
    outside = [*_limit_words(explanation)]
    if full or len(outside) < 2:
        yield from outside
    else:
        both = ((explanation.outside_limits, "outside the limits"), (explanation.at_limits, "at a limit"))
        yield "; ".join(f"{plural('joint', len(x))} {numbers(x)} {where}" for x, where in both if x)
        if explanation.same_inside:
            turned = ", ".join(f"joint {i} at {_degrees(value)}" for i, value in explanation.same_inside)
            yield f"the same posture inside the limits: {turned}"


def _limit_words(explanation: Explanation) -> Iterator[str]:
    """Each joint that is outside its limits or stands at one, with its value and the limits."""
    inside = dict(explanation.same_inside)
    for number, (joint, value) in enumerate(zip(explanation.robot.variables, explanation.q, strict=True), start=1):
        at, low, high = (_angle_or_length(x, joint.unit) for x in (value, joint.lower, joint.upper))
        if number in explanation.outside_limits:
            same = ""
            if number in inside:
                same = f"; {_degrees(inside[number])} is the same angle inside them"
            yield f"{joint_word(number, joint.name)} at {at} is outside its limits, {low} … {high}{same}"
        elif number in explanation.at_limits:
            yield f"{joint_word(number, joint.name)} at {at} stands at a limit ({low} … {high})"


def _angle_or_length(value: float, unit: str) -> str:
    """The value of a joint: "12.3°", "0.25 m"."""
    if unit == "rad":
        return f"{short(degrees(value))}°"
    return f"{short(value)} m"


def _listed(head: str, items: Iterable[str]) -> tuple[str, ...]:
    """One line that lists things; none where there are none."""
    texts = "; ".join(items)
    if texts:
        return (f"{head}: {texts}",)
    return ()


def _which(explanation: Explanation, full: bool) -> Iterator[Section]:
    met, notes = explanation.met, tuple[str, ...]()
    own = [one for one in met if one.family.corank == met[0].family.corank]
    lines: list[str] = []
    for one in own[: None if full else 2]:
        lines += _family_lines(explanation, one, full)
    if full:
        lines += _listed("lies on", (one.family.name for one in met if one not in own))
        lines += _listed("here", (one.words for one in explanation.relations if not one.structural))
        notes = _listed("at every configuration", (one.words for one in explanation.relations if one.structural))
    if lines or notes:
        yield Section("Which singularity" if met else "Axes", _focus(explanation), tuple(lines), notes=notes)


def _family_lines(explanation: Explanation, incidence: Incidence, full: bool) -> tuple[str, str]:
    """A family through q: its title, with `full` its corank, dimension and source; and the conditions on it."""
    family, robot, task = incidence.family, explanation.robot, explanation.task
    title = family_title(robot, task, family)
    conditions = "; ".join(condition_sentences(robot, task, family))
    if not full:
        return title, Formula(conditions)
    title = f"{title}  (corank {family.corank}, dimension {family.dimension}; {incidence.source})"
    return title, Formula(f"    {conditions}")


def _focus(explanation: Explanation) -> str:
    if np.array_equal(explanation.focus, explanation.q):
        return ""
    return "at the nearest singular configuration"


def _lost(explanation: Explanation, full: bool) -> Iterator[Section]:
    lost = explanation.lost
    if lost.framed is None:
        return
    if explanation.far.near_miss is not None and not explanation.rank.corank:
        can, torque = "can hardly move other than", "with hardly any joint torque"
    else:
        can, torque = "can only move", "without joint torque"
    seen = [one for frame, one in lost.seen.items() if full or frame != "link"] or lost.seen.values()
    lines = [f"The tool {can} so that"]
    for framed in seen:
        lines += _remaining(explanation.robot, framed, full)
    if full:
        lines += _screws(explanation, torque)
    if explanation.rank.corank:
        title = "What is lost"
    else:
        title = "What is nearly lost"
    notes = [_TWIST]
    if full and any(_has_nearly_pure(framed) for framed in seen):
        notes.append(_COUNTED)
    yield Section(title, _focus(explanation), tuple(lines), notes=tuple(notes))


def _remaining(robot: Robot, framed: FramedDirections, full: bool) -> Iterator[str]:
    """What all motions that remain obey, in one frame; with `full` also what that comes to."""
    words = lost_text(robot, framed)
    yield Formula(f"  in {words['axes']}: {', '.join(words['constraints'])}")
    brief = "; ".join(filter(None, words["short"]))
    if full and brief:
        yield f"      {brief}"


def _has_nearly_pure(framed: FramedDirections) -> bool:
    """Whether a lost direction is nearly a translation or nearly a rotation."""
    return any(is_nearly_pure(direction) for direction in framed.directions)


def _never(explanation: Explanation, full: bool) -> Iterator[Section]:
    rows = tuple(tuple(short(round(float(value), 4) + 0.0) for value in row) for row in explanation.lost.never)
    if rows:
        yield Section("Never possible", "twists that this arm makes nowhere around here",
                      columns=("vx", "vy", "vz", "ωx", "ωy", "ωz"), rows=rows, texts=(), notes=(_FEWER,))  # fmt: skip


def _screws(explanation: Explanation, torque: str) -> Iterator[str]:
    """What is lost as twists and wrenches, in the frame in which it is simplest."""
    lost, framed = explanation.lost, explanation.lost.framed
    assert framed is not None
    at_tip = framed.frame.origin == TIP and not any(framed.frame.point)
    yield f"In the axes of {framed.name}{', reference point at the tool' * at_tip}:"
    for direction, twist, wrench in zip(framed.directions, lost.twist_screws, lost.wrench_screws, strict=True):
        yield f"  lost twist {vector(direction)}: {pitch_text(twist.pitch)}"
        yield f"      carried {torque}: {wrench_text(wrench)}"


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
    if frame.axes in (BASE, TIP):
        number = frame.origin
    else:
        number = frame.axes
    if number in (BASE, TIP):
        return f"axes of {text}"
    joint, link = robot.joints[number - 1], f"link {number}"
    known = joint.link or f"after {joint.name}"
    return f"axes of {text.replace(link, f'{link} ({known})', 1)}"


Columns = dict[str, Callable[[Any], str]]
"""Heading -> the cell of a record."""


def _table(records: Iterable[Any], columns: Columns) -> dict[str, Any]:
    """Columns and rows of a section."""
    return {"columns": tuple(columns), "rows": tuple(_row(one, columns) for one in records)}


def _row(record: Any, columns: Columns) -> tuple[str, ...]:
    """The cells of a record."""
    return tuple(cell(record) for cell in columns.values())


def _yes(holds: bool) -> str:
    return "yes" if holds else "no"


_CIRCUITS: Columns = {
    "joints": lambda one: numbers(one.numbers), "when": lambda one: "always" if one.generic else "here",
    "joint rates that cancel": lambda one: vector(one.coefficients), "in words": attrgetter("words"),
}  # fmt: skip
_RUNS: Columns = {
    "joints": lambda one: f"{one.first}–{one.last}", "dimension": lambda one: str(one.dimension),
    "loss": lambda one: str(one.loss), "their test": lambda one: _yes(one.msos),
    "minimal": lambda one: _yes(one.minimal),
}  # fmt: skip
_HUNT: Columns = {
    "joint": lambda one: str(one.number), "column": lambda one: short(round(one.share, 4)),
    "named": lambda one: _yes(one.named), "GR's actuator": lambda one: _yes(one.actuator),
    "leads out, rate": lambda one: short(round(abs(one.rate), 4)) if one.tells else "no",
    "by finite motion": lambda one: _yes(one.escapes),
}  # fmt: skip


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
    if full:
        yield from _blame_tables(blame)


def _blame_tables(blame: Blame) -> Iterator[Section]:
    """Every circuit, the singular runs of joints, and Hunt's cofactors."""
    if blame.circuits:
        yield Section("Every circuit", "dependent sets of joints without a smaller one inside",
                      **_table(blame.circuits, _CIRCUITS), texts=(0, 1, 2, 3))  # fmt: skip
    if blame.ordered:
        yield Section("Singular runs of joints", "as Gallardo-Alvarado and Rico-Martínez look for them",
                      **_table(blame.ordered, _RUNS))  # fmt: skip
    if blame.hunt is not None:
        if blame.hunt.joints:
            table = _table(blame.hunt.joints, _HUNT)
        else:
            table = {}
        yield Section("Hunt's cofactors next to GR's rules", "", (hunt_words(blame.hunt),), **table)


def _dependencies(explanation: Explanation) -> str:
    usual = explanation.robot.n - explanation.rank.generic_rank
    place = special_words(explanation.summary.place, [joint.name for joint in explanation.robot.variables])
    text = "; ".join(filter(None, (place, "smallest sets of joints with dependent screws")))
    if usual:
        if explanation.met:
            corank = explanation.met[0].family.corank
        else:
            corank = explanation.rank.corank
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
    columns: tuple[str, ...] = ("joint", "order", f"σ{r} grows by", "try", f"σ{r} then", "carries out")
    if not full:
        columns, rows = (columns[0], *columns[3:5]), tuple((row[0], *row[3:5]) for row in rows)
    return Section("How to get out", "one joint alone, best first" if rows else "", (), columns, rows,
                   (0, 5) if full else (0,), tuple(_ways_out(explanation, full, alone=bool(helpful))),
                   (_ORDER,) * bool(rows and full))  # fmt: skip


_ORDER = "order p, rate c: σ grows as c·tᵖ; carries out: the screws that the motion takes out of the dependency"


def _ways_out(explanation: Explanation, full: bool, *, alone: bool) -> Iterator[str]:
    """What is known beside motions of one joint; `alone`: some joint restores the full rank."""
    out = explanation.escape
    if not alone:
        yield "no single joint restores the full rank"
    if out.best_pair is not None and full:
        yield f"best two joints: {_direction(explanation, out.best_pair)}"
    if full or not alone:
        yield f"best direction: {_direction(explanation, out.best_direction)}"
    if full or out.avoidable is not None:
        yield _sentence(avoidable_words(out))
    if full:
        yield from _lost_types(out)
    if full or out.boundary is not None:
        yield _sentence(boundary_words(out))


def _lost_types(out: Escape) -> Iterator[str]:
    """How the tool moves along the lost directions at second order, one sentence for each type."""
    if out.boundary is False and out.types[0].type == 1:
        slowly = "it can be passed slowly: "
    else:
        slowly = ""
    for kind in dict.fromkeys(one.type for one in out.types):
        which = [i for i, one in enumerate(out.types, start=1) if one.type == kind]
        words = lost_type(kind, _lost_numbered(which, len(out.types)))
        yield _sentence(f"{slowly}{words}")


def _proofs(explanation: Explanation, full: bool) -> Iterator[Section]:
    out = explanation.escape
    said: dict[str | int, str] = {out.avoidable_reason: avoidable_words(out)}
    said |= {one.type: lost_type(one.type) for one in out.types}
    said[out.boundary_reason] = boundary_words(out)
    lines = tuple(f"{_sentence(words)} {PROOF[reason]}" for reason, words in said.items() if reason in PROOF)
    if lines and explanation.rank.corank:
        yield Section("Why", "for ways out", lines)


def _sentence(words: str) -> str:
    return f"{words[0].upper()}{words[1:]}."


def _lost_numbered(which: list[int], count: int) -> str:
    if count == 1:
        return "the lost direction"
    if len(which) == count:
        return "each lost direction"
    return f"lost {plural('direction', len(which))} {numbers(which)}"


def _away(explanation: Explanation, full: bool) -> Section:
    out, r = explanation.escape, explanation.rank.generic_rank
    sigma = float(explanation.rank.sigma[r - 1])
    best = max(abs(one.rate) for one in out.single)
    helpful = [
        one for one in out.single if abs(one.rate) > max(IDLE * best, NO_RATE) and one.sigma_after >= WORTH * sigma
    ]
    rows = tuple(
        (f"{one.number} {one.joint}", *_rate_and_step(explanation, one))
        for one in (out.single if full else helpful[:_SHOWN])
    )
    now = f"one joint alone, best first; σ{r} = {short(sigma)} here"
    return Section("How to get away", now if rows else "", (), ("joint", f"σ{r} changes by", "try", f"σ{r} then"), rows,
                   (0,), (f"best direction: {_direction(explanation, out.best_direction)}",))  # fmt: skip


def _joint_row(explanation: Explanation, joint: JointEscape) -> tuple[str, ...]:
    name = f"{joint.number} {joint.joint}"
    if joint.order is None:
        return (name, "–", f"gains {joint.gain}, not all" if joint.gain else "no gain", "", "", "")
    if joint.receptors:
        carries = numbers(joint.receptors)
    else:
        carries = "–"
    return (name, str(joint.order), *_rate_and_step(explanation, joint, joint.order), carries)


def _rate_and_step(explanation: Explanation, joint: JointEscape, order: int = 1) -> tuple[str, str, str]:
    unit = explanation.robot.variables[joint.number - 1].unit
    if order == 1:
        per = unit
    else:
        per = f"{unit}{raised(order)}"
    rate = f"{short(joint.rate) if abs(joint.rate) > NO_RATE else '0'} per {per}"
    if not joint.within_limits or abs(joint.step) < NO_RATE:
        return rate, "not within limits", ""
    return rate, motion(joint.step, unit), short(joint.sigma_after)


def _direction(explanation: Explanation, direction: Direction) -> str:
    """The joints that matter, in words, and what they reach."""
    joints = explanation.robot.variables
    scale = np.where([joint.unit == "m" for joint in joints], explanation.length_scale, 1.0)
    size = np.abs(np.array(direction.delta)) / scale
    large = [number for number in direction.numbers if size[number - 1] >= SHARE * size.max()]
    parts = [
        f"joint {number} {motion(direction.delta[number - 1] * direction.step, joints[number - 1].unit)}"
        for number in large
    ]
    if len(large) < sum(size > 1e-9):
        rest = ", the others far less"
    else:
        rest = ""
    end = f"σ{explanation.rank.generic_rank} = {short(direction.sigma_after)}"
    if not direction.within_limits:
        end += ", outside the joint limits"
    return f"{', '.join(parts)}{rest}: {end}" + ("" if direction.restores else f", gains {direction.gain} only")


def _far(explanation: Explanation, full: bool) -> Iterator[Section]:
    lines = [*_nearest_words(explanation, full), *_certified_words(explanation)]
    rows = _distance_rows(explanation, full)
    columns, notes = tuple[str, ...](), tuple[str, ...]()
    if rows:
        columns = ("distance", "family")
    if rows and full:
        columns += tuple(f"{number}" for number in range(1, explanation.robot.n + 1))
        notes = ("by joint: the motion to it",)
    if lines or rows:
        yield Section(_how_far(explanation), "", tuple(lines), columns, tuple(rows), (0, 1), notes=notes)


def _distance_rows(explanation: Explanation, full: bool) -> list[tuple[str, ...]]:
    """Distance and name of the nearest families; with `full` of all of them, the motion of each joint, the nearest."""
    far, units, robot, task = explanation.far, explanation.robot.units, explanation.robot, explanation.task
    if not full:
        return [(angle(one.distance), family_title(robot, task, one.family)) for one in far.families[:2]]
    rows = []
    if far.nearest is not None and not _is_a_family(far.nearest, far.families):
        rows.append((angle(far.nearest.distance), "the nearest", *_deltas(far.nearest.delta, units)))
    for one in far.families:
        name = f"{family_title(robot, task, one.family)} (corank {one.family.corank})"
        rows.append((angle(one.distance), name, *_deltas(one.delta, units)))
    return rows


def _how_far(explanation: Explanation) -> str:
    if explanation.rank.corank:
        return "How far the next one is"
    return "How far"


def _nearest(explanation: Explanation, full: bool) -> Iterator[Section]:
    """How far: the nearest configuration with the motion to it, what is proven, the distance to each family."""
    if full:
        yield from _far(explanation, full)
        return
    far, names = explanation.far, [joint.name for joint in explanation.robot.variables]
    lines = [*_nearest_words(explanation, True)]
    if far.nearest is not None:
        steps = _deltas(far.nearest.delta, explanation.robot.units)
        moved = [f"{joint_word(i, name)} by {step}" for i, (name, step) in enumerate(zip(names, steps, strict=True), 1)
                 if step != "0"]  # fmt: skip
        if moved:
            lines += [MOTION_TO_IT.format(", ".join(moved))]
    lines += _certified_words(explanation)
    title = partial(family_title, explanation.robot, explanation.task)
    rows = tuple((angle(one.distance), f"{title(one.family)} (corank {one.family.corank})") for one in far.families)
    if lines or rows:
        columns = ("distance", "family") if rows else ()
        more = MORE_NEAREST.format(advised("full"))
        yield Section(_how_far(explanation), "", tuple(lines), columns, rows, (0, 1), notes=(more,))


def _is_a_family(nearest: Nearest, families: Sequence[FamilyDistance]) -> bool:
    return any(one.distance <= nearest.distance * (1 + 1e-9) for one in families)


def _nearest_words(explanation: Explanation, full: bool) -> Iterator[str]:
    far = explanation.far
    if far.nearest is not None and (full or not far.families):
        if far.nearest_family is None:
            name = ""
        else:
            name = f" ({family_title(explanation.robot, explanation.task, far.nearest_family.family)})"
        if far.nearest.within_limits:
            limits = ""
        else:
            limits = "; it is outside the joint limits"
        checked = f"; {far.nearest.agreeing} of {far.nearest.starts} searches agree; σ there at most "
        yield (f"nearest singular configuration found: {angle(far.nearest.distance)} away{name}"
               f"{checked + power(far.nearest.sigma) if full else ''}{limits}")  # fmt: skip


def _certified_words(explanation: Explanation) -> Iterator[str]:
    """What is proven about the distance; nothing where every configuration is deficient."""
    far, rank = explanation.far, explanation.rank
    if rank.always_singular:
        return
    if far.certificate is not None:
        spent = f"{far.certificate.evaluations:,} enclosures{'' if far.certificate.complete else '; interrupted'}"
        yield f"certified: no singularity within {angle_below(far.certificate.radius)} (proven; {spent})"
    elif far.uncertified and not rank.corank:
        yield f"no certified radius: {far.uncertified}"


def _deltas(delta: Sequence[float], units: list[str]) -> tuple[str, ...]:
    return tuple(motion(value, unit, 4) for value, unit in zip(delta, units, strict=True))


def _rates(explanation: Explanation, full: bool) -> Iterator[Section]:
    """One row for each axis: its lost share where something is lost, then what its motion costs."""
    rates, n = explanation.rates, explanation.robot.n
    losing = any(rates.lost_shares)
    norms = full or not losing
    if full:
        impossible = ("–", "", "0", *[""] * n)
    else:
        impossible = ("", "0")
    rows = [
        (axis.name, *[_percent(share)] * losing,
         *(impossible if left is None else _costs(left, axis.unit, full, brief=losing)))
        for axis, share, left in zip(rates.axes, rates.lost_shares, rates.remaining, strict=True)
    ]  # fmt: skip
    if rates.weakest is not None:
        rows.append((rates.weakest.name, *[""] * losing, *_costs(rates.weakest, "", full, brief=losing)))
    if np.isfinite(rates.limits).any():
        held = "held back by"
    else:
        held = "fastest"
    columns = ("unit speed", *["lost"] * losing, *["joint rates"] * norms, held, "at most")
    axes = explanation.turned_task.frame.axes
    yield Section("What motion costs", {BASE: "base axes", TIP: "tool axes"}.get(axes, f"axes of link {axes}"), (),
                  (*columns, *(str(number) for number in range(1, n + 1) if full)), tuple(rows),
                  (0, len(columns) - 2, len(columns) - 1), notes=tuple(_rate_notes(explanation, norms)))  # fmt: skip


def _rate_notes(explanation: Explanation, norms: bool) -> Iterator[str]:
    rates = explanation.rates
    unlimited = [number for number, limit in enumerate(rates.limits, start=1) if isinf(limit)]
    if any(rates.lost_shares):
        yield "lost: the share of this motion that cannot be made"
        yield "the other columns: the nearest motion that can be made, at 1 m/s or 1 rad/s along the axis"
    if norms:
        yield "joint rates: the smallest for 1 m/s or 1 rad/s, as a norm [rad/s]"
    if len(unlimited) < len(rates.limits):
        if unlimited:
            none = f"; {plural('joint', len(unlimited))} {numbers(unlimited)} without one"
        else:
            none = ""
        yield f"at most: the largest speed within the velocity limits{none}"
    else:
        yield "no velocity limits are known"
    if rates.weakest is not None:
        yield (f"weakest direction: that of σ{explanation.rank.rank}, the smallest that is not zero; 1 rad/s, or "
               f"{short(rates.length_scale)} m/s")  # fmt: skip


def _percent(share: float) -> str:
    """A share in percent: never rounded to all or nothing."""
    if share in (0.0, 1.0):
        return f"{share:.0%}".replace("%", " %")
    if share < 1e-3:
        return "< 0.1 %"
    if share > 0.999:
        return "> 99.9 %"
    return f"{100 * share:.3g} %"


def _costs(rates: DirectionRates, unit: str, full: bool, *, brief: bool) -> tuple[str, ...]:
    """Joint rates (not where it is `brief`), the joint that holds back, the largest speed [`unit` or mixed]."""
    if full:
        each = tuple(short(round(rate, 6)) for rate in rates.joint_rates)
    else:
        each = ()
    if not unit or isinf(rates.speed):
        most = _largest(rates)
    else:
        most = f"{short(rates.speed, 3)} {unit}"
    if rates.worst is None:
        held = ""
    else:
        held = f"{rates.worst} {rates.worst_joint}"
    if brief and not full:
        return (held, most)
    return (short(rates.norm), held, most, *each)


def _largest(rates: DirectionRates) -> str:
    if isinf(rates.speed):
        return "no limit"
    if rates.unit != "1":
        return f"{short(rates.speed, 3)} {rates.unit}"
    parts = [(float(np.linalg.norm(part)) * rates.speed, unit)
             for part, unit in ((rates.direction[:3], "m/s"), (rates.direction[3:], "rad/s"))]  # fmt: skip
    return ", ".join(f"{short(value, 3)} {unit}" for value, unit in parts if value > 1e-9)


_SHAPES: Columns = {
    "": attrgetter("name"), "velocity half-axes": lambda part: _lengths(part.velocity.half_lengths),
    "force half-axes": lambda part: _lengths(part.force.half_lengths),
    "σ_min": lambda part: short(part.sigma_min.value),
    "condition": lambda part: short(part.condition.value),
    "manipulability": lambda part: short(part.manipulability.value),
}  # fmt: skip


def _ellipsoids(explanation: Explanation, full: bool) -> Iterator[Section]:
    shapes = explanation.ellipsoids
    for group in filter(None, (shapes.unit_rates, shapes.rate_limits)):
        parts = [*filter(None, (group.translation, group.rotation, group.task))]
        units = ", ".join(f"{part.name} {part.velocity.unit} and {part.force.unit}" for part in parts)
        notes = (f"units: {units}; the task as a whole takes {shapes.length_scale:.4g} m for 1 rad",)
        yield Section("Ellipsoids", group.ball, (), **_table(parts, _SHAPES), texts=(0, 1, 2), notes=notes)


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


_COORDINATES: Columns = {
    "name": attrgetter("name"),
    "value [rad, 1]": lambda one: ", ".join(
        f"{name} {short(value)}" for name, value in zip(one.names, one.coordinates, strict=True)),
    "σ_min of E": lambda one: short(round(one.sigma_min, 12)),
    "nearest singularity": lambda one: "none" if isinf(one.angle) else f"{degrees(one.angle):.3g}°",
    "verdict": lambda one: "SINGULAR" if one.singular else "near" if one.near else "",
}  # fmt: skip


def _representation(explanation: Explanation, full: bool) -> Iterator[Section]:
    rows = _table(explanation.representations.every, _COORDINATES)["rows"]
    columns = ("", *tuple(_COORDINATES)[1:4], "")
    yield Section("Coordinates of the orientation", explanation.representations.words, (), columns, rows,
                  texts=(0, 1, 4))  # fmt: skip


def _lengths(values: Iterable[float]) -> str:
    return " ".join(short(round(float(value), 6)) for value in values)


def _place(explanation: Explanation, full: bool) -> Iterator[Section]:
    """Where the tool is, and how the file of the arm was read: which tip was chosen, units that look wrong."""
    robot = explanation.robot
    notes = [f"Note: {note}" for note in robot.notes if not full]
    yield Section("", "", (tool_sentence(robot, pose(robot, explanation.q)), *notes))


def _more(_: Explanation, full: bool) -> Iterator[Section]:
    """What else there is, where it is not printed."""
    if not full:
        there = "joint rates, failures, σ and angles, circuits, redundancy, …"
        yield Section("", "", notes=(f"more with {advised('full')}: {there}",))


PARTS: dict[str, Callable[[Explanation, bool], Iterator[Section]]] = {
    "summary": _summary,
    "which": _which,
    "lost": lambda explanation, full: chain(_lost(explanation, full), _never(explanation, full)),
    "escape": _escape,
    "far": _far,
    "nearest": _nearest,
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
    "place": _place,
    "more": _more,
}
"""Every part by its name, in order."""
DETAILS = frozenset(
    ("nearest", "blame", "proofs", "rates", "failures", "ellipsoids", "redundancy", "representation", "numbers", "more")
)
"""Parts that are shown only on demand."""


LONGEST = 120
"""Characters of a condition that is printed; of a longer one the joints are named."""
_SHIFTED = 1e-12  # an angle that conditions count from elsewhere than the joint does [rad]


class _Condition(NamedTuple):
    """A condition for people, the joints it is about, and the lengths that stand in it as letters."""

    text: str
    joints: frozenset[int]
    letters: frozenset[str] = frozenset()


def _written(robot: Robot, task: Task, family: Family) -> tuple[list[_Condition], Record] | None:
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
            beyond, letters = len(one["pinned"]), record["letters"]
            each = zip(one["conditions"][beyond:], one["terms"][beyond:], one["polynomials"], strict=True)
            return [_Condition(text, _joints(terms), _letters(f, letters)) for text, terms, f in each], letters
    return None


def _joints(terms: list[Record]) -> frozenset[int]:
    """Numbers of the joints of an equation, from its terms: harmonics of angles, powers of slides."""
    found: set[int] = set()
    for one in terms:
        exponents = zip(one["harmonics"], one["powers"], strict=True)
        found |= {number for number, exponent in enumerate(exponents, start=1) if any(exponent)}
    return frozenset(found)


def _letters(polynomial: list[Any], letters: Record) -> frozenset[str]:
    """Lengths that stand in a polynomial as letters, from its terms [[variable, power, …], coefficient]."""
    names: set[str] = set()
    for variables, _ in polynomial:
        names.update(variables[::2])
    return frozenset(names & letters.keys())


def condition_sentences(robot: Robot, task: Task, family: Family) -> tuple[str, ...]:
    """What has to hold on a family, one sentence each.

    Joints at fixed values first: "θ4 = −26.76° or 153.24°". Then the exact conditions where they are shipped, with the
    lengths that stand in them; else the fitted ones. Long ones are not printed: they name their joints.

    Args:
        robot: the arm.
        task: its rows.
        family: of the catalogue, of an analysis, or found on the spot.
    """
    written = _written(robot, task, family)
    if written is None and not family.equations:
        return family.words or ("no condition found",)
    conditions, letters = _unpinned(family, written)
    short = [one for one in conditions if len(one.text) <= LONGEST]
    long = [one for one in conditions if len(one.text) > LONGEST]
    pins = ((one.number, values_in_degrees(robot, one.number, one.values)) for one in family.pinned)
    told = [f"{joint_symbols(robot)[number - 1]} = {values}" for number, values in pins]
    told += (one.text for one in short)
    named = frozenset[str]().union(*(one.letters for one in short))
    lengths = [f"{name} = {value:.6g} m".replace("-", "−") for name, value in letters.items() if name in named]
    if lengths:
        told[-1] += f", {', '.join(lengths)}"
    if long:
        told.append(_long_words(long, exact=written is not None))
    return tuple(told)


def _long_words(long: Sequence[_Condition], *, exact: bool) -> str:
    """How many conditions are too long to print, on which joints, and where they stand."""
    if exact:
        where = "`rankdrop conditions` prints it"
    else:
        where = "in the JSON"
    if len(long) == 1:
        count = "a long condition"
    else:
        count = f"{len(long)} long conditions"
    joints = frozenset[int]().union(*(one.joints for one in long))
    return f"{count} on joints {numbers(sorted(joints))} ({where})"


def _unpinned(family: Family, written: tuple[list[_Condition], Record] | None) -> tuple[list[_Condition], Record]:
    """The conditions beyond those that only pin joints, exact where they are shipped, and their lengths."""
    fixed = {one.number for one in family.pinned}
    if written is None:
        fitted = [_Condition(f"{one} = 0", frozenset(one.joints)) for one in family.equations]
        return [one for one in fitted if not one.joints <= fixed], {}
    return [one for one in written[0] if not one.joints <= fixed], written[1]
