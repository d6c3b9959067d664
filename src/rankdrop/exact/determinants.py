"""The determinant of a Jacobian said out loud, or the minors that take its place; and the closed inverse.

All in factors:

    as many joints as rows      det J; where J is block triangular: det J = ± det J11 det J22
    more joints than rows       the minors |$1 … $m| of every m columns: the rank drops where all of them vanish
    fewer joints than rows      the minors of every n rows

A minor of all rows of a pose, a position or an orientation is the same number in the axes of every link, and of a pose
about every reference point: a change of either multiplies J by a matrix of determinant 1. Of other rows it is that in
the axes of the task; axes turned upside down would change its sign.

The closed inverse of a square Jacobian is its adjugate over its determinant, entry by entry, both in factors.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from rankdrop.errors import OptionError
from rankdrop.exact.algebra.factoring import factors_within
from rankdrop.exact.algebra.field import P, complete, value_at
from rankdrop.exact.algebra.polynomial import Polynomial
from rankdrop.exact.algebra.ring import MANY, Ring
from rankdrop.exact.algebra.work import OutOfTime, Work
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.link_jacobian import POSE, POSITION
from rankdrop.exact.arm.structure import listed
from rankdrop.exact.decoupling import Decoupling, decouple
from rankdrop.exact.methods.derivation import values_of
from rankdrop.exact.writing.notation import C, Python
from rankdrop.exact.writing.value import FOLDED, Quotient, Value
from rankdrop.kinematics import task_jacobian
from rankdrop.local.block import sample
from rankdrop.task import ROWS
from rankdrop.tolerances import DEFAULT

ORIENTATION = (3, 4, 5)
_TRIED = 20  # random configurations at most on which a sign is read off
MOST = 60
"""More minors than that are counted, not written."""


@dataclass(frozen=True, eq=False)
class Minor:
    """The determinant of some rows and columns of a Jacobian.

    Attributes:
        name: "det J", "det J11", "|$1 $2 $3 $4 $5 $6|" of screws, "|J1 J3|" of columns for a task with fewer rows.
        joints: of its columns, numbered from 1, in order.
        rows: of the task, out of vx … wz, in order.
        about: where its rows are taken, where that is not said for all.
        value: the determinant.
    """

    name: str
    joints: tuple[int, ...]
    rows: tuple[str, ...]
    about: str
    value: Value

    @property
    def mark(self) -> str:
        """A name for code: det_J11, minor_1_2_3, minor_vx_wz."""
        if self.name.startswith("det"):
            return self.name.replace(" ", "_")
        return "minor_" + "_".join(word.lstrip("$J") for word in self.name.strip("|").split())

    @property
    def factored(self) -> bool:
        """Whether its factors were found."""
        return self.value.factors is not None or self.value.polynomial == 0


@dataclass(frozen=True, eq=False)
class Determinants:
    """What there is to say of the determinants of an arm.

    Attributes:
        product: how the determinant follows from the minors: "det J = −det J11 det J22"; "" where there is one, or
            none.
        meaning: what the minors are, and where the rank drops, in a sentence.
        minors: the determinant or the minors, those that vanish everywhere too; of blocks first, det J last.
        left: what was not done within the limit on work.
    """

    product: str
    meaning: str
    minors: tuple[Minor, ...]
    left: tuple[str, ...] = ()

    def lines(self, most: int | None = FOLDED) -> tuple[str, ...]:
        """In text.

        Args:
            most: factors of more characters are told by their size; None for none.
        """
        found = [self.meaning]
        for one in self.minors:
            found += [one.about] if one.about else []
            name = self.product if self.product and one.name == "det J" else one.name
            found.append(f"{name} = {one.value.text(most)}")
        return (*found, *(f"not done: {what}" for what in self.left))

    def folded(self) -> bool:
        """Whether `lines` tells a factor by its size."""
        return self.lines() != self.lines(None)

    def to_dict(self, shifts: tuple[float, ...]) -> dict[str, Any]:
        """For a result file; code is in the joint variables q = θ − shift."""
        return {
            "product": self.product,
            "meaning": self.meaning,
            "left": list(self.left),
            "minors": [_minor_dict(one, shifts) for one in self.minors],
        }


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
        >>> [f"{one.name} = {one.value.text()}" for one in found.minors]
        ['det J11 = −a2 d4 s3 (a2 c2 + d4 c23)', 'det J22 = −s5', 'det J = a2 d4 s3 s5 (a2 c2 + d4 c23)']
    """
    n, m = chain.n, chain.task.m
    split = decouple(chain, names=False) if n == m else None
    if split is not None:
        return _decoupled(chain, split)
    minors: list[Minor] = []
    left: list[str] = []
    chosen = list(_chosen(chain))
    for name, joints, rows in chosen[:MOST]:
        place = [chain.task.rows.index(r) for r in rows]
        try:
            work.check()
            found = chain.ring.determinant([[chain.columns[j - 1][i] for j in joints] for i in place])
            found = found * _sign(chain, found, joints) if len(rows) == chain.task.m else found
            value = _value(chain, found, work)
        except OutOfTime:
            left.append(name)
            continue
        minors.append(Minor(name, joints, tuple(ROWS[r] for r in rows), "", value))
    if len(chosen) > MOST:
        left.append(f"{len(chosen) - MOST} more minors")
    return Determinants("", _meaning(chain), tuple(minors), tuple(left))


def _value(chain: Chain, p: Polynomial, work: Work) -> Value:
    """A polynomial with its factors, if it is not too long to be factored."""
    if p == 0 or len(p) > MANY:
        return Value(chain.ring, p, None)
    return Value(chain.ring, p, factors_within(chain.ring, p, work.left))


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


def _chosen(chain: Chain) -> Iterator[tuple[str, tuple[int, ...], tuple[int, ...]]]:
    """(name, joints, rows) of every minor."""
    joints, rows = tuple(range(1, chain.n + 1)), chain.task.rows
    if chain.n == len(rows):
        yield "det J", joints, rows
    elif chain.n > len(rows):
        letter = "$" if len(rows) == 6 else "J"
        for some in combinations(joints, len(rows)):
            yield f"|{' '.join(f'{letter}{j}' for j in some)}|", some, rows
    else:
        for kept in combinations(rows, chain.n):
            yield f"|{' '.join(ROWS[r] for r in kept)}|", joints, kept


def _meaning(chain: Chain) -> str:
    n, rows = chain.n, chain.task.rows
    told = ", ".join(ROWS[r] for r in rows)
    if n == len(rows):
        return f"rows {told}, joints 1 to {n}: {_axes(chain)}"
    if n > len(rows):
        column = "$j = (v; ω) is the screw of joint j" if len(rows) == 6 else f"Jj is column j of J, rows {told}"
        return f"{column}: the rank drops where all of these minors vanish; {_axes(chain)}"
    where = f"rows in the frame of link {chain.frame}" if rows == POSE else "rows in axes in which they are short"
    return f"each minor is made of as many rows as there are joints, {where}: the rank drops where all of them vanish"


def _axes(chain: Chain) -> str:
    """In which axes the determinant is that."""
    if chain.task.rows in (POSE, POSITION, ORIENTATION):
        return "the same number in the axes of every link"
    return "in the axes of the task"


def _decoupled(chain: Chain, split: Decoupling) -> Determinants:
    """det J11 and det J22 of the blocks, and det J with the sign of their product."""
    ring, rows = chain.ring, chain.task.rows
    names = ("det J11", "det J22")
    minors = []
    for name, block in zip(names, split.blocks, strict=True):
        told = f"J{name[-2:]}, {block.name}: rows {', '.join(block.rows)} of joints {listed(block.joints)}"
        minors.append(Minor(name, block.joints, block.rows, told, Value(ring, block.determinant, block.factors)))
    whole = ring.determinant([[split.columns[j][i] for j in range(chain.n)] for i in range(len(rows))])
    joints = tuple(range(1, chain.n + 1))
    whole = whole * _sign(chain, whole, joints)
    minors.append(Minor("det J", joints, tuple(ROWS[r] for r in rows), "", Value(ring, whole, ring.factor(whole))))
    together = ring.reduce(split.blocks[0].determinant * split.blocks[1].determinant)
    sign = "" if whole == together else "−"
    meaning = (
        f"rows {', '.join(ROWS[r] for r in rows)}, joints 1 to {chain.n}, reference point: {split.point}; the "
        "determinant is the same at the tip"
    )
    return Determinants(f"det J = {sign}det J11 det J22", meaning, tuple(minors))


def _minor_dict(minor: Minor, shifts: tuple[float, ...]) -> dict[str, Any]:
    return {
        "name": minor.name,
        "mark": minor.mark,
        "joints": list(minor.joints),
        "rows": list(minor.rows),
        "about": minor.about,
        "factored": minor.factored,
        "sign": minor.value.sign,
        "number": str(minor.value.form.number),
        "factors": [
            {"text": text, "latex": latex, "multiplicity": power} for text, latex, power in minor.value.powers()
        ] if minor.factored else [],
        "terms": minor.value.terms,
        "text": minor.value.text(),
        "latex": minor.value.latex(),
        "python": minor.value.code(Python(shifts=shifts)),
        "c": minor.value.code(C(shifts=shifts)),
    }  # fmt: skip


POINTS = 3
"""Random points at which the product with the Jacobian is computed modulo the prime."""


@dataclass(frozen=True, eq=False)
class ClosedInverse:
    """The inverse of a square matrix over the trigonometric ring.

    Attributes:
        determinant: in factors where they were found.
        entries: entries[i][j] of the inverse.
        agree, tested: at how many of the random points modulo the prime J · adj J = det J · 1.
    """

    determinant: Value
    entries: tuple[tuple[Quotient, ...], ...]
    agree: int
    tested: int


def closed_inverse(ring: Ring, rows: Sequence[Sequence[Polynomial]], work: Work) -> ClosedInverse:
    """J⁻¹ = adj J / det J.

    Args:
        ring: of the entries.
        rows: square.
        work: limit.

    Raises:
        OptionError: not square, or the determinant vanishes everywhere.
        OutOfTime: the limit was met.
    """
    n = len(rows)
    if any(len(row) != n for row in rows):
        raise OptionError(
            "only a square Jacobian has an inverse", got=f"{n} rows, {len(rows[0])} joints",
            mend="a task with as many rows as joints",
        )
    work.check()
    whole = ring.determinant(rows)
    if whole == 0:
        raise OptionError("a Jacobian that is singular everywhere has no inverse", mend="a task that the arm can serve")
    below = _entry(ring, whole, work)
    adjugate = [[_cofactor(ring, rows, j, i, work) for j in range(n)] for i in range(n)]
    entries = tuple(tuple(Quotient(_entry(ring, x, work), below) for x in row) for row in adjugate)
    agree = sum(_agrees(ring, rows, adjugate, whole, seed) for seed in range(POINTS))
    return ClosedInverse(below, entries, agree, POINTS)


def _entry(ring: Ring, p: Polynomial, work: Work) -> Value:
    """An entry of the adjugate with its factors."""
    work.check()
    return Value(ring, p, None if p == 0 else factors_within(ring, p, work.left))


def _cofactor(ring: Ring, rows: Sequence[Sequence[Polynomial]], i: int, j: int, work: Work) -> Polynomial:
    """(−1)^(i+j) times the determinant without row i and column j."""
    work.check()
    minor = ring.determinant([[x for b, x in enumerate(row) if b != j] for a, row in enumerate(rows) if a != i])
    return -minor if (i + j) % 2 else minor


def _agrees(
    ring: Ring,
    rows: Sequence[Sequence[Polynomial]],
    adjugate: Sequence[Sequence[Polynomial]],
    whole: Polynomial,
    seed: int,
) -> bool:
    """Whether J · adj J = det J · 1 at a random point modulo the prime."""
    rng, n = random.Random(seed), len(rows)
    point = None
    while point is None:
        point = complete(ring, {name: rng.randrange(P) for name in ring.names}, {})
    one = [[value_at(ring, x, point) for x in row] for row in rows]
    two = [[value_at(ring, x, point) for x in row] for row in adjugate]
    middle = value_at(ring, whole, point)
    entries = ((i, j, sum(one[i][k] * two[k][j] for k in range(n)) % P) for i in range(n) for j in range(n))
    return all(value == (middle if i == j else 0) for i, j, value in entries)
