"""The conditions of one family for people: values of pinned joints in degrees, exact conditions where they are shipped.

What is shipped is read as it was written: no condition is derived, and no python-flint needed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import degrees

from rankdrop.family.equation import pretty_angle
from rankdrop.family.record import Family, LocalFamily
from rankdrop.family.which import Condition
from rankdrop.results.conditions.known import shipped_record
from rankdrop.robot.model import Robot
from rankdrop.task import Task

LONGEST = 120
"""Characters of a condition that is printed; of a longer one the joints are named."""
_SHIFTED = 1e-12  # an angle that conditions count from elsewhere than the joint does [rad]


@dataclass(frozen=True, slots=True)
class Written:
    """The shipped conditions of one family.

    Attributes:
        pins: those of joints at fixed values, the first of `texts`.
        texts: for people.
        letters: lengths that stand in them [m].
    """

    pins: int
    texts: tuple[str, ...]
    letters: Mapping[str, float]


def written_conditions(robot: Robot, task: Task, family: Condition) -> Written | None:
    """What is shipped for this family of an arm of the catalogue; None for another arm, or another family.

    Conditions that count an angle from elsewhere than the joint does are left out: they read as if they were of q.
    """
    record = shipped_record(robot, task) if isinstance(family, Family) else None
    if record is None or not isinstance(family, Family):
        return None
    for one in record["families"]:
        if (one["id"], one["name"], one["corank"]) == (family.id, family.name, family.corank):
            bound = {*one["coupled"], *(pin["number"] for pin in one["pinned"])}
            if any(abs(shift) > _SHIFTED for number, shift in enumerate(record["shifts"], 1) if number in bound):
                return None
            return Written(len(one["pinned"]), tuple(one["conditions"]), record["letters"])
    return None


def told_conditions(robot: Robot, task: Task, family: Condition) -> tuple[str, ...]:
    """What has to hold on a family, one sentence each.

    Joints at fixed values first: "θ4 = −26.76° or 153.24°". Then the exact conditions where they are shipped, with the
    lengths that stand in them; else the fitted ones. Long ones are not printed: they name their joints.

    Args:
        robot: the arm.
        task: its rows.
        family: of the catalogue, of an analysis, or found on the spot.
    """
    pinned = family.pinned if isinstance(family, (Family, LocalFamily)) else ()
    pins = [f"{_symbol(robot, one.number)} = {values_in_degrees(robot, one.number, one.values)}" for one in pinned]
    fixed = {one.number for one in pinned}
    written = written_conditions(robot, task, family)
    if written is not None:
        rest = [text for text in written.texts[written.pins :] if not {*_joints([text])} <= fixed]
    else:
        rest = [f"{one} = 0" for one in family.equations if not set(one.joints) <= fixed]
        if not family.equations:
            return getattr(family, "words", ()) or ("no condition found",)
    short = [text for text in rest if len(text) <= LONGEST]
    long = [text for text in rest if len(text) > LONGEST]
    told = [*pins, *short]
    if long:
        joints = _joints(long)
        where = "in the JSON" if written is None else "`rankdrop conditions` prints it"
        count = "a long condition" if len(long) == 1 else f"{len(long)} long conditions"
        told.append(f"{count} on joints {', '.join(map(str, joints))} ({where})")
    if written is not None:
        there = [name for name in written.letters if any(re.search(rf"\b{re.escape(name)}\b", one) for one in short)]
        if there:
            values = ", ".join(f"{name} = {written.letters[name]:.6g} m".replace("-", "−") for name in there)
            told[-1 - bool(long)] += f", {values}"
    return tuple(told)


def values_in_degrees(robot: Robot, number: int, values: Sequence[float]) -> str:
    """ "0 or π", "−26.76° or 153.24°", "0.25 m"."""
    if robot.variables[number - 1].unit != "rad":
        return " or ".join(f"{value:.6g} m".replace("-", "−") for value in values)
    told = [pretty_angle(value) for value in values]
    plain = [one if "π" in one or one == "0" else f"{degrees(x):.2f}°" for one, x in zip(told, values, strict=True)]
    return " or ".join(plain).replace("-", "−")


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
