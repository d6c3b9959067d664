r"""The tables of an analysis as LaTeX, laid out as AM print them (Tables 3–5): θ columns, dimension, lost motion.

What is written compiles with pdfLaTeX and the package amsmath alone: every letter that is not plain is set as
mathematics, and what has no sign there is left out.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator, Sequence

from rankdrop.family.derivation import Derivation, ExactRow
from rankdrop.family.record import CorankSummary, Family
from rankdrop.robot.model import JointKind, Robot, lost_told, witness_text
from rankdrop.text.families import COUPLED, FREE, at_witness, columns, joint_cells, row_cells, share_text, within

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
    parts = [r"% needs \usepackage{amsmath}"]
    for summary in coranks:
        rows = [family for family in families if family.corank == summary.corank]
        if rows:
            parts.append(_table(robot, rank, summary, rows, exact, limits=limits))
    if len(parts) == 1:
        parts.append(f"% {as_text(robot.name)}: no families were found, which is no proof that there are none")
    return "\n\n".join(parts) + "\n"


def _table(
    robot: Robot, rank: int, summary: CorankSummary, rows: Sequence[Family], exact: Derivation | None, *, limits: bool
) -> str:
    heads = [f"${_symbol(robot, number)}$" for number in range(1, robot.n + 1)]
    lost = columns(robot, summary.corank)[-3]
    share = summary.completeness
    caption = (
        f"{as_text(robot.name)}: singularities of corank {summary.corank} (rank {summary.rank} of {rank}). "
        "$\\times$: any value; c: coupled, see below the table; dim: dimension of the family. "
        f"The rows explain {share.agree} of {share.tested} fresh singular points "
        f"({as_text(share_text(share.agree, share.tested))})."
    )
    name = re.sub(r"[^A-Za-z0-9-]+", "-", robot.name)
    joints = zip(*(joint_cells(robot, one) for one in rows), strict=True)
    decimals = sum(any("(" in cell for cell in joint) for joint in joints)
    words = max(0.3, _WORDS - _COLUMN * robot.n - _DEGREES * decimals)
    shape = f"rp{{{0.4 * words:.3f}\\linewidth}}*{{{robot.n}}}{{c}}cp{{{0.6 * words:.3f}\\linewidth}}"
    size = r"\footnotesize" if decimals else r"\small"
    lines = [
        r"\begin{table}[htbp]", r"\centering", size, r"\setlength{\tabcolsep}{3pt}", f"\\caption{{{caption}}}",
        f"\\label{{tab:{name}-corank-{summary.corank}}}",
        f"\\begin{{tabular}}{{{shape}}}", r"\hline",
        " & ".join(["", "family", *heads, "dim", lost]) + r" \tabularnewline", r"\hline",
    ]  # fmt: skip
    notes = []
    for number, family in enumerate(rows, start=1):
        inside, _ = within(family, robot, limits=limits)
        lines.append(" & ".join(_cells(robot, number, inside)) + r" \tabularnewline")
        told = list(_conditions(family, exact))
        if at_witness(family):
            told.append(as_text(f"witness {witness_text(robot, family.witness)}"))
        if told:
            notes.append(f"\\noindent Row {number}: {'; '.join(told)}.\\par")
    lines += [r"\hline", r"\end{tabular}"]
    links = lost_told(robot, [words for family in rows for words in family.lost_words])
    if links:
        notes.append(f"\\noindent {as_text(links)}\\par")
    if notes:
        lengths = ", ".join(f"${mathematics(name)} = {value:.6g}$ m" for name, value in _letters_in(notes, exact))
        if lengths:
            notes.append(f"\\noindent Lengths: {lengths}.\\par")
        lines += [r"\par\smallskip", r"\begin{minipage}{\linewidth}\raggedright", *notes, r"\end{minipage}"]
    return "\n".join([*lines, r"\end{table}"])


def _letters_in(notes: Sequence[str], exact: Derivation | None) -> Iterator[tuple[str, float]]:
    """The lengths that stand as letters in the conditions printed."""
    for name, value in ((exact.letters or {}) if exact is not None else {}).items():
        if any(mathematics(name) in note for note in notes):
            yield name, value


def _cells(robot: Robot, number: int, family: Family) -> Iterator[str]:
    _, name, *joints, dimension, lost, _, _ = row_cells(robot, family)
    yield str(number)
    yield rf"\raggedright {as_text(name)}"
    yield from map(_cell, joints)
    yield dimension
    yield rf"\raggedright {'; '.join(map(as_text, lost.splitlines()))}"


def _cell(text: str) -> str:
    """What a joint does; several values stand under each other."""
    if text == FREE:
        return r"$\times$"
    if text == COUPLED:
        return "c"
    values = [as_text(value) for value in re.split(r"(?<=\)),\n|\n", text)]  # as `joint_cell` breaks them
    if len(values) == 1:
        return values[0]
    stacked = r" \\ ".join(values)
    return rf"\begin{{tabular}}[t]{{@{{}}c@{{}}}}{stacked}\end{{tabular}}"


def _symbol(robot: Robot, number: int) -> str:
    slides = robot.variables[number - 1].kind is JointKind.PRISMATIC
    return f"q_{{{number}}}" if slides else rf"\theta_{{{number}}}"


def _conditions(family: Family, derivation: Derivation | None) -> Iterator[str]:
    """The conditions that the columns do not say, as mathematics: exact ones where there are, else the fitted ones."""
    exact = [] if derivation is None else _exact(family, derivation)
    bound = set(family.coupled)
    own = [equation for equation in family.equations if bound & set(equation.joints)]
    fitted = [f"${mathematics(equation.pretty())} = 0$" for equation in own]
    chosen = [f"${one}$" for one in exact] or fitted
    for text in chosen[:_LINES]:
        yield text if len(text) <= _LONGEST else f"a condition of {len(text)} characters, see the JSON"
    if len(chosen) > _LINES:
        yield f"{len(chosen) - _LINES} more, see the JSON"
    if not family.named:
        yield "no condition found"


def _exact(family: Family, derivation: Derivation) -> list[str]:
    """LaTeX of the exact conditions of the row, less those of joints in its columns."""
    row = derivation.of_row(family.id)
    return [] if row is None else _beyond_columns(family, row)


def _beyond_columns(family: Family, row: ExactRow) -> list[str]:
    known = {one.number for one in family.pinned}
    pins = len(row.pinned)
    kept = [text for text, pin in zip(row.latex, row.pinned, strict=False) if pin.number not in known]
    return [*kept, *row.latex[pins:]]


def as_text(text: str) -> str:
    """Text for LaTeX: numbered joints with subscripts, signs as mathematics, nothing that LaTeX would obey.

    Example:
        >>> as_text("θ3 = ±π/2, 50 %")
        '$\\\\theta_{3}$ = $\\\\pm$$\\\\pi$/2, 50 \\\\%'
    """
    pieces, at = [], 0
    for found in _NUMBERED.finditer(text):
        pieces.append(_letters(text[at : found.start()]))
        pieces.append(f"${_SIGNS.get(found[1], found[1])}_{{{found[2]}}}$")
        at = found.end()
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
    return "".join(_PLAIN.get(one, one) for one in unicodedata.normalize("NFKD", sign) if " " <= one <= "~")


def mathematics(text: str) -> str:
    """A condition as `Equation.pretty` writes it, as mathematics without the dollar signs.

    Example:
        >>> mathematics("0.5 cos(θ2+θ3) − sin θ4")
        '0.5 \\\\cos(\\\\theta_{2}+\\\\theta_{3}) - \\\\sin \\\\theta_{4}'
    """
    text = re.sub(r"([θqad])(\d+)", r"\1_{\2}", text)
    text = re.sub(r"\b(sin|cos|tan)", r"\\\1", text)
    out = "".join(_SIGNS[one] + (" " if _SIGNS[one][-1].isalpha() else "") if one in _SIGNS else one for one in text)
    return out.replace(r"\theta _", r"\theta_")
