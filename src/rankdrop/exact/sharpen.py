"""Conditions that hold on a set and nowhere else where the rank is higher.

An irreducible set is solved for one variable after the other, and the equations met on the way may hold elsewhere too:
A t + B = 0 and A'B − AB' = 0 hold where A = B = 0, whatever t is. A factor of a minor that vanishes on the set, and not
there, tells the two apart.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np

from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.polynomial import used
from rankdrop.exact.algebra.variety import Variety
from rankdrop.exact.algebra.work import Work
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.tree import by_length
from rankdrop.exact.writing.condition import Condition
from rankdrop.robot.model import Array

_MINORS = 60  # minors that are factored in search of a condition
_ENOUGH = 6  # conditions that are compared
_FAR = 1e-6  # |f| above this, coefficients of size one: the condition does not hold


def sharpened(
    chain: Chain, piece: Variety, rank: int, strays: Array, known: Sequence[Polynomial], work: Work
) -> Variety | None:
    """The set with one more condition, which fails at some of the strays; None where none was found.

    Args:
        chain: the arm.
        piece: irreducible set.
        rank: of the task Jacobian almost everywhere on it.
        strays: (k, n) configurations of `Chain.own`, of higher rank, at which all its conditions hold; k ≥ 1.
        known: conditions that served other sets: tried first, so that sets alike get the same words.
        work: deadline.

    Raises:
        OutOfTime: the deadline has passed.
    """
    best: tuple[tuple[int, int], Polynomial] | None = None
    for f in islice((f for f in _candidates(chain, piece, rank, known, work)), _ENOUGH + len(known)):
        away = _away(chain, f, strays)
        if away and any(f is one for one in known):
            return replace(piece, equations=(*piece.equations, f))
        if away and (best is None or (-away, len(f)) < best[0]):
            best = ((-away, len(f)), f)
    return None if best is None else replace(piece, equations=(*piece.equations, best[1]))


def _away(chain: Chain, f: Polynomial, strays: Array) -> int:
    """At how many configurations a condition does not hold."""
    condition = Condition(chain.ring, chain.own_polynomial(f))
    equation = condition.equation(chain.own_numbers, chain.n, chain.shifts.tolist())
    return int((np.abs(equation(strays)) > _FAR).sum())


def _candidates(
    chain: Chain, piece: Variety, rank: int, known: Sequence[Polynomial], work: Work
) -> Iterator[Polynomial]:
    """Half-angle polynomials that vanish on a set: known ones, then factors of minors that are zero on it."""
    ring = piece.ring
    seen = {str(f) for f in piece.equations}
    pinned = {ring.index[f"t{joint}"] for joint in piece.pins}
    for f in known:
        if not pinned & {*used(f)} and piece.half_vanishes(f):
            yield f
    columns = [[ring.at(x, piece.pins) for x in column] for column in chain.columns]
    lengths = [[len(x) if x != 0 else 0 for x in column] for column in columns]
    for columns_used, rows_used in islice(by_length(lengths, rank + 1), _MINORS):
        work.check()
        minor = ring.determinant([[columns[c][r] for c in columns_used] for r in rows_used])
        for atom, _ in ring.factor(minor).atoms if minor != 0 else ():
            if not atom.pinned and atom.key not in seen and piece.half_vanishes(atom.f):
                seen.add(atom.key)
                yield atom.f
