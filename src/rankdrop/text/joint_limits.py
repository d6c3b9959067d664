"""Values of pinned joints within the joint limits: moved by whole turns, and those that no turn brings inside named."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rankdrop.distance.distance import nearest_turns
from rankdrop.families.record import Family, Pin
from rankdrop.robot.model import Robot
from rankdrop.text.joint_values import fixed_point, joint_symbol, values_text


@dataclass(frozen=True, slots=True)
class Inside:
    """A row as the limits allow it.

    Attributes:
        pinned: the pinned joints with the values inside their limits, each moved by as few whole turns as that takes.
        outside: pinned joints with the values that lie outside at every turn.
        holds: whether every pinned joint has a value inside; otherwise the whole row lies outside the limits.
    """

    pinned: tuple[Pin, ...]
    outside: tuple[Pin, ...]

    @property
    def holds(self) -> bool:
        """Whether every pinned joint has a value inside its limits."""
        return all(pin.values for pin in self.pinned)

    def with_values_inside(self, family: Family) -> Family:
        """The family with the values inside; a joint that has none keeps its values."""
        kept = (mine if mine.values else given for mine, given in zip(self.pinned, family.pinned, strict=True))
        return replace(family, pinned=tuple(kept))


def inside_limits(family: Family, robot: Robot) -> Inside:
    """What the limits leave of the values of a family's pinned joints."""
    kept, left = [], []
    for pin in family.pinned:
        j = pin.number - 1
        bounds = np.array([robot.lower[j], robot.upper[j]])
        moved = [_nearest_turn_inside(value, bool(robot.periodic[j]), bounds) for value in pin.values]
        kept.append(replace(pin, values=tuple(value for value in moved if value is not None)))
        outside = tuple(value for value, there in zip(pin.values, moved, strict=True) if there is None)
        if outside:
            left.append(replace(pin, values=outside))
    return Inside(tuple(kept), tuple(left))


def _nearest_turn_inside(
    value: float, periodic: bool, bounds: np.ndarray[tuple[int], np.dtype[np.float64]]
) -> float | None:
    options = nearest_turns(np.array([value]), value, periodic, bounds)
    if not len(options):
        return None
    return float(options[np.abs(options - value).argmin()])


def outside_text(inside: Inside, robot: Robot) -> str:
    """What lies outside the limits, with the limits: "θ6 = −2.9218 is outside −0.0175 … 3.7525"."""
    told = []
    for pin in inside.outside:
        joint = robot.variables[pin.number - 1]
        kind = str(joint.kind)
        values = values_text(pin.values, kind)
        verb = "is" if len(pin.values) == 1 else "are"
        limits = f"{fixed_point(joint.lower)} … {fixed_point(joint.upper)} {joint.unit}"
        told.append(f"{joint_symbol(pin.number, kind)} = {values} {verb} outside {limits}")
    return ("" if inside.holds else "the row lies outside the joint limits: ") + "; ".join(told)
