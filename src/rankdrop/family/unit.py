"""Families between an arm's own unit of length and the one it was given in.

Angles stay as they are; values of slides change, and so do the coefficients of equations in which slides stand. Lost
directions are told in `counted` lengths and stay, and sentences speak of the given unit from the start.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from rankdrop.family.equation import Equation
from rankdrop.family.record import Family, Pinned
from rankdrop.robot.model import JointKind, Robot
from rankdrop.units import UnitRobot, exponent, into_metres, into_units, metre_exponent, out_of_units, shifted

_RATE = re.compile(r"(\d[\d.]*(?:e[+−]?\d+)?) (rad/m|m/rad)")


def family_out_of_units(family: Family, robot: Robot) -> Family:
    """A family of `in_units(robot)` as one of the arm itself."""
    return _moved(family, robot, exponent(robot), out_of_units(robot, family.witness).tolist())


def family_in_units(family: Family, robot: Robot) -> Family:
    """A family of an arm as one of `in_units(robot)`."""
    return _moved(family, robot, -exponent(robot), into_units(robot, family.witness).tolist())


def family_from_metres(family: Family, robot: Robot, power: int) -> Family:
    """A family of an arm in metres as one of the same arm with lengths 10 to a power as large in numbers."""
    witness = [shifted(x, power) if i in slides_of(robot) else x for i, x in enumerate(family.witness)]
    words = tuple(_retold(one, power) for one in family.lost_words)
    return replace(_moved(family, robot, power, witness), lost_words=words)


def _retold(sentence: str, power: int) -> str:
    """A sentence on a lost motion with its rates in the other unit."""

    def moved(match: re.Match[str]) -> str:
        value = shifted(float(match[1].replace("−", "-")), -power if match[2] == "rad/m" else power)
        return f"{value:.3g} {match[2]}".replace("-", "−")

    return _RATE.sub(moved, sentence)


def family_in_metres(family: Family, robot: Robot) -> Family:
    """A family of an arm as one of `in_metres(robot)`: always another object."""
    moved = _moved(family, robot, -metre_exponent(robot), into_metres(robot, family.witness).tolist())
    return replace(moved) if moved is family else moved


def _moved(family: Family, robot: Robot, power: int, witness: list[float]) -> Family:
    if isinstance(robot, UnitRobot) or not power or not slides_of(robot):
        return family
    return replace(
        family,
        pinned=tuple(_pinned(one, robot, power) for one in family.pinned),
        equations=tuple(rescaled(one, slides_of(robot), power) for one in family.equations),
        witness=tuple(witness),
    )


def slides_of(robot: Robot) -> tuple[int, ...]:
    """Variables (from 0) that are lengths."""
    return tuple(i for i, joint in enumerate(robot.variables) if joint.kind is JointKind.PRISMATIC)


def _pinned(one: Pinned, robot: Robot, power: int) -> Pinned:
    if robot.variables[one.number - 1].kind is not JointKind.PRISMATIC:
        return one
    return replace(one, values=tuple(shifted(value, power) for value in one.values))


def rescaled(equation: Equation, slides: Sequence[int], power: int) -> Equation:
    """The equation where the numbers of slides are 10 to a power times as large; its largest coefficient is 1 again.

    Args:
        equation: of one arm.
        slides: variables (from 0) that are lengths; powers of helical joints are powers of an angle.
        power: of ten.

    Example:
        >>> from rankdrop.family.equation import Term
        >>> slide = Equation((Term(1.0, "cos", (0, 0), (0, 1)), Term(-0.3, "cos", (2, 0), (0, 0))))
        >>> print(slide, "|", rescaled(slide, [1], 3))
        q2 − 0.3 cos θ1 | 0.003333 q2 − cos θ1
    """
    lengths = [sum(term.powers[i] for i in slides) for term in equation.terms]
    if not power or not any(lengths):
        return equation
    values = [shifted(term.coefficient, -power * n) for term, n in zip(equation.terms, lengths, strict=True)]
    largest = max(map(abs, values))
    return Equation(
        tuple(replace(term, coefficient=value / largest) for value, term in zip(values, equation.terms, strict=True))
    )
