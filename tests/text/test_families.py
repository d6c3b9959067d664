"""Values and shares in words."""

from __future__ import annotations

from math import pi

import pytest

from rankdrop.results.known import shipped
from rankdrop.robot.open import open_robot
from rankdrop.text.families import inside_limits, share_text, value_text, values_text


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
