"""Rows of a table are found in a text: which form it has, its columns, its variables."""

from __future__ import annotations

import pytest

from rankdrop.errors import RobotError
from rankdrop.robot.dh_rows import is_table, table_in


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


def test_the_joint_variable_is_found_in_a_row() -> None:
    found = table_in("a alpha d theta\n0 0 1 q1\n0 0 q2 0\n0 0 d3* 0\n0 0 1 θ4-90°\n0 0 1 0\n", "t")
    assert found is not None
    assert [(row.slides, row.varies) for row in found.rows] == [
        (False, True), (True, True), (True, True), (False, True), (False, False),
    ]  # fmt: skip
    assert [row.entries["theta"] for row in found.rows] == ["0", "0", "0", "-90°", "0"]


def test_text_without_a_table_has_none() -> None:
    lists = "a = [1, 2]\nalpha = [1]\nd = [1, 2]\n"
    for text in ("nothing known", "alpha, beta, gamma\n1, 2, 3\n", lists, "Link", "a1 = 1"):
        assert not is_table(text)


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


@pytest.mark.parametrize("row", [
    "{'a': %s, 'd': %s, 'alpha': np.pi/2}", '{"alpha": np.pi/2, "a": %s, "d": %s},',
    "dict(a=%s, d=%s, alpha=np.pi/2),", "links.append({'a': %s, 'd': %s, 'alpha': np.pi/2})",
])  # fmt: skip
def test_rows_with_names_are_read(row: str) -> None:
    found = table_in("arm = [\n" + "\n".join(row % (i, 0.1) for i in range(3)) + "\n]\n", "t")
    assert found is not None
    assert [dict(row.entries) for row in found.rows] == [
        {"a": str(i), "d": "0.1", "alpha": "np.pi/2"} for i in range(3)
    ]
    assert [row.line for row in found.rows] == [2, 3, 4]


def test_the_joint_variable_may_be_an_entry_of_a_list() -> None:
    named = "[{'a': 1, 'd': 0, 'alpha': 0, 'theta': q[0]}, {'a': 1, 'd': 0, 'alpha': 0, 'theta': theta[1] + pi/2}]"
    headed = "# a, alpha, d, theta\n[1, 0, 0, q[0]],\n[1, 0, 0, q[1] + pi/2],\n"
    for text in (named, headed):
        found = table_in(text, "t")
        assert found is not None
        assert [row.varies for row in found.rows] == [True, True]
        assert [row.entries["theta"].replace(" ", "").lstrip("+") for row in found.rows] == ["0", "pi/2"]


def test_rows_with_names_that_leave_doubt_are_refused() -> None:
    row = "{'a': 1, 'd': 0, 'alpha': 0},\n"
    with pytest.raises(RobotError, match="t, line 3: the row has not each of a, alpha and d"):
        table_in(row * 2 + "{'d': 0, 'alpha': 0},\n", "t")
    with pytest.raises(RobotError, match="two arms; got rows in 2 lists"):
        table_in(f"one = [\n{row * 2}]\nother = [\n{row * 2}]\n", "t")
    with pytest.raises(RobotError, match="t, line 3: the row may be that of a slide; got 'type': 'prismatic'"):
        table_in(row * 2 + "{'type': 'prismatic', 'a': 1, 'd': 0, 'alpha': 0},\n", "t")
    with pytest.raises(RobotError, match="t, line 3: a call has no end"):
        table_in(row * 2 + "dict(a=1, d=0, alpha=(0", "t")
    assert not is_table("{'a': 1, 'd': 0, 'alpha': 0}")


def test_a_row_with_names_is_read_whole() -> None:
    """However long it is, with brackets inside, limits, and what says that the joint turns."""
    long = "{'name': '" + 500 * "n" + "', 'joint_type': 'revolute', 'a': 1, 'd': 0, 'alpha': 0, 'upper': pi},"
    called = "dict(a=sqrt(2)*(1 + 1), d=0, alpha=0, type='R')"
    found = table_in(f"[{long}\n{called}]", "t")
    assert found is not None
    assert [dict(row.entries) for row in found.rows] == [
        {"a": "1", "d": "0", "alpha": "0", "upper": "pi"}, {"a": "sqrt(2)*(1 + 1)", "d": "0", "alpha": "0"},
    ]  # fmt: skip


def test_a_call_without_arguments_is_a_row_and_values_without_names_are_refused() -> None:
    found = table_in("[RevoluteDH(d=1), RevoluteDH(), Link('d', 1, 'm', 2, 'standard')]", "t")
    assert found is not None
    assert [row.entries.get("d") for row in found.rows] == ["1", None, "1"]
    for call in ("RevoluteDH(0.1, alpha=pi/2)", "RevoluteDH(0.1)", "Link(pi/2)"):
        with pytest.raises(RobotError, match="t, line 2: an argument has no name; got "):
            table_in(f"RevoluteDH(d=1)\n{call}", "t")
    assert not is_table("Link (1) is the base")
