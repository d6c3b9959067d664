"""Irreducible sets that differ in the simple angle of one joint only, put into one row."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

from rankdrop.exact.algebra.ring import SIMPLE
from rankdrop.exact.algebra.variety import Variety
from rankdrop.exact.writing.condition import Condition
from rankdrop.exact.writing.pins import pin_text

Pins = dict[int, tuple[str, ...]]
"""Joint number -> the simple angles it stands at."""
Row = tuple[Pins, list[Variety]]
"""Every combination of the angles belongs to it, one set each."""


def merge(pieces: Sequence[Variety]) -> list[Row]:
    """Rows of sets with the same conditions whose simple angles form all combinations; large sets first."""
    groups: dict[tuple[str, ...], list[Variety]] = {}
    for piece in pieces:
        groups.setdefault(tuple(sorted(map(str, piece.equations))), []).append(piece)
    return sorted((row for group in groups.values() for row in _rows(group)), key=_order)


def alone(piece: Variety) -> Row:
    """One set as a row of its own."""
    return {joint: (value,) for joint, value in sorted(piece.pins.items())}, [piece]


def row_texts(row: Row) -> tuple[str, ...]:
    """The conditions of a row, for people."""
    pins, pieces = row
    return (
        *(pin_text(joint, values) for joint, values in sorted(pins.items())),
        *(Condition(pieces[0].ring, f).text() for f in sorted(pieces[0].equations, key=len)),
    )


def _rows(group: Sequence[Variety]) -> list[Row]:
    rows = [alone(one) for one in group]
    while True:
        for one, two in combinations(rows, 2):
            joint = _different(one[0], two[0])
            if joint is not None:
                break
        else:
            return rows
        values = tuple(sorted({*one[0][joint], *two[0][joint]}, key=SIMPLE.index))
        rows = [row for row in rows if row is not one and row is not two]
        rows.append(({**one[0], joint: values}, [*one[1], *two[1]]))


def _different(one: Pins, two: Pins) -> int | None:
    """The joint in which alone two rows differ."""
    if set(one) != set(two):
        return None
    joints = [joint for joint in one if one[joint] != two[joint]]
    return joints[0] if len(joints) == 1 else None


def _order(row: Row) -> tuple[object, ...]:
    pins, (piece, *_) = row
    return piece.codimension, len(piece.equations), sorted(pins.items()), sum(map(len, piece.equations)), piece.key
