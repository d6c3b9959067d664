"""The units of a table: stated, shown by the numbers, or refused."""

from __future__ import annotations

import pytest

from rankdrop.errors import RobotError
from rankdrop.robot.dh_rows import WrittenTable
from rankdrop.robot.dh_units import angle_unit, length_unit


@pytest.mark.parametrize(
    ("line", "unit"),
    [("lengths in mm", "mm"), ("all in m and rad", "m"), ("Units: cm", "cm"), ("all in cm", "cm")],
)
def test_a_line_on_lengths_states_their_unit_whatever_their_size(line: str, unit: str) -> None:
    for sizes in ([0.0, 0.4], [0.0, 20.0], [0.0, 400.0], [0.0, 0.1, 574.0]):
        assert length_unit(WrittenTable(()), f"standard\n{line}\n", "t", sizes) == unit


@pytest.mark.parametrize(
    ("line", "unit", "sizes"),
    [("standard DH, m, rad", "m", [0.1, 574.0]), ("a and d in metres, alpha in degrees", "m", [0.4]),
     ("(in millimetres)", "mm", [20.0]), ("# in cm", "cm", [20.0]), ("in mm", "mm", [400.0])],
)  # fmt: skip
def test_a_unit_in_passing_counts_where_the_numbers_agree(line: str, unit: str, sizes: list[float]) -> None:
    assert length_unit(WrittenTable(()), line, "t", [0.0, *sizes]) == unit


@pytest.mark.parametrize("line", ["for row in m:", "for a, d in mm:", "a drawing", "m"])
def test_code_and_letters_state_no_unit(line: str) -> None:
    assert length_unit(WrittenTable(()), line, "t", [0.0, 0.4]) == "m"
    assert length_unit(WrittenTable(()), line, "t", [0.0, 400.0]) == "mm"


@pytest.mark.parametrize(
    ("text", "sizes"),
    [("in m, in mm", [0.0, 1.0]), ("", [0.0, 20.0]), ("", [0.0, 0.08, 574.0]), ("reach in m", [0.0, 475.0]),
     ("repeats to 0.1 in mm", [0.0, 0.4])],
)  # fmt: skip
def test_lengths_in_doubt_are_refused(text: str, sizes: list[float]) -> None:
    with pytest.raises(RobotError, match=r"lengths in cm$"):
        length_unit(WrittenTable(()), text, "t", sizes)


def test_where_each_length_has_its_own_unit_none_is_in_doubt() -> None:
    assert length_unit(WrittenTable(()), "tolerance in mm", "t", [0.0]) == "m"


def test_the_heading_comes_before_a_line() -> None:
    assert length_unit(WrittenTable((), units={"a": "mm"}), "in m", "t", [0.0, 0.4]) == "mm"


@pytest.mark.parametrize(
    ("text", "largest", "unit"),
    [("", 1.5708, "rad"), ("", 90.0, "deg"), ("in rad", 2.0, "rad"), ("deg, rad", 90.0, "deg")],
)  # fmt: skip
def test_angles_show_their_unit(text: str, largest: float, unit: str) -> None:
    assert angle_unit(WrittenTable(()), text, "t", [0.0, largest]) == unit


@pytest.mark.parametrize(("text", "largest"), [("in radians", 90.0), ("in degrees", 1.0), ("", 10.0)])
def test_angles_in_doubt_are_refused(text: str, largest: float) -> None:
    with pytest.raises(RobotError, match=r"90deg$"):
        angle_unit(WrittenTable(()), text, "t", [0.0, largest])
