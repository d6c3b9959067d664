"""From irreducible sets to families as people list them: real, merged over 0 and π, named, checked."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from rankdrop.exact.chain import Chain
from rankdrop.exact.condition import Condition
from rankdrop.exact.family import Check, ExactFamily
from rankdrop.exact.real import Reality, real_points, reality
from rankdrop.exact.ring import SIMPLE
from rankdrop.exact.split import decompose
from rankdrop.exact.tidy import tidy
from rankdrop.exact.tree import Drop, largest
from rankdrop.exact.variety import Variety
from rankdrop.exact.verify import rank_modulo
from rankdrop.exact.work import Work
from rankdrop.robot.model import Array

_CHECKED = 3  # random points modulo a prime at which the rank of each irreducible set is taken again

Pins = dict[int, tuple[str, ...]]


@dataclass(frozen=True, eq=False)
class RealSet:
    """An irreducible set with real points of the arm on it."""

    piece: Variety
    rank: int
    reality: Reality


def real_sets(chain: Chain, drops: Sequence[Drop], work: Work, seed: int = 0) -> tuple[list[RealSet], list[str]]:
    """The sets that have real points, in short words, and sentences on those that do not.

    Where the real points of a set are fewer than its conditions say (a sum of squares vanishes), the set is cut down to
    them by the derivatives of its conditions.

    Raises:
        OutOfTime: the deadline has passed.
    """
    kept: list[RealSet] = []
    left_out: list[str] = []
    waiting = list(drops)
    while waiting:
        work.check()
        drop = waiting.pop(0)
        piece = tidy(drop.piece, work)
        found = reality(chain, piece, drop.rank, np.random.default_rng([seed, len(kept), drop.rank]))
        if found.real:
            kept.append(RealSet(piece, drop.rank, found))
        elif found.proof:
            left_out.append(f"{_text(piece)}: not real, for {found.proof}")
        else:
            thinner = _thinner(chain, piece, drop.rank, work, seed)
            waiting += thinner
            if not thinner:
                left_out.append(f"{_text(piece)}: no real point was found, from {_starts(found)} starts")
    remaining = largest([Drop(one.piece, one.rank) for one in kept])
    return [one for one in kept if any(one.piece is drop.piece for drop in remaining)], left_out


def _starts(found: Reality) -> str:
    return "random" if not len(found.points) else "all"


def _thinner(chain: Chain, piece: Variety, rank: int, work: Work, seed: int) -> list[Drop]:
    """The real points of a set whose condition does not change its sign: there its derivatives vanish too."""
    if len(piece.equations) != 1 or piece.also:
        return []
    f = piece.equations[0]
    ring = chain.ring
    slopes = [f.derivative(name) for name in ring.names[: ring.moving]]
    found = decompose(ring, piece.pins, [f, *slopes], chain.n, work)
    del seed
    return [Drop(one, rank) for one in found if one.codimension > piece.codimension]


def _text(piece: Variety) -> str:
    return piece.key


def families(
    chain: Chain,
    sets: Sequence[RealSet],
    generic_rank: int,
    work: Work,
    describe: Callable[[int, Array, Pins], tuple[str, tuple[str, ...], tuple[float, ...]]],
) -> list[ExactFamily]:
    """Merge sets that differ in the simple angle of a joint only, and describe each family.

    Args:
        chain: the arm.
        sets: from `real_sets`.
        generic_rank: of the task Jacobian.
        work: random points.
        describe: (corank, points, pins) -> (name, sentences on lost motions, witness).

    Returns:
        Families by corank, large ones first, with their numbers.
    """
    result: list[ExactFamily] = []
    for corank in range(1, generic_rank + 1):
        members = [one for one in sets if one.rank == generic_rank - corank]
        groups: dict[tuple[str, ...], list[RealSet]] = {}
        for one in members:
            groups.setdefault((*sorted(map(str, one.piece.equations)), one.reality.condition), []).append(one)
        rows = [row for group in groups.values() for row in _merged(group)]
        rows.sort(key=lambda row: _order(chain, row))
        for number, (pins, parts) in enumerate(rows, 1):
            work.check()
            result.append(_family(chain, f"k{corank}.f{number}", corank, pins, parts, work, describe))
    return result


def _merged(group: Sequence[RealSet]) -> list[tuple[Pins, list[RealSet]]]:
    """Sets with the same conditions and pinned joints become one row where their angles form all combinations."""
    rows: list[tuple[Pins, list[RealSet]]] = [
        ({joint: (value,) for joint, value in sorted(one.piece.pins.items())}, [one]) for one in group
    ]
    while True:
        pair = next((pair for pair in combinations(rows, 2) if _differ_in_one(pair[0][0], pair[1][0]) is not None), None)
        if pair is None:
            return rows
        (one, first), (two, second) = pair
        joint = _differ_in_one(one, two)
        assert joint is not None
        values = tuple(sorted({*one[joint], *two[joint]}, key=SIMPLE.index))
        rows = [row for row in rows if row is not pair[0] and row is not pair[1]]
        rows.append(({**one, joint: values}, [*first, *second]))


def _differ_in_one(one: Pins, two: Pins) -> int | None:
    """The joint in which alone two rows differ."""
    if set(one) != set(two):
        return None
    different = [joint for joint in one if one[joint] != two[joint]]
    return different[0] if len(different) == 1 else None


def _order(chain: Chain, row: tuple[Pins, list[RealSet]]) -> tuple[object, ...]:
    pins, parts = row
    piece = parts[0].piece
    return piece.codimension, len(piece.equations), sorted(pins.items()), sum(map(len, piece.equations)), piece.key


def _family(
    chain: Chain,
    identifier: str,
    corank: int,
    pins: Pins,
    parts: Sequence[RealSet],
    work: Work,
    describe: Callable[[int, Array, Pins], tuple[str, tuple[str, ...], tuple[float, ...]]],
) -> ExactFamily:
    piece = parts[0].piece
    conditions = tuple(Condition(chain.ring, f) for f in sorted(piece.equations, key=len))
    coupled = tuple(sorted({joint for condition in conditions for joint in condition.joints}))
    free = tuple(j for j in range(1, chain.n + 1) if j not in pins and j not in coupled)
    ranks = [rank_modulo(chain, point) for one in parts for point in one.piece.points(work.rng, _CHECKED)]
    points = np.concatenate([one.reality.points for one in parts])
    name, lost, witness = describe(corank, points, pins)
    return ExactFamily(
        id=identifier,
        name=name,
        corank=corank,
        dimension=piece.dimension,
        codimension=piece.codimension,
        pins=tuple(sorted(pins.items())),
        conditions=conditions,
        free=free,
        coupled=coupled,
        reality=parts[0].reality.condition,
        witness=witness,
        lost_words=lost,
        rank_check=Check(len(ranks), sum(rank == parts[0].rank for rank in ranks)),
        numbers=chain.numbers,
        shifts=tuple(float(x) for x in chain.shifts),
        pieces=tuple(one.piece for one in parts),
    )
