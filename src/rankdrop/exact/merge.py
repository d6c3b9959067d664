"""Irreducible sets that differ in one simple angle, or in one sum of angles by π, put into one row."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import cos

from rankdrop.exact.algebra.atom import SIMPLE
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.variety import Variety
from rankdrop.exact.writing.condition import Condition
from rankdrop.exact.writing.pins import pin_text

_SAME = 1e-9

Pins = dict[int, tuple[str, ...]]
"""Joint number -> the simple angles it stands at."""


@dataclass(frozen=True, eq=False)
class Row:
    """Irreducible sets in one row.

    Attributes:
        pins: every combination of these angles belongs to it.
        equations: half-angle polynomials that vanish on all of it; a product where a sum of angles is 0 or π.
        pieces: the sets.
    """

    pins: Pins
    equations: tuple[Polynomial, ...]
    pieces: tuple[Variety, ...]

    @property
    def texts(self) -> tuple[str, ...]:
        """The conditions, for people."""
        return (
            *(pin_text(joint, values) for joint, values in sorted(self.pins.items())),
            *(Condition(self.pieces[0].ring, f).text() for f in sorted(self.equations, key=len)),
        )


def merge(pieces: Sequence[Variety]) -> list[Row]:
    """Rows of sets with the same conditions whose simple angles form all combinations; large sets first.

    Two rows that differ in one sum of angles alone, which is x on the one and x + π on the other, become one too.
    """
    groups: dict[tuple[str, ...], list[Row]] = {}
    for piece in pieces:
        groups.setdefault(tuple(sorted(map(str, piece.equations))), []).append(alone(piece))
    rows = [row for group in groups.values() for row in _joined(group, _angles_joined)]
    return sorted(_joined(rows, _sums_joined), key=_order)


def alone(piece: Variety) -> Row:
    """One set as a row of its own."""
    return Row({joint: (value,) for joint, value in sorted(piece.pins.items())}, tuple(piece.equations), (piece,))


def _joined(rows: list[Row], join: Callable[[Row, Row], Row | None]) -> list[Row]:
    """Rows joined two by two as long as that is possible."""
    while True:
        for one, two in combinations(rows, 2):
            both = join(one, two)
            if both is not None:
                rows = [*(row for row in rows if row is not one and row is not two), both]
                break
        else:
            return rows


def _angles_joined(one: Row, two: Row) -> Row | None:
    joint = _different(one.pins, two.pins)
    if joint is None:
        return None
    values = tuple(sorted({*one.pins[joint], *two.pins[joint]}, key=SIMPLE.index))
    return Row({**one.pins, joint: values}, one.equations, (*one.pieces, *two.pieces))


def _sums_joined(one: Row, two: Row) -> Row | None:
    """θ5 = θ3 and θ5 = θ3 + π: sin(θ3 − θ5) = 0."""
    if one.pins != two.pins or len(one.equations) != len(two.equations):
        return None
    ring = one.pieces[0].ring
    mine, others = ({str(f): f for f in row.equations} for row in (one, two))
    left, right = ([f for text, f in a.items() if text not in b] for a, b in ((mine, others), (others, mine)))
    if len(left) != 1 or len(right) != 1:
        return None
    first, second = (Condition(ring, f).relation for f in (left[0], right[0]))
    if first is None or second is None or first[0] != second[0] or abs(cos((first[1] - second[1]) / 2)) > _SAME:
        return None
    kept = tuple(f for f in one.equations if f is not left[0])
    return Row(one.pins, (left[0] * right[0], *kept), (*one.pieces, *two.pieces))


def _different(one: Pins, two: Pins) -> int | None:
    """The joint in which alone two rows differ."""
    if set(one) != set(two):
        return None
    joints = [joint for joint in one if one[joint] != two[joint]]
    return joints[0] if len(joints) == 1 else None


def _order(row: Row) -> tuple[object, ...]:
    piece = row.pieces[0]
    return piece.codimension, len(row.equations), sorted(row.pins.items()), sum(map(len, row.equations)), piece.key
