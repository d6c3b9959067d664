"""Derived families in q and in the arm's unit, assumptions on the lengths, and sets without a real configuration.

A family is the record of `families/record.py`; `Family.exact` holds its polynomials.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from math import pi, remainder
from typing import TypeVar

import numpy as np

from rankdrop.exact.arm.chain import numbers_in_units, polynomial_in_units
from rankdrop.exact.arm.parts import parts_of, scale_angle, values_in_turns, whole_angles
from rankdrop.families.evidence import FamilyEvidence, ObtainedFrom
from rankdrop.families.record import ExactConditions, Family, Pin, exact_of
from rankdrop.formula.equation import Equation
from rankdrop.formula.writing import AnglePin, Condition
from rankdrop.lists import flat_map
from rankdrop.robot.model import Robot
from rankdrop.sections import words_of
from rankdrop.units import exponent, into_units

EVIDENCE = FamilyEvidence(ObtainedFrom.EXACT)
"""Of families that were derived."""
Stated = AnglePin | Condition
"""A condition that was derived."""

READABLE = 40
"""Terms of a set's conditions beyond which they are not written out."""

Merged = TypeVar("Merged")
Pins = dict[int, tuple[str, ...]]
"""Joint number -> the simple angles it stands at."""


def pins_in_q(robot: Robot, pins: Iterable[AnglePin], shifts: Sequence[float]) -> tuple[Pin, ...]:
    """Joints at simple angles θ as values of q = θ − shift in (−π, π], under the names of the arm's joints.

    Of a part of an angle (`AnglePin.part`) they are those of the part.
    """
    in_q = []
    for pin in pins:
        values = tuple(_angle(angle - shifts[pin.joint - 1] / pin.part) for angle in pin.angles)
        in_q.append(Pin(robot.variables[pin.joint - 1].name, pin.joint, values))
    return tuple(in_q)


def slides_at_zero(robot: Robot, conditions: Iterable[Condition]) -> tuple[Pin, ...]:
    """Sliding joints that a condition q = 0 of their own holds, under the names of the arm's joints."""
    alone = [condition for condition in conditions if len(condition.polynomial) == 1 and len(condition.joints) == 1]
    joints = [condition.joints[0] for condition in alone if condition.joints[0] in condition.ring.prismatic]
    return tuple(Pin(robot.variables[joint - 1].name, joint, (0.0,)) for joint in joints)


def equations_of(
    stated: Iterable[Stated], numbers: Mapping[str, float], shifts: Sequence[float]
) -> tuple[Equation, ...]:
    """Conditions as equations in q with numbers for the lengths, as `analyze` has them."""
    return tuple(condition.equation(numbers, len(shifts), shifts) for condition in stated)


def polynomials_in_units(exact: ExactConditions, robot: Robot) -> tuple[Condition, ...]:
    """The polynomials of a family's conditions for the arm in its own unit of length, `units.in_units(robot)`."""
    power = exponent(robot)
    return tuple(
        Condition(condition.ring, polynomial_in_units(condition.polynomial, exact.numbers, power))
        for condition in exact.polynomials
    )


def derived_in_units(family: Family, robot: Robot, numbers: Mapping[str, float] | None = None) -> Family:
    """A derived family of an arm as one of `units.in_units(robot)`, with equations made of its polynomials again.

    Args:
        family: with exact conditions, which stay those of the arm as given.
        robot: the arm as given, or one of the same kind.
        numbers: values of its letters [m]; None for those that the family was derived with.
    """
    parts = parts_of(robot)
    return replace(
        family,
        equations=tuple(scale_angle(equation, parts) for equation in equations_in_parts(family, robot, numbers)),
        witness=tuple(float(x) for x in into_units(robot, family.witness)),
    )


def equations_in_parts(
    family: Family, robot: Robot, numbers: Mapping[str, float] | None = None
) -> tuple[Equation, ...]:
    """The equations of `derived_in_units` in the variables of `in_parts(robot)`; arguments as there."""
    exact = exact_of(family)
    if numbers is None:
        numbers = exact.numbers
    stated: tuple[Stated, ...] = (*exact.pins, *polynomials_in_units(exact, robot))
    return equations_of(stated, numbers_in_units(numbers, exponent(robot)), exact.shifts)


def families_in_whole_angles(robot: Robot, families: Iterable[Family]) -> tuple[Family, ...]:
    """Families of `in_parts(robot)`, as they are derived, as those of the arm: their angles are b φ."""
    return tuple(_in_whole_angles(family, robot) for family in families)


def _in_whole_angles(family: Family, robot: Robot) -> Family:
    parts, exact = parts_of(robot), exact_of(family)
    if max(parts) == 1:
        return family

    def pin_in_whole_angles(pin: Pin) -> Pin:
        place = pin.number - 1
        inside = partial(values_in_turns, part=parts[place], lower=robot.lower[place], upper=robot.upper[place])
        return replace(pin, values=tuple(flat_map(inside, pin.values)))

    return replace(
        family,
        pinned=tuple(map(pin_in_whole_angles, family.pinned)),
        equations=tuple(scale_angle(equation, parts) for equation in family.equations),
        witness=tuple(float(x) for x in whole_angles(robot, np.array(family.witness))),
        exact=replace(exact, pinned=tuple(map(pin_in_whole_angles, exact.pinned))),
    )


def _angle(value: float) -> float:
    angle = remainder(value, 2 * pi)
    return pi if angle <= -pi else angle


@dataclass(frozen=True, slots=True)
class EqualLengths:
    """Two lengths that are equal or opposite: length = sign · other.

    Attributes:
        length, other: letters.
        sign: 1 or −1.
    """

    length: str
    sign: int
    other: str


@dataclass(frozen=True, slots=True)
class SpecialFamily:
    """A family that an arm of special lengths has besides.

    Attributes:
        conditions: all of them, for people.
        corank: freedoms that it takes away.
    """

    conditions: tuple[str, ...]
    corank: int


@dataclass(frozen=True, slots=True)
class Assumption:
    """Lengths for which the derivation does not hold as it stands.

    Attributes:
        text: what was assumed: "d3 ≠ d5".
        holds: whether it is true of the arm's own lengths.
        derived: whether the special arm was derived.
        equal: the lengths for which it fails; None for other lengths than equal or opposite ones.
        families: the first families that the special arm has besides; none where it was not derived.
        more: number of its other families.
    """

    text: str
    holds: bool
    derived: bool
    equal: EqualLengths | None = None
    families: tuple[SpecialFamily, ...] = ()
    more: int = 0

    @property
    def words(self) -> str:
        """What happens where it fails: "if d3 = d5, θ4 = π alone loses two freedoms"; "" where nothing is known."""
        sentence: str = words_of(self).special_sentence(self)
        return sentence


class Unreal(StrEnum):
    """Why a set of lower rank is left out: no real configuration on it is known.

    PROVEN: the arm's lengths exclude one. NOT_FOUND: a search found none. NOR_MODULO_PRIMES: nor is a point modulo any
    of several primes.
    """

    PROVEN = "proven"
    NOT_FOUND = "not found"
    NOR_MODULO_PRIMES = "nor modulo primes"


@dataclass(frozen=True, slots=True)
class UnrealSet:
    """A set of lower rank on which no real configuration is known.

    Attributes:
        conditions: of the set, for people.
        reason: why it is left out.
        tried: random starts of the search, or primes.
        negative: where it is proven, the expression in the lengths that is negative, which excludes real points; ""
            where it is a number.
    """

    conditions: str
    reason: Unreal
    tried: int = 0
    negative: str = ""

    def __str__(self) -> str:
        """In words: "θ4 = 0: no real point was found from 96 random starts"."""
        words: str = words_of(self).unreal_words(self)
        return words
