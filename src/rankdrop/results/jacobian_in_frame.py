"""The Jacobian in the axes of a link: closed forms, numbers, and checks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, ClassVar

import numpy as np

from rankdrop.algebra.polynomial import Polynomial
from rankdrop.codec import Result
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.closed_inverse import ClosedInverse
from rankdrop.formula.notation import Python
from rankdrop.formula.value import FOLDED
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section, words_of
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT


@dataclass(frozen=True, eq=False)
class JacobianNumbers:
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


class CheckKind(StrEnum):
    """What a check compares."""

    CLOSED_FORM = "closed form"
    NUMERIC_INVERSE = "numeric inverse"
    ADJUGATE = "adjugate"
    CLOSED_INVERSE = "closed inverse"


@dataclass(frozen=True, slots=True)
class Agreement:
    """One check.

    Attributes:
        kind: `CLOSED_FORM`: the closed Jacobian with the numeric one, turned; `NUMERIC_INVERSE`: the inverse times the
            Jacobian with 1, at the configuration given; `ADJUGATE`: J adj J with det J, modulo a prime;
            `CLOSED_INVERSE`: the closed inverse times the numeric Jacobian with 1.
        holds: whether it does.
        worst: the largest difference found, relative; None for a check that is exact.
        points, agreeing: random configurations or points it was made at, and at how many of them it holds.
    """

    kind: CheckKind
    holds: bool
    worst: float | None
    points: int = 1
    agreeing: int = 0

    @property
    def what(self) -> str:
        """The check in words."""
        words: str = words_of(self).check_words(self)
        return words


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
    numbers: JacobianNumbers | None
    checks: tuple[Agreement, ...]
    chain: Chain
    FILE: ClassVar[str] = "jacobian"

    @property
    def holds(self) -> bool:
        """Whether every check does."""
        return all(check.holds for check in self.checks)

    def __repr__(self) -> str:
        return f"<{words_of(self).repr_words(self)}>"

    def texts(self) -> tuple[tuple[str, ...], ...]:
        """The entries as text, row by row: s2 is sin θ2, c23 is cos(θ2 + θ3)."""
        texts: tuple[tuple[str, ...], ...] = words_of(self).entry_texts(self)
        return texts

    def inverse_texts(self, most: int | None = None) -> tuple[tuple[str, ...], ...]:
        """The entries of the inverse as text, one row per joint.

        Args:
            most: sums of more characters are told by their size; None for none.
        """
        texts: tuple[tuple[str, ...], ...] = words_of(self).inverse_texts(self, most)
        return texts

    def latex(self) -> str:
        """The matrix, its determinant and its inverse in LaTeX, as displayed formulas."""
        latex: str = words_of(self).latex(self)
        return latex

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
        sections: tuple[Section, ...] = words_of(self).sections_of(self, most)
        return sections


def regular(matrix: Array) -> bool:
    """Whether a square matrix has an inverse: its smallest singular value over the largest tells."""
    sigma = np.linalg.svd(matrix, compute_uv=False)
    return bool(sigma[-1] > DEFAULT.singular * sigma[0])
