"""Rows whose entries have names are read, and refused where they leave doubt."""

from __future__ import annotations

import pytest

from rankdrop.errors import RobotError
from rankdrop.robot.dh_rows import is_table, table_in


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


def test_a_call_of_dict_that_is_no_row_may_have_no_end() -> None:
    found = table_in("{'a': 1, 'd': 0, 'alpha': 0},\n" * 2 + "dict(name=(1", "t")
    assert found is not None
    assert len(found.rows) == 2
