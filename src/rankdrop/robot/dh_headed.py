"""A table with a heading that names its columns: as it is printed, in CSV, Markdown or LaTeX, or above an array."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

from rankdrop.robot.dh_cells import cells_of_row, without_assignment
from rankdrop.robot.dh_code import constants_in
from rankdrop.robot.dh_columns import heading_in
from rankdrop.robot.dh_latex import rows_of_line
from rankdrop.robot.dh_variable import LABEL, row_of_cells
from rankdrop.robot.dh_written import WrittenRow, WrittenTable

_FRAME = re.compile(r"[+\-=─━═╋┼┳┻┏┓┗┛┣┫┌┐└┘├┤┬┴|┃│\s:]+|```\w*")
_CLOSED = re.compile(r"\s*[└┗╚╰]")
_RULE = re.compile(r"\s*\+[-=+]+\+\s*")


class _RowText(NamedTuple):
    """A text that may be a row, and the number of its line: LaTeX may have several rows in one line."""

    text: str
    line: int


def table_with_heading(lines: list[str]) -> WrittenTable | None:
    """The table below the first heading that has rows; None where there is none."""
    pieces = _row_texts(lines)
    constants = constants_in(lines)
    for place, piece in enumerate(pieces):
        heading = heading_in(piece.text)
        if heading is None:
            continue
        first_key = heading.keys[0] or LABEL
        rows = _rows_below(pieces, place + 1, (first_key, *heading.keys[1:]), constants)
        if rows:
            return WrittenTable(rows, heading.convention, heading.units, constants=constants)
    return None


def _row_texts(lines: list[str]) -> list[_RowText]:
    """The texts of a file that may be rows."""
    pieces: list[_RowText] = []
    for number, line in enumerate(lines, 1):
        for text in rows_of_line(line):
            pieces.append(_RowText(text, number))
    return pieces


def _rows_below(
    pieces: list[_RowText], start: int, keys: tuple[str, ...], constants: Mapping[str, str]
) -> tuple[WrittenRow, ...]:
    """The rows below a heading, up to the end of the table, or to another heading.

    Args:
        pieces: all texts that may be rows.
        start: place of the first text below the heading.
        keys: of the columns.
        constants: names with their expressions.
    """
    rows: list[WrittenRow] = []
    for place in range(start, len(pieces)):
        if rows and _ends_table(pieces, place):
            break
        piece = pieces[place]
        text = without_assignment(piece.text)
        if not text.strip() or _FRAME.fullmatch(text):
            continue
        cells = cells_of_row(text, len(keys))
        if cells:
            by_key = dict(zip(keys, cells, strict=True))
            rows.append(row_of_cells(by_key, piece.line, constants))
        elif rows or heading_in(piece.text) is not None:
            break
    return tuple(rows)


def _ends_table(pieces: list[_RowText], place: int) -> bool:
    """Whether a line closes the frame of a table; the printout may go on with a table of configurations."""
    text = pieces[place].text
    if _CLOSED.match(text):
        return True
    return not text.strip() and _RULE.fullmatch(pieces[place - 1].text) is not None
