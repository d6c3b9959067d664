"""Irreducible sets put together in rows of a table.

Sets with the same conditions and with their simple angles in all combinations are one row, and so are θ5 = θ3 and
θ5 = θ3 + π: sin(θ3 − θ5) = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import cos

from rankdrop.algebra.polynomial import SIMPLE, Polynomial
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact.family import READABLE, Merged, Pins
from rankdrop.formula.writing import Condition, pin_of

_SAME = 1e-9  # cosines and sines of whole turns and quarters, to rounding


@dataclass(frozen=True, eq=False)
class SetsInRow:
    """Irreducible sets in one row.

    Attributes:
        pins: every combination of these angles belongs to it.
        equations: half-angle polynomials that vanish on all of it; a product where a sum of angles is 0 or π.
        pieces: the sets.
    """

    pins: Pins
    equations: tuple[Polynomial, ...]
    pieces: tuple[ZeroSet, ...]

    @property
    def texts(self) -> tuple[str, ...]:
        """The conditions, for people."""
        return (
            *(pin_of(self.pieces[0].ring, *pin).text() for pin in sorted(self.pins.items())),
            *(Condition(self.pieces[0].ring, f).text() for f in sorted(self.equations, key=len)),
        )

    @property
    def terms(self) -> int:
        """Number of terms of all conditions but the pins."""
        return sum(map(len, self.equations))

    @property
    def text(self) -> str:
        """All conditions, or how long they are: they take time to be written shortly, and nobody reads them."""
        if self.terms <= READABLE:
            return ", ".join(self.texts)
        pins = (pin_of(self.pieces[0].ring, *pin).text() for pin in sorted(self.pins.items()))
        count = len(self.equations)
        return ", ".join([*pins, f"{count} condition{'s' if count > 1 else ''} of {self.terms} terms"])


def merge(pieces: Sequence[ZeroSet]) -> list[SetsInRow]:
    """Rows of sets with the same conditions whose simple angles form all combinations; large sets first.

    Two rows that differ in one sum of angles alone, which is x on the one and x + π on the other, become one too.
    """
    groups: dict[tuple[str, ...], list[SetsInRow]] = {}
    for piece in pieces:
        groups.setdefault(tuple(sorted(map(str, piece.equations))), []).append(row_of_set(piece))
    rows = [row for group in groups.values() for row in merge_pairs(group, _angles_joined)]
    return sorted(merge_pairs(rows, _sums_joined), key=_order)


def row_of_set(piece: ZeroSet) -> SetsInRow:
    """One set as a row of its own."""
    return SetsInRow({joint: (value,) for joint, value in sorted(piece.pins.items())}, tuple(piece.equations), (piece,))


def merge_pairs(rows: Sequence[Merged], join: Callable[[Merged, Merged], Merged | None]) -> list[Merged]:
    """Rows of which no two can be joined; where two were, the one row comes last."""
    kept = list(rows)
    while True:
        pairs = ((first, second, join(first, second)) for first, second in combinations(kept, 2))
        mergeable = next((pair for pair in pairs if pair[2] is not None), None)
        if mergeable is None:
            return kept
        first, second, both = mergeable
        kept = [*(row for row in kept if row is not first and row is not second), *([] if both is None else [both])]


def _angles_joined(first: SetsInRow, second: SetsInRow) -> SetsInRow | None:
    """Two rows that differ in the angles of one joint alone as one; None for others."""
    joint = _different(first.pins, second.pins)
    if joint is None:
        return None
    values = tuple(sorted({*first.pins[joint], *second.pins[joint]}, key=SIMPLE.index))
    return SetsInRow({**first.pins, joint: values}, first.equations, (*first.pieces, *second.pieces))


def _sums_joined(row: SetsInRow, other: SetsInRow) -> SetsInRow | None:
    """θ5 = θ3 and θ5 = θ3 + π: sin(θ3 − θ5) = 0."""
    if row.pins != other.pins or len(row.equations) != len(other.equations):
        return None
    ring = row.pieces[0].ring
    mine, others = ({str(f): f for f in joined.equations} for joined in (row, other))
    left, right = ([f for text, f in a.items() if text not in b] for a, b in ((mine, others), (others, mine)))
    if len(left) != 1 or len(right) != 1:
        return None
    first, second = (Condition(ring, f).relation for f in (left[0], right[0]))
    if first is None or second is None or first[0] != second[0] or abs(cos((first[1] - second[1]) / 2)) > _SAME:
        return None
    kept = tuple(f for f in row.equations if f is not left[0])
    return SetsInRow(row.pins, (left[0] * right[0], *kept), (*row.pieces, *other.pieces))


def _different(first: Pins, second: Pins) -> int | None:
    if set(first) != set(second):
        return None
    joints = [joint for joint in first if first[joint] != second[joint]]
    if len(joints) == 1:
        return joints[0]
    return None


def _order(row: SetsInRow) -> tuple[object, ...]:
    """Sort key of rows: large sets first, then few and short conditions."""
    piece = row.pieces[0]
    return piece.codimension, len(row.equations), sorted(row.pins.items()), sum(map(len, row.equations)), piece.key
