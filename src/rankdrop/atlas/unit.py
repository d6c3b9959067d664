"""Families between an arm's own unit of length and the one it was given in.

Angles stay as they are; values of slides change, and so do the coefficients of equations in which slides stand. Lost
directions are told in `counted` lengths and stay, and sentences speak of the given unit from the start.
"""

from __future__ import annotations

from dataclasses import replace

from rankdrop.atlas.equation import Equation, Term
from rankdrop.atlas.family import Family, Pinned
from rankdrop.robot.model import JointKind, Robot
from rankdrop.units import UnitRobot, exponent, into_units, out_of_units, shifted


def family_out_of_units(family: Family, robot: Robot) -> Family:
    """A family of `in_units(robot)` as one of the arm itself."""
    return _moved(family, robot, exponent(robot), out_of_units(robot, family.witness).tolist())


def family_in_units(family: Family, robot: Robot) -> Family:
    """A family of an arm as one of `in_units(robot)`."""
    return _moved(family, robot, -exponent(robot), into_units(robot, family.witness).tolist())


def _moved(family: Family, robot: Robot, power: int, witness: list[float]) -> Family:
    if isinstance(robot, UnitRobot) or not power or not _slides(robot):
        return family
    return replace(
        family,
        pinned=tuple(_pinned(one, robot, power) for one in family.pinned),
        equations=tuple(rescaled(one, power) for one in family.equations),
        witness=tuple(witness),
    )


def _slides(robot: Robot) -> bool:
    return any(joint.kind is JointKind.PRISMATIC for joint in robot.variables)


def _pinned(one: Pinned, robot: Robot, power: int) -> Pinned:
    if robot.variables[one.number - 1].kind is not JointKind.PRISMATIC:
        return one
    return replace(one, values=tuple(shifted(value, power) for value in one.values))


def rescaled(equation: Equation, power: int) -> Equation:
    """The equation for slides that are 10 to a power times as large in numbers; its largest coefficient is 1 again.

    Example:
        >>> from rankdrop.atlas.equation import Term
        >>> slide = Equation((Term(1.0, "cos", (0, 0), (0, 1)), Term(-0.3, "cos", (2, 0), (0, 0))))
        >>> print(slide, "|", rescaled(slide, 3))
        q2 − 0.3 cos θ1 | 0.003333 q2 − cos θ1
    """
    if not power or not any(any(term.powers) for term in equation.terms):
        return equation
    values = [shifted(term.coefficient, -power * sum(term.powers)) for term in equation.terms]
    largest = max(map(abs, values))
    return Equation(
        tuple(
            Term(value / largest, term.kind, term.harmonics, term.powers, term.shift)
            for value, term in zip(values, equation.terms, strict=True)
        )
    )
