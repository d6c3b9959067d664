"""Sections of an explanation on the terminal: a heading, then lines or rows."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import RenderableType

    from rankdrop.sections import Section


def print_sections(sections: Iterable[Section]) -> None:
    """Print to stdout: headings bold, notes dim, tables aligned."""
    from rankdrop.cli.terminal import results, show

    console = results()
    for number, section in enumerate(sections):
        show(console, _parts(section, first=number == 0))


def _parts(section: Section, *, first: bool) -> Iterable[RenderableType]:
    from rich import box
    from rich.padding import Padding
    from rich.table import Table
    from rich.text import Text

    if not first:
        yield ""
    yield Text.assemble((section.title, "bold"), f"  {section.summary}" if section.summary else "")
    for line in section.lines:
        yield Padding(Text(line), (0, 0, 0, 2))
    if section.rows:
        table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
        for index, name in enumerate(section.columns):
            table.add_column(name, justify="left" if index in section.texts else "right", overflow="fold")
        for row in section.rows:
            table.add_row(*row)
        yield Padding(table, (0, 0, 0, 2))
    for note in section.notes:
        yield Padding(Text(note, style="dim"), (0, 0, 0, 2))
