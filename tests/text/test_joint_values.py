"""Joints and their values as people write them."""

from __future__ import annotations

from math import pi

import pytest

from rankdrop.robot.open import open_robot
from rankdrop.text.joint_values import (
    fixed_point,
    joints_named,
    letters_text,
    symbols,
    value_text,
    values_in_degrees,
    values_text,
    witness_text,
)


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ((0.0, pi), "0, π"),
        ((pi, 0.0), "0, π"),
        ((pi / 2, -pi / 2), "±π/2"),
        ((-pi / 2,), "−π/2"),
        ((0.0,), "0"),
        ((-2 * pi / 3, 2 * pi / 3), "±2π/3"),
        ((0.7731, -0.7731), "±0.7731 (±44.30°)"),
        ((-0.5,), "−0.5000 (−28.65°)"),
        ((-0.5, pi), "−0.5000 (−28.65°), π"),
        ((0.1, 0.2), "0.1000 (5.73°), 0.2000 (11.46°)"),
    ],
)
def test_opposite_values_are_merged_and_multiples_of_pi_are_exact(values: tuple[float, ...], text: str) -> None:
    assert values_text(values) == text


def test_a_value_near_a_multiple_of_pi_is_not_called_one() -> None:
    assert value_text(pi / 2 + 1e-6) == "1.5708 (90.00°)"


def test_a_prismatic_value_is_in_metres() -> None:
    assert values_text((0.25, -0.25), "prismatic") == "±0.25 m"
    assert values_text((0.0,), "prismatic") == "0 m"


def test_joints_are_named_where_their_maker_counts_otherwise() -> None:
    """Sawyer's joints count from 0; PUMA's have the numbers of their symbols."""
    assert joints_named(open_robot("puma560")) == ""
    assert joints_named(open_robot("sawyer")).startswith("θ1 right_j0, θ2 right_j1, ")
    assert symbols(open_robot("stanford")) == ("θ1", "θ2", "q3", "θ4", "θ5", "θ6")


def test_lengths_that_stand_as_letters_have_their_values() -> None:
    assert letters_text({"a2": 0.4318, "d3": -0.1}) == "a2 = 0.4318 m, d3 = −0.1 m"
    assert letters_text(None) == ""


def test_values_of_a_joint_are_angles_in_degrees_or_lengths() -> None:
    robot = open_robot("stanford")
    assert values_in_degrees(robot, 1, (pi / 2, 0.5)) == "π/2 or 28.65°"
    assert values_in_degrees(robot, 3, (-0.25,)) == "−0.25 m"


def test_a_witness_names_the_joints_beyond_their_limits() -> None:
    robot = open_robot("panda")
    q = (robot.lower + robot.upper) / 2
    assert "beyond" not in witness_text(robot, q.tolist())
    q[[0, 5]] = robot.upper[[0, 5]] + 0.1
    assert witness_text(robot, q.tolist()).endswith(", beyond the limits of joints 1, 6")


@pytest.mark.parametrize(("value", "digits", "text"), [
    (-0.00004, 4, "0.0000"), (-0.004, 2, "0.00"), (-0.006, 2, "−0.01"), (-0.0, 1, "0.0"), (1.25, 2, "1.25"),
])  # fmt: skip
def test_what_is_rounded_to_zero_has_no_sign(value: float, digits: int, text: str) -> None:
    assert fixed_point(value, digits) == text
