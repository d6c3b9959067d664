"""Tables that are written one parameter after the other: as lists, and by numbered names."""

from __future__ import annotations

import pytest

from rankdrop.errors import RobotError
from rankdrop.robot.dh_lists import table_of_lists, table_of_numbered_names


@pytest.mark.parametrize(
    "names",
    [("a", "alpha", "d"), ("as", "alphas", "ds"), ("dh_a", "dh_alpha", "dh_d"), ("a_ur5", "alpha_ur5", "d_ur5"),
     ("UR5_A", "UR5_ALPHA", "UR5_D")],
)  # fmt: skip
@pytest.mark.parametrize("form", ["{} = [{}, {}]", "{}: [{} {}]", "{} = np.array([{}, {}])", "double {} = {{{}, {}}};"])
def test_a_list_for_each_parameter_is_a_table(names: tuple[str, str, str], form: str) -> None:
    values = (("1", "2"), ("3", "4"), ("5", "6"))
    lines = [form.format(name, *pair) for name, pair in zip(names, values, strict=True)]
    table = table_of_lists(lines, "t")
    assert table is not None
    assert [dict(row.entries) for row in table.rows] == [
        {"a": "1", "alpha": "3", "d": "5"}, {"a": "2", "alpha": "4", "d": "6"},
    ]  # fmt: skip


def test_offsets_are_a_list_too() -> None:
    table = table_of_lists(["a = [1]", "alpha = [2]", "d = [3]", "theta_offset = [4]"], "t")
    assert table is not None
    assert dict(table.rows[0].entries) == {"a": "1", "alpha": "2", "d": "3", "offset": "4"}


def test_lists_that_are_no_table() -> None:
    for lines in (["a = [1]", "alpha = [1]"], ["a = [1]", "alpha = [1]", "d = [1, 2]"],
                  ["a_x = [1]", "alpha_x = [1]", "d_y = [1]"]):  # fmt: skip
        assert table_of_lists(lines, "t") is None


def test_lists_of_two_arms_are_refused() -> None:
    lines = ["a = [1]", "alpha = [0]", "d = [0]"]
    assert table_of_lists([*lines, *lines], "t") is not None
    with pytest.raises(RobotError, match="t: the file has two arms; got a again"):
        table_of_lists([*lines, "a = [2]"], "t")
    with pytest.raises(RobotError, match="t: the file has two arms; got 2 lists of alpha"):
        table_of_lists([*lines, "a_2 = [1]", "alpha_2 = [0]", "d_2 = [0]"], "t")


def test_numbered_names_from_0_are_those_of_the_link_before() -> None:
    lines = ["alpha0 = 0, a0 = 1, d1 = 2, q1 = q1", "alpha1 = 3, a1 = 4, d2 = 5, q2 = q2 - pi/2"]
    table = table_of_numbered_names(lines)
    assert table is not None
    assert table.convention == "modified"
    assert [(dict(row.entries), row.line, row.varies) for row in table.rows] == [
        ({"a": "1", "alpha": "0", "d": "2", "theta": "0"}, 1, True),
        ({"a": "4", "alpha": "3", "d": "5", "theta": "- pi/2"}, 2, True),
    ]


def test_numbered_names_from_1_say_no_convention() -> None:
    lines = ["a1 = 1; a2 = 2; % a1 = 9", "d1 = 3; d2 = 4;", "alpha1 = 5; alpha2 = 6;"]
    table = table_of_numbered_names(lines)
    assert table is not None
    assert table.convention == ""
    assert [(dict(row.entries), row.line, row.varies) for row in table.rows] == [
        ({"a": "1", "alpha": "5", "d": "3"}, 2, None), ({"a": "2", "alpha": "6", "d": "4"}, 2, None),
    ]  # fmt: skip
    assert table.constants["a2"] == "2"


@pytest.mark.parametrize("first", [0, 1, 2])
def test_names_that_all_count_from_one_number_say_no_convention(first: int) -> None:
    rows = [f"dict(a{i}=1, alpha{i}=2, d{i}=3)" for i in (first, first + 1)]
    table = table_of_numbered_names(rows)
    assert table is not None
    assert table.convention == ""
    assert [dict(row.entries) for row in table.rows] == [{"a": "1", "alpha": "2", "d": "3"}] * 2


def test_numbered_names_of_one_row_are_no_table() -> None:
    assert table_of_numbered_names(["a1 = 1, alpha1 = 0, d1 = 0"]) is None
    assert table_of_numbered_names(["a1 = 1, a2 = 1, d1 = 0, d2 = 0"]) is None
