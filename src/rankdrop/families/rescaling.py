"""How do the numbers of a family change with the unit of the arm's lengths?

Between an arm's own unit of length and the one it was given in angles stay as they are; values of slides change, and so
do the coefficients of equations in which slides stand. Lost directions are in `counted` lengths and stay, and those of
`lost_freedoms` have the given unit from the start.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rankdrop.families.record import Family, Pin
from rankdrop.formula.equation import Equation
from rankdrop.robot.model import JointKind, Robot
from rankdrop.units import exponent, metre_exponent, shift_decimal


def family_out_of_units(family: Family, robot: Robot) -> Family:
    """A family of `in_units(robot)` as one of the arm itself."""
    return _with_slides(family, robot, exponent(robot))


def family_in_units(family: Family, robot: Robot) -> Family:
    """A family of an arm as one of `in_units(robot)`."""
    return _with_slides(family, robot, -exponent(robot))


def family_in_metres(family: Family, robot: Robot) -> Family:
    """A family of an arm as one of `in_metres(robot)`."""
    return _with_slides(family, robot, -metre_exponent(robot))


def family_from_metres(family: Family, robot: Robot, power: int) -> Family:
    """A family of an arm in metres as one of the same arm with lengths 10 to a power as large in numbers."""
    lost = tuple(freedom.rescaled(power) for freedom in family.lost_freedoms)
    return replace(_with_slides(family, robot, power), lost_freedoms=lost)


def _with_slides(family: Family, robot: Robot, power: int) -> Family:
    """The family where the numbers of slides are 10 to a power times as large."""
    if robot.exponent is not None or not power:
        return family
    slides = slides_of(robot)
    if not slides:
        return family
    return replace(
        family,
        pinned=tuple(rescaled_pin(pin, slides, power) for pin in family.pinned),
        equations=tuple(rescale_equation(equation, slides, power) for equation in family.equations),
        witness=tuple(shift_decimal(x, power) if i in slides else x for i, x in enumerate(family.witness)),
    )


def slides_of(robot: Robot) -> tuple[int, ...]:
    """Variables (from 0) that are lengths."""
    return tuple(i for i, joint in enumerate(robot.variables) if joint.kind is JointKind.PRISMATIC)


def rescaled_pin(pin: Pin, slides: Sequence[int], power: int) -> Pin:
    """The pin where the numbers of slides are 10 to a power times as large."""
    if pin.number - 1 in slides:
        return replace(pin, values=tuple(shift_decimal(x, power) for x in pin.values))
    return pin


def rescale_equation(equation: Equation, slides: Sequence[int], power: int) -> Equation:
    """The equation where the numbers of slides are 10 to a power times as large; its largest coefficient is 1 again.

    Args:
        equation: of one arm.
        slides: variables (from 0) that are lengths; powers of helical joints are powers of an angle.
        power: of ten.

    Example:
        >>> from rankdrop.formula.equation import Term
        >>> slide = Equation((Term(1.0, "cos", (0, 0), (0, 1)), Term(-0.3, "cos", (2, 0), (0, 0))))
        >>> print(slide, "|", rescale_equation(slide, [1], 3))
        q2 − 0.3 cos θ1 | 0.003333 q2 − cos θ1
    """
    lengths = [sum(term.powers[i] for i in slides) for term in equation.terms]
    if not power or not any(lengths):
        return equation
    values = [shift_decimal(term.coefficient, -power * n) for term, n in zip(equation.terms, lengths, strict=True)]
    largest = max(map(abs, values))
    return Equation(
        tuple(replace(term, coefficient=value / largest) for value, term in zip(values, equation.terms, strict=True))
    )
