"""The Jacobian in the axes of a link, as it is handed over: matrices, numbers and checks as text and as LaTeX."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from rankdrop.formula.notation import Latex, latex_name
from rankdrop.formula.shortest import form_of
from rankdrop.formula.writing import text_of
from rankdrop.results.jacobian_in_frame import Agreement, CheckKind, JacobianNumbers, LinkJacobian, regular
from rankdrop.robot.model import Array
from rankdrop.sections import Section
from rankdrop.task import ROWS

_WIDTH = 76  # characters up to which a matrix stands as a table
_CHECKS = {
    CheckKind.CLOSED_FORM: "the closed form is the numeric Jacobian, turned, at {points} random configurations",
    CheckKind.NUMERIC_INVERSE: "the inverse times the Jacobian is the identity at the configuration given",
    CheckKind.ADJUGATE: "J · adj J = det J · 1 at {agreeing} of {points} random points modulo 2^61 − 11913",
    CheckKind.CLOSED_INVERSE: "the closed inverse times the numeric Jacobian is the identity at {points} random "
    "configurations",
}


def check_words(check: Agreement) -> str:
    """What was compared, and at how many points."""
    return _CHECKS[check.kind].format(points=check.points, agreeing=check.agreeing)


def repr_words(jacobian: LinkJacobian) -> str:
    """A result in a line of Python."""
    return f"LinkJacobian of {jacobian.robot.name}: frame {jacobian.frame}, about {_point(jacobian.at)}"


def entry_texts(jacobian: LinkJacobian) -> tuple[tuple[str, ...], ...]:
    """The entries as text, row by row."""
    return _each_entry(jacobian.rows, lambda entry: text_of(jacobian.chain.ring, entry))


def inverse_texts(jacobian: LinkJacobian, most: int | None) -> tuple[tuple[str, ...], ...]:
    """The entries of the inverse as text; longer sums than `most` by their size."""
    if jacobian.closed is None:
        return ()
    return _each_entry(jacobian.closed.entries, lambda entry: entry.text(most))


def latex(jacobian: LinkJacobian) -> str:
    """The matrix, its determinant and its inverse in LaTeX, as displayed formulas."""
    name = f"{{}}^{{{jacobian.frame}}}J"
    formulas = [f"{name} = {_matrix(_latex_entries(jacobian))}"]
    if jacobian.closed is not None:
        formulas.append(rf"\det {name} = {jacobian.closed.determinant.latex()}")
        inverse = _each_entry(jacobian.closed.entries, lambda entry: entry.latex())
        formulas.append(f"{name}^{{-1}} = {_matrix(inverse)}")
    lines = ["% needs \\usepackage{amsmath}", *(f"\\[ {formula} \\]" for formula in formulas)]
    lengths = [rf"{latex_name(letter)} = {value:.12g}\,\mathrm{{m}}" for letter, value in jacobian.letters.items()]
    if lengths:
        lines.append(rf"${', '.join(lengths)}$")
    return "\n".join([*lines, ""])


def _latex_entries(jacobian: LinkJacobian) -> tuple[tuple[str, ...], ...]:
    notation, ring = Latex(), jacobian.chain.ring

    def entry_latex(entry: Any) -> str:
        if entry == 0:
            return "0"
        return notation.value(form_of(ring, entry))

    return _each_entry(jacobian.rows, entry_latex)


def sections_of(jacobian: LinkJacobian, most: int | None) -> tuple[Section, ...]:
    """Matrix, determinant, inverse, numbers and checks; longer sums than `most` by their size."""
    return tuple(_sections(jacobian, most))


def _sections(jacobian: LinkJacobian, most: int | None) -> Iterator[Section]:
    rows = [ROWS[r] for r in jacobian.task.rows]
    joints = [f"joint {j}" for j in range(1, jacobian.robot.n + 1)]
    k = jacobian.frame
    axes = f"axes of link {k} (z along axis {k}, x along the common normal after it)"
    lines = [f"{axes}, reference point {_point(jacobian.at)}"]
    if jacobian.letters and jacobian.rows:
        letters = ", ".join(f"{name} = {value:.12g} m" for name, value in jacobian.letters.items())
        lines.append(f"lengths: {letters}")
    yield Section(f"{jacobian.robot.name}: Jacobian in the frame of link {k}", "", tuple(lines))
    if jacobian.rows:
        yield _table(f"J seen from link {k}", rows, joints, entry_texts(jacobian))
        yield Section("Shortest", "", tuple(_frames(jacobian)))
    if jacobian.closed is not None:
        yield Section("Determinant", "", (f"det J = {jacobian.closed.determinant.text(most)}",))
        yield _table("Inverse", joints, rows, inverse_texts(jacobian, most))
    if jacobian.numbers is not None:
        yield from _numbers(jacobian.numbers, rows, joints)
    if jacobian.checks:
        yield Section("Checks", "", tuple(map(_agreement_text, jacobian.checks)))


def _frames(jacobian: LinkJacobian) -> Iterator[str]:
    """Terms of the closed form in the axes of each link, and where it is shorter about another point."""
    here = [(terms, k) for terms, k, at in jacobian.shortest if at == jacobian.at]
    told = ", ".join(f"link {k}: {terms}" for terms, k in sorted(here))
    yield f"terms, multiplied out, about {_point(jacobian.at)}: {told}"
    terms, k, at = jacobian.shortest[0]
    if at != jacobian.at or terms < here[0][0]:
        yield f"of all reference points: link {k} about {_point(at)}, {terms} terms"


def _each_entry(rows: Iterable[Iterable[Any]], text: Callable[[Any], str]) -> tuple[tuple[str, ...], ...]:
    """The entries of a matrix as text, row by row."""
    return tuple(tuple(map(text, row)) for row in rows)


def _point(at: int | None) -> str:
    if at is None:
        return "the tip"
    return f"the origin of link {at}"


def _agreement_text(check: Agreement) -> str:
    text = check_words(check)
    if not check.holds:
        text = f"FAILS: {text}"
    if check.worst is None:
        return text
    return text + f" (largest difference {check.worst:.1e})".replace("-", "−")


def _table(title: str, left: Sequence[str], above: Sequence[str], entries: Sequence[Sequence[str]]) -> Section:
    """A matrix as a table where it is narrow, else entry by entry, zeros left out."""
    columns = zip(above, *entries, strict=True)
    widths = [max(map(len, column)) for column in columns]
    if sum(widths) + 2 * len(widths) + max(map(len, left)) <= _WIDTH:
        return _as_table(title, left, above, entries, texts=tuple(range(len(above) + 1)))
    lines = []
    for name, row in zip(left, entries, strict=True):
        for head, entry in zip(above, row, strict=True):
            if entry != "0":
                lines.append(f"{name}, {head}: {entry}")
    return Section(title, "", (*lines, "all other entries are 0"))


def _as_table(
    title: str, left: Sequence[str], above: Sequence[str], entries: Iterable[Sequence[str]],
    texts: tuple[int, ...] = (0,),
) -> Section:  # fmt: skip
    rows = tuple((name, *row) for name, row in zip(left, entries, strict=True))
    return Section(title, "", (), ("", *above), rows, texts=texts)


def _matrix_cells(matrix: Array) -> Iterator[list[str]]:
    """The numbers of a matrix, row by row."""
    for row in np.where(np.abs(matrix) < 1e-15, 0.0, matrix):
        yield [f"{x + 0.0:.6g}".replace("-", "−") for x in row]


def _numbers(numbers: JacobianNumbers, rows: Sequence[str], joints: Sequence[str]) -> Iterator[Section]:
    q = ", ".join(f"{x:.6g}" for x in numbers.q).replace("-", "−")
    yield _as_table(f"At q = ({q}) [rad, m]", rows, joints, _matrix_cells(numbers.matrix))
    lines = [f"singular values, lengths in metres: {', '.join(f'{x:.4g}' for x in numbers.sigma)}"]
    if numbers.determinant is not None:
        lines.insert(0, f"determinant {numbers.determinant:.6g}".replace("-", "−"))
        if not regular(numbers.matrix):
            lines.append("no inverse: the configuration is singular")
    yield Section("", "", tuple(lines))
    if numbers.inverse is not None:
        yield _as_table("Inverse at q", joints, rows, _matrix_cells(numbers.inverse))


def _matrix(entries: Sequence[Sequence[str]]) -> str:
    body = r" \\ ".join(" & ".join(row) for row in entries)
    return rf"\begin{{bmatrix}} {body} \end{{bmatrix}}"
