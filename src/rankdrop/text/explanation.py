"""An explanation in words: the answer in five lines, then section by section in the order of use.

Last the parts that are shown on demand: joint rates, failures, ellipsoids, redundancy, coordinates of the orientation,
singular values and joint angles.

Columns of a table of records stand in tables: heading and cell.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain
from math import degrees, isinf
from operator import attrgetter
from typing import Any

import numpy as np

from rankdrop.configuration import Cause, configuration_at
from rankdrop.families.incidence import Incidence
from rankdrop.kinematics import pose
from rankdrop.lists import flat_map
from rankdrop.local.ellipsoids import PartSet
from rankdrop.local.pointing import place_alone, pointing_task, tool_stays_level, turn_follows
from rankdrop.local.rates import DirectionRates
from rankdrop.options import advise
from rankdrop.results.explained import Blame
from rankdrop.results.explanation import Explanation
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Formula, Section
from rankdrop.task import BASE, TIP, resolve_task
from rankdrop.text.distances import far_sections, nearest_sections
from rankdrop.text.family_conditions import condition_sentences
from rankdrop.text.inverse import tool_sentence
from rankdrop.text.joint_values import fixed_point
from rankdrop.text.lost_directions import focus_words, lost_sections, never_sections
from rankdrop.text.procedure import hunt_words
from rankdrop.text.robots import notes_words
from rankdrop.text.special import family_title, special_words
from rankdrop.text.verdict import SINGULAR_HERE as SINGULAR_HERE
from rankdrop.text.verdict import degrees_words, motions_words, summary_lines
from rankdrop.text.verdict import difference_sentence as difference_sentence
from rankdrop.text.verdict import reason_of as reason_of
from rankdrop.text.ways_out import escape_sections, proof_sections
from rankdrop.text.words import (
    CHECKED_POINTING,
    NEVER_HERE,
    NEVER_TILTS,
    NEVER_TURNS,
    PLACES_ALONE,
    POINTING_HERE,
    degrees_hint,
    failures_table,
    joint_word,
    numbers,
    plural,
    power,
    short,
    vector,
)

TONE = {"regular": "good", "near": "warning", "singular": "bad", "always-singular": "bad"}
"""How the verdict is coloured."""
_HUGE = 100.0  # an arm that reaches farther was hardly meant in m

_FOUR, _POSE_ROWS = 4, 6

Columns = dict[str, Callable[[Any], str]]
"""Heading -> the cell of a record."""

_CIRCUITS: Columns = {
    "joints": lambda circuit: numbers(circuit.numbers), "when": lambda circuit: "always" if circuit.generic else "here",
    "joint rates that cancel": lambda circuit: vector(circuit.coefficients), "in words": attrgetter("words"),
}  # fmt: skip

_SHAPES: Columns = {
    "": attrgetter("name"), "velocity half-axes": lambda part: _lengths(part.velocity.half_lengths),
    "force half-axes": lambda part: _lengths(part.force.half_lengths),
    "σ_min": lambda part: short(part.sigma_min.value),
    "condition": lambda part: short(part.condition.value),
    "manipulability": lambda part: short(part.manipulability.value),
}  # fmt: skip

_COORDINATES: Columns = {
    "name": attrgetter("name"),
    "value [rad, 1]": lambda form: ", ".join(
        f"{name} {short(value)}" for name, value in zip(form.names, form.coordinates, strict=True)),
    "σ_min of E": lambda form: short(round(form.sigma_min, 12)),
    "nearest singularity": lambda form: "none" if isinf(form.angle) else f"{degrees(form.angle):.3g}°",
    "verdict": lambda form: "SINGULAR" if form.singular else "near" if form.near else "",
}  # fmt: skip

DETAILS = frozenset(
    ("nearest", "blame", "proofs", "rates", "failures", "ellipsoids", "redundancy", "representation", "numbers", "more")
)
"""Parts that are shown only on demand."""


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
        yield Section("Degrees?", "", (f"{hint}; {advise('deg', python='np.radians(q)')} reads them as degrees",))
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
    if place_alone(robot, task):
        yield f"{PLACES_ALONE.format(robot.n)}."
        return
    other = pointing_task(robot, task)
    if other is not None:
        measured = configuration_at(robot, explanation.q, other, explanation.here.tolerances).measured
        if measured.corank:
            verdict = "singular"
        else:
            verdict = "regular"
        asked = advise("task", other.name)
        words = POINTING_HERE.format(task=asked, verdict=verdict, rank=measured.rank, r=measured.generic_rank)
        yield f"{NEVER_TURNS.format(robot.n)}. {words}."
    elif len(explanation.lost.never) and explanation.cause != Cause.NEVER:
        motions = motions_words(explanation.lost.never.tolist())
        yield f"{NEVER_HERE.format(motions=motions, r=rank.generic_rank, m=task.m)}."
        yield from _position_lines(explanation)


def _position_lines(explanation: Explanation) -> Iterator[str]:
    """That an arm of four joints is singular for the position of its tool, which the pose does not show."""
    robot, task = explanation.robot, explanation.task
    if robot.n != _FOUR or task.m != _POSE_ROWS:
        return
    place = replace(resolve_task("position", robot, frame=task.frame), length_scale=task.length_scale)
    measured = configuration_at(robot, explanation.q, place, explanation.here.tolerances).measured
    if measured.corank and not explanation.rank.corank:
        asked = advise("task", place.name)
        yield f"For position alone ({asked}) it is singular here, rank {measured.rank} of {measured.generic_rank}."


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
    yield Section("Numbers", "", tuple(lines), columns, _joint_values(robot, explanation.q),
                  notes=notes_words(robot.notes))  # fmt: skip


def _joint_values(robot: Robot, q: Array) -> tuple[tuple[str, ...], ...]:
    """The joint values as a row of a table, and those of revolute joints in degrees as a second one."""
    joints = robot.variables
    unit = "rad"
    if any(joint.unit == "m" for joint in joints):
        unit = "rad, m"
    first = (unit, *map(fixed_point, q))
    if not any(joint.unit == "rad" for joint in joints):
        return (first,)
    second = ["deg"]
    for joint, value in zip(joints, np.degrees(q), strict=True):
        if joint.unit == "m":
            second.append("")
        else:
            second.append(fixed_point(float(value), 2))
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
            turned = ", ".join(f"joint {i} at {degrees_words(value)}" for i, value in explanation.same_inside)
            inside = dict(explanation.same_inside)
            rest = [number for number in explanation.outside_limits if number not in inside]
            if rest:
                none = f"none of {plural('joint', len(rest))} {numbers(rest)}"
                yield f"the same angle inside the limits: {turned}; {none}"
            else:
                yield f"the same posture inside the limits: {turned}"


def _limit_words(explanation: Explanation) -> Iterator[str]:
    """Each joint that is outside its limits or stands at one, with its value and the limits."""
    inside = dict(explanation.same_inside)
    for number, (joint, value) in enumerate(zip(explanation.robot.variables, explanation.q, strict=True), start=1):
        at, low, high = (_angle_or_length(x, joint.unit) for x in (value, joint.lower, joint.upper))
        if number in explanation.outside_limits:
            same = ""
            if number in inside:
                same = f"; {degrees_words(inside[number])} is the same angle inside them"
            yield f"{joint_word(number, joint.name)} at {at} is outside its limits, {low} … {high}{same}"
        elif number in explanation.at_limits:
            yield f"{joint_word(number, joint.name)} at {at} stands at a limit ({low} … {high})"


def _angle_or_length(value: float, unit: str) -> str:
    """The value of a joint: "12.3°", "0.25 m"; no rounding as in −3e−16°."""
    if unit == "rad":
        return f"{short(round(degrees(value), 9) + 0.0)}°"
    return f"{short(value)} m"


def _list_line(head: str, items: Iterable[str]) -> tuple[str, ...]:
    """One line that lists things; none where there are none."""
    texts = "; ".join(items)
    if texts:
        return (f"{head}: {texts}",)
    return ()


def _family_section(explanation: Explanation, full: bool) -> Iterator[Section]:
    met, notes = explanation.met, tuple[str, ...]()
    same_corank = [incidence for incidence in met if incidence.family.corank == met[0].family.corank]
    lines: list[str] = []
    for incidence in same_corank[: None if full else 2]:
        lines += _family_lines(explanation, incidence, full)
    if full:
        lines += _list_line("lies on", (incidence.family.name for incidence in met if incidence not in same_corank))
        lines += _list_line("here", (relation.words for relation in explanation.relations if not relation.structural))
        structural = (relation.words for relation in explanation.relations if relation.structural)
        notes = _list_line("at every configuration", structural)
    if lines or notes:
        yield Section("Which singularity" if met else "Axes", focus_words(explanation), tuple(lines), notes=notes)


def _family_lines(explanation: Explanation, incidence: Incidence, full: bool) -> tuple[str, str]:
    """A family through q: its title, with `full` its corank, dimension and source; and the conditions on it."""
    family, robot, task = incidence.family, explanation.robot, explanation.task
    title = family_title(robot, task, family)
    conditions = "; ".join(condition_sentences(robot, task, family))
    if not full:
        return title, Formula(conditions)
    title = f"{title}  (corank {family.corank}, dimension {family.dimension}; {incidence.source})"
    return title, Formula(f"    {conditions}")


def _table(records: Iterable[Any], columns: Columns) -> dict[str, Any]:
    """Columns and rows of a section."""
    return {"columns": tuple(columns), "rows": tuple(_row(record, columns) for record in records)}


def _row(record: Any, columns: Columns) -> tuple[str, ...]:
    """The cells of a record."""
    return tuple(cell(record) for cell in columns.values())


def _yes(holds: bool) -> str:
    return "yes" if holds else "no"


_RUNS: Columns = {
    "joints": lambda run: f"{run.first}–{run.last}", "dimension": lambda run: str(run.dimension),
    "loss": lambda run: str(run.loss), "their test": lambda run: _yes(run.msos),
    "minimal": lambda run: _yes(run.minimal),
}  # fmt: skip
_HUNT: Columns = {
    "joint": lambda joint: str(joint.number), "column": lambda joint: short(round(joint.share, 4)),
    "named": lambda joint: _yes(joint.named), "GR's actuator": lambda joint: _yes(joint.actuator),
    "leads out, rate": lambda joint: short(round(abs(joint.rate), 4)) if joint.tells else "no",
    "by finite motion": lambda joint: _yes(joint.escapes),
}  # fmt: skip


def _blame(explanation: Explanation, full: bool) -> Iterator[Section]:
    blame = explanation.blame
    lines = [circuit.words for circuit in blame.smallest]
    lines += [system.words for system in blame.systems if system.permanent or full]
    if blame.always:
        lines.append(f"deficient at every configuration: {blame.always}")
    if not blame.complete and not blame.circuits:
        lines.append("the chain is too long to list dependent sets of joints")
    if lines:
        yield Section("Joints to blame", _dependencies(explanation) if blame.smallest else "", tuple(lines))
    if full:
        yield from _blame_tables(blame)


def _blame_tables(blame: Blame) -> Iterator[Section]:
    """Every circuit, the singular runs of joints, and Hunt's cofactors."""
    if blame.circuits:
        if blame.complete:
            heading = "Every circuit"
        else:
            heading = f"The first {len(blame.circuits):,} circuits"
        yield Section(heading, "dependent sets of joints without a smaller one inside",
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


def unit_balls(parts: PartSet) -> str:
    """The unit balls of joint rates and of joint torques: "Σ q̇² ≤ (1 rad/s)²; Σ τ² ≤ (1 N m)²"."""
    if parts.by_limits:
        return "Σ (q̇/limit)² ≤ 1; Σ (τ · limit)² ≤ (1 W)²"
    rates, torques = "Σ q̇² ≤ (1 rad/s)²", "Σ τ² ≤ (1 N m)²"
    if parts.slide_length is None:
        return f"{rates}; {torques}"
    return f"{rates}, slides in units of {parts.slide_length:.4g} m; {torques}"


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
    rows = tuple(tuple(fixed_point(value) for value in row) for row in spare.null_basis)
    columns = tuple(f"{number} {joint.name}" for number, joint in enumerate(explanation.robot.variables, start=1))
    title = "Joint motions that leave the task still"
    yield Section(title, "" if rows else "none", tuple(lines), columns if rows else (), rows, texts=(),
                  notes=("rows: joint rates [rad/s, m/s], to first order",) if rows else ())  # fmt: skip


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
    notes = [f"Note: {note}" for note in notes_words(robot.notes) if not full]
    yield Section("", "", (tool_sentence(robot, pose(robot, explanation.q)), *notes))


def _more(_: Explanation, full: bool) -> Iterator[Section]:
    """What else there is, where it is not printed."""
    if not full:
        there = "joint rates, failures, σ and angles, circuits, redundancy, …"
        yield Section("", "", notes=(f"more with {advise('full')}: {there}",))


PARTS: dict[str, Callable[[Explanation, bool], Iterator[Section]]] = {
    "summary": _summary,
    "which": _family_section,
    "lost": lambda explanation, full: chain(lost_sections(explanation, full), never_sections(explanation, full)),
    "escape": escape_sections,
    "far": far_sections,
    "nearest": nearest_sections,
    "blame": _blame,
    "proofs": proof_sections,
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
