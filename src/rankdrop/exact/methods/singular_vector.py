"""The singular vector: Jᵀ u = 0 solved by elimination, without fractions, in every case of a pivot.

After k steps the entries that are left are, up to the pivots before, minors of order k + 1 that border the pivot's
minor: they are computed as such, which is elimination without fractions and without growth. A pivot that may vanish
parts the case. After m − 1 pivots (m rows of the task) u is known up to its length: its components are the cofactors of
the pivots' columns, and J is singular where the equations that are left hold, too: where all minors bordering the last
pivot vanish (Kronecker).
"""

from __future__ import annotations

from dataclasses import dataclass

from rankdrop.exact.algebra.polynomial import Polynomial, order
from rankdrop.exact.algebra.work import OutOfTime
from rankdrop.exact.methods.derivation import Equality
from rankdrop.exact.methods.draft import Case, Columns, Draft, Factors, branches, pieces


@dataclass(frozen=True)
class _Step:
    """A case in the middle of elimination: the minor of these rows and columns (from 0) does not vanish in it."""

    case: Case
    rows: tuple[int, ...] = ()
    columns: tuple[int, ...] = ()


def singular_vector(draft: Draft) -> None:
    """Conditions case by case: which pivots do not vanish, and what is left of Jᵀ u = 0.

    Args:
        draft: filled in. Sizes: "cases", "longest" equation of a case in terms.

    Raises:
        OptionError: the rank is not full anywhere.
        OutOfTime: no time is left; what was found until then is in the draft.
    """
    draft.full_rank()
    draft.sizes |= {"cases": 0, "longest": 0}
    waiting = [_Step(Case())]
    while waiting:
        step = waiting.pop(0)
        try:
            waiting[:0] = _eliminated(draft, step)  # pivots that do not vanish first: that case holds most
        except OutOfTime as error:
            draft.generic = True
            raise OutOfTime(f"{error}; {len(waiting) + 1} cases") from error
    draft.notes.append(
        f"{draft.sizes['cases']} cases of pivots, {len(draft.conditions)} of them with singular configurations; some "
        "may be empty, and where a case holds no more than another one it is not left out"
    )


def _eliminated(draft: Draft, step: _Step) -> list[_Step]:
    """One step of elimination; the cases that follow from it."""
    draft.check("elimination")
    ring, case = draft.ring, step.case
    columns = case.columns(ring, draft.chain.columns)
    size = min(len(columns), len(columns[0]))
    while len(step.rows) < size:
        left = _bordering(draft, columns, step)
        if len(step.rows) == size - 1:
            break
        pivot = _pivot(draft, case, left)
        if pivot is None:  # everything that is left vanishes: the rank is lower still
            left = []
            break
        row, column, factors = pivot
        following = _Step(case.with_nonzero(*factors), (*step.rows, row), (*step.columns, column))
        if factors:
            parts = [_Step(part, step.rows, step.columns) for part in branches(draft, case, factors)]
            return [following, *parts]
        step = following
    draft.sizes["cases"] += 1
    found = [case.factors(draft, entry) for _, _, entry in left]
    met = pieces([Equality(tuple(sorted(factors, key=order))) for factors in found if factors is not None])
    draft.conditions += [case.conjunction(ring, piece) for piece in met]
    longest = max((equality.terms for piece in met for equality in piece.equal), default=0)
    draft.sizes["longest"] = max(draft.sizes["longest"], longest)
    return []


def _bordering(draft: Draft, columns: Columns, step: _Step) -> list[tuple[int, int, Polynomial]]:
    """(row, column, minor) for each row and column besides the pivots', minors that are not zero."""
    found = []
    for column in range(len(columns)):
        for row in range(len(columns[0])):
            if row not in step.rows and column not in step.columns:
                minor = draft.minor([columns[c] for c in (*step.columns, column)], (*step.rows, row))
                if minor != 0:
                    found.append((row, column, minor))
    return found


def _pivot(
    draft: Draft, case: Case, left: list[tuple[int, int, Polynomial]]
) -> tuple[int, int, Factors] | None:
    """The entry with the fewest and shortest atoms that may vanish; None where all entries vanish in the case."""
    best = None
    for row, column, entry in sorted(left, key=lambda item: len(item[2])):
        if best is not None and len(entry) > 4 * best[0]:
            break
        factors = case.factors(draft, entry)
        if factors is None:
            continue
        weight = (len(factors), sum(atom.weight for atom in factors))
        if best is None or weight < best[1]:
            best = (len(entry), weight, (row, column, factors))
        if not factors:
            break
    return None if best is None else best[2]
