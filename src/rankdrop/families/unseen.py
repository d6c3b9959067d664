"""What the rows leave open: points that no row explains, and families that sampling may have missed.

Nothing is hidden: each kind of points that no row explains becomes a family without a name.

What sampling has not seen is estimated. Every converged start lands on one piece of the singular set (a row with one
combination of its values). Pieces met exactly once are the sign that others were not met at all: with f1 of them among
N starts, the chance that the next start lands on a piece never met is about f1/N (I. J. Good, The population
frequencies of species, 1953).

The bound at 95 % starts from the exact binomial bound on f1 of N (3/N, the rule of three, when f1 = 0). The error of
Good's estimate has variance (f1(1 − f1/N) + 2·f2)/N², f2 the pieces met twice (W. W. Esty, 1983); the binomial bound
covers the first part, and the second is added in quadrature. It speaks of the search's own sampling mass: a piece that
no start is drawn to is beyond any such estimate.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import exp, hypot, lgamma, log, log1p, sqrt

import numpy as np
from numpy.typing import NDArray

from rankdrop.families.linear import Linear
from rankdrop.families.signature import Inspection, inspect
from rankdrop.family.naming import lost_motions
from rankdrop.family.record import Check, Family, Pin, Sampled, Unseen
from rankdrop.family.system import Mask
from rankdrop.problem import Problem
from rankdrop.robot.model import Array

VALUES = 12  # values of a pinned joint that are listed at most
SMALL = 0.5  # a group with less than this share of another's points is small beside it
Joints = tuple[int, ...]
Shape = tuple[bool, int, Joints, Joints, Joints]
"""Regular or not; rank of D; joints pinned, free, coupled."""


def leftovers(
    problem: Problem, cloud: Inspection, left_cloud: Mask, fresh: Inspection, left_fresh: Mask
) -> list[tuple[Family, int]]:
    """Families without a name: the points of exactly this corank that are left, grouped by the shape of their tangent.

    Args:
        problem: the arm, and the corank.
        cloud, fresh: the two clouds.
        left_cloud, left_fresh: (N,) points that no row explains.

    Returns:
        The families, that of most points first, and how many points of the cloud each has. The dimension is n − rank D,
        an upper bound where the points are irregular; the witness is the point farthest from a higher corank.
    """
    q = np.concatenate([cloud.q[left_cloud & cloud.exact], fresh.q[left_fresh & fresh.exact]])
    from_cloud = int((left_cloud & cloud.exact).sum())
    if not len(q):
        return []
    inspection = inspect(problem, q)
    groups: dict[Shape, list[int]] = {}
    for i, signature in enumerate(inspection.signatures):
        key = (
            (True, signature.rank, signature.pinned, signature.free, signature.coupled)
            if signature is not None
            else _shape(inspection, i, problem)
        )
        groups.setdefault(key, []).append(i)
    ordered = sorted(_joined(groups).items(), key=lambda item: (-len(item[1]), item[1][0]))
    tested = int(fresh.exact.sum())
    return [_unnamed(problem, inspection, key, np.array(members), from_cloud, tested) for key, members in ordered]


def _joined(groups: dict[Shape, list[int]]) -> dict[Shape, list[int]]:
    """Put groups with the same pinned joints together where one is small beside the other.

    Near a degenerate geometry (offsets of a fraction of a millimetre) tangents of one set come in many shapes. What is
    coupled in one of them is coupled; the larger dimension is the bound.
    """
    joined: dict[Shape, list[int]] = {}
    for shape, members in sorted(groups.items(), key=lambda item: (-len(item[1]), item[0])):
        home = next((s for s in joined if s[2] == shape[2] and len(members) < SMALL * len(joined[s])), None)
        if home is None:
            joined[shape] = list(members)
            continue
        everyone = sorted(joined.pop(home) + members)
        coupled = tuple(sorted({*home[4], *shape[4]}))
        free = tuple(j for j in home[3] if j not in coupled)
        joined[(home[0] and shape[0], min(home[1], shape[1]), home[2], free, coupled)] = everyone
    return joined


def _shape(inspection: Inspection, i: int, problem: Problem) -> Shape:
    """Irregular points are told apart by the dimension of ker D alone; joints that never matter are free."""
    dimension = round(float(np.trace(inspection.tangent[i])))
    n = problem.n
    free = tuple(int(j) for j in np.flatnonzero(problem.idle))
    return (False, n - dimension, (), free, tuple(j for j in range(n) if j not in free))


def _unnamed(
    problem: Problem,
    inspection: Inspection,
    key: Shape,
    members: NDArray[np.int64],
    from_cloud: int,
    tested: int,
) -> tuple[Family, int]:
    regular, rank, pinned, free, coupled = key
    q, cloud = inspection.q[members], int((members < from_cloud).sum())
    gap = inspection.sigma[members, problem.rank - 1] if problem.rank else np.ones(len(members))
    at = q[int(np.argmax(gap))]
    directions, sentences = lost_motions(problem, at, q)
    kind = "" if regular else "; D has no clear rank there, so that the dimension is an upper bound"
    names = problem.robot.variables
    family = Family(
        id="",
        name="unnamed family",
        corank=problem.corank,
        dimension=problem.n - rank,
        pinned=tuple(Pin(names[j].name, j + 1, _values(problem, q, j)) for j in pinned),
        free=tuple(j + 1 for j in free),
        coupled=tuple(j + 1 for j in coupled),
        equations=(),
        witness=tuple(float(x) for x in at),
        lost_directions=directions,
        lost_words=sentences,
        evidence=Sampled(
            f"{cloud} points of the cloud and {len(members) - cloud} fresh ones, no condition found{kind}",
            Check(0, 0),
            Check(tested, len(members) - cloud),
        ),
        named=False,
    )
    return family, cloud


def _values(problem: Problem, q: Array, joint: int) -> tuple[float, ...]:
    """Different values of a joint over points, at most twelve."""
    linear = Linear.of(problem.robot, [tuple(int(i == joint) for i in range(problem.n))])
    found = linear.combinations(q, np.ones(len(q)), 1e-5)
    return tuple(sorted(values[0] for values in found)[:VALUES])


NORMAL = 1.645  # one-sided 95 % point of the normal distribution


def unseen(counts: Iterable[int]) -> Unseen:
    """Estimate the share of the sampling mass on pieces not met.

    Args:
        counts: how many points met each piece (zeros are ignored).

    Returns:
        Unseen with the Good–Turing estimate and the 95 % upper bound; 1 and 1 when there is no point at all.
    """
    met = [int(count) for count in counts if count > 0]
    total = sum(met)
    if not total:
        return Unseen(1.0, 1.0, "no point was found")
    once, twice = met.count(1), met.count(2)
    estimate = once / total
    upper = min(1.0, estimate + hypot(binomial_upper(once, total) - estimate, NORMAL * sqrt(2 * twice) / total))
    how = f"Good–Turing: {once} of {len(met)} pieces met once in {total} points"
    return Unseen(estimate, upper, how if once else f"{how}; rule of three")


def none_found(starts: int) -> Unseen:
    """When no start converged: the share of starts that would is below the rule-of-three bound."""
    return Unseen(0.0, binomial_upper(0, starts), f"none of {starts} starts converged; rule of three on the starts")


def binomial_upper(successes: int, trials: int, confidence: float = 0.95) -> float:
    """Exact (Clopper–Pearson) one-sided upper bound on a probability; 1 without trials."""
    if successes >= trials:
        return 1.0
    low, high = 0.0, 1.0
    for _ in range(60):  # the chance of so few successes falls with p: bisection to the last bit
        middle = (low + high) / 2
        low, high = (middle, high) if _at_most(successes, trials, middle) > 1 - confidence else (low, middle)
    return high


def _at_most(successes: int, trials: int, p: float) -> float:
    """Chance of at most so many successes, each trial succeeding with probability p in (0, 1)."""
    choose = [lgamma(trials + 1) - lgamma(k + 1) - lgamma(trials - k + 1) for k in range(successes + 1)]
    return sum(exp(choose[k] + k * log(p) + (trials - k) * log1p(-p)) for k in range(successes + 1))
