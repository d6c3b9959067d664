"""Sets derived by each method, points modulo P with their ranks, and the conditions that hold at them."""

from __future__ import annotations

import random
from collections.abc import Sequence
from functools import cache
from itertools import combinations

from exact.chains import chain_of

from rankdrop.algebra.field import ModularPoint, P, bivariate, common_zeros, complete, holds, roots, univariate
from rankdrop.algebra.polynomial import SIMPLE, Equality
from rankdrop.algebra.ring import Ring
from rankdrop.exact.arm.verify import rank_check
from rankdrop.exact.conjunctions import Conjunction, SetDerivation
from rankdrop.exact.methods import derive


@cache
def derived(name: str, method: str) -> SetDerivation:
    return derive(chain_of(name), method, 60.0)


def vanishes(equality: Equality, ring: Ring, point: ModularPoint) -> bool:
    parts = equality.atoms if equality.whole is None else (equality.whole,)
    return any(holds(ring, part, point) for part in parts)


def holds_at(condition: Conjunction, ring: Ring, point: ModularPoint) -> bool:
    """Whether a condition holds at a point modulo P, exactly."""
    unequal = (any(not vanishes(equality, ring, point) for equality in group) for group in condition.unequal)
    return all(vanishes(equality, ring, point) for equality in condition.equal) and all(unequal)


def holds_modulo(found: SetDerivation, points: Sequence[ModularPoint]) -> tuple[bool, ...]:
    """Whether one of the conditions holds at each of the points modulo P, exactly."""
    return tuple(any(holds_at(one, found.ring, point) for one in found.conditions) for point in points)


@cache
def strata(name: str, count: int = 200) -> tuple[tuple[ModularPoint, ...], tuple[bool, ...]]:
    """Points modulo P with joints at simple angles or where one or two minors vanish, and whether they are singular."""
    chain, rng = chain_of(name), random.Random(7)
    ring, m = chain.ring, chain.task.m
    points: list[ModularPoint] = []
    subsets = list(combinations(chain.columns, m))
    while len(points) < count:
        pins = {j: rng.choice(SIMPLE) for j in ring.revolute if rng.random() < rng.choice([0.0, 0.3, 0.6])}
        values = ModularPoint({name: rng.randrange(1, P) for name in ring.names if name not in {f"t{j}" for j in pins}})
        moving = [name for name in ring.names[: ring.moving] if name in values]
        rng.shuffle(moving)
        chosen = rng.sample(subsets, min(2, len(subsets)))
        minors = [ring.determinant([[column[row] for column in subset] for row in range(m)]) for subset in chosen]
        found = [ring.to_half(p).f for p in (ring.at(p, pins) for p in minors) if p != 0]
        if found and moving and rng.random() < 0.5:
            zeros = roots(univariate(ring, found[0], moving[0], values))
            if zeros:
                values[moving[0]] = rng.choice(zeros)
        elif len(found) == 2 and len(moving) > 1:
            x, y = moving[:2]
            pair = next(common_zeros(*(bivariate(ring, f, x, y, values) for f in found)), None)
            if pair is not None:
                values[x], values[y] = pair
        point = complete(ring, values, pins)
        if point is not None:
            points.append(point)
    return tuple(points), tuple(rank < min(m, chain.n) for rank in rank_check(chain, points))
