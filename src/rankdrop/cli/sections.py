"""Sections of an explanation on the terminal: a heading, then lines or rows."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from rankdrop.cli import exits

if TYPE_CHECKING:
    from rich.console import RenderableType

    from rankdrop.results import Explanation
    from rankdrop.sections import Section

INDENT = 2
"""Blanks before every line under a heading."""
_GAP = 2  # between columns
_LABEL = 24  # a column of words is wrapped, but not narrower than this


def print_sections(sections: Iterable[Section], *, first: bool = True) -> None:
    """Print to stdout: headings bold, notes dim, tables aligned; a blank line before each but the `first`."""
    from rankdrop.cli.terminal import results, show

    console = results()
    for number, section in enumerate(sections):
        show(console, _parts(section, console.width, first=first and number == 0))


def interrupted(explanation: Explanation) -> int:
    """Exit code where Ctrl-C ended the proof early (what was proven holds), else 0."""
    from rankdrop.cli.terminal import say

    if explanation.far.certificate is None or explanation.far.certificate.complete:
        return exits.FINE
    say("interrupted: the certified radius could have become larger")
    return exits.INTERRUPTED


def _parts(section: Section, width: int, *, first: bool) -> Iterable[RenderableType]:
    from rich.padding import Padding
    from rich.text import Text

    from rankdrop.cli.terminal import TONES

    if not first:
        yield ""
    if section.title or section.summary:
        yield Text.assemble((section.title, TONES[section.tone]), f"  {section.summary}" if section.summary else "")
    for line in section.lines:
        yield _indented(line)
    for columns in _pieces(section, width - INDENT):
        yield Padding(_table(section, columns), (0, 0, 0, INDENT))
    for line in section.after:
        yield _indented(line)
    for note in section.notes:
        yield Padding(Text(note, style="dim"), (0, 0, 0, INDENT))


def _indented(line: str) -> RenderableType:
    """A sentence; blanks before it stay before its second line too."""
    from rich.padding import Padding
    from rich.text import Text

    text = line.lstrip(" ")
    return Padding(Text(text), (0, 0, 0, INDENT + len(line) - len(text)))


def _pieces(section: Section, width: int) -> list[list[int]]:
    """The columns, in as many tables as their numbers need: no number is broken, the first column leads each."""
    if not section.rows:
        return []
    widths = [_least(section, index) for index in range(len(section.columns))]
    pieces: list[list[int]] = [[0]] if widths else []
    for index in range(1, len(widths)):
        used = sum(widths[i] + _GAP for i in pieces[-1])
        if used + widths[index] > width and len(pieces[-1]) > 1:
            pieces.append([0])
        pieces[-1].append(index)
    return pieces


def _least(section: Section, index: int) -> int:
    """Characters that a column needs: its longest cell, or the longest word of a column of words."""
    from rich.cells import cell_len

    cells = [section.columns[index], *(row[index] for row in section.rows)]
    if index not in section.texts:
        return max(map(cell_len, cells))
    words = max(cell_len(word) for cell in cells for word in (cell.split() or [""]))
    return max(words, min(_LABEL, max(map(cell_len, cells))))


def _table(section: Section, columns: list[int]) -> RenderableType:
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
    for index in columns:
        words = index in section.texts
        table.add_column(
            section.columns[index], justify="left" if words else "right", overflow="fold", no_wrap=not words,
            min_width=_least(section, index),
        )  # fmt: skip
    for row in section.rows:
        table.add_row(*(row[index] for index in columns))
    return table
