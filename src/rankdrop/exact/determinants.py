"""The determinant of a Jacobian in factors, or the minors that take its place.

    as many joints as rows      det J; where J is block triangular: det J = ± det J11 det J22
    more joints than rows       the minors |$1 … $m| of every m columns: the rank drops where all of them vanish
    fewer joints than rows      the minors of every n rows

A minor of all rows of a pose, a position or an orientation is the same number in the axes of every link, and of a pose
about every reference point: a change of either multiplies J by a matrix of determinant 1. Of other rows it is that in
the axes of the task; axes turned upside down would change its sign.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum, auto
from itertools import combinations

import numpy as np

from rankdrop.algebra.matrix import submatrix
from rankdrop.algebra.polynomial import Polynomial
from rankdrop.algebra.ring import MANY, Ring
from rankdrop.algebra.work import OutOfTime, Work
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.structure import (
    ORIENTATION,
    POSE,
    POSITION,
    BlockForm,
)
from rankdrop.exact.conjunctions import values_of
from rankdrop.exact.decoupling import Decoupling, decouple
from rankdrop.formula.value import FOLDED, Value
from rankdrop.kinematics import task_jacobian
from rankdrop.local.block import sample
from rankdrop.sections import words_of
from rankdrop.task import ROWS
from rankdrop.tolerances import DEFAULT

_TRIED = 20  # random configurations at most on which a sign is read off
MOST = 60
"""More minors than that are counted, not written."""


class MinorOf(Enum):
    """The rows and columns of a Jacobian that a minor takes.

    BLOCK: a square matrix. SCREWS, COLUMNS: all rows, and as many joint screws or columns. ROWS: all columns.
    """

    BLOCK = auto()
    SCREWS = auto()
    COLUMNS = auto()
    ROWS = auto()


@dataclass(frozen=True, eq=False)
class Minor:
    """The determinant of some rows and columns of a Jacobian.

    Attributes:
        of: the rows and columns that are taken.
        joints: of its columns, numbered from 1, in order.
        rows: of the task, out of vx … wz, in order.
        value: the determinant.
        shifts: θ = q + shift, per joint: code is in the joint variables q [rad].
        matrix: of a block: "J", "J11" or "J22".
        block: name of the block of "J11" and "J22", as `Block.name`; "" of all others.
    """

    of: MinorOf
    joints: tuple[int, ...]
    rows: tuple[str, ...]
    value: Value
    shifts: tuple[float, ...]
    matrix: str = "J"
    block: str = ""

    @property
    def about(self) -> str:
        """Rows and joints of a block in words; "" of all others, of which `Determinants.meaning` gives them."""
        about: str = words_of(self).about_minor(self)
        return about

    @property
    def name(self) -> str:
        """In formulas: "det J11", "|$1 $2 $3 $4 $5 $6|" of screws, "|J1 J3|" of columns, "|vx wz|" of rows."""
        return minor_name(self.of, self.joints, self.rows, self.matrix)

    @property
    def entries(self) -> tuple[tuple[str, str], ...]:
        """(letter, index) of each of its columns or rows: ("$", "1"), ("J", "1") or ("v", "x"); none of a block."""
        return _entries(self.of, self.joints, self.rows)

    @property
    def mark(self) -> str:
        """A name for code: det_J11, minor_1_2_3, minor_vx_wz."""
        if self.of is MinorOf.BLOCK:
            return f"det_{self.matrix}"
        if self.of is MinorOf.ROWS:
            taken = self.rows
        else:
            taken = tuple(map(str, self.joints))
        return f"minor_{'_'.join(taken)}"

    @property
    def factored(self) -> bool:
        """Whether its factors were found."""
        return self.value.factors is not None or self.value.polynomial == 0


def minor_name(of: MinorOf, joints: Sequence[int], rows: Sequence[str], matrix: str = "J") -> str:
    """The name of a minor in formulas: see `Minor`."""
    if of is MinorOf.BLOCK:
        return f"det {matrix}"
    words = [letter + index for letter, index in _entries(of, joints, rows)]
    return f"|{' '.join(words)}|"


def _entries(of: MinorOf, joints: Sequence[int], rows: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """See `Minor.entries`."""
    if of is MinorOf.BLOCK:
        return ()
    if of is MinorOf.ROWS:
        return tuple((row[0], row[1:]) for row in rows)
    letter = {MinorOf.SCREWS: "$", MinorOf.COLUMNS: "J"}[of]
    return tuple((letter, str(joint)) for joint in joints)


@dataclass(frozen=True)
class MinorsLeft:
    """Minors that were not computed within the limit on work.

    Attributes:
        of: the rows and columns of the only one; None where several more were not tried.
        joints: of its columns, numbered from 1, in order.
        rows: of the task, out of vx … wz, in order.
        number: of minors.
    """

    of: MinorOf | None = None
    joints: tuple[int, ...] = ()
    rows: tuple[str, ...] = ()
    number: int = 1

    def __str__(self) -> str:
        """In words: "|J1 J3|", or "3 more minors"."""
        words: str = words_of(self).minors_left_words(self)
        return words


class RowAxes(Enum):
    """The axes in which the rows of minors are taken.

    EVERY_LINK: any, a minor is the same number in the axes of every link. TASK: those of the task. LINK: the frame of
    one link, where all six rows are there. SHORT: axes in which the rows are short.
    """

    EVERY_LINK = auto()
    TASK = auto()
    LINK = auto()
    SHORT = auto()


@dataclass(frozen=True, eq=False)
class Determinants:
    """The determinant of an arm, or the minors that all vanish where it is singular.

    Attributes:
        of: the rows and columns that each minor takes; of BLOCK there is one determinant, and two of blocks with it
            where `form` is given.
        rows: of the task, out of vx … wz, in order.
        joints: number of the arm's joint variables.
        axes: in which the rows are taken.
        link: number of the link in the frame of which they are where `axes` is LINK; else 0.
        form: the block triangular Jacobian, with its reference point; None where there is none.
        sign: det J = sign · det J11 det J22, where `form` is given.
        minors: the determinant or the minors, those that vanish everywhere too; of blocks first, det J last.
        left: minors that were not computed within the limit on work.
    """

    of: MinorOf
    rows: tuple[str, ...]
    joints: int
    axes: RowAxes
    minors: tuple[Minor, ...]
    left: tuple[MinorsLeft, ...] = ()
    link: int = 0
    form: BlockForm | None = None
    sign: int = 1

    @property
    def product(self) -> str:
        """The determinant as product of those of its blocks: "det J = −det J11 det J22"; "" where it has none."""
        if self.form is None:
            return ""
        if self.sign < 0:
            return "det J = −det J11 det J22"
        return "det J = det J11 det J22"

    @property
    def meaning(self) -> str:
        """The minors and where the rank drops, in a sentence."""
        meaning: str = words_of(self).meaning_of_minors(self)
        return meaning

    def lines(self, most: int | None = FOLDED) -> tuple[str, ...]:
        """In text.

        Args:
            most: factors of more characters are told by their size; None for none.
        """
        told: tuple[str, ...] = words_of(self).lines(self, most)
        return told

    def tells_sizes(self) -> bool:
        """Whether `lines` tells a factor by its size."""
        return self.lines() != self.lines(None)


def determinants_of(chain: Chain, work: Work) -> Determinants:
    """The determinant or the minors of an arm, in factors.

    Args:
        chain: from `exact_chain`.
        work: limit; what is not done by then is told.

    Example:
        >>> from rankdrop.exact.arm.chain import exact_chain
        >>> from rankdrop.robot.open import open_robot
        >>> found = determinants_of(exact_chain(open_robot("anthropomorphic")), Work())
        >>> found.product
        'det J = det J11 det J22'
        >>> [f"{minor.name} = {minor.value.text()}" for minor in found.minors]
        ['det J11 = −a2 d4 s3 (a2 c2 + d4 c23)', 'det J22 = −s5', 'det J = a2 d4 s3 s5 (a2 c2 + d4 c23)']
    """
    split = decouple(chain)
    if split is not None:
        return _block_determinants(chain, split)
    minors: list[Minor] = []
    left: list[MinorsLeft] = []
    shifts = tuple(map(float, chain.whole_shifts))
    chosen = list(maximal_minors(chain))
    for of, joints, rows in chosen[:MOST]:
        words = tuple(ROWS[r] for r in rows)
        place = [chain.task.rows.index(r) for r in rows]
        try:
            work.check()
            minor = chain.ring.determinant(submatrix(chain.columns, (j - 1 for j in joints), place))
            if len(rows) == chain.task.m:
                minor = minor * _sign(chain, minor, joints)
            else:
                minor = minor
            value = factored_value(chain.ring, minor, work)
        except OutOfTime:
            left.append(MinorsLeft(of, joints, words))
            continue
        minors.append(Minor(of, joints, words, value, shifts))
    if len(chosen) > MOST:
        left.append(MinorsLeft(number=len(chosen) - MOST))
    axes = _axes(chain)
    link = chain.frame if axes is RowAxes.LINK else 0
    return Determinants(chosen[0][0], _row_names(chain), chain.n, axes, tuple(minors), tuple(left), link)


def factored_value(ring: Ring, p: Polynomial, work: Work) -> Value:
    """A polynomial over the ring as a value, in factors where the work allows it."""
    # a longer one takes minutes and gigabytes to factor
    work.check()
    return Value(ring, p, None if p == 0 or len(p) > MANY else ring.factors_within(p, work.remaining))


def _sign(chain: Chain, p: Polynomial, joints: tuple[int, ...]) -> int:
    """1, or −1 where a minor of all rows has the other sign in the axes of the task, see at a configuration."""
    if p == 0 or chain.task.rows in (POSE, POSITION, ORIENTATION):
        return 1
    for q in sample(chain.own, chain.own_task, _TRIED, 0):
        wanted = np.linalg.det(task_jacobian(chain.own, q, chain.own_task)[:, [j - 1 for j in joints]])
        value = values_of(chain, p, np.atleast_2d(q) + chain.shifts)[0][0]
        if abs(wanted) > DEFAULT.singular:
            return 1 if wanted * value > 0 else -1
    return 1


MinorChoice = tuple[MinorOf, tuple[int, ...], tuple[int, ...]]
"""The kind of a minor, its joints, numbered from 1, and its rows, numbers 0 … 5 of (v; ω)."""


def maximal_minors(chain: Chain) -> Iterator[MinorChoice]:
    """The determinant of a square Jacobian, else its minors of the highest order; in the order of `combinations`."""
    joints, rows = tuple(range(1, chain.n + 1)), chain.task.rows
    if chain.n == len(rows):
        yield MinorOf.BLOCK, joints, rows
    elif chain.n > len(rows):
        if len(rows) == 6 and not chain.has_mimics:
            of = MinorOf.SCREWS
        else:
            of = MinorOf.COLUMNS
        for some in combinations(joints, len(rows)):
            yield of, some, rows
    else:
        for kept in combinations(rows, chain.n):
            yield MinorOf.ROWS, joints, kept


def _axes(chain: Chain) -> RowAxes:
    """The axes in which the rows of the minors are."""
    rows = chain.task.rows
    if chain.n < len(rows):
        if rows == POSE:
            return RowAxes.LINK
        return RowAxes.SHORT
    if rows in (POSE, POSITION, ORIENTATION):
        return RowAxes.EVERY_LINK
    return RowAxes.TASK


def _row_names(chain: Chain) -> tuple[str, ...]:
    """Rows of the task, out of vx … wz."""
    return tuple(ROWS[row] for row in chain.task.rows)


def _block_determinants(chain: Chain, split: Decoupling) -> Determinants:
    """det J11 and det J22 of the blocks, and det J with the sign of their product."""
    ring, rows, shifts = chain.ring, _row_names(chain), tuple(map(float, chain.whole_shifts))
    minors = []
    for matrix, block in zip(("J11", "J22"), split.blocks, strict=True):
        value = Value(ring, block.determinant, block.factors)
        minors.append(Minor(MinorOf.BLOCK, block.joints, block.rows, value, shifts, matrix, block.name))
    whole = ring.determinant(submatrix(split.form.columns, range(chain.n), range(len(rows))))
    joints = tuple(range(1, chain.n + 1))
    whole = whole * _sign(chain, whole, joints)
    value = Value(ring, whole, ring.factor(whole))
    minors.append(Minor(MinorOf.BLOCK, joints, rows, value, shifts))
    together = ring.reduce(split.blocks[0].determinant * split.blocks[1].determinant)
    if whole == together:
        sign = 1
    else:
        sign = -1
    return Determinants(MinorOf.BLOCK, rows, chain.n, _axes(chain), tuple(minors), form=split.form, sign=sign)
