"""Parts of the arm that are special at a singular configuration, in words: "wrist: joint 5 near 0°"."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import degrees, radians

import numpy as np

from rankdrop.families.name import Detail, FamilyName
from rankdrop.families.parts import FamilyParts, parts_of
from rankdrop.families.record import Family
from rankdrop.local.special import Shape, Special, specials_at
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.text.names import name_words
from rankdrop.text.words import joint_word, listing, short

_NEAR = radians(20.0)
"""Up to this angle a condition is nearly satisfied; the angle itself is stated beyond it."""
_WORDS = {
    Shape.JOINT: "{joint} at {value}",
    Shape.STRETCHED: "arm stretched",
    Shape.FOLDED: "arm folded",
    Shape.ABOVE_AXIS: "wrist above axis {axis}",
    Shape.ON_AXIS: "wrist on axis {axis}",
    Shape.TIP_ABOVE_AXIS: "tip above axis {axis}",
    Shape.TIP_ON_AXIS: "tip on axis {axis}",
}
_NEARLY = {
    Shape.JOINT: "{joint} near {value}",
    Shape.STRETCHED: "arm nearly stretched",
    Shape.FOLDED: "arm nearly folded",
    Shape.ABOVE_AXIS: "wrist nearly above axis {axis}",
    Shape.TIP_ABOVE_AXIS: "tip nearly above axis {axis}",
}
_FAR = {
    Shape.JOINT: "{joint} {off} from {value}",
    Shape.STRETCHED: "arm {off} from stretched",
    Shape.FOLDED: "arm {off} from folded",
    Shape.ABOVE_AXIS: "wrist {off} from above axis {axis}",
    Shape.TIP_ABOVE_AXIS: "tip {off} from above axis {axis}",
}


def special_words(specials: Sequence[Special], names: Sequence[str] = ()) -> str:
    """The parts, and what is special about them where there are at most two; "" without any.

    Args:
        specials: of one configuration.
        names: of all joints, in order: a joint is called by its name where that has another number.
    """
    if len(specials) > 2:
        details = ""
    else:
        details = ", ".join(_detail(special, names) for special in specials)
    return parts_words(specials) + (f": {details}" if details else "")


def parts_words(specials: Sequence[Special]) -> str:
    """The parts alone: "shoulder and wrist"."""
    *first, last = list(dict.fromkeys(special.part.value for special in specials)) or [""]
    if first:
        return f"{', '.join(first)} and {last}"
    return last


def _detail(special: Special, names: Sequence[str]) -> str:
    if names and special.joint:
        joint = joint_word(special.joint, names[special.joint - 1])
    else:
        joint = f"joint {special.joint}"
    if special.exact:
        words = _WORDS
    elif special.off <= _NEAR:
        words = _NEARLY
    else:
        words = _FAR
    value = round(degrees(special.value), 1) + 0.0
    shown, off = f"{short(180.0 if value == -180.0 else value, 4)}°", f"{short(degrees(special.off), 2)}°"
    return words[special.shape].format(joint=joint, axis=special.joint, value=shown, off=off)


def names_no_reason(specials: Sequence[Special], family: Family) -> bool:
    """Whether the parts are all far from their conditions and the family has a relation of axes that says more.

    A leg with axis 1 parallel to 3, 4, 5 (joint 2 at 90°) would be called "elbow: arm 21° from folded".
    """
    related = any(isinstance(detail, Detail) for detail in family.called.details)
    return bool(specials) and related and all(special.off > _NEAR for special in specials)


def place_name(robot: Robot, task: Task, family: Family) -> str:
    """The part of the arm that is special at the witness, as `explain` names it; the family's name without any."""
    q = np.asarray(family.witness, dtype=np.float64)
    return place_words(robot, task, q, family.corank) or family.name


def place_words(robot: Robot, task: Task, q: Array, corank: int = 1) -> str:
    """The part of the arm that is special at a singular configuration q (n,), as `explain` names it; "" without any."""
    names = [joint.name for joint in robot.variables]
    return special_words(specials_at(robot, task, q, corank), names)


def place_parts(robot: Robot, task: Task, q: Array, corank: int) -> str:
    """The parts of the arm that are special at a singular configuration q (n,) alone."""
    return parts_words(specials_at(robot, task, q, corank))


def family_label(robot: Robot, task: Task, family: Family) -> str:
    """A family in a word or two: the parts of the arm, else its short name.

    "shoulder and elbow", "base and wrist", or for one condition near several places "shoulder, elbow or wrist".
    """
    return label_words(parts_of(robot, task, family), family.called)


def label_words(parts: FamilyParts, name: FamilyName) -> str:
    """The parts of the arm that a family is about, else its short name."""
    return _words_of_parts(parts) or name.short


def family_title(robot: Robot, task: Task, family: Family) -> str:
    """The name of a family with the parts of the arm in front: "elbow: axes 3 and 5 aligned"."""
    family_parts = parts_of(robot, task, family)
    if family.called.parts == family_parts.parts:
        return family.name
    if family.called.parts:
        return name_words(replace(family.called, parts=family_parts.parts))
    parts = _words_of_parts(family_parts)
    if not parts:
        return family.name
    return f"{parts}: {family.name}"


def _words_of_parts(parts: FamilyParts) -> str:
    """The parts of the arm that a family is about in words; "" where none is known."""
    words = [part.value for part in parts.parts]
    if parts.either:
        words = [f"{', '.join(words[:-1])} or {words[-1]}"]
    return listing(["base"] * parts.base + words)
