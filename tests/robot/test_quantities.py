"""Text in robot files is arithmetic with a unit, and nothing else."""

from __future__ import annotations

from contextlib import suppress
from math import inf, isfinite, pi, radians, sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rankdrop.errors import RobotError
from rankdrop.robot.quantities import quantity


@pytest.mark.parametrize(
    ("text", "measure", "value"),
    [
        ("pi/2", "angle", pi / 2), ("-3*pi/4", "angle", -3 * pi / 4), ("90 deg", "angle", pi / 2),
        ("180 - 36.5 deg", "angle", radians(143.5)), ("-1.5e-1 rad", "angle", -0.15), ("45°", "angle", pi / 4),
        ("pi", "angle", pi), ("+pi", "angle", pi), ("2*(1 + 0.5)", "angle", 3.0),
        ("316 mm", "length", 0.316), ("-(156.43 + 128.38) mm", "length", -0.28481), ("12 in", "length", 0.3048),
        ("7 cm", "length", 0.07), (".5 m", "length", 0.5), ("sqrt(2)/2", "length", sqrt(0.5)), ("1.", "length", 1.0),
    ],
)  # fmt: skip
def test_text_has_the_value_it_shows(text: str, measure: str, value: float) -> None:
    assert quantity(text, measure, where="x") == pytest.approx(value, rel=1e-15)


def test_quarter_turns_are_the_nearest_doubles() -> None:
    assert quantity("90 deg", "angle", where="x") == pi / 2
    assert quantity("180 deg", "angle", where="x") == pi


def test_rates_have_their_unit_per_second() -> None:
    assert quantity("180 deg/s", "angle", where="x", rate=True) == pytest.approx(pi)
    with pytest.raises(RobotError, match="unit"):
        quantity("180 deg", "angle", where="x", rate=True)
    with pytest.raises(RobotError, match="unit"):
        quantity("180 deg/s", "angle", where="x")


def test_limits_may_be_endless_and_geometry_may_not() -> None:
    assert quantity(-inf, "angle", where="x", endless=True) == -inf
    assert quantity("inf", "angle", where="x", endless=True) == inf
    for value in (inf, "inf", float("nan"), "nan", 10**400):
        with pytest.raises(RobotError, match="not finite"):
            quantity(value, "angle", where="x")


@pytest.mark.parametrize(
    "text",
    [
        "", " ", "deg", "1 foot", "316 mm", "__import__('os')", "pi.real", "1 if 1 else 2", "2**3", "sqrt(2, 3)",
        "sqrt", "pi(2)", "1//2", "3 4", "1,5", "1_000", "0x10", "sqrt(-1)", "1/0", "e", "(1", "1)", "9" * 300,
        "(" * 150,
        "1 deg + 2 deg", "lambda: 1", "[1]", "١",
        "+".join(["10"] * 40) + "!", "1" * 150 + "!",  # an expression that tries every way to split them never ends
    ],
)  # fmt: skip
def test_everything_else_is_an_error_that_names_the_place(text: str) -> None:
    with pytest.raises(RobotError, match="place") as caught:
        quantity(text, "angle", where="the place")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("value", [True, None, [1.0], {"a": 1}, b"1"])
def test_other_types_are_errors(value: object) -> None:
    with pytest.raises(RobotError, match="not a number"):
        quantity(value, "length", where="x")


@given(st.text(alphabet="0123456789.+-*/() episqrtmndg", max_size=30))
def test_any_text_gives_a_finite_number_or_a_robot_error(text: str) -> None:
    with suppress(RobotError):
        assert isfinite(quantity(text, "length", where="x"))
