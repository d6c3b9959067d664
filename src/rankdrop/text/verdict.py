"""The verdict on a configuration: a sentence, its reason, and the answer in five sentences.

The sentences stand in tables, one row for each cause of the verdict.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import degrees, isinf
from textwrap import wrap

import numpy as np

from rankdrop.configuration import Cause
from rankdrop.families.record import Family
from rankdrop.local.slowest import StraightMotion
from rankdrop.options import advise
from rankdrop.results.explained import Difference, DifferenceKind, Summary
from rankdrop.results.explanation import Explanation
from rankdrop.robot.model import Array, Robot
from rankdrop.text.joint_values import fixed_point
from rankdrop.text.special import family_title, names_no_reason, parts_words, special_words
from rankdrop.text.words import (
    NO_JOG,
    NOT_SEARCHED,
    after_jog,
    angle,
    angle_below,
    below,
    jog_step,
    joint_word,
    lost_count,
    power,
    short,
)
from rankdrop.tolerances import SLOW

_AXIS = 5e-3  # components below it are 0.00 as shown: the axis is X, Y or Z
_DIGITS = 6  # of numbers that have to differ as shown, fewer

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

SINGULAR_HERE = "the configuration is singular"
"""Why no radius is certified at a singular configuration."""
_DIFFERENCES = {
    DifferenceKind.GAIN: "joint {number} alone: a rank gain of {predicted} was predicted, finite motion gains "
    "{measured}",
    DifferenceKind.RADIUS: "certified radius {radius} beyond a singularity at {distance}",
    DifferenceKind.SEARCH_MISSED: "the search missed a nearer point of family {family}",
    DifferenceKind.FAMILIES_MISSED: "the search found a singularity nearer than every family",
}

_NEAR = "near a singularity: {name}{place}"
_OUT, _FARTHER = "Get out: {jog}. Cartesian jogging fails", "Get farther away: {jog}"
_NO_JOG = {_OUT: f"Get out: {NO_JOG}", _FARTHER: f"Get farther away: {NO_JOG}"}
"""What to do -> the same where no jog was found."""
_NO_BETTER = "Get farther away: no small jog of one joint raises σ{r} by 1 %"
"""The same from a regular configuration."""
_SLOW, _SLOWEST = "Slow: at most {slowest}", "Slowest straight motion: at most {slowest}"
_NEARLY = "Nearly lost: {lost}{straight}"
"""What is nearly lost, and how fast the tool still moves straight."""
_FAMILY, _PROVEN = "; family from {source}", "{proven}"
_SUMMARY = {
    Cause.LOST: ("singular: {name}{pinned}", "Lost: {lost}",
                 _OUT, _FAMILY),
    Cause.NEVER: ("singular at every configuration: rank {r} of {m}", "Never possible: {never}",
                  "Get out: ask for a task with fewer rows (planar, position, …)", _PROVEN),
    Cause.NEAR_MISS: ("near a singularity that it just misses: σ{r} does not vanish, {miss} is its least nearby",
                      _NEARLY, _FARTHER, _PROVEN),
    Cause.DISTANCE: (_NEAR, _NEARLY, _FARTHER, _FAMILY),
    Cause.SMALL: (_NEAR, _NEARLY, _FARTHER, _FAMILY),
    Cause.SLOW: (_NEAR, _SLOW, _FARTHER, _PROVEN),
    Cause.NONE: ("regular: rank {rank} of {r}, no direction of the tool is lost",
                 _SLOWEST, _FARTHER, _PROVEN),
}  # fmt: skip
"""Cause -> what the configuration is, what is lost, what to do, and how sure that is."""
_REGULAR_BUT_NEVER = "regular: rank {rank} of {r}, no direction is lost in addition to those it never has"
_SOURCES = {"catalogue": "the catalogue", "analysis": "the analysis given", "on the spot": "singular points around it"}

_COLUMNS, _LINES = 78, 6  # of the answer on a terminal of 80 columns, indented by two

_MIXED = 0.25  # below this share of a direction its smaller part is not named


def sentence_of(explanation: Explanation) -> str:
    """What may be claimed of one configuration; its word is `Explanation.verdict`."""
    if explanation.disagreements:
        differ = "; two methods disagree, see the end"
    else:
        differ = ""
    return f"{explanation.robot.name}: {explanation.verdict.upper()}, {explanation.reason}{differ}."


def reason_of(explanation: Explanation) -> str:
    """What decides the verdict, in a sentence."""
    facts, far = _measured_values(explanation), explanation.far
    if explanation.cause == Cause.NONE and far.nearest is None:
        near = far.certificate
        if near:
            proven = f"none lies within {angle_below(near.radius)}"
        else:
            proven = "that is no proof"
        return _NONE_FOUND.format_map({**facts, "proven": proven})
    return _REASONS[explanation.cause].format_map(facts)


def _measured_values(explanation: Explanation) -> dict[str, object]:
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
        "slow": " and ".join(_speed_words(link) for link in explanation.straight if link.speed < link.limit),
    }  # fmt: skip


def difference_sentence(difference: Difference) -> str:
    """Two methods that give two answers."""
    if difference.family is None:
        family = ""
    else:
        family = f"{difference.family.id} ({difference.family.name})"
    return _DIFFERENCES[difference.kind].format(
        number=difference.number, predicted=difference.predicted, measured=difference.measured,
        radius=f"{difference.radius:.6g}", distance=f"{difference.distance:.6g}", family=family,
    )  # fmt: skip


def summary_lines(explanation: Explanation) -> tuple[str, ...]:
    """The answer in five sentences: what it is, what is lost, what to do, what is next, how sure."""
    summary, rank = explanation.summary, explanation.rank
    templates, following = _templates(explanation), _next_words(explanation)
    facts = _summary_facts(explanation, summary)
    size = f"rank {rank.rank} computed to {power(rank.sigma_error)}"
    name, parts = str(facts["name"]), parts_words(summary.place)
    if not parts or _telling_family(explanation) is not None:
        parts = name
    for shown, here in ((2, name), (1, name), (0, name), (0, parts)):
        facts["name"] = here
        if summary.lost:
            facts["lost"] = motions_words(summary.lost, shown)
        else:
            facts["lost"] = f"see {advise('full')}"
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
        lost = _nothing_lost(explanation)
    if summary.cause == Cause.NONE and explanation.task.m > explanation.rank.generic_rank:
        what = _REGULAR_BUT_NEVER
    if not summary.way_out and summary.cause == Cause.NONE:
        way = _NO_BETTER
    elif not summary.way_out:
        way = _NO_JOG.get(way, way)
    return what, lost, way, sure


def _nothing_lost(explanation: Explanation) -> str:
    """No motion is lost, of an arm without joint rates; said where a speed was asked for."""
    if explanation.options.speed in (0.0, SLOW):
        return "Lost: nothing"
    return "Lost: nothing. Speed is not checked: the arm's file has no joint rates"


def _next_words(explanation: Explanation) -> str:
    """The nearest other singularity, or that none was found, or that nobody looked."""
    summary = explanation.summary
    if summary.next_distance is not None:
        other = parts_words(summary.next_place)
        if not other and explanation.next.family is not None:
            other = explanation.next.family.called.short
        return f"Next: {other}, {degrees_words(summary.next_distance)} of joint motion away."
    if summary.next_searches and explanation.families:
        return f"Next: none found by {summary.next_searches} searches."
    if summary.next_searches:
        more = f"{advise('analysis', '…')} with a file of analyze finds more"
        return f"Next: none found by {summary.next_searches} searches; {more}."
    return NOT_SEARCHED


def _summary_facts(explanation: Explanation, summary: Summary) -> dict[str, object]:
    """What the sentences of the summary are filled with."""
    names = [joint.name for joint in explanation.robot.variables]
    if summary.ideal:
        place = f"; offsets of {_offset_words(summary)} keep it from being exact"
    else:
        place = f", {degrees_words(summary.distance or 0.0)} away"
    slowest = proven = ""
    if summary.slowest is not None:
        slowest = _speed_words(summary.slowest)
    if summary.radius:
        proven = f"; none within {short(below(degrees(summary.radius), 3))}° (proven)"
    return _measured_values(explanation) | {
        "name": _name_words(explanation, summary, names),
        "pinned": _pinned_words(explanation.robot, summary),
        "place": place,
        "never": motions_words(explanation.lost.never.tolist()),
        "slowest": slowest,
        "straight": _still_moves_words(explanation),
        "jog": _jog_words(explanation),
        "source": "the exact conditions" if summary.exact else _SOURCES[summary.source],
        "proven": proven,
    }


def _still_moves_words(explanation: Explanation) -> str:
    """How fast the tool still moves straight, or turns where turning alone is nearly lost; "" without joint rates."""
    rows = [np.array(row) for row in explanation.summary.lost]
    moves = any(np.linalg.norm(row[:3]) > _MIXED * np.linalg.norm(row) for row in rows)
    if moves:
        unit, what = "m/s", "straight motion"
    else:
        unit, what = "rad/s", "turning"
    for motion in explanation.straight:
        if motion.unit == unit and not isinf(motion.speed):
            return f"; {what} at most {_speed_words(motion)}"
    return ""


def _telling_family(explanation: Explanation) -> Family | None:
    """The family here, where its axes say more and the parts of the arm are far from their conditions."""
    summary = explanation.summary
    for family in (incidence.family for incidence in explanation.met):
        if family.id == summary.family_id and names_no_reason(summary.place, family):
            return family
    return None


def _name_words(explanation: Explanation, summary: Summary, names: Sequence[str]) -> str:
    """What the singularity is called: by the parts that are special; by its axes where these are far from it."""
    family = _telling_family(explanation)
    if family is not None:
        return family_title(explanation.robot, explanation.task, family)
    return special_words(summary.place, names) or summary.family or "family unknown"


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
        return f"jog {jog}; σ{rank.generic_rank} rises from {_two_apart(before, after)}"
    outcome = after_jog(rank.generic_rank, regular=summary.regular_after, deficient=rank.always_singular)
    if summary.crosses:
        outcome += "; it passes another singularity on the way"
    return f"jog {jog}{outcome}"


def _two_apart(before: float, after: float) -> str:
    """Two numbers, with as many digits as tell them apart: "0.067 to 0.1", "0.226 to 0.234"."""
    for digits in range(2, _DIGITS):
        if short(before, digits) != short(after, digits):
            break
    return f"{short(before, digits)} to {short(after, digits)}"


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


def motions_words(directions: Sequence[Sequence[float]], most: int = 2) -> str:
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


def _axis_words(vector: Iterable[float]) -> str:
    unit = np.array(list(vector))
    unit = unit / max(float(np.linalg.norm(unit)), 1e-300)
    large = np.flatnonzero(np.abs(unit) > _AXIS)
    if len(large) == 1:
        return "XYZ"[int(large[0])]
    return f"({', '.join(fixed_point(x, 2) for x in unit.tolist())})"


def degrees_words(distance: float) -> str:
    """An angle given in rad: "12.5°"."""
    return f"{short(degrees(distance), 3)}°"
