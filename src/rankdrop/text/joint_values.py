"""Joints and their values as people write them: θ3, ±π/2, 0.7731 (44.30°), 0.25 m; a witness in degrees."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import degrees, isclose

from rankdrop.formula.equation import pretty_angle, share_of_pi
from rankdrop.robot.model import Robot, joints_beyond_limits
from rankdrop.robot.quantities import degrees_text

_NUMBERS = re.compile(r"\d+")  # in a joint's name
_ALIKE = 1e-9


def fixed_point(value: float, digits: int = 4) -> str:
    """A number with so many decimals; zero has no sign."""
    return f"{round(float(value), digits) + 0.0:.{digits}f}".replace("-", "−")


def joint_symbol(number: int, kind: str) -> str:
    """θ3 for an angle, q3 for a length, as conditions write them."""
    return f"{'q' if kind == 'prismatic' else 'θ'}{number}"


def value_text(value: float, kind: str = "revolute") -> str:
    """One value: "π/2", "0.7731 (44.30°)" or, for a prismatic joint, "0.25 m"."""
    return value_and_degrees(_value_parts(value, kind))


def _value_parts(value: float, kind: str) -> tuple[str, str]:
    """A value, and the same in degrees where that helps: ("π/2", ""), ("0.7731", "44.30°")."""
    if kind == "prismatic":
        return f"{value:.6g} m", ""
    if share_of_pi(value) is not None:
        return pretty_angle(value), ""
    return fixed_point(value, 4), _in_degrees(value)


def value_and_degrees(parts: tuple[str, str]) -> str:
    """A value with the same in degrees after it, where there is that: "π/2", "0.7731 (44.30°)"."""
    number, angle = parts
    if angle:
        return f"{number} ({angle})"
    return number


def values_text(values: Iterable[float], kind: str = "revolute") -> str:
    """A set of values, v and −v merged: "0, π", "±π/2", "±0.7731 (±44.30°)"."""
    return ", ".join(map(value_and_degrees, merge_signs(values, kind)))


def merge_signs(values: Iterable[float], kind: str) -> Iterator[tuple[str, str]]:
    """`_value_parts` of a set of values, v and −v as one."""
    left = sorted(values, key=lambda value: (abs(value), value))
    while left:
        value = left.pop(0)
        opposite = next((other for other in left if value and isclose(other, -value, abs_tol=_ALIKE)), None)
        if opposite is None:
            yield _value_parts(value, kind)
        else:
            left.remove(opposite)
            number, angle = _value_parts(abs(opposite), kind)
            yield f"±{number}", f"±{angle}" if angle else ""


def values_in_degrees(robot: Robot, number: int, values: Sequence[float]) -> str:
    """Values as "0 or π", "−26.76° or 153.24°", "0.25 m"."""
    if robot.variables[number - 1].unit != "rad":
        return " or ".join(f"{value:.6g} m".replace("-", "−") for value in values)
    return " or ".join(map(_in_degrees, values))


def _in_degrees(value: float) -> str:
    """An angle as "π/2" or "−26.76°"."""
    if share_of_pi(value) is not None:
        return pretty_angle(value)
    return f"{fixed_point(degrees(value), 2)}°"
def joints_named(robot: Robot) -> str:
    """Which symbol is which joint, where a maker's name has another number than the symbol: "q1 rail, θ2 a1"; else "".

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> joints_named(open_robot("ur5e"))[:41], joints_named(open_robot("pa10"))
        ('θ1 shoulder_pan_joint, θ2 shoulder_lift_j', '')
    """
    named = list(zip(symbols(robot), (joint.name for joint in robot.variables), strict=True))
    numbers = [_NUMBERS.findall(name) for _, name in named]
    other = any(digits and int(digits[-1]) != place for place, digits in enumerate(numbers, start=1))
    if other:
        return ", ".join(f"{symbol} {name}" for symbol, name in named)
    return ""


def symbols(robot: Robot) -> tuple[str, ...]:
    """The joints as conditions write them: "θ1", "q3" for a slide."""
    return tuple(joint_symbol(number, str(joint.kind)) for number, joint in enumerate(robot.variables, start=1))


def witness_text(robot: Robot, q: Sequence[float]) -> str:
    """A witness as people set it, and the joints beyond their limits: of some families every member has such.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> witness_text(open_robot("panda"), [0.0, 0.0, 0.0, 0.0, 0.0, 1.5, 0.0])
        'q = (0°, 0°, 0°, 0°, 0°, 85.94°, 0°), beyond the limits of joint 4'
    """
    values = f"q = {degrees_text(q, robot.units)}"
    beyond = joints_beyond_limits(robot, q)
    if not beyond:
        return values
    listed = ", ".join(map(str, beyond))
    if len(beyond) == 1:
        return f"{values}, beyond the limits of joint {listed}"
    return f"{values}, beyond the limits of joints {listed}"


def letters_text(letters: Mapping[str, float] | None) -> str:
    """Lengths that stand as letters: "a2 = 0.4318 m, d3 = −0.1 m"."""
    return ", ".join(f"{name} = {value:.6g} m".replace("-", "−") for name, value in (letters or {}).items())
