"""How to get out of a singularity, or away from one: joints, motions, and the proofs of what holds."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rankdrop.local.jog import WORTH
from rankdrop.local.ways_out import Direction, Escape, JointEscape
from rankdrop.results.explanation import Explanation
from rankdrop.sections import Section
from rankdrop.text.words import (
    PROOF,
    avoidable_words,
    boundary_words,
    lost_type,
    motion,
    numbers,
    plural,
    short,
    superscript,
)

_SHOWN = 3  # ways out and families
IDLE = 0.01
"""Away from a singularity: a joint whose rate is below this share of the best does not help."""
NO_RATE = 1e-12
"""A rate or a step below it is rounding."""
SHARE = 0.02
"""A joint that moves less than this share of the fastest is left out of a direction."""


_ANSWER = {True: "yes", False: "no", None: "not known"}

_ORDER = "order p, rate c: σ grows as c·tᵖ; carries out: the screws that the motion takes out of the dependency"


def sections_of(out: Escape) -> tuple[Section, ...]:
    """For notebooks: per joint what it does alone, then the best direction and the self-motion."""
    best = out.best_direction
    delta = ", ".join(f"{x:+.4g}" for x in best.delta)
    section = Section(
        "Ways out", f"corank {out.corank}",
        columns=(
            "joint", "order", "rank gained", "σ grows by [1/rad, 1/m]", "step [rad, m]", "σ then", "within limits",
        ),
        rows=tuple(map(_notebook_row, out.single)), texts=(0, 1, 6),
        after=(
            f"best direction Δq = ({delta}) [rad, m]: σ = {best.sigma_after:.4g}",
            f"with the tool held still: {_ANSWER[out.avoidable]} ({out.avoidable_reason})",
            f"at an edge of the reach: {_ANSWER[out.boundary]} ({out.boundary_reason})",
        ),
    )  # fmt: skip
    return (section,)


def _notebook_row(alone: JointEscape) -> tuple[str, ...]:
    """What a joint does alone."""
    order, limits = "never", "no"
    if alone.order is not None:
        order = str(alone.order)
    if alone.within_limits:
        limits = "yes"
    return (
        f"{alone.number} {alone.joint}", order, str(alone.gain), f"{alone.rate:.4g}", f"{alone.step:+.4g}",
        f"{alone.sigma_after:.4g}", limits,
    )  # fmt: skip


def escape_sections(explanation: Explanation, full: bool) -> Iterator[Section]:
    """Joints that lead out, best first; then the best motions of several, and what is known of the end effector."""
    if explanation.rank.corank:
        yield _out(explanation, full)
    elif full or any(abs(joint.rate) > NO_RATE for joint in explanation.escape.single):
        yield _single_joints_section(explanation, full)


def _out(explanation: Explanation, full: bool) -> Section:
    out, r = explanation.escape, explanation.rank.generic_rank
    helpful = [joint for joint in out.single if joint.order is not None]
    rows = tuple(_joint_row(explanation, joint) for joint in (out.single if full else helpful[:_SHOWN]))
    columns: tuple[str, ...] = ("joint", "order", f"σ{r} grows by", "try", f"σ{r} then", "carries out")
    if not full:
        columns, rows = (columns[0], *columns[3:5]), tuple((row[0], *row[3:5]) for row in rows)
    return Section("How to get out", "one joint alone, best first" if rows else "", (), columns, rows,
                   (0, 5) if full else (0,), tuple(_ways_out(explanation, full, alone=bool(helpful))),
                   (_ORDER,) * bool(rows and full))  # fmt: skip


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
    for kind in dict.fromkeys(lost.type for lost in out.types):
        which = [i for i, lost in enumerate(out.types, start=1) if lost.type == kind]
        words = lost_type(kind, _lost_numbered(which, len(out.types)))
        yield _sentence(f"{slowly}{words}")


def proof_sections(explanation: Explanation, full: bool) -> Iterator[Section]:
    """Theorems behind the statements on ways out."""
    out = explanation.escape
    said: dict[str | int, str] = {out.avoidable_reason: avoidable_words(out)}
    said |= {lost.type: lost_type(lost.type) for lost in out.types}
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


def _single_joints_section(explanation: Explanation, full: bool) -> Section:
    out, r = explanation.escape, explanation.rank.generic_rank
    sigma = float(explanation.rank.sigma[r - 1])
    best = max(abs(joint.rate) for joint in out.single)
    helpful = [
        joint
        for joint in out.single
        if abs(joint.rate) > max(IDLE * best, NO_RATE) and joint.sigma_after >= WORTH * sigma
    ]
    rows = tuple(
        (f"{joint.number} {joint.joint}", *_rate_and_step(explanation, joint))
        for joint in (out.single if full else helpful[:_SHOWN])
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
        per = f"{unit}{superscript(order)}"
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
