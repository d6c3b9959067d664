"""From irreducible sets to families as people list them: real, merged over 0 and π, named, checked."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from rankdrop.exact.algebra.decompose import decompose
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.solving import form
from rankdrop.exact.algebra.split import with_points
from rankdrop.exact.algebra.tidy import tidy
from rankdrop.exact.algebra.variety import Variety
from rankdrop.exact.algebra.work import OutOfTime, Work
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.check import Check
from rankdrop.exact.family import ExactFamily
from rankdrop.exact.merge import Pins, Row, alone, merge
from rankdrop.exact.real import STARTS, Reality, reality
from rankdrop.exact.sharpen import sharpened
from rankdrop.exact.tree import Drop, largest, rank_on
from rankdrop.exact.verify import rank_agreement
from rankdrop.exact.writing.condition import Condition
from rankdrop.family.naming import told_apart
from rankdrop.robot.model import Array

_LONG = 40  # terms of a set's conditions beyond which they are not written out
_SHARPENED = 3  # conditions added at most
_CHECKED = 3  # random points modulo a prime at which the rank of each irreducible set is taken again


@dataclass(frozen=True, eq=False)
class RealSet:
    """An irreducible set with real points of the arm on it."""

    piece: Variety
    rank: int
    reality: Reality


def real_sets(
    chain: Chain, drops: Sequence[Drop], work: Work, left: list[str], seed: int = 0
) -> tuple[list[RealSet], list[str]]:
    """The sets that have real points, in short words, and sentences on those that do not.

    Where the real points of a set are fewer than its conditions say (a sum of squares vanishes), the set is cut down to
    them by the derivatives of its conditions. What time does not allow is told in `left`.
    """
    kept: list[RealSet] = []
    left_out: dict[str, list[Variety]] = {}
    known: list[Polynomial] = []
    waiting = list(drops)
    while waiting:
        work.show("sets with real points", max(len(drops) - len(waiting), 0), len(drops))
        try:
            work.check()
            drop = waiting[0]
            piece, found = _sharp(chain, drop, np.random.default_rng([seed, len(kept), drop.rank]), known, work)
            systems = len(work.unresolved)
            work.pointless.clear()
            thinner = [] if found.real or found.proof else _thinner(chain, piece, work)
        except (OutOfTime, KeyboardInterrupt) as stop:
            what = str(stop) if isinstance(stop, OutOfTime) else "interrupted"
            left.append(f"{what}: {len(waiting)} of {len(drops)} sets were not looked at for real points")
            if isinstance(stop, KeyboardInterrupt):
                work.interrupt()
            break
        waiting = [*waiting[1:], *thinner]
        if work.pointless or len(work.unresolved) > systems:
            left.append(f"the real points of a set were not all taken apart: {_named(piece)}")
            work.pointless.clear()
        if found.real:
            kept.append(RealSet(piece, drop.rank, found))
            if len(found.strays):
                left.append(
                    f"the conditions of a set of rank {drop.rank} hold at configurations of higher rank, too, and no "
                    f"further condition was found that tells them apart: {_named(piece)}"
                )
        elif found.proof:
            left_out.setdefault(f"not real, for {found.proof}", []).append(piece)
        elif not thinner and (found.unclear or (len(piece.equations) > 1 and len(found.points))):
            left.append(
                f"a set has real points, but its conditions are dependent at all that were found: {_named(piece)}"
            )
        elif not thinner:
            left_out.setdefault(f"no real point was found from {STARTS} random starts", []).append(piece)
    remaining = largest([Drop(one.piece, one.rank) for one in kept])
    sentences = [f"{', '.join(row.texts)}: {why}" for why, pieces in left_out.items() for row in merge(pieces)]
    return [one for one in kept if any(one.piece is drop.piece for drop in remaining)], sentences


def _sharp(
    chain: Chain, drop: Drop, rng: np.random.Generator, known: list[Polynomial], work: Work
) -> tuple[Variety, Reality]:
    """A set in short words, with conditions added until no configuration of higher rank satisfies them."""
    piece = tidy(drop.piece, work)
    found = reality(chain, piece, drop.rank, rng)
    for _ in range(_SHARPENED):
        if not len(found.strays):
            break
        more = sharpened(chain, piece, drop.rank, found.strays, known, work)
        if more is None:
            break
        known += [f for f in more.equations[-1:] if not any(f is one for one in known)]
        piece, found = more, reality(chain, more, drop.rank, rng)
    return piece, found


def _named(piece: Variety) -> str:
    """A set for people: its conditions, or how long they are."""
    terms = sum(map(len, piece.equations))
    return ", ".join(alone(piece).texts) if terms <= _LONG else f"{len(piece.equations)} conditions of {terms} terms"


def _thinner(chain: Chain, piece: Variety, work: Work) -> list[Drop]:
    """The real points of a set whose condition does not change its sign: there its derivatives vanish too."""
    if len(piece.equations) != 1 or piece.also:
        return []
    ring, (f, degree) = chain.ring, form(piece.equations[0], chain.ring)
    slopes = []
    for place, name in enumerate(ring.names[: ring.moving]):
        slope = f.derivative(name)
        if place < ring.angles:  # by the angle, of f / (1 + t²)^(D/2): a polynomial of degree D again
            t = f.context().gen(place)
            slope = (1 + t**2) * slope - degree[place] * t * f
        slopes.append((slope, degree))
    found = decompose(ring, piece.pins, [(f, degree), *slopes], chain.n, work)
    smaller = with_points([one for one in found if one.codimension > piece.codimension], work)
    return [Drop(one, rank_on(chain.columns, one)) for one in smaller]


def families(
    chain: Chain,
    sets: Sequence[RealSet],
    generic_rank: int,
    work: Work,
    describe: Callable[[int, Array, Pins, bool], tuple[str, tuple[str, ...], tuple[float, ...]]],
) -> list[ExactFamily]:
    """Merge sets that differ in the simple angle of a joint only, and describe each family.

    Args:
        chain: the arm.
        sets: from `real_sets`.
        generic_rank: of the task Jacobian.
        work: random points.
        describe: (corank, points, pins, whether there are other conditions) -> (name, sentences on lost motions,
            witness).

    Returns:
        Families by corank, large ones first, with their numbers.
    """
    result: list[ExactFamily] = []
    seen = {id(one.piece): one.reality for one in sets}
    for corank in range(1, generic_rank + 1):
        rank = generic_rank - corank
        by_reality: dict[str, list[Variety]] = {}
        for one in sets:
            if one.rank == rank:
                by_reality.setdefault(one.reality.condition, []).append(one.piece)
        rows = [row for pieces in by_reality.values() for row in merge(pieces)]
        here: list[ExactFamily] = []
        for row in rows:
            work.show("families described", len(result) + len(here), len(result) + len(rows))
            realities = [seen[id(piece)] for piece in row.pieces]
            points = np.concatenate([one.points for one in realities])
            told = describe(corank, points, row.pins, bool(row.equations))
            check = rank_agreement(chain, (p for piece in row.pieces for p in piece.points(work.rng, _CHECKED)), rank)
            here.append(_family(chain, corank, row, realities[0].condition, told, check))
        here.sort(key=lambda family: family.place(chain.robot))
        names = told_apart([one.name for one in here], [partial(getattr, one, "texts") for one in here])
        result += [
            replace(family, id=f"k{corank}.f{number}", name=name)
            for number, (family, name) in enumerate(zip(here, names, strict=True), 1)
        ]
    return result


def _family(
    chain: Chain,
    corank: int,
    row: Row,
    condition: str,
    told: tuple[str, tuple[str, ...], tuple[float, ...]],
    check: Check,
) -> ExactFamily:
    piece = row.pieces[0]
    conditions = tuple(Condition(chain.ring, f) for f in sorted(row.equations, key=len))
    coupled = tuple(sorted({joint for one in conditions for joint in one.joints}))
    return ExactFamily(
        id="",
        name=told[0],
        corank=corank,
        dimension=piece.dimension,
        codimension=piece.codimension,
        pins=tuple(sorted(row.pins.items())),
        conditions=conditions,
        free=tuple(j for j in range(1, chain.n + 1) if j not in row.pins and j not in coupled),
        coupled=coupled,
        reality=condition,
        witness=told[2],
        lost_words=told[1],
        rank_check=check,
        numbers=chain.numbers,
        shifts=tuple(float(x) for x in chain.shifts),
        pieces=row.pieces,
    )
