"""Rows with a name for each entry: `{'a': 0, 'd': 0.1, 'alpha': pi/2}`, `dict(a=0, d=0.1, alpha=pi/2)`."""

from __future__ import annotations

import re
from dataclasses import dataclass

from rankdrop.errors import RobotError
from rankdrop.robot.dh_code import call_arguments, call_without_end, code_of, constants_in, line_at, line_starts
from rankdrop.robot.dh_variable import row_of_cells
from rankdrop.robot.dh_written import NEEDED, WrittenRow, WrittenTable, names_twist, two_arms

_DICT = "dict("
_ROW = re.compile(r"\{(?P<items>[^{}]*)\}|\bdict\(")
_ENTRY = re.compile(
    r"(?<!\w)[\"']?(?P<key>alpha|theta|offset|lower|upper|a|d)[\"']?\s*[:=]\s*[\"']?(?P<value>[^,:={}\"'\n]+)"
)
_KIND = re.compile(
    r"(?<!\w)[\"']?(?:(?:joint_?)?(?:type|kind)|sigma|prismatic)[\"']?\s*[:=](?P<value>[^,]*)", re.IGNORECASE
)
_TURNING = frozenset(("r", "revolute", "rotary", "rotational", "0", "false"))


@dataclass(frozen=True)
class _NamedRow:
    """A row in brackets.

    Attributes:
        items: the text between the brackets.
        line: of the opening bracket.
        in_another_list: a list ends between it and the row before.
        closed: it has a closing bracket.
    """

    items: str
    line: int
    in_another_list: bool
    closed: bool


def table_of_named_rows(lines: list[str], file: str) -> WrittenTable | None:
    """The table of rows with names; None where there are fewer than two.

    Raises:
        RobotError: a row without an end, without each of a, alpha and d, or of a slide; rows in several lists.
    """
    code = code_of(lines)
    constants = constants_in(code.splitlines())
    rows: list[WrittenRow] = []
    incomplete: list[int] = []  # lines of rows without a or d
    lists = 1
    for row in _rows_in(code):
        _refuse_row_without_end(row, file)
        if rows and row.in_another_list:
            lists += 1
        cells = {entry["key"]: entry["value"].strip() for entry in _ENTRY.finditer(row.items)}
        if cells.keys() >= NEEDED:
            _refuse_slide(row, file)
            rows.append(row_of_cells(cells, row.line, constants))
        elif "alpha" in cells:
            incomplete.append(row.line)
    if len(rows) < 2:
        return None
    if incomplete:
        raise RobotError("the row has not each of a, alpha and d", where=f"{file}, line {incomplete[0]}",
                         mend="write all three, 0 for none")  # fmt: skip
    if lists > 1:
        raise two_arms(file, f"rows in {lists} lists")
    return WrittenTable(tuple(rows), constants=constants)


def _rows_in(code: str) -> list[_NamedRow]:
    """The brackets in a text that may be rows."""
    rows: list[_NamedRow] = []
    starts = line_starts(code)
    end = 0  # of the row before
    found = _ROW.search(code)
    while found is not None:
        line = line_at(found.start(), starts)
        in_another_list = "]" in code[end : found.start()]
        items = found["items"]
        end = found.end()
        closed = True
        if items is None:
            arguments = call_arguments(code, found.end())
            items = ",".join(arguments.words)
            end = arguments.end
            closed = arguments.closed
        rows.append(_NamedRow(items, line, in_another_list, closed))
        found = _ROW.search(code, end)
    return rows


def _refuse_row_without_end(row: _NamedRow, file: str) -> None:
    if not row.closed and names_twist(row.items):
        raise call_without_end(_DICT, f"{file}, line {row.line}")


def _refuse_slide(row: _NamedRow, file: str) -> None:
    """Refuse a row that says of its joint anything but that it turns: what its d then means is not known."""
    kind = _KIND.search(row.items)
    if kind is not None and kind["value"].strip("\"' ").lower() not in _TURNING:
        raise RobotError("the row may be that of a slide", where=f"{file}, line {row.line}", got=kind[0].strip(),
                         mend="write a table with a heading, and q for the variable in its column d")  # fmt: skip
