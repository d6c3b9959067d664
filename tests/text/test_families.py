"""The tables of families: cells, conditions under them, shares of tests."""

from __future__ import annotations

from dataclasses import replace

from rankdrop.families.record import written_conditions
from rankdrop.formula.equation import Equation, Term
from rankdrop.results.analysis import Analysis
from rankdrop.text.families import conditions_of, coupled_conditions, exact_conditions, joint_cell, share_text


def test_only_all_is_one() -> None:
    assert share_text(1000, 1000) == "100 %"
    assert share_text(99_999, 100_000) == "99.9 %"
    assert share_text(0, 0) == "–"


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
