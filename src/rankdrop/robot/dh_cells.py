"""The cells of a line: of a table as it is printed, in CSV, Markdown and LaTeX, or of an array in code."""

from __future__ import annotations

import re

_FEWEST_HEADS = 3
_BARS = str.maketrans("┃│║&", "||||")
_SEPARATORS = tuple(map(re.compile, (r"\|", r";", r",", r"\t+", r"\s{2,}", r"\s+")))
_DECIMAL_COMMA = re.compile(r"^(-?\d+),(\d+)$")
_END_OF_ROW = re.compile(r"\\\\\s*$")
_COMMENT = re.compile(r"\s[#%]|//")
_ARRAY = re.compile(r"[\[{]")
_ASSIGNMENT = re.compile(r"^[^|,;\t\d]*?=\s*[\w.]*\(?\s*(?=\[)")


def without_assignment(line: str) -> str:
    """A line without what stands in front of an array: `[0, 0, 1]` of `T = np.array([0, 0, 1]`."""
    return _ASSIGNMENT.sub("", line)


def cells_of_row(line: str, count: int) -> list[str]:
    """The cells of a row, as many as the heading has; empty where the line is no row."""
    cells = _cells(line, count)
    if len(cells) == count and re.search(r"\d", line) and "=" not in line:
        return cells
    return []


def cells_of_heading(line: str) -> list[str]:
    """The cells of a heading, three at least; empty where the line has fewer."""
    return _cells(line, None)


def _cells(line: str, count: int | None) -> list[str]:
    """The cells of a line, by the first separator that makes as many as are wanted; None: at least three.

    Where bars stand between cells, nothing else separates them.
    """
    body = _END_OF_ROW.sub("", _without_comment(line)).translate(_BARS).strip()
    around = "|[](){} \t,;"
    if count is not None and "|" in body:
        around = "| \t"
    body = body.strip(around)
    for separator in _separators(body):
        cells = _cells_between(separator, body)
        enough = count is None and len(cells) >= _FEWEST_HEADS
        if enough or len(cells) == count:
            return cells
    return []


def _separators(body: str) -> tuple[re.Pattern[str], ...]:
    """The separators that the cells of a row may have."""
    if "|" in body:
        return _SEPARATORS[:1]
    return _SEPARATORS


def _cells_between(separator: re.Pattern[str], body: str) -> list[str]:
    """The cells between separators; between semicolons a comma is that of a decimal."""
    cells = [cell.strip(" []{}") for cell in separator.split(body)]
    if separator.pattern == ";":
        return [_DECIMAL_COMMA.sub(r"\1.\2", cell) for cell in cells]
    return cells


def _without_comment(line: str) -> str:
    """A row without a comment behind it and the brackets around it."""
    bare = _COMMENT.split(line, maxsplit=1)[0]
    if _ARRAY.search(bare):
        return bare.strip("[]{}(),; \t")
    return bare
