"""The parts of the arm that a family is about, measured at its members: for names that hold axes alone.

The name of a family has a part where a fact about the axes belongs to one (`rankdrop.families.naming`). An arm with
offsets has long conditions instead, with sheets that pass near the special places of the ideal arm, and an arm on a
mobile base has axes of the base among its own. Both are read off the special places of members
(`rankdrop.local.special`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from rankdrop.families.name import ArmPart
from rankdrop.families.record import Family
from rankdrop.local.axes import Scene
from rankdrop.local.special import ARM_AXES, ON_JOINTS, Special, exact_at, measured_at, specials_at
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.units import in_metres, task_in_metres

_MEMBERS = 48
_RARE = 0.1  # a part that is nearest at fewer of the members is not named
_MOST = 0.5  # unless it is nearest at more of the members that are solved from places where its own condition holds


@dataclass(frozen=True, slots=True)
class FamilyParts:
    """Which parts of the arm a family is about.

    Attributes:
        parts: from the base to the tool; empty where nothing is known.
        either: the family is one condition, and each of its members is near the special place of one of the parts;
            else all of them are special at every member.
        base: the family binds a joint of the base that carries the arm: one before its last seven axes.
    """

    parts: tuple[ArmPart, ...]
    either: bool = False
    base: bool = False


def parts_of(robot: Robot, task: Task, family: Family) -> FamilyParts:
    """The parts of the arm that a family is about: those of its name, else those that are special at its members.

    Where several freedoms are lost, parts that are special at every member are listed in addition to those of the name:
    a fact about the axes may tell of one part what two parts lose. A part is special where its condition holds exactly
    at every member. Without one, and with one freedom lost, the parts nearest to their conditions at a tenth of the
    members or more are listed, as alternatives; and a part that is nearest at half of the members solved from places
    where its joint has the value of its condition: few members of a family are near the elbow of a Gen3 by chance.

    Args:
        robot, task: the arm.
        family: of this arm and task.

    Example:
        >>> from rankdrop.results.known import shipped
        >>> found = shipped("crx10ial")
        >>> parts = parts_of(found.robot, found.task, found.families[0])
        >>> [part.value for part in parts.parts], parts.either
        (['shoulder', 'elbow', 'wrist'], True)
    """
    base = _binds_base(robot, family)
    named = family.called.parts
    if _is_settled(family):
        return FamilyParts(named, base=base)
    here, rows = in_metres(robot), task_in_metres(task, robot)
    members = _members_of(robot, task, family)
    seen = [specials_at(here, rows, q, family.corank) for q in members]
    exact = _in_order(part.value for part in (*named, *_special_everywhere(seen)))
    if exact or family.corank > 1:
        return FamilyParts(exact, base=base)
    together = _special_everywhere([exact_at(here, rows, q) for q in members])
    if together:
        return FamilyParts(together, base=base)
    nearest = _nearest_somewhere(robot, task, family, seen)
    return FamilyParts(nearest, len(nearest) > 1, base)


def _is_settled(family: Family) -> bool:
    """Whether the name of a family says all that is said of its parts."""
    name = family.called
    return bool(name.given) or name.unnamed or (bool(name.parts) and family.corank == 1)


def _special_everywhere(seen: Sequence[Sequence[Special]]) -> tuple[ArmPart, ...]:
    """The parts that are exactly special at every member, given the special places seen at each."""
    if not seen:
        return ()
    names = [{special.part.value for special in specials if special.exact} for specials in seen]
    return _in_order(set.intersection(*names))


def _nearest_somewhere(
    robot: Robot, task: Task, family: Family, seen: Sequence[Sequence[Special]]
) -> tuple[ArmPart, ...]:
    """The parts that are nearest to their conditions at members seen, or at most of those where one starts there."""
    often = _often_nearest(seen, _RARE)
    if not often:
        return ()
    names = {part.value for part in often}
    for part, place in _places(robot, task).items():
        if part not in names:
            there = _specials_of(robot, task, family, place)
            names |= {part} & {other.value for other in _often_nearest(there, _MOST)}
    return _in_order(names)


def _places(robot: Robot, task: Task) -> dict[str, tuple[int, float]]:
    """Part of the arm -> a joint, from 1, and its value where the part's condition holds, for parts with one [rad]."""
    somewhere = np.zeros(robot.n)
    specials = measured_at(in_metres(robot), task_in_metres(task, robot), somewhere)
    return {special.part.value: (special.joint, special.value) for special in specials if special.shape in ON_JOINTS}


def _members_of(robot: Robot, task: Task, family: Family, held: tuple[int, float] | None = None) -> Array:
    """(M, n) members of a family, of those solved from a joint at a value where that is given."""
    from rankdrop.families.pictured import members_of  # most families are settled, and it imports all of their fit

    return members_of(robot, task, family, _MEMBERS, held)


def _specials_of(
    robot: Robot, task: Task, family: Family, held: tuple[int, float] | None = None
) -> list[tuple[Special, ...]]:
    """The special places at each of some members, of those solved from a joint at a value where that is given."""
    here, rows = in_metres(robot), task_in_metres(task, robot)
    members = _members_of(robot, task, family, held)
    return [specials_at(here, rows, q, family.corank) for q in members]


def _often_nearest(seen: Sequence[Sequence[Special]], share: float) -> tuple[ArmPart, ...]:
    """The parts nearest to their conditions at a share of the members at least; exact conditions are not counted."""
    counts = Counter(special.part.value for specials in seen for special in specials if not special.exact)
    return _in_order(part for part, count in counts.items() if count >= share * len(seen))


def _in_order(names: Iterable[str]) -> tuple[ArmPart, ...]:
    """Parts of the arm by name, from the base to the tool."""
    wanted = set(names)
    return tuple(part for part in ArmPart if part.value in wanted)


def _binds_base(robot: Robot, family: Family) -> bool:
    """Whether a family binds a joint before the last seven axes of an arm that has more joints than these."""
    if robot.n <= ARM_AXES:
        return False
    axes = Scene(robot, np.zeros((1, robot.n))).axes
    if len(axes) < ARM_AXES:
        return False
    bound = {*(pin.number for pin in family.pinned), *family.coupled}
    return min(bound, default=robot.n) <= axes[-ARM_AXES]
