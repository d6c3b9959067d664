"""Values and shares in words."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import pytest

from rankdrop.families.record import written_conditions
from rankdrop.formula.equation import Equation, Term
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import shipped
from rankdrop.robot.open import open_robot
from rankdrop.text.families import (
    conditions_of,
    coupled_conditions,
    exact_conditions,
    inside_limits,
    joint_cell,
    share_text,
    value_text,
    values_text,
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


def test_only_all_is_one() -> None:
    assert share_text(1000, 1000) == "100 %"
    assert share_text(99_999, 100_000) == "99.9 %"
    assert share_text(0, 0) == "–"


def test_slides_do_not_turn():
    robot, found = open_robot("stanford"), shipped("stanford")
    slides = [row for row in found.families if any(pin.number == 3 for pin in row.pinned)]
    assert slides
    for row in slides:
        values = next(pin.values for pin in row.pinned if pin.number == 3)
        inside = inside_limits(row, robot)
        kept = next(pin.values for pin in inside.pinned if pin.number == 3)
        assert kept == tuple(value for value in values if robot.lower[2] <= value <= robot.upper[2])


def test_cells_say_pinned_free_coupled(shapes: Analysis) -> None:
    coupled = shapes.families[2]
    cells = [joint_cell(coupled, number, "revolute") for number in range(1, 8)]
    assert cells == ["×", "c", "c", ("±0.7731 (±44.30°)",), "×", "×", "×"]


def test_conditions_of_pinned_joints_are_not_said_twice(shapes: Analysis) -> None:
    assert len(shapes.families[2].equations) == 2
    assert coupled_conditions(shapes.families[2]) == ["0.9087 cos θ2 + cos(θ2+θ3) = 0"]


def test_a_family_without_conditions_says_so(shapes: Analysis) -> None:
    assert "no condition found" in coupled_conditions(shapes.families[3])[0]


def test_an_exact_condition_stands_in_place_of_a_fitted_one(shapes: Analysis) -> None:
    row = shapes.families[2]
    long = Equation(tuple(Term(1.0 + i, "cos", (0, 2 * i, 2, 0, 0, 0, 0), (0,) * 7) for i in range(26)))
    fitted = replace(row, equations=(long,))
    exact = written_conditions((), ("a2 c2 + a3 c23 = 0", "s4 = 0"), ("", ""), ("a3 − a2",))
    derived = replace(fitted, exact=exact)
    real = "s4 = 0; real if and only if a3 − a2 ≥ 0"
    assert conditions_of(derived) == [("exactly", "a2 c2 + a3 c23 = 0"), ("exactly", real)]
    assert exact_conditions(derived) == "a2 c2 + a3 c23 = 0 and s4 = 0; real if and only if a3 − a2 ≥ 0"
    ((label, text),) = conditions_of(fitted)
    assert (label, text[:8]) == ("c", coupled_conditions(fitted)[0][:8])
    assert conditions_of(row) == [("c", "0.9087 cos θ2 + cos(θ2+θ3) = 0")]
