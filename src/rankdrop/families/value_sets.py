"""Which values the pinned joints and relations of a fitted family take: all those that hold, and as products.

From the values that searches observed outwards by symmetry: v + π and −v are tried, and stay where the rank drops.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np

from rankdrop.families.inspection import HIGHER
from rankdrop.families.linear_conditions import Linear, Values
from rankdrop.families.row import Row
from rankdrop.problem import Problem


def grow(
    start: Iterable[Values], linear: Linear, holds: Callable[[list[Values]], list[bool]], most: int = 1024
) -> set[Values]:
    """All combinations that hold, from those observed outwards by symmetry.

    Args:
        start: observed combinations.
        linear: gives the neighbours.
        holds: tests a batch of combinations directly, by their rank.
        most: tested combinations at most.
    """
    known: dict[tuple[int, float], float] = {}

    def same(values: Values) -> Values:
        """Values that agree to 1e-9 become one, so that rounding makes no new combinations."""
        return tuple(known.setdefault((i, round(v, 9) + 0.0), v) for i, v in enumerate(values))

    tested: set[Values] = set()
    holding: set[Values] = set()
    front = list(dict.fromkeys(same(values) for values in start))
    while front and len(tested) < most:
        tested.update(front)
        good = [values for values, ok in zip(front, holds(front), strict=True) if ok]
        holding.update(good)
        near = dict.fromkeys(same(n) for values in good for n in linear.neighbours(values))
        front = [values for values in near if values not in tested][: max(0, most - len(tested))]
    return holding


def boxes(holding: set[Values]) -> list[tuple[Values, ...]]:
    """Cover a set of combinations by full products, large ones first: each product is one row of the table."""
    left = set(holding)
    result = []
    while left:
        seed = min(left, key=lambda values: (sum(abs(v) for v in values), values))
        sets = _grown(seed, left, holding)
        left -= set(product(*sets))
        result.append(tuple(tuple(sorted(values, key=_zero_first)) for values in sets))
    return result


def _grown(seed: Values, left: set[Values], holding: set[Values]) -> list[list[float]]:
    """Per covector the values of a product that contains one combination, and is as large as `holding` allows.

    Covectors with many values in `left` come first.
    """
    sets = [[v] for v in seed]
    for i in sorted(range(len(seed)), key=lambda i: -len({v[i] for v in left})):
        for v in sorted({values[i] for values in left} - set(sets[i]), key=_zero_first):
            slab = product(*sets[:i], [v], *sets[i + 1 :])  # what the product grows by
            if all(values in holding for values in slab):
                sets[i].append(v)
    return sets


def _zero_first(value: float) -> tuple[float, float]:
    """Order of values: small ones first, of v and −v the positive one."""
    return abs(value), -value


def complete_rows(problem: Problem, row: Row, start: Iterable[Values], rng: np.random.Generator) -> list[Row]:
    """Rows with all combinations of values that hold, from those observed outwards by symmetry."""
    combinations = grow(start, row.linear, partial(verify_values, problem, row, rng=rng))
    return [replace(row, sets=sets) for sets in boxes(combinations)]


def verify_values(problem: Problem, row: Row, values: list[Values], rng: np.random.Generator) -> list[bool]:
    """Which combinations of values belong to the family: tested directly, by σ at random values of all other joints.

    A combination holds when every tested configuration has corank ≥ k and most have exactly k (else it belongs to the
    table of a higher corank).
    """
    if row.residual or problem.limits:
        each = 24
    else:
        each = 8
    result = _holding(problem, row, values, each, rng)
    unsure = [i for i, answer in enumerate(result) if answer is None]
    if unsure:  # limits leave little room: look harder
        again = _holding(problem, row, [values[i] for i in unsure], 20 * each, rng)
        for i, answer in zip(unsure, again, strict=True):
            result[i] = answer
    return [answer is True for answer in result]


def _holding(
    problem: Problem, row: Row, values: list[Values], each: int, rng: np.random.Generator
) -> list[bool | None]:
    """`verify_values` with a number of starts; None where fewer than three of them could be used."""
    q, good = row.solve(problem, values, each, rng)
    sigma = problem.sigma(q)
    singular = sigma[..., problem.rank] <= problem.tolerances.singular
    if problem.rank:
        exact = sigma[..., problem.rank - 1] > HIGHER
    else:
        exact = np.ones_like(singular)
    count = good.sum(axis=1)
    holds = (singular | ~good).all(axis=1) & ((exact & good).sum(axis=1) > 0.5 * count)
    return [bool(ok) if used >= 3 else None for ok, used in zip(holds, count, strict=True)]
