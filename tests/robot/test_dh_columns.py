"""A heading names its columns, their units and its convention."""

from __future__ import annotations

import pytest

from rankdrop.robot.dh_columns import heading_in
from rankdrop.robot.dh_rows import table_in


@pytest.mark.parametrize(
    "heading",
    ["a,alpha,d,theta", "i | a_i | α_i | d_i | θ_i", "# [a, alpha, d, theta0]",
     "link length;twist;link offset;joint angle",
     "a (mm)  alpha (deg)  d (mm)  theta (deg)"],
)  # fmt: skip
def test_a_heading_names_its_columns(heading: str) -> None:
    row = "2, 90, 3, 45"
    if "|" in heading:
        row = "1 | 2 | 90 | 3 | 45"
    found = table_in(f"{heading}\n{row}\n", "t")
    assert found is not None
    entries = {{"offset": "theta"}.get(key, key): entry for key, entry in found.rows[0].entries.items()}
    assert entries == {"a": "2", "alpha": "90", "d": "3", "theta": "45"}
    assert found.convention == ""


def test_indices_of_the_link_before_say_the_convention() -> None:
    for heading in ("a_{i-1} alpha_{i-1} d_i theta_i", "aⱼ₋₁ ⍺ⱼ₋₁ dⱼ θⱼ", "a(i-1) alpha(i-1) d(i) theta(i)"):
        found = table_in(f"{heading}\n0 0 1 q1\n", "t")
        assert found is not None
        assert found.convention == "modified"


@pytest.mark.parametrize(
    ("unit", "known"),
    [("mm", "mm"), ("cm", "cm"), ("m", "m"), ("°", "deg"), ("degrees", "deg"), ("rad", "rad"), ("Radians", "rad")],
)
def test_a_heading_states_units(unit: str, known: str) -> None:
    for cell in (f"d [{unit}]", f"d ({unit})", f"d{{{unit}}}"):
        heading = heading_in(f"a | alpha | {cell} | theta")
        assert heading is not None
        assert heading.units == {"d": known}


@pytest.mark.parametrize(
    "line", ["a* | alpha | d | theta*", "link \t length | link  twist | link  offset | joint  angle"]
)
def test_stars_and_blanks_are_no_part_of_a_name(line: str) -> None:
    heading = heading_in(line)
    assert heading is not None
    assert heading.keys == ("a", "alpha", "d", "theta")


def test_next_to_r_the_length_d_is_the_a_of_others() -> None:
    heading = heading_in("j, alpha, d, theta, r")
    assert heading is not None
    assert heading.keys == ("", "alpha", "a", "theta", "d")
    assert heading.convention == "modified"


@pytest.mark.parametrize(
    "line",
    ["a, d, theta", "a, alpha, theta", "a, a, alpha, d", "alpha beta gamma", "alpha, d, r" + 400 * " ", "alpha d"],
)
def test_a_line_without_each_of_a_alpha_and_d_once_is_no_heading(line: str) -> None:
    assert heading_in(line) is None


def test_limits_and_offsets_have_columns() -> None:
    for names in ("offset, q-, q+", "theta0, qmin, qmax", "Offset, lower limit, Upper Limit", "off, min, max"):
        heading = heading_in(f"a, alpha, d, theta, {names}")
        assert heading is not None
        assert heading.keys[4:] == ("offset", "lower", "upper")
