"""A result as sections of text: what the terminal prints and a notebook shows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from html import escape
from importlib import import_module
from types import ModuleType

_WORDED = {
    "Analysis": "rankdrop.text.analysis", "Conditions": "rankdrop.text.conditions",
    "Covered": "rankdrop.text.coverings", "PartSet": "rankdrop.text.explanation", "Progress": "rankdrop.text.jobs",
    "Verified": "rankdrop.text.certificates",
    "Explanation": "rankdrop.text.explanation", "Far": "rankdrop.text.explanation", "Family": "rankdrop.text.family",
    "FamilyEvidence": "rankdrop.text.family",
    "FamilyName": "rankdrop.text.names", "Dependence": "rankdrop.text.names",
    "ExactConditions": "rankdrop.text.conditions",
    "Assumption": "rankdrop.text.conditions", "UnrealSet": "rankdrop.text.conditions",
    "UndividedSet": "rankdrop.text.conditions", "Designs": "rankdrop.text.designs",
    "SideBySide": "rankdrop.text.designs", "Parting": "rankdrop.text.structure",
    "BlockForm": "rankdrop.text.structure", "BlockLoss": "rankdrop.text.structure",
    "LintResult": "rankdrop.text.condition_tests",
    "Flags": "rankdrop.text.condition_tests", "Between": "rankdrop.text.condition_tests",
    "Executed": "rankdrop.text.procedure", "Remark": "rankdrop.text.procedure",
    "Disagreement": "rankdrop.text.procedure",
    "Representation": "rankdrop.text.orientation", "Representations": "rankdrop.text.orientation",
    "LinkJacobian": "rankdrop.text.link_jacobian", "Agreement": "rankdrop.text.link_jacobian",
    "LostDirection": "rankdrop.text.directions", "FramedDirections": "rankdrop.text.directions",
    "Idealised": "rankdrop.text.ideal", "Escape": "rankdrop.text.ways_out", "Nearest": "rankdrop.text.nearest",
    "ScrewSystem": "rankdrop.text.screw_systems", "AlwaysSingular": "rankdrop.text.screw_systems",
    "Unfinished": "rankdrop.text.unfinished", "NotDerived": "rankdrop.text.unfinished",
    "Determinants": "rankdrop.text.determinants", "MinorsLeft": "rankdrop.text.determinants",
    "Minor": "rankdrop.text.determinants",
    "Search": "rankdrop.text.searches", "Unseen": "rankdrop.text.searches",
    "Contradiction": "rankdrop.text.contradictions",
    "DerivationRemark": "rankdrop.text.remarks", "RobotNote": "rankdrop.text.robots",
    "Robot": "rankdrop.text.robots", "Relation": "rankdrop.text.relations",
    "SelfMotion": "rankdrop.text.redundancy", "Redundancy": "rankdrop.text.redundancy",
}  # fmt: skip
"""Class of a record -> module that words it."""


class Formula(str):
    """A line that is broken as mathematics: after a comma, before a sign or a bracket, not between any two words."""

    __slots__ = ()

    def __json__(self) -> str:
        return str(self)


@dataclass(frozen=True, slots=True)
class Section:
    """A heading with a summary, lines, and at most one table.

    Attributes:
        title: heading.
        summary: what stands beside it, one line.
        lines: sentences and formulas under it.
        columns: headings of the table.
        rows: its cells.
        texts: indices of the columns that hold words; the others hold numbers.
        after: sentences under the table.
        notes: smaller print below.
        tone: of the heading, where it is a verdict: "good", "warning" or "bad"; the words say it without a colour too.
    """

    title: str
    summary: str = ""
    lines: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    texts: tuple[int, ...] = (0,)
    after: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    tone: str = ""


def words_of(record: object) -> ModuleType:
    """The module that words a record, loaded when words are first asked for: no record imports its words.

    Args:
        record: of one of the classes in `_WORDED`.

    Example:
        >>> from rankdrop.results.known import shipped
        >>> words_of(shipped("planar2r").families[0]).__name__
        'rankdrop.text.family'
    """
    return _words_of_class(type(record).__name__)


@cache
def _words_of_class(name: str) -> ModuleType:
    """The module that words a class of records."""
    return import_module(_WORDED[name])


def text(sections: Iterable[Section]) -> str:
    """The sections as plain text, lines as long as they are."""
    return "\n\n".join("\n".join(_lines(section)) for section in sections)


def _lines(section: Section) -> Iterator[str]:
    heading = f"{section.title}  {section.summary}".strip()
    if heading:
        yield heading
    yield from (f"  {line}" for line in section.lines)
    if section.rows:
        table = (section.columns, *section.rows)
        widths = [max(len(row[index]) for row in table) for index in range(len(section.columns))]
        for row in table:
            aligned = (
                cell.ljust(width) if index in section.texts else cell.rjust(width)
                for index, (cell, width) in enumerate(zip(row, widths, strict=True))
            )
            yield f"  {'  '.join(aligned)}".rstrip()
    yield from (f"  {line}" for line in (*section.after, *section.notes))


def html(sections: Iterable[Section]) -> str:
    """The sections as HTML for a notebook; no style beyond what the notebook has, nothing loaded from elsewhere."""
    return "".join(_html(section) for section in sections)


def _html(section: Section) -> str:
    heading = f"<p><b>{escape(section.title)}</b> {escape(section.summary)}</p>"
    if section.title or section.summary:
        parts = [heading]
    else:
        parts = []
    parts += [_line(line) for line in section.lines]
    if section.rows:
        head = "".join(f"<th>{escape(name)}</th>" for name in section.columns)
        body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in section.rows)
        parts.append(f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>")
    parts += [_line(line) for line in section.after]
    parts += [f"<div><small>{escape(note)}</small></div>" for note in section.notes]
    return "".join(parts)


def _line(text: str) -> str:
    """A sentence; blanks before it are an indent."""
    inset = len(text) - len(text.lstrip(" "))
    if inset:
        style = f' style="margin-left:{inset / 2:g}em"'
    else:
        style = ""
    return f"<div{style}>{escape(text.strip())}</div>"
