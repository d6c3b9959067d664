"""A line has cells, by the separator that makes as many as the heading has."""

from __future__ import annotations

import pytest

from rankdrop.robot.dh_cells import cells_of_heading, cells_of_row, without_assignment


@pytest.mark.parametrize(
    "line",
    ["1|2|3|4", "| 1 | 2 | 3 | 4 |", "┃1 ┃ 2 ┃ 3 ┃ 4┃", "1 & 2 & 3 & 4 \\\\", "1;2;3;4", "1, 2, 3, 4", "1\t2\t3\t4",
     "1  2   3  4", "1 2 3 4", "[1, 2, 3, 4],  # of link 1", "{1, 2, 3, 4}; // of link 1", "1 2 3 4 % of link 1"],
)  # fmt: skip
def test_a_row_has_its_cells_whatever_separates_them(line: str) -> None:
    assert cells_of_row(line, 4) == ["1", "2", "3", "4"]


def test_the_first_separator_that_fits_counts() -> None:
    """Blanks inside cells stay where commas separate them; between bars nothing else separates."""
    assert cells_of_row("0.1 + 0.2, 90, 0, q1", 4) == ["0.1 + 0.2", "90", "0", "q1"]
    assert cells_of_row("| 1 2 | 3 |", 3) == []


def test_a_comma_between_semicolons_is_decimal() -> None:
    assert cells_of_row("0,5;-1,25;q1", 3) == ["0.5", "-1.25", "q1"]


@pytest.mark.parametrize("line", ["a, b, c", "1, 2", "1, 2, 3, 4", "x = 1, 2, 3", ""])
def test_a_line_of_other_cells_is_no_row(line: str) -> None:
    assert cells_of_row(line, 3) == []


def test_a_heading_has_three_cells_at_least() -> None:
    assert cells_of_heading("[a, alpha, d]") == ["a", "alpha", "d"]
    assert cells_of_heading("a alpha") == []


def test_an_array_is_read_without_its_name() -> None:
    assert without_assignment("T = np.array([[1, 2]])") == "[[1, 2]])"
    assert without_assignment("d = 1") == "d = 1"
