"""Sets that have no point modulo the prime, though they may be real: what is known of them all the same.

The rank tree tells sets apart at random points modulo a prime. With letters for lengths a set has such points for about
every other value of them. With numbers it may have none: √2 is real, and need not be a number modulo P.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rankdrop.exact.algebra.variety import Variety
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.family import ExactFamily
from rankdrop.exact.reading.example import real_points
from rankdrop.exact.tree import Tree
from rankdrop.exact.verify import Cloud, explained
from rankdrop.local.block import singular_values
from rankdrop.tolerances import DEFAULT
from rankdrop.units import into_units

_POINTS = 24  # real points looked at on each


def pointless(chain: Chain, tree: Tree, families: Sequence[ExactFamily], seed: int) -> list[str]:
    """What the tree leaves open for want of points, in words.

    A set is no loss where no real point of it is found, where all those found lie on the families of a rank as low, or
    where the rank is not lower there and no smaller set inside it is looked for.
    """
    lost: dict[str, Variety] = {}
    for piece, order, last in tree.pointless:
        if piece.key not in lost and not _settled(chain, tree, families, piece, order, last, seed):
            lost[piece.key] = piece
    if not lost:
        return []
    sets = "1 set that may be real has" if len(lost) == 1 else f"{len(lost)} sets that may be real have"
    return [
        f"{sets} no point modulo 2^61 − 11913, by which sets are told apart: what singular configurations there are "
        "inside is not known; letters for the lengths avoid this"
    ]


def _settled(
    chain: Chain, tree: Tree, families: Sequence[ExactFamily], piece: Variety, order: int, last: bool, seed: int
) -> bool:
    theta = [point for point, _ in zip(real_points(piece, chain, seed=seed), range(_POINTS), strict=False)]
    if not theta:
        return True
    q = into_units(chain.robot, np.array(theta) - chain.shifts)
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
