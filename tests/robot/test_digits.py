"""Rounded decimals: which text is which angle, and in which files the rule holds."""

from __future__ import annotations

from decimal import ROUND_DOWN, ROUND_HALF_EVEN, Decimal
from math import pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Robot
from rankdrop.robot.note import NoteOn
from rankdrop.robot.open import open_robot
from rankdrop.robot.quantities import angle
from rankdrop.robot.toml_file import robot_from_toml
from rankdrop.robot.urdf import from_urdf
from robot.urdf_text import joint, robot

PI = Decimal("3.14159265358979323846264338327950288419716939937510")


@pytest.mark.parametrize(
    ("text", "twelfths"),
    [
        ("1.5708", 6), ("-1.5708", -6), ("1.5707", 6), ("1.570796", 6), ("1.57079", 6), ("1.57080", 6), ("3.1416", 12),
        ("3.14159", 12), ("1.57", 6), ("-3.14", -12), ("1.571", 6), ("1.570", 6), ("0.785", 3), ("0.7854", 3),
        ("0.5236", 2), ("0.5235", 2), ("0.2618", 1), ("1.0472", 4), (".5236", 2), ("+2.0944", 8), ("1.57079632679", 6),
        ("1.5708e+00", 6), ("1.5708E0", 6), ("15.708e-1", 6), ("2.618e-1", 1), ("4.7124", 18), ("6.2832", 24),
        ("1.57079632679489661923", 6), ("1.57079632679490", 6), ("0.0015708e3", 6),
    ],
)  # fmt: skip
def test_a_decimal_that_rounds_or_cuts_a_multiple_of_15_degrees_is_that_angle(text: str, twelfths: int) -> None:
    value, change = angle(text)
    assert value == pytest.approx(twelfths * pi / 12, abs=1e-15)
    assert change == pytest.approx(value - float(text), abs=1e-15)


@pytest.mark.parametrize(
    "text",
    [
        "0", "0.0", "0.0000", "-0.00", "1e-17", "4.8006E-17", "0.0001", "0.00", "0.01", "1.5706", "1.5709", "1.5700",
        "1.58", "0.79", "0.52", "1.05", "0.524", "1.047", "0.262", "0.3491", "0.1745", "0.7853982e2", "1.6", "3.1", "3",
        "2", "1.", "1e0", "1.5708e-3", "1.57e1", "31.4159265", "1e300", "0.35", "2.5", "1.2345678",
    ],
)  # fmt: skip
def test_other_decimals_are_what_they_are(text: str) -> None:
    assert angle(text) == (float(text), 0.0)


def test_three_places_mean_multiples_of_45_degrees_and_two_those_of_90() -> None:
    meant = {
        places: [k for k in range(1, 25) if angle(f"{float(k * PI / 12):.{places}f}")[1]] for places in (1, 2, 3, 4)
    }
    assert meant == {1: [], 2: [6, 12, 18, 24], 3: list(range(3, 25, 3)), 4: list(range(1, 25))}


@given(st.integers(1, 24), st.integers(4, 26), st.sampled_from(["", "-"]), st.booleans())
def test_every_multiple_is_read_from_every_number_of_places(k: int, places: int, sign: str, cut: bool) -> None:
    exact = k * PI / 12
    text = str(exact.quantize(Decimal(1).scaleb(-places), rounding=ROUND_DOWN if cut else ROUND_HALF_EVEN))
    value, change = angle(sign + text)
    assert value == float(f"{sign}{exact}")
    assert abs(change) <= 10.0**-places
    assert angle(repr(value)) == (value, 0.0)  # read again, nothing is left to change


@given(st.integers(-24, 24), st.integers(4, 12), st.sampled_from([-2, 2]))
def test_two_units_in_the_last_place_beside_it_is_another_number(k: int, places: int, beside: int) -> None:
    last = Decimal(1).scaleb(-places)
    text = str((k * PI / 12).quantize(last) + beside * last)
    if k == 0 or float(text) == 0.0:
        return
    assert angle(text) == (float(text), 0.0)


def turned(rpy: str, **options: bool) -> Robot:
    inside = f'<origin xyz="0.1 0 1.5708" rpy="{rpy}"/><axis xyz="0 0 1"/><limit lower="-1.5708" upper="3.1416"/>'
    return from_urdf(robot([joint("j1", "a", "b"), joint("j2", "b", "c", inside=inside)]), **options)


def test_rpy_of_a_urdf_is_read_so_and_nothing_else_of_it() -> None:
    second = turned("1.5708 0 0").joints[1]
    assert second.screw[3:].tolist() == [0, -1, 0]
    assert second.frame[:3, 3].tolist() == [0.1, 0, 1.5708]
    assert (second.lower, second.upper) == (-1.5708, 3.1416)


def test_a_note_says_how_many_and_by_how_much() -> None:
    words = str(turned("1.5708 0 -3.1416").notes[-1])
    assert words.startswith("2 angles read as the multiples of 15° they round, at most 7.3e-06 rad; ")
    assert "1 angle read as the multiple of 15° it rounds, at most 0.0008 rad;" in str(turned("1.57 0 0").notes[-1])
    assert not any(note.kind is NoteOn.SQUARED for note in turned("1.5707963267948966 0 0").notes)


def test_as_written_keeps_the_numbers_to_the_bit() -> None:
    literal = turned("1.5708 0 0", as_written=True)
    assert literal.joints[1].screw[3:].tolist() == [0, -np.sin(1.5708), np.cos(1.5708)]
    assert not any(note.kind is NoteOn.SQUARED for note in literal.notes)


FIRST = '[[joints]]\na = 1.5708\nalpha = {0}\nupper = 1.5708\n'
TABLE = 'convention = "standard"\n' + FIRST + "[[joints]]\ntheta = {1}\na = 0.2\n"


@pytest.mark.parametrize("form", ["{}", '"{}"', '" {} rad"'])
def test_alpha_and_theta_of_a_table_are_read_so(form: str) -> None:
    text = TABLE.format(form.format("-1.5708"), form.format("1.571"))
    arm = robot_from_toml(text, file="arm.toml")
    same = from_dh([(1.5708, "-pi/2", 0, 0), (0.2, 0, 0, "pi/2")], convention="standard")
    assert np.array_equal(arm.home, same.home)
    assert arm.joints[0].upper == 1.5708
    literal = robot_from_toml(text, file="arm.toml", as_written=True)
    same = from_dh([(1.5708, -1.5708, 0, 0), (0.2, 0, 0, 1.571)], convention="standard")
    assert np.array_equal(literal.home, same.home)


def test_trailing_zeros_are_digits() -> None:
    assert angle("1.57")[0] == pi / 2
    arm = robot_from_toml(TABLE.format("1.57000", "0.1"), file="arm.toml")
    assert arm.joints[1].screw[3:].tolist() == [0, -np.sin(1.57), np.cos(1.57)]


@pytest.mark.parametrize("value", ['"89.95 deg"', '"pi/2 + 0.0001"', '"1.5708 + 0"', '"90.0 deg"'])
def test_degrees_and_arithmetic_are_taken_at_their_word(value: str) -> None:
    arm, literal = (
        robot_from_toml(TABLE.format(value, "0.1"), file="arm.toml", as_written=way) for way in (True, False)
    )
    if "1.5708" not in value:  # 3.7e-6 rad, which is noise, if no digits
        assert np.array_equal(arm.home, literal.home)
    assert not any("angle" in str(note) for note in arm.notes)


def test_rpy_of_tool_and_base_are_read_so() -> None:
    ends = "[base]\nrpy = [0, 1.5708, 0]\n[tool]\nrpy = [3.1416, 0, 0]\n"
    arm = robot_from_toml(TABLE.format("0.0", "0.0").replace("[[", ends + "[[", 1), file="arm.toml")
    assert arm.joints[0].screw[3:].tolist() == [1, 0, 0]
    assert set(np.abs(arm.home[:3, :3]).ravel()) == {0.0, 1.0}


def test_python_tables_are_taken_at_their_word() -> None:
    arm = from_dh([(0.3, 1.5708, 0, 0), (0.2, "1.5708", 0, 0)], convention="standard")
    assert arm.joints[1].screw[5] == np.cos(1.5708)


def test_open_robot_and_the_command_line_pass_it_on(tmp_path: Path) -> None:
    file = tmp_path / "arm.toml"
    file.write_text(TABLE.format("1.5708", "0.0"))
    assert open_robot(file).joints[1].screw[5] == 0.0
    assert open_robot(file, as_written=True).joints[1].screw[5] == np.cos(1.5708)
