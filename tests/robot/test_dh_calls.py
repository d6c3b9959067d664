"""Calls of toolboxes are the rows of a table: their arguments, their limits, the names that they are assigned to."""

from __future__ import annotations

import pytest

from rankdrop.errors import RobotError
from rankdrop.robot.dh_calls import table_of_calls
from rankdrop.robot.dh_rows import is_table, table_in
from rankdrop.robot.dh_written import WrittenTable


def read(*lines: str) -> WrittenTable:
    """The table of lines of calls."""
    table = table_of_calls(list(lines), "t")
    assert table is not None
    return table


def test_a_call_goes_on_over_several_lines() -> None:
    """What stands on the lines below is read; it was left out, and alpha taken as 0."""
    lines = ["L = [", "RevoluteDH(d=0.1, a=0.2,", "  alpha=pi / 2),", "RevoluteDH(", "  d=0.3,  # up", "  a=0.4,"]
    found = table_in("\n".join([*lines, "  ),", "]"]), "t")
    assert found is not None
    assert [dict(row.entries) for row in found.rows] == [
        {"a": "0.2", "alpha": "pi / 2", "d": "0.1", "offset": "0"}, {"a": "0.4", "d": "0.3", "offset": "0"},
    ]  # fmt: skip
    assert [row.line for row in found.rows] == [2, 4]


def test_a_statement_of_matlab_goes_on_after_three_points() -> None:
    lines = ["L(1) = Link([0 0.1 ...", "  0.2 pi/2], ... % the shoulder", "  'modified');"]
    found = table_in("\n".join([*lines, "L(2) = Link([0 0 0.3 0], 'modified');"]), "t")
    assert found is not None
    assert found.convention == "modified"
    assert [dict(row.entries) for row in found.rows] == [
        {"a": "0.2", "alpha": "pi/2", "d": "0.1", "offset": "0"}, {"a": "0.3", "alpha": "0", "d": "0", "offset": "0"},
    ]  # fmt: skip
    assert [row.line for row in found.rows] == [1, 4]


def test_a_call_without_arguments_is_a_row_and_values_without_names_are_refused() -> None:
    found = table_in("[RevoluteDH(d=1), RevoluteDH(), Link('d', 1, 'm', 2, 'standard')]", "t")
    assert found is not None
    assert [row.entries.get("d") for row in found.rows] == ["1", None, "1"]
    for call in ("RevoluteDH(0.1, alpha=pi/2)", "RevoluteDH(0.1)", "Link(pi/2)"):
        with pytest.raises(RobotError, match="t, line 2: an argument has no name; got "):
            table_in(f"RevoluteDH(d=1)\n{call}", "t")
    assert not is_table("Link (1) is the base")


@pytest.mark.parametrize(
    "call",
    ["Link('theta', 0, 'd', 0.1, 'a', 0.2, 'alpha', 0.3)", "Link([0 0.1 0.2 0.3])", "Link([0, 0.1, 0.2, 0.3])",
     "link([0.3 0.2 0 0.1])", "RevoluteDH(d=0.1, a=0.2, alpha=0.3)", "rtb.DHLink(alpha=0.3, a=0.2, d=0.1)",
     "Revolute('d', 0.1, 'a', 0.2, 'alpha', 0.3)", "Link('revolute', 'd', 0.1, 'a', 0.2, 'alpha', 0.3, 'sym')"],
)  # fmt: skip
def test_a_row_is_the_same_in_each_form_of_its_call(call: str) -> None:
    table = read(call)
    assert [dict(row.entries) for row in table.rows] == [{"d": "0.1", "a": "0.2", "alpha": "0.3", "offset": "0"}]
    assert (table.convention, table.radians, table.rows[0].slides) == ("standard", True, False)


@pytest.mark.parametrize(
    "call",
    ["Prismatic('theta', 1, 'd', 2, 'a', 3)", "PrismaticDH(theta=1, a=3)", "Link([1 2 3 0 1])",
     "Link('theta', 1, 'a', 3)", "Link('theta', 1, 'd', 2, 'a', 3, 'prismatic')"],
)  # fmt: skip
def test_the_d_of_a_slide_is_its_variable(call: str) -> None:
    row = read(call).rows[0]
    assert row.slides
    assert (row.entries["theta"], row.entries["a"]) == ("1", "3")
    assert "d" not in row.entries


@pytest.mark.parametrize("call", ["RevoluteMDH(a=1)", "Link([0 0 1 0], 'modified')", "DHLink(a=1, mdh=True)"])
def test_a_call_says_that_it_is_modified(call: str) -> None:
    assert read(call).convention == "modified"


@pytest.mark.parametrize(
    ("limits", "lower", "upper"),
    [("[-pi, pi]", "(-pi)", "(pi)"), ("[-165 165]*deg", "(-165)*deg", "(165)*deg"), ("'none'", None, None),
     ("deg2rad([-360 360])", "(-360)*pi/180", "(360)*pi/180"), ("[-deg2rad(9), 1]", "(-deg2rad(9))", "(1)")],
)  # fmt: skip
def test_limits_are_arguments_or_statements_of_their_own(limits: str, lower: str | None, upper: str | None) -> None:
    argument = read(f"L(1) = RevoluteDH(a=1, qlim={limits});")
    statement = read("L(1) = RevoluteDH(a=1);", f"L(1).qlim = {limits};")
    for table in (argument, statement):
        entries = table.rows[0].entries
        assert (entries.get("lower"), entries.get("upper")) == (lower, upper)


def test_an_offset_belongs_to_the_call_of_its_name() -> None:
    table = read("L(1) = Link([0 1 0 0]);", "L(2) = Link([0 1 0 0 0 0.5]);", "L(2).offset = pi/2;")
    assert [row.entries["offset"] for row in table.rows] == ["0", "pi/2"]


def test_the_first_number_without_a_name_is_reported() -> None:
    with pytest.raises(RobotError, match=r"t, line 1: an argument has no name; got 0\.1;"):
        read("RevoluteDH(0.1, 0.2, alpha=pi/2)")
