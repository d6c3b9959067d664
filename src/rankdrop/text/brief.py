"""The short form of an analysis and of exact conditions: one row per family, and what the largest families lose.

`--full` prints the long form: tables of every joint, conditions, tests.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from math import ceil, degrees, floor
from typing import Any

from rankdrop.distance.share import JointSpaceShares
from rankdrop.families.name import ArmPart
from rankdrop.families.parts import FamilyParts
from rankdrop.families.record import Family, Pin, exact_of
from rankdrop.families.speed_distance import SpeedDistance
from rankdrop.formula.equation import pretty_angle
from rankdrop.options import advise
from rankdrop.results.names import name_of
from rankdrop.robot.model import Robot
from rankdrop.robot.quantities import count, degrees_text
from rankdrop.sections import Section
from rankdrop.task import Task
from rankdrop.text.conditions import angles_text, condition_lines, shipped_line
from rankdrop.text.families import exact_conditions, restrict_to_limits, share_text
from rankdrop.text.joint_values import joints_named, letters_text, symbols, values_in_degrees, values_text
from rankdrop.text.lost import lost_note, lost_sentences
from rankdrop.text.robots import notes_words
from rankdrop.text.shares import near_total, share_cell, slow_line
from rankdrop.text.special import family_label, family_title, label_words
from rankdrop.text.words import listing

_SHORT = 36  # characters of a condition that stands in the table; of a longer one its joints are named

NO_RATE_LIMITS = "; –: too few joints have a rate limit, state `velocity` of the joints in the arm's file"


def arm_line(robot: Robot, task: Task, generic_rank: int, *, limits: bool = False) -> str:
    """The arm and its task in a line, with the notes on its file."""
    about = f": {robot.about}" if robot.about else ""
    if limits:
        where = "; within the joint limits"
    else:
        where = ""
    line = f"{robot.name}{about}; task {task.name}, rank {generic_rank} almost everywhere{where}."
    return "\n".join((line, *(f"Note: {note}" for note in notes_words(robot.notes))))


def analysis_table(analysis: Any) -> Section:
    """One row per family of an analysis: rank, name, what it asks of the joints; the share near it if known."""
    robot, near = analysis.robot, analysis.near
    if near is None:
        shares = {}
    else:
        shares = {share.id: share_cell(share) for share in near.families}
    rows, letters = [], False
    for family in analysis.families:
        exact = _short_condition(family)
        letters |= bool(exact)
        rank = str(analysis.generic_rank - family.corank)
        name = family_title(robot, analysis.task, family)
        row = [rank, name, _asked_and_tested(analysis, family, exact)]
        if near is not None:
            row.append(shares.get(family.id, ""))
        rows.append(tuple(row))
    if not letters:
        return _table(robot, rows, {}, "", near)
    return _table(robot, rows, analysis.exact.letters, angles_text(robot, analysis.exact.shifts), near)


def _short_condition(family: Family) -> str:
    """The exact condition on the coupled joints of a family where it is short enough for the table; else empty."""
    exact = exact_conditions(family)
    if not exact or len(exact) > _SHORT or not family.coupled:
        return ""
    return exact


def _asked_and_tested(analysis: Any, family: Family, exact: str) -> str:
    """What a family asks of the joints, the values outside the limits, and the share of a test that failed."""
    shown, outside = restrict_to_limits(family, analysis.robot, limits=analysis.settings.limits)
    asked = _family_condition(analysis.robot, shown, exact)
    if outside:
        asked += f"; outside the limits: {outside}"
    if family.soundness.agree < family.soundness.tested:
        asked += f"; TESTED {share_text(family.soundness.agree, family.soundness.tested)}"
    return asked


def conditions_table(conditions: Any) -> Section:
    """One row per family of an exact derivation: rank, name, conditions."""
    rows, letters = [], False
    for family in conditions.families:
        text = "; ".join(condition_lines(family))
        short = len(text) <= _SHORT
        letters |= short and bool(exact_of(family).polynomials)
        rank = str(conditions.generic_rank - family.corank)
        name = family_title(conditions.robot, conditions.task, family)
        rows.append((rank, name, text if short else _of_joints(conditions.robot, family)))
    angles = angles_text(conditions.robot, conditions.shifts)
    return _table(conditions.robot, rows, conditions.letters if letters else {}, angles, None)


def _table(
    robot: Robot, rows: Sequence[tuple[str, ...]], letters: Mapping[str, float], angles: str,
    near: JointSpaceShares | None,
) -> Section:  # fmt: skip
    columns: tuple[str, ...] = ("rank", "family", "condition")
    named = joints_named(robot)
    after = [f"joints: {named}"] if named else []
    if letters:
        after.append(f"s2 = sin θ2, c23 = cos(θ2 + θ3); {letters_text(letters)}")
    if angles:
        after.append(f"in conditions {angles}")
    if near is not None:
        columns = (*columns, "near")
        if near.limits:
            where = "joint space inside the limits"
        else:
            where = "joint space"
        after.append(f"near: share of the {where} within {degrees(near.within):.4g}° of the family; {near_total(near)}")
    return Section("", columns=columns, rows=tuple(rows), texts=(1, 2), after=tuple(after))


def _family_condition(robot: Robot, family: Family, exact: str) -> str:
    """What a family asks of the joints: values of pinned joints in degrees, then the condition or the joints in it."""
    if not family.named:
        return "no condition found"
    names = symbols(robot)
    parts = [f"{names[pin.number - 1]} = {_values(robot, pin)}" for pin in family.pinned]
    if family.coupled:
        parts.append(exact or _function(names[number - 1] for number in family.coupled))
    return "; ".join(parts) or "every configuration"


def _function(names: Iterable[str]) -> str:
    """A condition that is too long for the table: "f(θ2, θ4, θ5) = 0"."""
    return f"f({', '.join(names)}) = 0"


def _values(robot: Robot, pin: Pin) -> str:
    """Values of a pinned joint: "0, π", "±π/2", "−95.19° or 84.81°", "0.25 m"."""
    exact = all("π" in text or text == "0" for text in map(pretty_angle, pin.values))
    simple = exact and robot.variables[pin.number - 1].unit == "rad"
    if simple:
        return values_text(pin.values)
    return values_in_degrees(robot, pin.number, pin.values)


def _of_joints(robot: Robot, family: Family) -> str:
    names = symbols(robot)
    parts = [pin.text() for pin in exact_of(family).pins]
    if family.coupled:
        parts.append(_function(names[joint - 1] for joint in family.coupled))
    return "; ".join(parts)


def lost_section(robot: Robot, task: Task, generic_rank: int, families: Sequence[Family]) -> Section | None:
    """What is lost on the families of the highest rank; None where there is none."""
    first = min((family.corank for family in families), default=0)
    mine = [family for family in families if family.corank == first]
    if not mine:
        return None
    lines = tuple(
        f"{family_label(robot, task, family)}: {'; '.join(lost_sentences(family.lost_freedoms))}" for family in mine
    )
    freedoms = chain.from_iterable(family.lost_freedoms for family in mine)
    note = lost_note(robot, freedoms)
    return Section(f"Lost at rank {generic_rank - first}", lines=lines, notes=(note,) if note else ())


def compared_sentence(names: Sequence[str], task: str, best: Mapping[str, Sequence[str]]) -> str:
    """Which of several arms is best, and by which measure.

    Args:
        names: of the arms.
        task: for which they are compared.
        best: measure in words -> names of the arms that are best by it within the error.

    Example:
        >>> compared_sentence(["ur5", "gp7"], "pose", {"largest σ": ["ur5", "gp7"]})
        'ur5 and gp7 do not differ within the error, for task pose.'
        >>> compared_sentence(["ur5", "gp7"], "pose", {"largest σ": ["ur5"]})
        'ur5 has the largest σ, for task pose.'
    """
    advantages = [f"{listing(arms)} {'has' if len(arms) == 1 else 'have'} the {measure}"
            for measure, arms in best.items() if 0 < len(arms) < len(names)]  # fmt: skip
    differences = "; ".join(advantages) or f"{listing(names)} do not differ within the error"
    return f"{differences}, for task {task}."


def compared_arms(names: Sequence[str], records: Sequence[Mapping[str, Any]]) -> Section:
    """Each of several arms in a line: its families by corank, or what could not be measured."""
    lines = tuple(f"{name}: {_measured_arm_words(record)}" for name, record in zip(names, records, strict=True))
    more = f"every family with its share, and how it was verified: {advise('full')}"
    return Section("Families", lines=lines, notes=(more,))


def _measured_arm_words(record: Mapping[str, Any]) -> str:
    if record["error"]:
        parts = [record["error"]]
    else:
        parts = []
    families = record.get("families", [])
    coranks = sorted({family["corank"] for family in families})
    for corank in coranks:
        mine = [family for family in families if family["corank"] == corank]
        named = ", ".join(dict.fromkeys(map(_label_of, mine)))
        parts.append(f"{named if corank == coranks[0] else len(mine)} (corank {corank})")
    if record.get("verdict", "verified") != "verified":
        parts += [record["sentence"]]
    return "; ".join(parts) or "no family of singularities was found"


def _label_of(family: dict[str, Any]) -> str:
    """The parts of the arm that a family of a comparison is about, else its short name."""
    about = family.get("about")  # since 0.3
    if about is None:
        parts = FamilyParts(())
    else:
        parts = FamilyParts(tuple(map(ArmPart, about["parts"])), about["either"], about["base"])
    return label_words(parts, name_of(family))


def assumed_line(conditions: Any) -> str:
    """How many assumptions on the lengths were made, and which of them does not hold."""
    wrong = [assumption.text for assumption in conditions.assumptions if not assumption.holds]
    if not conditions.assumptions:
        return ""
    if wrong:
        held = f"NOT true of this arm: {', '.join(wrong)}"
    else:
        held = "all true of this arm"
    return f"Derived under {count(len(conditions.assumptions), 'assumption')} on the lengths, {held}."


def more_line(seconds: float | None = None) -> str:
    """How to print the long form, and the time that the work took [s]; None where the result comes with rankdrop."""
    more = f"All conditions, lost motions and tests: {advise('full', python='print(result)')}."
    if seconds is None:
        return f"{more} {shipped_line()}"
    return f"{more} Time taken: {seconds:.1f} s."


def sigma_note(variants: int, wide: int, uncovered: int) -> str:
    """What the proven bounds of σ over a region say of a comparison: how many are wide, or have no lower bound."""
    note = "; worse only if wholly below another"
    if wide:
        note += f"; {wide:,} of {variants:,} intervals stayed wide within their budget and exclude little"
    if uncovered:
        note += f"; for {uncovered:,} it is not proven that every pose is reached: the lower bound is 0"
    return note


def slow_note(speed: float | None, turn_speed: float | None, width: float, *, bound: bool) -> str:
    """The speeds [m/s, rad/s] below which the tool is slow, and the widest 95 % interval of the shares.

    Args:
        speed: of straight translations; None where a file of an earlier version does not hold it.
        turn_speed: of rotations about the tool point; 0 or None for none.
        width: of the interval [1].
        bound: whether a share is a lower bound.
    """
    limits = []
    if speed is not None:
        limits.append(f"{1000 * speed:.4g} mm/s")
    if turn_speed:
        limits.append(f"{degrees(turn_speed):.3g}°/s")
    if limits:
        slower = f" (slower than {' or '.join(limits)})"
    else:
        slower = ""
    if bound:
        larger = "; the shares may be larger"
    else:
        larger = ""
    return f"{slower}; 95 % intervals up to {100 * width:.2g} % wide{larger}"


def slow_poses_note(speed: float, width: float) -> str:
    """The speed [m/s] below which the tool is slow, and the widest 95 % interval of the shares."""
    return f" (slower than {speed:.4g} m/s); 95 % intervals up to {100 * width:.2g} % wide"


def speed_section(analysis: Any) -> Section | None:
    """From which distance of a family the tool keeps a speed: one line per family, and where it is proven."""
    speeds = analysis.speeds
    if speeds is None:
        return None
    names = {family.id: family_label(analysis.robot, analysis.task, family) for family in analysis.families}
    pace = f"{1000 * speeds.tool_speed:.4g} mm/s"
    if analysis.slow is None:
        lines: tuple[str, ...] = ()
    else:
        lines = (slow_line(analysis.slow),)
    rows = [
        (
            distance.family,
            names.get(distance.family, ""),
            _joints_of(distance),
            _proven_distance(distance),
            _slower(distance),
        )
        for distance in speeds.distances
    ]
    return Section(
        f"Speed {pace}", "how far the arm has to stay from each family",
        columns=("", "family", "joints", f"keeps {pace} from", "slower found"), rows=tuple(rows), lines=lines,
        texts=(0, 1, 2, 3, 4), notes=tuple(_speed_notes(analysis.robot, speeds, names)),
    )  # fmt: skip


def _speed_notes(robot: Robot, speeds: Any, names: Mapping[str, str]) -> Iterator[str]:
    """For which motions and configurations the distances hold, and of which families there are none."""
    middle = degrees_text(speeds.around, (joint.unit for joint in robot.variables))
    yield "every straight motion of the tool, in any direction and without turning, at the joints' rate limits"
    yield (
        "proven by intervals for every configuration inside the joint limits and within "
        f"{degrees(speeds.span):.3g}° of {middle} in each joint"
    )
    if speeds.free:
        free = ", ".join(map(str, speeds.free))
        yield f"joint{'s' if len(speeds.free) > 1 else ''} {free}: any value, the speed does not depend on it"
    if any(distance.spent for distance in speeds.distances):
        yield "≤: the boxes allowed were spent, a smaller distance may hold"
    yield from _measure_notes(speeds.distances)
    if speeds.others:
        others = ", ".join(f"{names.get(other, '')} ({other})" for other in speeds.others)
        yield f"{others}: nothing proven, as no single distance measures several conditions on joints, or slides"


def _measure_notes(distances: Sequence[SpeedDistance]) -> Iterator[str]:
    """What distances of several joints count."""
    if any(distance.measure == "joints" for distance in distances):
        yield "several joints: the largest of their distances counts, one joint that stays away is enough"
    if any(distance.unit == "m" for distance in distances):
        yield (
            "mm: distance of the point in which the last two axes meet from the plane through axis 1 along axis 2; it "
            "is zero on the family"
        )
    if any(distance.unit == "1" for distance in distances):
        yield "|f|: f = 0 is the condition of the family, as listed above"
    residuals = [distance for distance in distances if distance.measure == "residual"]
    if residuals:
        ends = ", ".join(f"{distance.joint} to {degrees(distance.value):.4g}°" for distance in residuals)
        yield f"the region goes on to the family: {ends}".replace("-", "−")


def _joints_of(distance: SpeedDistance) -> str:
    """The joints that a distance is of: a name, or numbers."""
    if distance.measure == "joint":
        return distance.joint
    return ", ".join(map(str, distance.numbers))


def _proven_distance(distance: SpeedDistance) -> str:
    """The proven distance, rounded up: "from 8.7° off 0°"."""
    if distance.kept_from is None:
        return "nowhere proven"
    if distance.kept_from == 0.0:
        return "everywhere in the region"
    if distance.spent:
        sign = "≤ "
    else:
        sign = ""
    if distance.unit == "m":
        return f"{sign}{ceil(round(1e3 * distance.kept_from, 6))} mm"
    if distance.unit == "1":
        return f"{sign}|f| = {ceil(round(1e3 * distance.kept_from, 6)) / 1e3:.3f}"
    off = ceil(round(10 * degrees(distance.kept_from), 6)) / 10
    values = ", ".join(f"{degrees(value):.4g}°" for value in distance.values or (distance.value,))
    return f"{sign}{off:.1f}° from {values}".replace("-", "−")


def _slower(distance: SpeedDistance) -> str:
    """The slower configuration that is farthest: "248 mm/s at 8.5°"."""
    if distance.slower_at is None or distance.slower_speed is None:
        return ""
    if distance.unit == "m":
        away = f"{floor(1e3 * distance.slower_at)} mm"
    elif distance.unit == "1":
        away = f"|f| = {floor(1e3 * distance.slower_at) / 1e3:.3f}"
    else:
        away = f"{floor(10 * degrees(distance.slower_at)) / 10:.1f}°"
    return f"{floor(10_000 * distance.slower_speed) / 10:.1f} mm/s at {away}"
