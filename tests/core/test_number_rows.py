"""Rows of plain numbers are read as NumPy reads them; anything else is left to it."""

from __future__ import annotations

import io

import numpy as np
import pytest

from rankdrop import _core


def test_the_bits_are_those_of_numpy() -> None:
    size = np.random.default_rng(1).integers(-300, 300, (500, 3))
    numbers = np.random.default_rng(0).normal(size=(500, 3)) * 10.0**size
    text = "".join(f"{a!r}, {b:.6f} ,{c:.17e}\n" for a, b, c in numbers.tolist())
    expected = np.loadtxt(io.StringIO(text), delimiter=",")
    for given in (text, text.rstrip("\n")):
        np.testing.assert_array_equal(_core.rows_of_text(given, ",", 3), expected)


@pytest.mark.parametrize("text", ["1,+2\n.5,-0.\n", "1e3,2E-3\n", " 1 ,\t2 \n"])
def test_signs_points_and_blanks(text: str) -> None:
    np.testing.assert_array_equal(
        _core.rows_of_text(text, ",", 2), np.loadtxt(io.StringIO(text), delimiter=",", ndmin=2)
    )


@pytest.mark.parametrize(
    "text",
    ["1,2,3\n", "1\n", "1,\n", "1,2\n\n3,4\n", "nan,1\n", "-inf,1\n", "1e400,1\n", "0x1p3,1\n", "1_0,1\n", "1;2\n",
     "+-1,2\n", "1e,2\n", "\ud800,1\n", "1,2\x00\n", "١,2\n", "1,2\r\n"],
)  # fmt: skip
def test_anything_else_is_not_read(text: str) -> None:
    assert _core.rows_of_text(text, ",", 2) is None


def test_tabs_separate_where_they_are_the_separator() -> None:
    assert np.asarray(_core.rows_of_text("1\t2\n", "\t", 2)).tolist() == [[1.0, 2.0]]
    assert _core.rows_of_text("1\t\t2\n", "\t", 2) is None
