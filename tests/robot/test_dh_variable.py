"""The joint variable of a row: found, taken out of its cell, and whether it is that of a slide."""

from __future__ import annotations

import pytest

from rankdrop.robot.dh_rows import table_in
from rankdrop.robot.dh_variable import LABEL, constant_part, names_variable, row_of_cells


def test_the_joint_variable_is_found_in_a_row() -> None:
    found = table_in("a alpha d theta\n0 0 1 q1\n0 0 q2 0\n0 0 d3* 0\n0 0 1 θ4-90°\n0 0 1 0\n", "t")
    assert found is not None
    assert [(row.slides, row.varies) for row in found.rows] == [
        (False, True), (True, True), (True, True), (False, True), (False, False),
    ]  # fmt: skip
    assert [row.entries["theta"] for row in found.rows] == ["0", "0", "0", "-90°", "0"]


def test_the_joint_variable_may_be_an_entry_of_a_list() -> None:
    named = "[{'a': 1, 'd': 0, 'alpha': 0, 'theta': q[0]}, {'a': 1, 'd': 0, 'alpha': 0, 'theta': theta[1] + pi/2}]"
    headed = "# a, alpha, d, theta\n[1, 0, 0, q[0]],\n[1, 0, 0, q[1] + pi/2],\n"
    for text in (named, headed):
        found = table_in(text, "t")
        assert found is not None
        assert [row.varies for row in found.rows] == [True, True]
        assert [row.entries["theta"].replace(" ", "").lstrip("+") for row in found.rows] == ["0", "pi/2"]


@pytest.mark.parametrize("name", ["q", "q1", "q_12", "theta3", "th1*", "t2", "q[0]", "d3*", "*"])
def test_a_variable_is_taken_out_of_its_cell(name: str) -> None:
    assert names_variable(name)
    assert constant_part(name) == "0"
    assert constant_part(f"{name} - pi/2") == "- pi/2"
    assert constant_part(f"90 + {name}") == "90"


@pytest.mark.parametrize("cell", ["0", "-pi/2", "d3", "L1 + 0.2", "a_2", "quarter", "tool"])
def test_a_cell_without_a_variable_is_constant(cell: str) -> None:
    assert not names_variable(cell)
    assert constant_part(cell) == cell


def test_a_distance_without_a_number_is_a_slide_where_theta_is_constant() -> None:
    cells = {"a": "0", "alpha": "0", "d": "0.1 + d_3", "theta": "30"}
    slide = row_of_cells(cells, 1, {})
    assert (slide.slides, slide.variable, slide.entries["d"], slide.assumed) == (True, "d_3", "0.1 + 0", True)
    fixed = [row_of_cells(cells, 1, {"d_3": "2"}), row_of_cells({**cells, LABEL: "tool"}, 1, {})]
    assert [(row.slides, row.varies, row.assumed) for row in fixed] == [(False, False, False)] * 2
    turning = row_of_cells({**cells, "theta": "q3"}, 1, {})
    assert (turning.slides, turning.variable, turning.entries["d"]) == (False, "q3", "0.1 + d_3")


def test_a_row_without_theta_turns() -> None:
    row = row_of_cells({"a": "1", "alpha": "0", "d": "d1"}, 1, {})
    assert (row.slides, row.varies, row.entries["d"]) == (False, True, "d1")
