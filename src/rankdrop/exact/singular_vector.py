"""Method "singular_vector": Jᵀ u = 0 solved by elimination, without fractions, in every case of a pivot.

After k steps the entries that are left are, up to the pivots before, minors of order k + 1 that border the pivot's
minor: they are computed as such, which is elimination without fractions and without growth. A pivot that may vanish
parts the case. After m − 1 pivots (m rows of the task) u is known up to its length: its components are the cofactors of
the pivots' columns, and J is singular where the equations that are left hold, too: where all minors bordering the last
pivot vanish (Kronecker).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rankdrop.algebra.halt import Halt, HaltKind, OutOfTime
from rankdrop.algebra.polynomial import Polynomial
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact.conjunctions import (
    Atoms,
    Columns,
    SetDerivation,
    columns_on,
    condition_within,
    conjunctions,
    equality_of,
)
from rankdrop.lists import flat_map

_Pivots = tuple[ZeroSet, tuple[int, ...], tuple[int, ...]]
"""A case in the middle of elimination: the minor of these rows and columns (from 0) does not vanish in it."""


def singular_vector(builder: SetDerivation) -> None:
    """Conditions case by case: which pivots do not vanish, and what is left of Jᵀ u = 0.

    Args:
        builder: filled in. Sizes: "cases", "longest" equation of a case in terms.

    Raises:
        OptionError: the rank is not full anywhere.
        OutOfTime: no time is left; what was found until then is in the builder.
    """
    builder.full_rank()
    builder.sizes |= {"cases": 0, "longest": 0}
    waiting: list[_Pivots] = [(ZeroSet.whole(builder.ring), (), ())]
    while waiting:
        step = waiting.pop(0)
        try:
            waiting[:0] = _eliminate_pivot(builder, step)  # pivots that do not vanish first: that case holds most
        except OutOfTime as error:
            builder.generic = True
            cases = Halt(HaltKind.CASES, number=len(waiting) + 1)
            raise OutOfTime(replace(error.halt, waiting=cases)) from error
    builder.note("pivots", cases=builder.sizes["cases"], conditions=len(builder.conditions))


def _eliminate_pivot(builder: SetDerivation, step: _Pivots) -> list[_Pivots]:
    """One step of elimination; the cases that follow from it."""
    builder.check(Halt(HaltKind.ELIMINATION))
    case, rows, chosen = step
    columns = columns_on(case, builder.chain.columns)
    size = min(len(columns), len(columns[0]))
    left: list[tuple[int, int, Polynomial]] = []
    while len(rows) < size:
        left = _bordering(builder, columns, rows, chosen)
        if len(rows) == size - 1:
            break
        pivot = _pivot(builder, case, left)
        if pivot is None:  # everything that is left vanishes: the rank is lower still
            left = []
            break
        row, column, factors = pivot
        following = (case.remove_zeros(*factors), (*rows, row), (*chosen, column))
        if factors:
            return [following, *((part, rows, chosen) for part in builder.branches(case, factors))]
        case, rows, chosen = following
    builder.sizes["cases"] += 1
    entries = [builder.factors(case, entry) for _, _, entry in left]
    met = conjunctions(equality_of(factors) for factors in entries if factors is not None)
    builder.conditions += [condition_within(case, piece) for piece in met]
    longest = max((condition.terms for condition in flat_map(lambda piece: piece.equal, met)), default=0)
    builder.sizes["longest"] = max(builder.sizes["longest"], longest)
    return []


def _bordering(
    builder: SetDerivation, columns: Columns, rows: Sequence[int], chosen: Sequence[int]
) -> list[tuple[int, int, Polynomial]]:
    """(row, column, minor) for each row and column besides the pivots', minors that are not zero."""
    others = [column for column in range(len(columns)) if column not in chosen]
    places = [(row, column) for column in others for row in range(len(columns[0])) if row not in rows]
    bordering = [(r, c, builder.minor([columns[k] for k in (*chosen, c)], (*rows, r))) for r, c in places]
    return [entry for entry in bordering if entry[2] != 0]


def _pivot(
    builder: SetDerivation, case: ZeroSet, left: list[tuple[int, int, Polynomial]]
) -> tuple[int, int, Atoms] | None:
    """The entry with the fewest and shortest atoms that may vanish; None where all entries vanish in the case."""
    best = None
    for row, column, entry in sorted(left, key=lambda item: len(item[2])):
        if best is not None and len(entry) > 4 * best[0]:
            break
        factors = builder.factors(case, entry)
        if factors is None:
            continue
        weight = (len(factors), sum(atom.weight for atom in factors))
        if best is None or weight < best[1]:
            best = (len(entry), weight, (row, column, factors))
        if not factors:
            break
    return None if best is None else best[2]
