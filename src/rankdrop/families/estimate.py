"""What sampling has not seen.

Every converged start lands on one piece of the singular set (a row with one combination of its values). Pieces met
exactly once are the sign that others were not met at all: with f1 of them among N starts, the chance that the next
start lands on a piece never met is about f1/N (I. J. Good, The population frequencies of species, 1953).

The bound at 95 % starts from the exact binomial bound on f1 of N (3/N, the rule of three, when f1 = 0). The error of
Good's estimate has variance (f1(1 − f1/N) + 2·f2)/N², f2 the pieces met twice (W. W. Esty, 1983); the binomial bound
covers the first part, and the second is added in quadrature. It speaks of the search's own sampling mass: a piece that
no start is drawn to is beyond any such estimate.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import exp, hypot, lgamma, log, log1p, sqrt

from rankdrop.family.record import Unseen

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
