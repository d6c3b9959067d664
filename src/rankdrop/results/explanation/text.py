"""An explanation in words: section by section, most useful first.

Last the parts that are shown only on demand, ellipsoids, redundancy, coordinates of the orientation; and what has to
hold on a family, one sentence each.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from math import degrees, isinf
from typing import TYPE_CHECKING

import numpy as np

from rankdrop.family.record import Family
from rankdrop.local.cofactors import Hunt
from rankdrop.results.codec import Record
from rankdrop.results.conditions_text import values_in_degrees
from rankdrop.results.explanation.failures import failures_part
from rankdrop.results.explanation.motion import answer, escape_part, far_part, proofs_part, rates_part
from rankdrop.results.explanation.words import (
    degrees_hint,
    fixed,
    minus,
    numbers,
    pitch_text,
    plural,
    power,
    short,
    vector,
    wrench_text,
)
from rankdrop.results.known import shipped_conditions_record
from rankdrop.robot.model import Robot
from rankdrop.sections import Section
from rankdrop.task import TIP, Task

if TYPE_CHECKING:
    from rankdrop.results.explanation.explanation import Explanation


TONE = {"regular": "good", "near": "warning", "singular": "bad", "always-singular": "bad"}
"""How the verdict is coloured."""
_FEWER = "a task with fewer rows (planar, position, …) asks only for what the arm is made for"
_TWIST = "v: velocity of the tool, at the link's origin where one is named [m/s]; ω: its turning [rad/s]"
_COUNTED = "nearly: turning by 1 rad counts as much as moving by 1 m"
_HUGE = 100.0  # an arm that reaches farther was hardly meant in m


def sentence_of(explanation: Explanation) -> str:
    """What may be claimed of one configuration; its word is `Explanation.verdict`."""
    differ = "; two methods differ on a detail, told at the end" if explanation.disagreements else ""
    return f"{explanation.robot.name}: {explanation.verdict.upper()}, {explanation.reason}{differ}."


def sections_of(explanation: Explanation, *, full: bool = False, parts: Sequence[str] = ()) -> tuple[Section, ...]:
    """The parts in the order in which they are asked for.

    Args:
        full: every detail; else what an engineer at a stopped robot needs.
        parts: names out of `PARTS` and `ANSWERS`; none: all of them, those in `DETAILS` only with `full`.
    """
    names = parts or [name for name in PARTS if full or name not in DETAILS]
    every = PARTS | ANSWERS
    return tuple(section for name in names for section in every[name](explanation, full))


def _hint(explanation: Explanation) -> Iterator[Section]:
    hint = degrees_hint(explanation.q, explanation.robot)
    if hint is not None:
        yield Section("Degrees?", "", (f"{hint}; --deg reads them as degrees, np.radians in Python",))


def _answer(explanation: Explanation, full: bool) -> Iterator[Section]:
    yield from _hint(explanation)
    lines = (*_warnings(explanation), *answer(explanation))
    yield Section(sentence_of(explanation), "", lines, notes=explanation.robot.notes, tone=TONE[explanation.verdict])


def _verdict(explanation: Explanation, full: bool) -> Iterator[Section]:
    rank, robot = explanation.rank, explanation.robot
    joints, r = robot.variables, rank.generic_rank
    sigma = ", ".join(short(value) if value > rank.sigma_error else "0" for value in rank.sigma)
    yield from _hint(explanation)
    told = f"rank {rank.rank} of {r}, corank {rank.corank}; " if rank.corank else ""
    lines = [
        *_warnings(explanation),
        f"{told}{_idle(explanation)} (nullity {rank.nullity})",
        f"σ = {sigma}  (each ± {power(rank.sigma_error)}; at or below {short(rank.tolerance)} is zero)",
        f"task {explanation.task.name}; σ has translation divided by {short(explanation.settings.length_scale)} m",
    ]
    names = [joint.name for joint in joints]
    if not all(name.endswith(str(number)) for number, name in enumerate(names, start=1)):
        lines.append("joints " + ", ".join(f"{number} {name}" for number, name in enumerate(names, start=1)))
    rows = [("rad, m" if any(joint.unit == "m" for joint in joints) else "rad", *map(fixed, explanation.q))]
    if any(joint.unit == "rad" for joint in joints):
        rows.append(("deg", *(_deg(value, joint.unit) for value, joint in zip(explanation.q, joints, strict=True))))
    yield Section(
        sentence_of(explanation), "", tuple(lines),
        ("joint", *(str(number) for number in range(1, robot.n + 1))), tuple(rows), notes=robot.notes,
        tone=TONE[explanation.verdict],
    )  # fmt: skip


def _idle(explanation: Explanation) -> str:
    """What the null space is to people."""
    count = explanation.rank.nullity
    what = "move the tool" if explanation.task.m == 6 else "change what the task asks for"
    if not count:
        return f"every joint motion {what.replace(' ', 's ', 1)}"
    return f"{count} {plural('way', count)} to move the joints {'does' if count == 1 else 'do'} not {what}"


def _warnings(explanation: Explanation) -> Iterator[str]:
    """Values that the arm cannot have."""
    reach = explanation.settings.length_scale
    if reach > _HUGE:
        yield f"lengths are divided by {short(reach)} m: are those of the robot file in mm?"
    for number, (joint, value) in enumerate(zip(explanation.robot.variables, explanation.q, strict=True), start=1):
        turns = joint.unit == "rad"
        at, low, high = (
            f"{short(degrees(x) if turns else x)}{'°' if turns else ' m'}" for x in (value, joint.lower, joint.upper)
        )
        if number in explanation.outside_limits:
            yield f"joint {number} at {at} is outside its limits, {low} … {high}"
        elif number in explanation.at_limits:
            yield f"joint {number} at {at} stands at a limit ({low} … {high})"


def _which(explanation: Explanation, full: bool) -> Iterator[Section]:
    special = [relation.words for relation in explanation.relations if not relation.structural]
    always = [relation.words for relation in explanation.relations if relation.structural]
    if not explanation.met and not full:
        return
    own = [met for met in explanation.met if met.family.corank == explanation.met[0].family.corank]
    others = [met.family.name for met in explanation.met if met not in own]
    lines = []
    for met in own:
        lines.append(f"{met.family.name}  (corank {met.family.corank}, dimension {met.family.dimension}; {met.source})")
        lines.append(f"    {'; '.join(condition_sentences(explanation.robot, explanation.task, met.family))}")
    if others:
        lines.append(f"lies on: {'; '.join(others)}")
    if special:
        lines.append(f"here: {'; '.join(special)}")
    notes = (f"at every configuration: {'; '.join(always)}",) if always else ()
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
        for seen in lost.seen:
            lines.append(f"  in {seen.axes}: {', '.join(seen.constraints)}")
            lines += [f"      {'; '.join(told)}" for told in [[one for one in seen.short if one]] if told]
        if full:
            lines.append(f"In the {_seen(explanation)}:")
            for direction, twist, wrench in zip(
                lost.framed.directions, lost.twist_screws, lost.wrench_screws, strict=True
            ):
                lines.append(f"  lost twist {vector(direction)}: {pitch_text(twist.pitch)}")
                torque = "with hardly any joint torque" if miss else "without joint torque"
                lines.append(f"      carried {torque}: {wrench_text(wrench)}")
        title = "What is lost" if explanation.rank.corank else "What is nearly lost"
        nearly = any(one.startswith("nearly") for seen in lost.seen for one in seen.short)
        notes = (_TWIST, *((_COUNTED,) if nearly else ()))
        yield Section(title, _focus(explanation), tuple(lines), notes=notes)
    if len(lost.never):
        rows = tuple(tuple(short(round(float(value), 4) + 0.0) for value in row) for row in lost.never)
        yield Section("Never possible", "twists that this arm makes nowhere around here",
                      columns=("vx", "vy", "vz", "ωx", "ωy", "ωz"), rows=rows, texts=(), notes=(_FEWER,))  # fmt: skip


def _seen(explanation: Explanation) -> str:
    """In which axes the directions are, and which point they refer to."""
    assert explanation.lost.framed is not None
    frame, name = explanation.lost.framed.frame, explanation.lost.framed.name
    at_tip = frame.origin == TIP and not any(frame.point)
    return f"axes of {name}" + (", reference point at the tool" if at_tip else "")


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
        yield _hunt(blame.hunt)


def _hunt(hunt: Hunt) -> Section:
    rows = tuple(
        (str(one.number), short(round(one.share, 4)), "yes" if one.named else "no", "yes" if one.actuator else "no",
         short(round(abs(one.rate), 4)) if one.tells else "no", "yes" if one.escapes else "no")
        for one in hunt.joints
    )  # fmt: skip
    return Section(
        "Hunt's cofactors beside GR's rules", "", (hunt.words,),
        columns=("joint", "column", "named", "GR's actuator", "leads out, rate", "by finite motion") if rows else (),
        rows=rows,
    )  # fmt: skip


def _dependencies(explanation: Explanation) -> str:
    usual = explanation.robot.n - explanation.rank.generic_rank
    text = "smallest sets of joints with dependent screws"
    if usual:
        corank = explanation.met[0].family.corank if explanation.met else explanation.rank.corank
        text += f"; {usual + corank} dependencies here, {usual} almost everywhere"
    return text


def _closing(explanation: Explanation, full: bool) -> Iterator[Section]:
    if explanation.disagreements:
        yield Section("Disagreement", "two methods differ; please report it", explanation.disagreements)


def _more(explanation: Explanation, full: bool) -> Iterator[Section]:
    if not full:
        yield Section("", "", notes=("more with --full: circuits, ellipsoids, rates, redundancy, representation",))


def _fuller(explanation: Explanation, full: bool) -> Iterator[Section]:
    yield Section(
        "", "", notes=("more with --full: every joint, joints to blame, tables of Hunt and of GR",)
    )


def _last(explanation: Explanation, full: bool) -> Iterator[Section]:
    yield Section(sentence_of(explanation), tone=TONE[explanation.verdict])


def _deg(value: float, unit: str) -> str:
    return "" if unit == "m" else minus(f"{degrees(value) + 0.0:.2f}")


def ellipsoids_part(explanation: Explanation, full: bool) -> Iterator[Section]:
    """Velocity and force ellipsoids with their indices, for unit joint rates and for the velocity limits."""
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


def redundancy_part(explanation: Explanation, full: bool) -> Iterator[Section]:
    """Null space, rank–nullity, both forms of the projector."""
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


def representation_part(explanation: Explanation, full: bool) -> Iterator[Section]:
    """Coordinates of the orientation and their own singularities."""
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


DETAIL_PARTS: dict[str, Callable[[Explanation, bool], Iterator[Section]]] = {
    "proofs": proofs_part,
    "ellipsoids": ellipsoids_part,
    "redundancy": redundancy_part,
    "representation": representation_part,
}
"""They by their names, in order."""

PARTS: dict[str, Callable[[Explanation, bool], Iterator[Section]]] = {
    "verdict": _verdict,
    "which": _which,
    "lost": _lost,
    "blame": _blame,
    "escape": escape_part,
    "far": far_part,
    "rates": rates_part,
    "failures": failures_part,
    **DETAIL_PARTS,
    "closing": _closing,
    "more": _more,
    "last": _last,
}
"""Every part by its name, in order."""
ANSWERS: dict[str, Callable[[Explanation, bool], Iterator[Section]]] = {"answer": _answer, "fuller": _fuller}
"""Parts that are shown by name only: the verdict with the way out in sentences, and what more there is to see."""
DETAILS = frozenset(DETAIL_PARTS)
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
    pins = [
        f"{_symbol(robot, one.number)} = {values_in_degrees(robot, one.number, one.values)}" for one in family.pinned
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


def _symbol(robot: Robot, number: int) -> str:
    return f"{'θ' if robot.variables[number - 1].unit == 'rad' else 'q'}{number}"


def _joints(texts: Sequence[str]) -> list[int]:
    """Joints that conditions are about: θ3, q2, s3, c23 for the sum of two."""
    found: set[int] = set()
    for text in texts:
        found |= {int(number) for number in re.findall(r"[θq](\d+)", text)}
        for digits in re.findall(r"\b[sc](\d+)\b", text):
            found |= {int(digit) for digit in digits}
    return sorted(found)
