"""An arm with joints that follow others by fractions, in parts of its joint angles: there every multiplier is whole.

Where θ_k = (p/q) θ_j, the cosine and sine of θ_k are no polynomials in those of θ_j. They are in those of φ_j = θ_j/b,
with b the common denominator of all multipliers of joint j. Such an arm is the same again after b turns of joint j.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np

from rankdrop.formula.equation import Equation, Term
from rankdrop.robot.model import Array, Joint, Mimic, Robot

_EDGE = 1e-9  # share of a period by which a value may lie beyond a limit


def parts_of(robot: Robot) -> tuple[int, ...]:
    """(n,) b of each variable: its angle is b φ; 1 where it needs no parts, or where no parts help."""
    return tuple(max(int(turns), 1) for turns in robot.turns)


def in_parts(robot: Robot) -> Robot:
    """The same arm with the variables φ = θ / b: joint j turns by φ, and a joint added on its axis by (b − 1) φ."""
    parts = dict(zip((joint.name for joint in robot.variables), parts_of(robot), strict=True))
    if max(parts.values()) == 1:
        return robot
    joints: list[Joint] = []
    for joint in robot.joints:
        part = parts[joint.driver]
        if part == 1:
            joints.append(joint)
        elif joint.mimic is not None:
            whole = float(round(joint.multiplier * part))
            joints.append(replace(joint, mimic=Mimic(joint.driver, whole, joint.offset)))
        else:
            ends = {name: getattr(joint, name) / part for name in ("lower", "upper", "velocity")}
            joints.append(replace(joint, **ends))
            rest = Mimic(joint.name, part - 1.0)
            joints.append(replace(joint, name=f"{joint.name} (rest)", link="", mimic=rest))
    return replace(robot, joints=tuple(joints))


def scale_angle(equation: Equation, parts: tuple[int, ...]) -> Equation:
    """An equation in φ as one in θ = b φ."""
    if max(parts) == 1:
        return equation

    def in_theta(term: Term) -> Term:
        return replace(term, harmonics=tuple(map(_share, term.harmonics, parts)))

    return Equation(tuple(map(in_theta, equation.terms)))


def _share(harmonic: int | Fraction, part: int) -> int | Fraction:
    share = Fraction(harmonic) / part
    if share.denominator == 1:
        return int(share)
    return share


def whole_angles(robot: Robot, q: Array) -> Array:
    """(..., n) configurations of `in_parts(robot)` as those of the arm."""
    return np.asarray(q * np.array(parts_of(robot), dtype=np.float64))


def values_in_turns(value: float, part: int, lower: float, upper: float) -> list[float]:
    """The values of θ = b φ for a value of φ: those inside the limits, modulo 2πb; else the one in (−πb, πb]."""
    first, period = part * value, 2 * np.pi * part
    if not (np.isfinite(lower) and np.isfinite(upper)):
        return [first]
    low, high = int(np.ceil((lower - first) / period - _EDGE)), int(np.floor((upper - first) / period + _EDGE))
    return [first + period * k for k in range(low, high + 1)] or [first]
