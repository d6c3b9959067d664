"""The rows below a heading: where the table begins and ends, and on which lines its rows are."""

from __future__ import annotations

import pytest

from rankdrop.robot.dh_headed import table_with_heading
from rankdrop.robot.dh_rows import table_in


def framed(rows: list[list[str]], ascii_only: bool) -> list[str]:
    """Rows in a frame of lines, as the package ansitable prints them for Robotics Toolbox."""
    widths = [max(map(len, column)) + 2 for column in zip(*rows, strict=True)]
    left, cross, right = "++", "++", "++"
    line, bar = "-", "|"
    if not ascii_only:
        left, cross, right = "┌└", "┬┴", "┐┘"
        line, bar = "─", "│"
    top, bottom = (left[i] + cross[i].join(line * width for width in widths) + right[i] for i in (0, 1))
    middle = bottom if ascii_only else "├" + "┼".join(line * width for width in widths) + "┤"
    first, *others = (bar + bar.join(cell.center(width) for cell, width in zip(row, widths, strict=True)) + bar
                      for row in rows)  # fmt: skip
    return [top, first, middle, *others, bottom, ""]


@pytest.mark.parametrize("ascii_only", [False, True])
@pytest.mark.parametrize("limits", [False, True])
@pytest.mark.parametrize("n", [2, 3, 4, 5, 6, 7])
def test_configurations_below_a_printed_table_are_no_rows(n: int, limits: bool, ascii_only: bool) -> None:
    """`print(rtb.models.DH.Puma560())` has qr and qz below the table; with n + 1 columns, as many as the table may."""
    head = ["θⱼ", "dⱼ", "aⱼ", "⍺ⱼ", *["q⁻", "q⁺"] * limits]
    rows = [[f"q{i}", "0.1", "0", "-90.0°", *["-160.0°", "160.0°"] * limits] for i in range(1, n + 1)]
    table = ["DHRobot.Puma560: standard DH parameters", *framed([head, *rows], ascii_only)]
    below = framed([["name", *(f"q{i}" for i in range(n))], ["qr", *["90°"] * n], ["qz", *["0°"] * n]], ascii_only)
    alone, whole = (table_in("\n".join(lines), "t") for lines in (table, [*table, *below]))
    assert alone is not None
    assert len(alone.rows) == n
    assert whole is not None
    assert whole.rows == alone.rows


def test_blanks_separate_nothing_between_bars() -> None:
    """Cut at blanks, the line of a configuration has as many cells as the table: it is no row."""
    table = "standard\n| i | θ | d | a | α |\n| 1 | q1 | 0.1 | 0.2 | 90° |\n| 2 | q2 | 0 | 0.3 | 0° |\n"
    below = "\n| name | q0  | q1  | q2  | q3  | q4  |\n| qr   | 0  | 90  | 0  | 0  | 0  |\n"
    found = table_in(table + below, "t")
    assert found is not None
    assert len(found.rows) == 2


def test_rows_know_their_lines() -> None:
    """Several rows of LaTeX in one line have its number."""
    lines = ["A table", "a & alpha & d & theta", "1 & 0 & 0 & q1 \\\\ 2 & 0 & 0 & q2 \\\\", "", "3 & 0 & 0 & q3"]
    table = table_with_heading(lines)
    assert table is not None
    assert [(row.entries["a"], row.line) for row in table.rows] == [("1", 3), ("2", 3), ("3", 5)]


def test_a_table_ends_at_text_and_at_another_heading() -> None:
    head, row = "a,alpha,d,theta", "1,0,0,q1"
    for lines in ([head, row, "The second link is longer.", row], [head, row, head, row], [head, head, row]):
        table = table_with_heading(lines)
        assert table is not None
        assert len(table.rows) == 1
    assert table_with_heading([head, head]) is None


def test_a_first_column_without_a_key_is_the_label_of_its_row() -> None:
    table = table_with_heading(["link | a | alpha | d | theta", "1 (shoulder) | 0 | 90 | 0 | q1"])
    assert table is not None
    assert table.rows[0].label == "1 (shoulder)"
    assert table.rows[0].entries.keys() == {"a", "alpha", "d", "theta"}


def test_the_nearest_heading_names_the_columns() -> None:
    table = table_with_heading(["a, alpha, d, theta", "alpha, a, d, theta", "90, 1, 0, q1"])
    assert table is not None
    assert table.rows[0].entries["a"] == "1"


@pytest.mark.parametrize("between", ["", "|---|---|---|---|", "├───┼───┼───┼───┤", "```"])
def test_empty_lines_and_frames_between_rows_are_left_out(between: str) -> None:
    table = table_with_heading(
        ["| a | alpha | d | theta |", between, "| 1 | 0 | 0 | q1 |", between, "| 2 | 0 | 0 | q2 |"]
    )
    assert table is not None
    assert [row.entries["a"] for row in table.rows] == ["1", "2"]


def test_rows_of_an_array_are_read_behind_its_name() -> None:
    table = table_with_heading(["# a, alpha, d, theta", "T = np.array([[1, 0, 0, 0],", "[2, 0, 0, 0]])"])
    assert table is not None
    assert [row.entries["a"] for row in table.rows] == ["1", "2"]
