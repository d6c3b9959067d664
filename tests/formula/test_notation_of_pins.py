"""Pinned joints: every subset of the simple angles vanishes there and nowhere else."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from rankdrop.algebra.polynomial import SIMPLE
from rankdrop.errors import OptionError
from rankdrop.formula.notation import C, Python
from rankdrop.formula.writing import RADIANS, AnglePin
from rankdrop.robot.open import open_robot
from rankdrop.text.families import exact_conditions
from rankdrop.verbs.analyze import analyze

SUBSETS = [values for size in range(1, 5) for values in itertools.combinations(SIMPLE, size)]


@pytest.mark.parametrize("values", SUBSETS)
@pytest.mark.parametrize("shift", [0.0, 0.3, -2.1])
def test_expression_and_equation_vanish_exactly_there(values, shift):
    shifts = [0.0, shift, 0.0]
    pin = AnglePin(2, values)
    equation = pin.equation({}, 3, shifts)
    text = pin.code(Python(shifts=shifts))
    theta = np.concatenate([[RADIANS[value] for value in SIMPLE], np.linspace(-3, 3, 40)])
    q = np.zeros((len(theta), 3))
    q[:, 1] = theta - shift
    one = equation(q)
    two = eval(text, {"q2": q[:, 1], "sin": np.sin, "cos": np.cos, "pi": np.pi})
    expected = np.array([value in values for value in SIMPLE] + [False] * 40)
    assert ((np.abs(one) < 1e-9) == expected).all()
    assert ((np.abs(two) < 1e-9) == expected).all()
    assert not pin.code(C(shifts=shifts)).count("pi")


@pytest.mark.parametrize(
    ("values", "text", "latex", "expression"),
    [
        (("0", "pi"), "θ4 = 0 or π", r"\theta_4 \in \{0, \pi\}", "sin(q4)"),
        (("pi/2", "-pi/2"), "θ4 = ±π/2", r"\theta_4 = \pm\frac{\pi}{2}", "cos(q4)"),
        (("pi",), "θ4 = π", r"\theta_4 = \pi", "cos(q4/2)"),
        (("-pi/2",), "θ4 = −π/2", r"\theta_4 = -\frac{\pi}{2}", "sin((q4 + pi/2)/2)"),
    ],
)
def test_pins_read_as_in_tables(values, text, latex, expression):
    pin = AnglePin(4, values)
    assert (pin.text(), pin.latex(), pin.code(Python())) == (text, latex, expression)


def test_other_angles_are_refused():
    with pytest.raises(OptionError, match="pi/3"):
        AnglePin(1, ("pi/3",)).text()
    with pytest.raises(OptionError, match="none"):
        AnglePin(1, ()).equation({}, 2)


@pytest.mark.slow
def test_a_pinned_slide_is_said_once_as_a_pinned_turn_is() -> None:
    """Stanford arm, wrist centre on axis 2: the table says 0 m, and "exactly q3 = 0" below said it again."""
    found = analyze(open_robot("stanford"), starts=30)
    assert found.exact is not None
    rows = found.of_corank(1)
    assert [[pin.number for pin in row.pinned] for row in rows] == [[3], [2], [5]]
    assert list(map(exact_conditions, rows)) == ["", "", ""]
    slide, turn, _ = (row.exact for row in rows)
    assert slide is not None
    assert turn is not None
    assert (slide.conditions, turn.conditions) == (("q3 = 0",), ("θ2 = 0 or π",))
    assert [pin.values for pin in slide.pinned] == [(0.0,)]
