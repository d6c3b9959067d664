"""The Jacobian in the axes of a link, as it is handed over: closed forms, numbers, checks; as text, LaTeX and JSON."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from rankdrop.algebra.polynomial import Polynomial
from rankdrop.codec import Result
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.determinants import ClosedInverse
from rankdrop.formula.notation import Latex, Python, latex_name
from rankdrop.formula.writing import FOLDED, form_of, text_of
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section
from rankdrop.task import ROWS, Task
from rankdrop.tolerances import DEFAULT

_WIDTH = 76  # characters up to which a matrix stands as a table


@dataclass(frozen=True, eq=False)
class Numbers:
    """The Jacobian at one configuration.

    Attributes:
        q: (n,) [rad, m].
        matrix: (m, n) rows of the task.
        determinant: None where the matrix is not square.
        inverse: (n, m); None where the matrix is not square, or singular here.
        sigma: its singular values with lengths in metres, largest first.
    """

    q: tuple[float, ...]
    matrix: Array
    determinant: float | None
    inverse: Array | None
    sigma: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Agreement:
    """One check.

    Attributes:
        what: in words.
        holds: whether it does.
        worst: the largest difference found, relative; None for a check that is exact.
    """

    what: str
    holds: bool
    worst: float | None


@dataclass(frozen=True, eq=False, repr=False)
class LinkJacobian(Result):
    """The Jacobian in the axes of a link.

    Attributes:
        robot, task: the arm, and the rows.
        frame: link k whose axes are taken: z along axis k, x along the common normal after it.
        at: link on whose frame's origin the reference point is; None for the tip.
        letters, shifts: values of the lengths that are letters [m]; θ = q + shift.
        rows: the entries as trigonometric polynomials, one list of n per row of the task; empty where only numbers
            were asked for.
        shortest: (terms, link, reference point) of all axes and reference points, the shortest first; as `rows`.
        closed: the inverse in closed form, where it was asked for.
        numbers: at a configuration, where one was given.
        checks: what was checked, and how.
        chain: the arm over the exact ring.
    """

    robot: Robot
    task: Task
    frame: int
    at: int | None
    letters: Mapping[str, float]
    shifts: tuple[float, ...]
    rows: tuple[tuple[Polynomial, ...], ...]
    shortest: tuple[tuple[int, int, int | None], ...]
    closed: ClosedInverse | None
    numbers: Numbers | None
    checks: tuple[Agreement, ...]
    chain: Chain
    FILE: ClassVar[str] = "jacobian"

    @property
    def holds(self) -> bool:
        """Whether every check does."""
        return all(check.holds for check in self.checks)

    def __repr__(self) -> str:
        return f"<LinkJacobian of {self.robot.name}: frame {self.frame}, about {_point(self.at)}>"

    def texts(self) -> tuple[tuple[str, ...], ...]:
        """The entries as text, row by row: s2 is sin θ2, c23 is cos(θ2 + θ3)."""
        return _each_entry(self.rows, lambda entry: text_of(self.chain.ring, entry))

    def inverse_texts(self, most: int | None = None) -> tuple[tuple[str, ...], ...]:
        """The entries of the inverse as text, one row per joint.

        Args:
            most: sums of more characters are told by their size; None for none.
        """
        if self.closed is None:
            return ()
        return _each_entry(self.closed.entries, lambda entry: entry.text(most))

    def latex(self) -> str:
        """The matrix, its determinant and its inverse in LaTeX, as displayed formulas."""
        name, notation, ring = f"{{}}^{{{self.frame}}}J", Latex(), self.chain.ring
        entries = _each_entry(self.rows, lambda entry: notation.value(form_of(ring, entry)) if entry != 0 else "0")
        found = [f"{name} = {_matrix(entries)}"]
        if self.closed is not None:
            found.append(rf"\det {name} = {self.closed.determinant.latex()}")
            inverse = _each_entry(self.closed.entries, lambda entry: entry.latex())
            found.append(f"{name}^{{-1}} = {_matrix(inverse)}")
        lengths = [rf"{latex_name(one)} = {value:.12g}\,\mathrm{{m}}" for one, value in self.letters.items()]
        if lengths:
            said = [rf"${', '.join(lengths)}$"]
        else:
            said = []
        return "\n".join(["% needs \\usepackage{amsmath}", *(f"\\[ {one} \\]" for one in found), *said, ""])

    @property
    def inverse_code(self) -> list[list[tuple[Any, Python]]]:
        """The entries of the inverse, each with the notation of its code."""
        code = Python(shifts=self.shifts)
        if self.closed is None:
            return []
        return [[(x, code) for x in row] for row in self.closed.entries]

    def sections(self, *, most: int | None = FOLDED) -> tuple[Section, ...]:
        """In words.

        Args:
            most: sums of the inverse of more characters are told by their size; None for none.
        """
        return tuple(self._sections(most))

    def _sections(self, most: int | None) -> Iterator[Section]:
        rows = [ROWS[r] for r in self.task.rows]
        joints = [f"joint {j}" for j in range(1, self.robot.n + 1)]
        k = self.frame
        axes = f"axes of link {k} (z along axis {k}, x along the common normal after it)"
        where = f"{axes}, reference point {_point(self.at)}"
        letters = ", ".join(f"{name} = {value:.12g} m" for name, value in self.letters.items())
        yield Section(f"{self.robot.name}: Jacobian in the frame of link {k}", "",
                      (where, *([f"lengths: {letters}"] if letters and self.rows else [])))  # fmt: skip
        if self.rows:
            yield _table(f"J seen from link {k}", rows, joints, self.texts())
            yield Section("Shortest", "", tuple(self._frames()))
        if self.closed is not None:
            yield Section("Determinant", "", (f"det J = {self.closed.determinant.text(most)}",))
            yield _table("Inverse", joints, rows, self.inverse_texts(most))
        if self.numbers is not None:
            yield from _numbers(self.numbers, rows, joints)
        if self.checks:
            yield Section("Checks", "", tuple(_agreement_text(check) for check in self.checks))

    def _frames(self) -> Iterator[str]:
        here = [(terms, k) for terms, k, at in self.shortest if at == self.at]
        told = ", ".join(f"link {k}: {terms}" for terms, k in sorted(here))
        yield f"terms, multiplied out, about {_point(self.at)}: {told}"
        terms, k, at = self.shortest[0]
        if at != self.at or terms < here[0][0]:
            yield f"of all reference points: link {k} about {_point(at)}, {terms} terms"


def _each_entry(rows: Iterable[Iterable[Any]], text: Callable[[Any], str]) -> tuple[tuple[str, ...], ...]:
    """The entries of a matrix as text, row by row."""
    return tuple(tuple(map(text, row)) for row in rows)


def regular(matrix: Array) -> bool:
    """Whether a square matrix has an inverse: its smallest singular value over the largest tells."""
    sigma = np.linalg.svd(matrix, compute_uv=False)
    return bool(sigma[-1] > DEFAULT.singular * sigma[0])


def _point(at: int | None) -> str:
    if at is None:
        return "the tip"
    return f"the origin of link {at}"


def _agreement_text(check: Agreement) -> str:
    if check.worst is None:
        size = ""
    else:
        size = f" (largest difference {check.worst:.1e})".replace("-", "−")
    return f"{'' if check.holds else 'FAILS: '}{check.what}{size}"


def _table(title: str, left: Sequence[str], above: Sequence[str], entries: Sequence[Sequence[str]]) -> Section:
    """A matrix as a table where it is narrow, else entry by entry, zeros left out."""
    widths = [max(len(head), *(len(row[i]) for row in entries)) for i, head in enumerate(above)]
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


def _written(matrix: Array) -> Iterator[list[str]]:
    """The numbers of a matrix, row by row."""
    for row in np.where(np.abs(matrix) < 1e-15, 0.0, matrix):
        yield [f"{x + 0.0:.6g}".replace("-", "−") for x in row]


def _numbers(numbers: Numbers, rows: Sequence[str], joints: Sequence[str]) -> Iterator[Section]:
    q = ", ".join(f"{x:.6g}" for x in numbers.q).replace("-", "−")
    yield _as_table(f"At q = ({q}) [rad, m]", rows, joints, _written(numbers.matrix))
    lines = [f"singular values, lengths in metres: {', '.join(f'{x:.4g}' for x in numbers.sigma)}"]
    if numbers.determinant is not None:
        lines.insert(0, f"determinant {numbers.determinant:.6g}".replace("-", "−"))
        if not regular(numbers.matrix):
            lines.append("no inverse: the configuration is singular")
    yield Section("", "", tuple(lines))
    if numbers.inverse is not None:
        yield _as_table("Inverse at q", joints, rows, _written(numbers.inverse))


def _matrix(entries: Sequence[Sequence[str]]) -> str:
    body = r" \\ ".join(" & ".join(row) for row in entries)
    return rf"\begin{{bmatrix}} {body} \end{{bmatrix}}"
