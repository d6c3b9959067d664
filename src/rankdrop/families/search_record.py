"""What a search found: how every start ended and what happened on the way, how small a near miss is, what is unseen.

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

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from functools import cached_property
from math import exp, hypot, lgamma, log, log1p, sqrt

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.family.record import Unseen
from rankdrop.kinematics import chain_of, task_view
from rankdrop.local.minimax import brought_down
from rankdrop.problem import Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section, html
from rankdrop.task import Task
from rankdrop.tolerances import TIE, Tolerances
from rankdrop.units import in_units, into_units, task_in_units

AM_THRESHOLD = 1e-6
"""AM's ε: the two descent methods stop a start here [1]."""
MOST = 200
"""Iterations of block-LM for each start, unless told otherwise."""
LOWEST = 32
"""Near misses that are looked at more closely: those of the smallest σ."""
_FINISHED = 4  # so many at a time are brought down to the end
_SAME = 4  # decimals to which all singular values of two near misses agree where they are one minimum
_DIGITS = 9  # of what it comes down to: the rest depends on the library of linear algebra


class Outcome(IntEnum):
    """How one start ended."""

    CONVERGED = 0
    """σ beyond the kept rank is zero within the tolerance: a singular configuration."""
    NEAR_MISS = 1
    """A local minimum that is not zero: no singularity, however small σ is there."""
    SLOW = 2
    """The iterations ran out on the way."""
    NOT_RUN = 3
    """Stopped before this start was done."""
    CREASE = 4
    """Stuck, and at no local minimum: σ ties with the next one, and another direction leads on down; descent only."""


@dataclass(frozen=True, eq=False)
class History:
    """What happened on the way, per start and iteration; NaN after the end (AM Figures 1–3).

    Attributes:
        sigma: (N, iterations + 1, min(m, n)) singular values.
        turning: (N, iterations + 1) angle between the gradients followed in this iteration and the one before [rad];
            NaN in the first, and where a start ended; descent only.
    """

    sigma: Array
    turning: Array


@dataclass(frozen=True, eq=False)
class Search:
    """The outcome of every start, in the order of the starts.

    Attributes:
        robot, task: what was searched.
        corank: k, task freedoms lost.
        rank: the kept rank, generic rank − k.
        method, seed, limits, tolerances: how.
        step, tie, most: rule of the steps (None: line search), gap that counts as a tie, most iterations.
        q: (N, n) where each start ended; angles in (−π, π] unless `limits` [rad or m].
        sigma: (N, min(m, n)) singular values there.
        outcome: (N,) `Outcome`.
        iterations: (N,) iterations used.
        history: per-iteration values, if asked for.
        stratum, strata: of method "reciprocal", (N,) which stratum each is from, and their names; else None and none.
        interrupted: of method "reciprocal", fewer were drawn than were asked for, for Ctrl-C came.
    """

    robot: Robot
    task: Task
    corank: int
    rank: int
    method: str
    seed: int
    limits: bool
    tolerances: Tolerances
    q: Array
    sigma: Array
    outcome: NDArray[np.int8]
    iterations: NDArray[np.int32]
    history: History | None = None
    step: float | None = None
    tie: float = TIE
    most: int = MOST
    stratum: NDArray[np.int32] | None = None
    strata: tuple[str, ...] = ()
    interrupted: bool = False

    @cached_property
    def problem(self) -> Problem:
        """What was asked."""
        return Problem(self.robot, self.task, self.corank, self.tolerances, self.limits)

    @property
    def converged(self) -> Array:
        """(C, n) the singular configurations found."""
        found: Array = self.q[self.outcome == Outcome.CONVERGED]
        return found

    @property
    def complete(self) -> bool:
        """Whether every start was run to its end."""
        return not self.interrupted and not bool((self.outcome == Outcome.NOT_RUN).any())

    @cached_property
    def smallest_near_miss(self) -> float | None:
        """Smallest σ[rank] at a nonzero local minimum, or None where there was none.

        Block-LM ends near where the sum of squares of all that has to vanish is least, and goes on to there from the
        lowest of them. Where that is more than one singular value, σ[rank] itself is brought down from there, across
        its creases; where starts converged, and all of these go down to zero as well, there is none.
        """
        missed = np.flatnonzero(self.outcome == Outcome.NEAR_MISS)
        if not len(missed):
            return None
        lowest = missed[np.argsort(self.sigma[missed, self.rank], kind="stable")]
        if self.method != "lm":
            return float(self.sigma[lowest[0], self.rank])
        own = replace(self.problem, robot=in_units(self.robot), task=task_in_units(self.task, self.robot))
        q, sigma = to_the_ground(own, into_units(self.robot, self.q[lowest[:LOWEST]]))
        order = np.argsort(sigma[:, self.rank], kind="stable")
        order = order[sigma[order, self.rank] > self.tolerances.singular]  # others were on a saddle on the way to zero
        q, sigma = q[order], sigma[order]
        if not len(q):
            return None
        if self.rank == sigma.shape[1] - 1:
            return float(sigma[0, self.rank])
        _, members = np.unique(np.round(sigma, _SAME), axis=0, return_index=True)
        q = q[np.sort(members)]  # often all of them are one minimum, met again and again
        quick = brought_down(own, q, iterations=60, effort=3)
        best = quick.q[np.argsort(quick.value, kind="stable")]
        for first in range(0, len(best), _FINISHED):
            some = best[first : first + _FINISHED]
            found = brought_down(own, some, effort=6)
            least = found.value
            if len(self.converged):  # some lead on to zero: they were minima of the sum of squares alone
                least = least[least > np.maximum(AM_THRESHOLD, found.slope)]
            if len(least):
                return float(f"{least.min():.{_DIGITS}g}")
        return None

    def count(self, outcome: Outcome) -> int:
        """Number of starts that ended so."""
        return int((self.outcome == outcome).sum())

    def _repr_html_(self) -> str:
        """For notebooks: what became of the starts."""
        counts = [(outcome_word(outcome), self.count(outcome)) for outcome in Outcome]
        smallest = self.smallest_near_miss
        return html([search_overview(self.robot, self.corank, counts, smallest, self.method, self.seed)])

    def residual(self) -> float:
        """Largest σ[rank] over the converged starts, evaluated anew; 0.0 where there is none."""
        found = self.converged
        if not len(found):
            return 0.0
        return float(self.problem.sigma(found)[:, self.rank].max())


def to_the_ground(problem: Problem, q: Array) -> tuple[Array, Array]:
    """Where the descents from (N, n) configurations end, known as well as `Tolerances.stationary` says, and σ there."""
    told = problem.tolerances
    settings = _core.SearchSettings(
        method=0, rank=problem.rank, iterations=MOST, singular=told.singular, target=told.target,
        stationary=told.stationary, seed=0, scale=problem.scale,
        limits=None if problem.walls is None else np.stack(problem.walls), tie=TIE, kicks=0,
    )  # fmt: skip
    robot = problem.robot
    found = _core.search(chain_of(robot), task_view(robot, problem.task), np.ascontiguousarray(q), settings, threads=1)
    return found[0], found[1]


def outcome_word(outcome: Outcome) -> str:
    """For people: "near miss", "stuck on a crease"."""
    return "stuck on a crease" if outcome is Outcome.CREASE else outcome.name.lower().replace("_", " ")


def search_overview(
    robot: Robot, corank: int, counts: Sequence[tuple[str, int]], smallest: float | None, method: str, seed: int
) -> Section:
    """What became of the starts of one search.

    Args:
        robot: the arm.
        corank: what was searched for.
        counts: (outcome, how many starts).
        smallest: smallest σ of a nonzero local minimum; None where there was none.
        method, seed: how.
    """
    near = "" if smallest is None else f"smallest near miss σ = {smallest:.4g}, not singular"
    return Section(
        f"{robot.name}: search for corank {corank}",
        f"method {method}, seed {seed}",
        columns=("outcome", "starts"),
        rows=tuple((name, f"{count:,}") for name, count in counts if count),
        after=(near,) if near else (),
    )


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
