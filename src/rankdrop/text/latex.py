r"""The tables of an analysis as LaTeX, laid out as AM print them (Tables 3–5): θ columns, dimension, lost motion.

What is written compiles with pdfLaTeX and the package amsmath, and longtable where a table needs more than a page:
every letter that is not plain is set as mathematics, and what has no sign there is left out.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from math import ceil

from rankdrop.families.corank_families import CorankSummary
from rankdrop.families.derivation import Derivation
from rankdrop.families.record import Family
from rankdrop.robot.model import Robot
from rankdrop.text.families import JOINT, WORDS, Column, at_witness, columns, lines_of, restrict_to_limits, share_text
from rankdrop.text.joint_values import witness_text
from rankdrop.text.lost import lost_note

_PLAIN = {
    "\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": "$<$", ">": "$>$", "|": "$|$", '"': "''",
    "…": r"\dots{}", "–": "--", "—": "---", "“": "``", "”": "''", "’": "'", "\u00a0": "~",
}  # fmt: skip
_SIGNS = {
    "−": "-", "±": r"\pm", "×": r"\times", "·": r"\cdot", "°": r"^\circ", "≤": r"\le", "≥": r"\ge", "≠": r"\ne",
    "≈": r"\approx", "∈": r"\in", "∥": r"\parallel", "⟂": r"\perp", "π": r"\pi", "θ": r"\theta", "σ": r"\sigma",
    "ω": r"\omega", "α": r"\alpha", "β": r"\beta", "Δ": r"\Delta", "²": "^2", "³": "^3", "∞": r"\infty", "→": r"\to",
}  # fmt: skip
_NUMBERED = re.compile(r"([θσqωv])(\d+)")
_WORDS, _COLUMN, _DEGREES = 0.8, 0.052, 0.07
"""Of the width of a page: what two columns of words share, what a joint takes of that, what decimals add."""
_LINES = 8  # conditions of one row that are printed; the rest is in the JSON
_PAGE, _LINE = 38, 62  # lines of a table that fits one page with its caption; characters of a line of the page
_LONGEST = 1500  # characters of one condition


def latex_tables(
    robot: Robot, rank: int, coranks: Sequence[CorankSummary], families: Sequence[Family],
    exact: Derivation | None = None, *, limits: bool = False,
) -> str:  # fmt: skip
    r"""One table environment for each corank, with caption and label; under each the conditions of coupled joints.

    Args:
        robot: the arm.
        rank: the generic one.
        coranks, families: of its analysis.
        exact: exact conditions held against the families, if there are any.
        limits: values of pinned joints inside the joint limits only.

    Returns:
        Lines of LaTeX; the first says what they need.
    """
    parts, long = [""], False
    for summary in coranks:
        rows = [family for family in families if family.corank == summary.corank]
        if rows:
            table, breaks = _table(robot, rank, summary, rows, exact, limits=limits)
            parts.append(table)
            long = long or breaks
    parts[0] = r"% needs \usepackage{amsmath,longtable}" if long else r"% needs \usepackage{amsmath}"
    if len(parts) == 1:
        parts.append(f"% {as_text(robot.name)}: no families were found, which is no proof that there are none")
    return "\n\n".join(parts) + "\n"


def _table(
    robot: Robot, rank: int, summary: CorankSummary, rows: Sequence[Family], exact: Derivation | None, *, limits: bool
) -> tuple[str, bool]:
    """The table and whether it breaks over pages."""
    every = [column for column in columns(robot, summary.corank) if column.printed]
    share, name = summary.completeness, re.sub(r"[^A-Za-z0-9-]+", "-", robot.name)
    caption = (
        f"{as_text(robot.name)}: singularities of corank {summary.corank} (rank {summary.rank} of {rank}). "
        "$\\times$: any value; c: coupled, see below the table; dim: dimension of the family. "
        f"The rows explain {share.agree} of {share.tested} test points "
        f"({as_text(share_text(share.agree, share.tested))})."
    )
    decimals = sum(any(_in_degrees(column, row) for row in rows) for column in every)
    words = max(0.3, _WORDS - _COLUMN * robot.n - _DEGREES * decimals)
    shape = "".join(_shape(column, words) for column in every)
    heads = [f"${_symbol(column.title)}$" if column.holds == JOINT else as_text(column.title) for column in every]
    cells = [
        [_cell(column, inside, number) for column in every]
        for number, (inside, _) in enumerate((restrict_to_limits(row, robot, limits=limits) for row in rows), start=1)
    ]
    notes = _notes(robot, rows, exact)
    body = [*_tabular_lines([heads]), r"\hline", *_tabular_lines(cells), r"\hline"]
    size = r"\footnotesize" if decimals else r"\small"
    label = rf"\label{{tab:{name}-corank-{summary.corank}}}"
    if _height(every, rows, words, notes) > _PAGE:
        broken = [
            "{" + size, r"\setlength{\tabcolsep}{3pt}", rf"\begin{{longtable}}{{{shape}}}",
            rf"\caption{{{caption}}}{label}\\", r"\hline", *_tabular_lines([heads]), r"\hline", r"\endhead", *body[2:],
            r"\end{longtable}", r"\raggedright\sloppy", *notes, "}",
        ]  # fmt: skip
        return "\n".join(broken), True
    small = [r"\par\smallskip", r"\begin{minipage}{\linewidth}\raggedright", *notes, r"\end{minipage}"]
    lines = [
        r"\begin{table}[htbp]", r"\centering", size, r"\setlength{\tabcolsep}{3pt}", f"\\caption{{{caption}}}", label,
        f"\\begin{{tabular}}{{{shape}}}", r"\hline", *body, r"\end{tabular}",
        *(small if notes else []), r"\end{table}",
    ]  # fmt: skip
    return "\n".join(lines), False


def _in_degrees(column: Column, row: Family) -> bool:
    """Whether a column of a joint has values that are shown in degrees, too."""
    return column.values is not None and any(angle for _, angle in column.values(row))


def _height(every: Sequence[Column], rows: Sequence[Family], words: float, notes: Sequence[str]) -> int:
    """About how many lines a table and what stands below it take."""
    told = {column.key: _share(column, words) * _LINE for column in every if column.holds == WORDS}
    lines = sum(
        max(2, *(ceil(len("; ".join(lines_of(column, row))) / told[column.key])
                 for column in every if column.holds == WORDS))
        for row in rows
    )
    return lines + sum(ceil(len(note) / (1.2 * _LINE)) for note in notes)


def _share(column: Column, words: float) -> float:
    """Width of a column of words, of that of the page."""
    return {"name": 0.4, "lost": 0.6}.get(column.key, 0.3) * words


def _tabular_lines(rows: Iterable[Sequence[str]]) -> Iterator[str]:
    return (" & ".join(row) + r" \tabularnewline" for row in rows)


def _shape(column: Column, words: float) -> str:
    """The column in the head of a table: right, centred, or so wide a paragraph of words."""
    if column.key == "id":
        return "r"
    if column.holds == WORDS:
        return f"p{{{_share(column, words):.3f}\\linewidth}}"
    return "c"


def _notes(robot: Robot, rows: Sequence[Family], exact: Derivation | None) -> list[str]:
    """What stands below a table: conditions and witnesses by row, letters of links, lengths."""
    notes = []
    for number, family in enumerate(rows, start=1):
        parts = [*_conditions(family)]
        if at_witness(family):
            parts += [as_text(f"witness {witness_text(robot, family.witness)}")]
        if parts:
            notes += [f"\\noindent Row {number}: {'; '.join(parts)}.\\par"]
    links = lost_note(robot, chain.from_iterable(family.lost_freedoms for family in rows))
    if links:
        notes += [f"\\noindent {as_text(links)}\\par"]
    lengths = ", ".join(f"${_symbol(name)} = {value:.6g}$ m" for name, value in _letters_in(notes, exact))
    return [*notes, *([f"\\noindent Lengths: {lengths}.\\par"] if lengths else [])]


def _letters_in(notes: Sequence[str], exact: Derivation | None) -> Iterator[tuple[str, float]]:
    for name, value in ((exact.letters or {}) if exact is not None else {}).items():
        if any(_symbol(name) in note for note in notes):
            yield name, value


def _cell(column: Column, family: Family, number: int) -> str:
    """A cell; several values of a joint stand under each other."""
    if column.key == "id":
        return str(number)
    values = [as_text(line) for line in lines_of(column, family)]
    if column.holds == WORDS:
        return rf"\raggedright {'; '.join(values)}"
    parts = () if column.values is None else column.values(family)
    if any(angle for _, angle in parts):
        lines = [line for number, angle in parts for line in (number, f"({angle})" if angle else "") if line]
        stacked = r" \\ ".join(map(as_text, lines))
        return rf"\begin{{tabular}}[t]{{@{{}}c@{{}}}}{stacked}\end{{tabular}}"
    return ", ".join(values)


def _symbol(name: str) -> str:
    """The symbol of a joint, or the letter of a length, with its number below."""
    letter = _SIGNS.get(name[0], name[0])
    if name[1:]:
        return f"{letter}_{{{name[1:]}}}"
    return letter


def _conditions(family: Family) -> Iterator[str]:
    """The conditions that the columns do not say, as mathematics: exact ones where there are, else the fitted ones."""
    chosen = [f"${text}$" for text in _chosen(family)]
    for text in chosen[:_LINES]:
        yield text if len(text) <= _LONGEST else f"a condition of {len(text)} characters, see the JSON"
    if len(chosen) > _LINES:
        yield f"{len(chosen) - _LINES} more, see the JSON"
    if not family.named:
        yield "no condition found"


def _chosen(family: Family) -> list[str]:
    """The exact conditions of a family beyond its pinned joints; where there are none the fitted ones."""
    row = family.exact
    if row is not None:
        known = {pin.number for pin in family.pinned}
        pins = zip(row.latex, row.pinned, strict=False)
        exact = [text for text, pin in pins if pin.number not in known]
        exact += row.latex[len(row.pinned) :]
        if exact:
            return exact
    bound = set(family.coupled)
    return [f"{equation.latex()} = 0" for equation in family.equations if bound & set(equation.joints)]


def as_text(text: str) -> str:
    """Text for LaTeX: numbered joints with subscripts, signs as mathematics, nothing that LaTeX would obey.

    Example:
        >>> as_text("θ3 = ±π/2, 50 %")
        '$\\\\theta_{3}$ = $\\\\pm$$\\\\pi$/2, 50 \\\\%'
    """
    pieces, at = [], 0
    for match in _NUMBERED.finditer(text):
        pieces.append(_letters(text[at : match.start()]))
        pieces.append(f"${_SIGNS.get(match[1], match[1])}_{{{match[2]}}}$")
        at = match.end()
    return "".join([*pieces, _letters(text[at:])])


def _letters(text: str) -> str:
    return "".join(map(_letter, text))


def _letter(sign: str) -> str:
    if sign in _PLAIN:
        return _PLAIN[sign]
    if sign in _SIGNS:
        return f"${_SIGNS[sign]}$"
    if " " <= sign <= "~":
        return sign
    if sign.isspace():
        return " "
    return "".join(_PLAIN.get(letter, letter) for letter in unicodedata.normalize("NFKD", sign) if " " <= letter <= "~")
