"""Distance to the nearest singularity and to each family, with the proven bound."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

from rankdrop.distance.distance import FamilyDistance
from rankdrop.local.nearest import Nearest
from rankdrop.options import advise
from rankdrop.results.explanation import Explanation
from rankdrop.sections import Section
from rankdrop.text.special import family_title
from rankdrop.text.words import (
    MORE_NEAREST,
    MOTION_TO_IT,
    angle,
    angle_below,
    joint_word,
    motion,
    power,
)


def far_sections(explanation: Explanation, full: bool) -> Iterator[Section]:
    """The nearest singular configuration, the proven distance, and the nearest families."""
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
        return [(angle(near.distance), family_title(robot, task, near.family)) for near in far.families[:2]]
    rows = []
    if far.nearest is not None and not _is_a_family(far.nearest, far.families):
        rows.append((angle(far.nearest.distance), "the nearest", *_deltas(far.nearest.delta, units)))
    for near in far.families:
        name = f"{family_title(robot, task, near.family)} (corank {near.family.corank})"
        rows.append((angle(near.distance), name, *_deltas(near.delta, units)))
    return rows


def _how_far(explanation: Explanation) -> str:
    if explanation.rank.corank:
        return "How far the next one is"
    return "How far"


def nearest_sections(explanation: Explanation, full: bool) -> Iterator[Section]:
    """How far: the nearest configuration with the motion to it, what is proven, the distance to each family."""
    if full:
        yield from far_sections(explanation, full)
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
    rows = tuple((angle(near.distance), f"{title(near.family)} (corank {near.family.corank})") for near in far.families)
    if lines or rows:
        columns = ("distance", "family") if rows else ()
        more = MORE_NEAREST.format(advise("full"))
        yield Section(_how_far(explanation), "", tuple(lines), columns, rows, (0, 1), notes=(more,))


def _is_a_family(nearest: Nearest, families: Sequence[FamilyDistance]) -> bool:
    return any(near.distance <= nearest.distance * (1 + 1e-9) for near in families)


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
