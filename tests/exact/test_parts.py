"""Arms whose joints follow others by fractions: the same poses and equations in parts of their joint angles."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from math import pi

import numpy as np
import pytest
from reference import kinematics
from reference.arms import standard_dh

from rankdrop.exact.arm.parts import in_parts, parts_of, scale_angle, values_in_turns, whole_angles
from rankdrop.formula.equation import Equation, Term
from rankdrop.robot.model import Mimic, Robot
from rankdrop.robot.open import open_robot

ROWS = [(0.5, pi / 2, 0.1, 0), (0.4, 0.3, 0, 0.2), (0.3, -0.7, 0.2, 0), (0.2, 0.1, 0, 0)]


def following(multiplier: float, offset: float = 0.3) -> Robot:
    """Joint 3 follows joint 1."""
    arm = standard_dh("following", ROWS, "position")
    joints = list(arm.joints)
    joints[2] = replace(joints[2], mimic=Mimic(joints[0].name, multiplier, offset))
    return replace(arm, joints=tuple(joints))


@pytest.mark.parametrize(("multiplier", "parts"), [(0.5, 2), (-1.5, 2), (2 / 3, 3), (-1.0, 1)])
def test_an_arm_in_parts_of_its_angles_has_the_same_poses(
    multiplier: float, parts: int, rng: np.random.Generator
) -> None:
    arm = following(multiplier)
    assert parts_of(arm) == (parts, 1, 1)
    whole = in_parts(arm)
    assert all(joint.mimic is None or joint.mimic.multiplier == round(joint.mimic.multiplier) for joint in whole.joints)
    phi = rng.uniform(-pi, pi, (30, 3))
    theta = whole_angles(arm, phi)
    assert theta == pytest.approx(phi * [parts, 1, 1])
    assert kinematics.pose(whole, phi) == pytest.approx(kinematics.pose(arm, theta), abs=1e-12)


def test_limits_and_rates_are_those_of_the_parts() -> None:
    arm = following(0.5)
    first = replace(arm.joints[0], lower=-1.0, upper=3.0, velocity=2.0)
    part = in_parts(replace(arm, joints=(first, *arm.joints[1:]))).joints[0]
    assert (part.lower, part.upper, part.velocity) == (-0.5, 1.5, 1.0)


def test_an_arm_that_needs_no_parts_is_itself() -> None:
    arm = open_robot("puma560")
    assert in_parts(arm) is arm


def test_an_equation_in_parts_has_the_same_values_in_whole_angles(rng: np.random.Generator) -> None:
    terms = (Term(1.0, "sin", (2, 6), (0, 0)), Term(-0.4, "cos", (4, 0), (0, 0)), Term(0.7, "sin", (1, 2), (0, 0), 0.3))
    equation = Equation(terms)
    phi = rng.uniform(-pi, pi, (50, 2))
    scaled = scale_angle(equation, (2, 3))
    assert scaled(phi * [2, 3]) == pytest.approx(equation(phi), abs=1e-12)
    assert scaled.terms[2].harmonics == (Fraction(1, 2), Fraction(2, 3))


def test_values_are_all_those_inside_the_limits() -> None:
    """φ = 0.5 is θ = 1 and, 4π on, 1 + 4π: both inside −12 … 14, and 1 − 4π."""
    assert values_in_turns(0.5, 2, -12.0, 14.0) == pytest.approx([1 - 4 * pi, 1.0, 1 + 4 * pi])
    assert values_in_turns(0.5, 2, -np.inf, np.inf) == [1.0]
    assert values_in_turns(0.5, 2, 3.0, 4.0) == [1.0]  # none is inside: the one that φ stands for
