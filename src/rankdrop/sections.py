"""A result as sections of text: what the terminal prints and a notebook shows."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from html import escape


@dataclass(frozen=True, slots=True)
class Section:
    """A heading with a summary, lines, and at most one table.

    Attributes:
        title: heading.
        summary: what stands beside it, one line.
        lines: sentences under it.
        columns: headings of the table.
        rows: its cells.
        texts: indices of the columns that hold words; the others hold numbers.
        notes: smaller print below.
    """

    title: str
    summary: str = ""
    lines: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    texts: tuple[int, ...] = (0,)
    notes: tuple[str, ...] = ()


def html(sections: Iterable[Section]) -> str:
    """The sections as HTML for a notebook; no style beyond what the notebook has, nothing loaded from elsewhere."""
    return "".join(_html(section) for section in sections)


def _html(section: Section) -> str:
    parts = [f"<p><b>{escape(section.title)}</b> {escape(section.summary)}</p>"]
    parts += [f"<div>{escape(line)}</div>" for line in section.lines]
    if section.rows:
        head = "".join(f"<th>{escape(name)}</th>" for name in section.columns)
        body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in section.rows)
        parts.append(f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>")
    parts += [f"<div><small>{escape(note)}</small></div>" for note in section.notes]
    return "".join(parts)
