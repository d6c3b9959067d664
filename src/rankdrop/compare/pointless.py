"""Sets without a point modulo any of the primes, though they may be real: what is known of them all the same.

The rank tree tells sets apart at random points modulo primes. With letters for lengths a set has such points for about
every other value of them, with numbers modulo about every other prime; a few have none modulo all that are tried.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rankdrop.compare.cloud import Cloud, explained
from rankdrop.exact.algebra.field import PRIMES
from rankdrop.exact.algebra.variety import Variety
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.family import ExactFamily
from rankdrop.exact.merge import alone, merge
from rankdrop.exact.reading.lint import real_points
from rankdrop.exact.tree import Tree
from rankdrop.local.block import singular_values
from rankdrop.robot.model import Array
from rankdrop.tolerances import DEFAULT
from rankdrop.units import into_units

_POINTS = 24  # real points looked at on each
_LONG = 40  # terms of a set's conditions beyond which they tell nobody anything


def pointless(
    chain: Chain, tree: Tree, families: Sequence[ExactFamily], seed: int
) -> tuple[list[str], list[str]]:
    """What the tree leaves open for want of points, and the sets on which no real point was found, in sentences.

    A set is no loss where all real points found lie on the families of a rank as low, or where the rank is not lower
    there and no smaller set inside it is looked for. That none was found is no proof that there is none.
    """
    lost: dict[str, Variety] = {}
    unmet: dict[str, Variety] = {}
    for piece, order, last in tree.pointless:
        theta = [point for point, _ in zip(real_points(piece, chain, seed=seed), range(_POINTS), strict=False)]
        if not theta:
            unmet[piece.key] = piece
        elif piece.key not in lost and not _settled(chain, tree, families, np.array(theta), order, last):
            lost[piece.key] = piece
    short = [piece for piece in unmet.values() if _terms(piece) <= _LONG]
    words = f"no real point was found, nor one modulo {len(PRIMES)} primes"
    told = [f"{', '.join(row.texts)}: {words}" for row in merge(short)]
    if len(unmet) > len(short):
        told.append(f"{len(unmet) - len(short)} sets with long conditions: no real point was found on them either")
    return [_sentence(list(lost.values()))] if lost else [], told


def _sentence(lost: Sequence[Variety]) -> str:
    sets = "1 set of real configurations" if len(lost) == 1 else f"{len(lost)} sets of real configurations"
    shortest = min(lost, key=_terms)
    texts = ", ".join(alone(shortest).texts) if _terms(shortest) <= _LONG else ""
    where = f" ({'' if len(lost) == 1 else 'one is '}{texts})" if texts else ""
    return (
        f"{sets}{where} could not be looked into: roots of numbers that stand in the conditions exist modulo none of "
        f"the {len(PRIMES)} primes by which ranks are taken. Whether the rank drops inside is not known; "
        "--lengths letters may avoid this"
    )


def _terms(piece: Variety) -> int:
    return sum(map(len, piece.equations))


def _settled(
    chain: Chain,
    tree: Tree,
    families: Sequence[ExactFamily],
    theta: Array,
    order: int,
    last: bool,
) -> bool:
    q = into_units(chain.robot, theta - chain.shifts)
    rank = (singular_values(chain.own, q, chain.own_task) > DEFAULT.singular).sum(axis=1)
    low = rank < order
    if not low.any():
        return last
    corank = tree.generic_rank - rank
    for k in sorted(set(corank[low].tolist())):
        here = q[low & (corank == k)]
        known = [family.in_units(chain).equations for family in families if family.corank >= k]
        _, over = explained(Cloud(chain.own, chain.own_task, here, np.full(len(here), k)), known)
        if len(over):
            return False
    return bool(low.all()) or last
