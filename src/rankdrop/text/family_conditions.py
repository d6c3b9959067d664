"""What has to hold on a family, one sentence for each condition."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from rankdrop.codec import Record
from rankdrop.families.inspection import Covector
from rankdrop.families.record import Family, LocalConditions, Pin
from rankdrop.formula.equation import pretty_angle
from rankdrop.results.known import shipped_conditions_record
from rankdrop.robot.model import Robot
from rankdrop.task import Task
from rankdrop.text.joint_values import symbols as joint_symbols
from rankdrop.text.joint_values import values_in_degrees
from rankdrop.text.words import listing, numbers

LONGEST = 120
"""Characters of a condition that is printed; of a longer one the joints are named."""
_SHIFTED = 1e-12  # an angle that conditions count from elsewhere than the joint does [rad]


class _PrintedCondition(NamedTuple):
    """A condition for people, the joints it is about, and the lengths that stand in it as letters."""

    text: str
    joints: frozenset[int]
    letters: frozenset[str] = frozenset()


def _shipped_conditions(robot: Robot, task: Task, family: Family) -> tuple[list[_PrintedCondition], Record] | None:
    """Conditions, beyond pinned joints, and lengths shipped for this family; None for another arm or another family.

    Conditions that count an angle from elsewhere than the joint does are left out: they read as if they were of q.
    """
    record = shipped_conditions_record(robot, task)
    if record is None:
        return None
    for stored in record["families"]:
        if (stored["id"], stored["name"], stored["corank"]) == (family.id, family.name, family.corank):
            bound = {*stored["coupled"], *(pin["number"] for pin in stored["pinned"])}
            if any(abs(shift) > _SHIFTED for number, shift in enumerate(record["shifts"], 1) if number in bound):
                return None
            beyond, letters = len(stored["pinned"]), record["letters"]
            each = zip(stored["conditions"][beyond:], stored["terms"][beyond:], stored["polynomials"], strict=True)
            return [_PrintedCondition(text, _joints(terms), _letters(f, letters)) for text, terms, f in each], letters
    return None


def _joints(terms: list[Record]) -> frozenset[int]:
    """Numbers of the joints of an equation, from its terms: harmonics of angles, powers of slides."""
    joints: set[int] = set()
    for term in terms:
        exponents = zip(term["harmonics"], term["powers"], strict=True)
        joints |= {number for number, exponent in enumerate(exponents, start=1) if any(exponent)}
    return frozenset(joints)


def _letters(polynomial: list[Any], letters: Record) -> frozenset[str]:
    """Lengths that stand in a polynomial as letters, from its terms [[variable, power, …], coefficient]."""
    names: set[str] = set()
    for variables, _ in polynomial:
        names.update(variables[::2])
    return frozenset(names & letters.keys())


def condition_sentences(robot: Robot, task: Task, family: Family) -> tuple[str, ...]:
    """What has to hold on a family, one sentence each.

    Joints at fixed values first: "θ4 = −26.76° or 153.24°". Then the exact conditions where they are shipped, with the
    lengths that stand in them; else the fitted ones. Long ones are not printed: they name their joints.

    Args:
        robot: the arm.
        task: its rows.
        family: of the catalogue, of an analysis, or found on the spot.
    """
    written = _shipped_conditions(robot, task, family)
    if written is None and not family.equations:
        return local_conditions(family) or ("no condition found",)
    conditions, letters = _conditions_beyond_pins(family, written)
    short = [condition for condition in conditions if len(condition.text) <= LONGEST]
    long = [condition for condition in conditions if len(condition.text) > LONGEST]
    pins = ((pin.number, values_in_degrees(robot, pin.number, pin.values)) for pin in family.pinned)
    sentences = [f"{joint_symbols(robot)[number - 1]} = {values}" for number, values in pins]
    sentences += (condition.text for condition in short)
    named = frozenset[str]().union(*(condition.letters for condition in short))
    lengths = [f"{name} = {value:.6g} m".replace("-", "−") for name, value in letters.items() if name in named]
    if lengths:
        sentences[-1] += f", {', '.join(lengths)}"
    if long:
        sentences.append(_long_words(long, exact=written is not None))
    return tuple(sentences)


def local_conditions(family: Family) -> tuple[str, ...]:
    """Conditions of a family that was found around one configuration; () for a row of a table.

    Where families meet, a sentence for each.
    """
    if family.parts:
        return tuple(" and ".join(local_conditions(part)) for part in family.parts)
    if family.local is None:
        return ()
    return _local_condition_words(family, family.local)


def _local_condition_words(family: Family, local: LocalConditions) -> tuple[str, ...]:
    if local.isolated:
        return ("an isolated singular configuration",)
    if not family.named:
        return ("no condition found around it",)
    conditions = [_pin_words(pin, family.slides) for pin in family.pinned]
    conditions += [_relation_words(multiples, value) for multiples, value in local.relations]
    conditions += [f"{equation.pretty()} = 0" for equation in local.residual]
    if not local.complete:
        conditions.append(f"coupled: joints {listing([str(number) for number in family.coupled])}")
    return tuple(conditions)


def _pin_words(pin: Pin, slides: tuple[int, ...]) -> str:
    """A joint at the value that is met here: "θ4 = 0", "q3 = 0.2 m"."""
    if pin.number in slides:
        return f"q{pin.number} = " + f"{pin.values[0]:.4g} m".replace("-", "−")
    return f"θ{pin.number} = {pretty_angle(pin.values[0])}"


def _relation_words(multiples: Covector, value: float) -> str:
    """A whole-number relation of angles for people: "θ3 + θ5 = 0", "2 θ2 − θ4 = π"."""
    text = ""
    minus, plus = "−", ""
    for number, multiple in enumerate(multiples, start=1):
        if multiple == 0:
            continue
        if multiple < 0:
            text += minus
        else:
            text += plus
        text += _multiple(abs(multiple), number)
        minus, plus = " − ", " + "
    return f"{text} = {pretty_angle(value)}"


def _multiple(factor: int, number: int) -> str:
    """ "2 θ3"; "θ3" for the factor 1."""
    if factor == 1:
        return f"θ{number}"
    return f"{factor} θ{number}"


def _long_words(long: Sequence[_PrintedCondition], *, exact: bool) -> str:
    """How many conditions are too long to print, on which joints, and where they stand."""
    if len(long) == 1:
        count, them = "a long condition", "it"
    else:
        count, them = f"{len(long)} long conditions", "them"
    if exact:
        where = f"`rankdrop conditions` prints {them}"
    else:
        where = "in the JSON"
    joints = frozenset[int]().union(*(condition.joints for condition in long))
    return f"{count} on joints {numbers(sorted(joints))} ({where})"


def _conditions_beyond_pins(
    family: Family, written: tuple[list[_PrintedCondition], Record] | None
) -> tuple[list[_PrintedCondition], Record]:
    """The conditions beyond those that only pin joints, exact where they are shipped, and their lengths."""
    fixed = {pin.number for pin in family.pinned}
    if written is None:
        fitted = [_PrintedCondition(f"{equation} = 0", frozenset(equation.joints)) for equation in family.equations]
        return [condition for condition in fitted if not condition.joints <= fixed], {}
    return [condition for condition in written[0] if not condition.joints <= fixed], written[1]
