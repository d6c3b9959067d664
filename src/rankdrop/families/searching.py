"""Search: drive many starts into singularities of one corank, and say of each how it ended.

The block F = U₂ᵀJV₂ is driven to zero by Levenberg–Marquardt with D as its derivative (`method="lm"`). Steepest descent
of a single singular value (AM eq. 11, `"gradient"`) and AM's own method, which turns the singular subspaces where
singular values tie (AM eqs 12–14, `"almarkhi"`), are there for comparison.

AM do not print their rule for the length of a step, α_k. There are two here: an exact line search, and

    α = f σ/‖∇σ‖       a share f of the step at whose end σ would be zero, were it linear (f = 1: Polyak's step)

`method="reciprocal"` searches nothing: it draws exact singular configurations (`rankdrop.families.reciprocal`).

With the line search successive gradients are at right angles where σ is smooth, so that the angles of 120° to 180° in
AM's figures come from steps that go beyond the minimum, as those of the other rule do.

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

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from enum import IntEnum
from functools import cached_property
from math import exp, hypot, lgamma, log, log1p, sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop import _core
from rankdrop.errors import OptionError
from rankdrop.families.corank_families import Estimator, Unseen
from rankdrop.families.reciprocal import draw_singular
from rankdrop.kinematics import chain_of, check_robot, configurations, task_view, whole_number
from rankdrop.local.block import generic_rank, sample
from rankdrop.local.minimax import brought_down, stays_up
from rankdrop.options import takes
from rankdrop.problem import Problem, into_one_turn
from rankdrop.questions import SearchOptions
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section, html, words_of
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT, TIE, Tolerances
from rankdrop.units import in_units, into_units, out_of_units, task_in_units

AM_THRESHOLD = 1e-6
"""AM's ε: the two descent methods stop a start here [1]."""
MOST = 200
"""Iterations of block-LM for each start, unless told otherwise."""
LOWEST = 32
"""Near misses that are looked at more closely: those of the smallest σ."""
_FINISHED = 4  # so many at a time are brought down to the end
_SAME = 4  # decimals to which all singular values of two near misses agree where they are one minimum
_DIGITS = 6  # of what it comes down to: the rest depends on the library of linear algebra


Progress = Callable[[int, int], None]
"""Called with (starts done, starts in all)."""

METHODS = ("lm", "gradient", "almarkhi")
_MET = 1e-3
"""Share of F inside the range of D from which on a start has met a nonzero local minimum: its value is known to a
millionth then, and further digits cost two to four steps each."""
_PASSED = 1e-2
"""The same of starts of a barren search: of 10,000 on the way to a singularity 8 stand so at some time (Canadarm2)."""
_KICKS = 2  # starts from beside such a minimum
_TRIED = 1000  # starts none of which converges before those after them start from nowhere else
RECIPROCAL = "reciprocal"
MOST_STARTS = 10_000_000  # some GB of results; more is a slip of the hand
_Part = tuple[Array, Array, NDArray[np.int8], NDArray[np.int32], Array | None, Array | None, bool]
"""What the core hands back: q, sigma, outcome, iterations, history, turning, whether Ctrl-C came."""
_ITERATIONS = {"lm": MOST, "gradient": 3000, "almarkhi": 3000}
SHARE = 0.5
"""Default share of the step to linearised zero. Of 2,000 starts on PA-10, at most 3,000 iterations, it reaches corank 2
from 1,843 and corank 3 from 2,000; an exact line search from 1,679 and 431 (docs/mathematics/driving.md)."""
MOST_SHARE = 2.0  # of the step to linearised zero: from there on σ grows where it is linear

NORMAL = 1.645  # one-sided 95 % point of the normal distribution


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

    def __post_init__(self) -> None:
        for array in (self.q, self.sigma, self.outcome, self.iterations, self.stratum):
            if array is not None:
                array.flags.writeable = False

    @cached_property
    def problem(self) -> Problem:
        """What was asked."""
        return Problem(self.robot, self.task, self.corank, self.tolerances, self.limits)

    @property
    def converged(self) -> Array:
        """(C, n) the singular configurations found."""
        return np.asarray(self.q[self.outcome == Outcome.CONVERGED])

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
        scaled = replace(self.problem, robot=in_units(self.robot), task=task_in_units(self.task, self.robot))
        q, sigma = descend_to_minimum(scaled, into_units(self.robot, self.q[lowest[:LOWEST]]))
        order = np.argsort(sigma[:, self.rank], kind="stable")
        order = order[sigma[order, self.rank] > self.tolerances.singular]  # others were on a saddle on the way to zero
        q, sigma = q[order], sigma[order]
        if not len(q):
            return None
        if self.rank == sigma.shape[1] - 1:
            return float(f"{sigma[0, self.rank]:.{_DIGITS}g}")
        _, members = np.unique(np.round(sigma, _SAME), axis=0, return_index=True)
        q = q[np.sort(members)]  # often all of them are one minimum, met again and again
        quick = brought_down(scaled, q, iterations=60, effort=3)
        best = quick.q[np.argsort(quick.value, kind="stable")]
        for first in range(0, len(best), _FINISHED):
            batch = best[first : first + _FINISHED]
            brought = brought_down(scaled, batch, effort=6)
            least = brought.value
            if len(self.converged):  # some lead on to zero: they were minima of the sum of squares alone
                least = least[least > np.maximum(AM_THRESHOLD, brought.slope)]
            if len(least):
                return float(f"{least.min():.{_DIGITS}g}")
        return None

    def count(self, outcome: Outcome) -> int:
        """Number of starts that ended so."""
        return int((self.outcome == outcome).sum())

    def _repr_html_(self) -> str:
        """For notebooks: what became of the starts."""
        sections: tuple[Section, ...] = words_of(self).sections_of(self)
        return html(sections)

    def residual(self) -> float:
        """Largest σ[rank] over the converged starts, evaluated anew; 0.0 where there is none."""
        return float(self.problem.sigma(self.converged)[:, self.rank].max(initial=0.0))


@takes(SearchOptions)
def search(
    robot: Robot,
    corank: int,
    options: SearchOptions | None = None,
    *,
    task: Task | str | None = None,
    history: bool = False,
    progress: Progress | None = None,
    tolerances: Tolerances = DEFAULT,
    **given: Any,
) -> Search:
    """Search for singularities of one corank from uniform random starts.

    Args:
        robot: the arm.
        corank: k ≥ 1, at most the generic rank.
        task: what the tip has to do; None for the arm's own task.
        options: method, starts, limits, seed and steps; or its fields as keywords. The result depends on the seed, not
            on threads.
        history: keep singular values per iteration.
        progress: called now and then with (done, total).
        tolerances: thresholds; σ ≤ `singular` is zero ("gradient" and "almarkhi" stop at AM's 1e-6).
        given: fields of the options.

    Returns:
        A `Search`. On Ctrl-C the starts already done are kept, the rest are `Outcome.NOT_RUN`.

    Raises:
        OptionError: corank, starts, seed, threads, method, iterations, step or tie outside what is allowed.
        RobotError: not a Robot.
        TaskError: no such task.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = search(open_robot("pa10"), 3, starts=100)
        >>> bool((found.sigma[found.outcome == 0][:, 3] <= 1e-9).all())
        True
    """
    check_robot(robot)
    how = SearchOptions.of(options, given)
    resolved = resolve_task(task, robot)
    if how.method == RECIPROCAL:
        if (how.iterations, how.step, history) != (None, None, False):
            raise OptionError("nothing is iterated with reciprocal wrenches", where="method", got=how.method,
                              allowed="no iterations, step or history")  # fmt: skip
        full = generic_rank(robot, resolved)
        problem = _problem(robot, resolved, whole_number("corank", corank, 1, max(full, 1)), how, tolerances)
        return _out_of_units(_draw_as_search(problem, how, progress), robot, resolved)
    problem = _problem(robot, resolved, corank, how, tolerances)
    q0 = sample(problem.robot, problem.task, how.starts, how.seed, limits=how.limits)
    result = _refine_in_unit(problem, q0, how, history=history, progress=progress, first=None)
    return _out_of_units(result, robot, resolved)


@takes(SearchOptions)
def refine(
    robot: Robot,
    q0: ArrayLike,
    corank: int,
    options: SearchOptions | None = None,
    *,
    task: Task | str | None = None,
    first: int = 0,
    history: bool = False,
    progress: Progress | None = None,
    tolerances: Tolerances = DEFAULT,
    **given: Any,
) -> Search:
    """`search` from starts of your own.

    Args:
        q0: (N, n) starts [rad or m]; outside the limits they are moved to the nearest limit if `limits`.
        first: number of the first of them, from 0: as start `first` of a search it ends where it ended there, except
            that where none converged a search leaves the local minima that it meets sooner.

    Other arguments, result and errors as for `search`; and
        ConfigurationError: q0 has the wrong shape or is not finite.
    """
    check_robot(robot)
    how = SearchOptions.of(options, given)
    resolved = resolve_task(task, robot)
    rows, _ = configurations(robot, q0)
    scaled = robot.exponent is not None
    problem = _problem(robot, resolved, corank, how, tolerances)
    rows = rows if scaled else into_units(robot, rows)
    result = _refine_in_unit(problem, rows, how, history=history, progress=progress, first=first)
    if scaled:
        return result
    return _out_of_units(result, robot, resolved)


def _problem(robot: Robot, task: Task, corank: int, how: SearchOptions, tolerances: Tolerances) -> Problem:
    """What is searched for, in the arm's own unit of length."""
    return Problem(in_units(robot), task_in_units(task, robot), corank, tolerances, how.limits)


def _refine_in_unit(
    problem: Problem, q0: Array, how: SearchOptions, *, history: bool, progress: Progress | None,
    first: int | None,
) -> Search:  # fmt: skip
    """`refine` of an arm in its own unit of length; `search`, which is sparing, where no first start has a number.

    Sparing: where none of the first starts converges, those after them end at the first local minimum they meet; as
    soon as one of them does converge all of them are run as ever. Where none does, the lowest are followed on.
    """
    if how.method not in METHODS:
        raise OptionError("there is no such method", got=repr(how.method), allowed=", ".join((*METHODS, RECIPROCAL)))
    full = problem.generic_rank
    if not 1 <= problem.corank <= full:
        raise OptionError("there is no such corank for this arm and task", got=problem.corank, allowed=f"1 … {full}")
    most, step = _steps(how)
    if problem.walls is None:
        box, starts = None, q0
    else:
        box = np.stack(problem.walls)
        starts = np.ascontiguousarray(np.clip(q0, box[0], box[1]))
    descent = _Descent(problem, how, starts, box, most, step, first or 0, history, progress)
    sparing = first is None and how.method == "lm"
    if sparing and len(starts) > _TRIED:
        parts = _sparingly(descent)
    else:
        parts, _ = descent.run(0, len(starts))
    result = _assemble(problem, how.method, how.seed, starts, parts)
    return replace(_creases_told(result), step=step, tie=how.tie, most=most)


@dataclass(frozen=True)
class _Descent:
    """The starts of one search, and how the core descends from them.

    Attributes:
        problem, how: what is searched for, and the options.
        starts: (N, n) within the limits.
        box: (2, n) limits of the joints; None: none.
        most: iterations of each start.
        step: share of the step to linearised zero; None: line search.
        first: number of the first start.
        history: keep σ and the turning of the gradients on the way.
        progress: called with (starts done, starts in all).
    """

    problem: Problem
    how: SearchOptions
    starts: Array
    box: Array | None
    most: int
    step: float | None
    first: int
    history: bool
    progress: Progress | None

    def run(self, begin: int, end: int, kicks: int = _KICKS, stationary: float = _MET) -> tuple[list[_Part], bool]:
        """Outcomes of the starts from `begin` to before `end`, and whether Ctrl-C let all of them be done.

        Args:
            begin, end: which of the starts.
            kicks: starts from next to a nonzero minimum.
            stationary: share of F inside the range of D from which on a start has reached such a minimum.
        """
        settings = self._settings(kicks, stationary)
        robot, task, progress = self.problem.robot, self.problem.task, self.progress

        def descend(part: Array, done: int) -> _Part:
            return _core.search(
                chain_of(robot), task_view(robot, task), part, settings, first=self.first + begin + done,
                history=self.history, threads=self.how.threads,
            )  # fmt: skip

        report = None if progress is None else lambda done, total: progress(begin + done, len(self.starts))
        return _in_parts(descend, self.starts[begin:end], report)

    def _settings(self, kicks: int, stationary: float) -> _core.SearchSettings:
        problem, how, tolerances = self.problem, self.how, self.problem.tolerances
        singular = tolerances.singular
        if how.method != "lm":
            singular = max(singular, AM_THRESHOLD)
        return _core.SearchSettings(
            method=METHODS.index(how.method), rank=problem.rank, iterations=self.most, singular=singular,
            target=tolerances.target, stationary=max(tolerances.stationary, stationary), seed=how.seed,
            scale=problem.scale, limits=self.box, tie=how.tie, share=self.step or 0.0, kicks=kicks,
        )  # fmt: skip


def _sparingly(descent: _Descent) -> list[_Part]:
    """Outcomes of more than `_TRIED` starts, with little work for the later ones where none of the first converges."""
    count = len(descent.starts)
    parts, whole = descent.run(0, _TRIED)
    if not whole:
        return parts
    if _any_converged(parts):
        rest, _ = descent.run(_TRIED, count)
        return parts + rest
    rest, whole = descent.run(_TRIED, count, 0, _PASSED)
    if whole and _any_converged(rest):
        rest, _ = descent.run(_TRIED, count)
    parts += rest
    if whole and not _any_converged(parts):
        _follow_near_misses(descent.problem, parts)
    return parts


def _any_converged(parts: list[_Part]) -> bool:
    return any(bool((part[2] == Outcome.CONVERGED).any()) for part in parts)


def _follow_near_misses(problem: Problem, parts: list[_Part]) -> None:
    """Where none converged: follow the lowest near misses on, and take those for converged that go down to zero."""
    places = [(part, row) for part in parts for row in np.flatnonzero(part[2] == Outcome.NEAR_MISS)]
    places = sorted(places, key=lambda place: float(place[0][1][place[1], problem.rank]))[:LOWEST]
    if not places:
        return
    q, sigma = descend_to_minimum(problem, np.array([part[0][row] for part, row in places]))
    for (part, row), at, values in zip(places, q, sigma, strict=True):
        if values[problem.rank] <= problem.tolerances.singular:
            part[0][row], part[1][row], part[2][row] = at, values, Outcome.CONVERGED


def _draw_as_search(problem: Problem, how: SearchOptions, progress: Progress | None) -> Search:
    """Configurations drawn by reciprocal wrenches, as a search in which every start converged at once."""
    q, sigma, stratum, names, complete = draw_singular(problem, how.starts, how.seed, progress)
    return Search(
        problem.robot, problem.task, problem.corank, problem.rank, RECIPROCAL, how.seed, problem.limits,
        problem.tolerances, q=q, sigma=sigma, outcome=np.full(len(q), Outcome.CONVERGED, dtype=np.int8),
        iterations=np.zeros(len(q), dtype=np.int32), most=0, stratum=stratum, strata=names, interrupted=not complete,
    )  # fmt: skip


def _creases_told(cloud: Search) -> Search:
    """Descents that ended for want of a fall: at a local minimum, or on a crease where another direction leads on."""
    stuck = np.flatnonzero(cloud.outcome == Outcome.NEAR_MISS)
    if cloud.method == "lm" or not len(stuck):
        return cloud
    least = stays_up(cloud.problem, cloud.q[stuck])
    outcome = cloud.outcome.copy()
    outcome[stuck[~least]] = Outcome.CREASE
    return replace(cloud, outcome=outcome)


def _out_of_units(cloud: Search, robot: Robot, task: Task) -> Search:
    """A search made in the arm's own unit of length, told in that of `robot`."""
    return replace(cloud, robot=robot, task=task, q=out_of_units(robot, cloud.q))


def _in_parts(run: Callable[[Array, int], _Part], rows: Array, progress: Progress | None) -> tuple[list[_Part], bool]:
    """Run parts of about a tenth of a second, so that progress moves; what is done when Ctrl-C comes is kept, and
    whether none came."""
    parts: list[_Part] = []
    done, size = 0, 64
    try:
        while done < len(rows) and not (parts and parts[-1][6]):
            begun = time.perf_counter()
            parts.append(run(rows[done : done + size], done))
            done += len(parts[-1][0])
            if progress is not None:
                progress(done, len(rows))
            size = int(np.clip(size * 0.1 / max(time.perf_counter() - begun, 1e-4), 64, 16 * size))
    except KeyboardInterrupt:  # met between two parts, in `progress` say
        return parts, False
    return parts, not (parts and parts[-1][6])


def _steps(how: SearchOptions) -> tuple[int, float | None]:
    """How many iterations at most, and the rule of the steps of a descent."""
    if how.method == "lm" and how.step is not None:
        raise OptionError(
            "block Levenberg-Marquardt chooses its own steps", where="step", got=how.step,
            allowed="a rule of the steps with the methods gradient and almarkhi",
        )  # fmt: skip
    step = SHARE if how.step is None and how.method != "lm" else how.step
    return _ITERATIONS[how.method] if how.iterations is None else how.iterations, step


def _assemble(
    problem: Problem, method: str, seed: int, starts: Array, parts: list[_Part]
) -> Search:
    """What the parts of the core say, and for starts that were not run that they were not."""
    rest = starts[sum(len(part[0]) for part in parts) :]
    nothing = np.full((len(rest), min(problem.task.m, problem.n)), np.nan)
    not_run = np.full(len(rest), Outcome.NOT_RUN, np.int8)
    q = np.concatenate([*(part[0] for part in parts), rest])
    history = None
    if parts and parts[0][4] is not None and parts[0][5] is not None:
        history = History(*(np.concatenate([part[i] for part in parts]) for i in (4, 5)))
        history.sigma.flags.writeable = history.turning.flags.writeable = False
    return Search(
        problem.robot, problem.task, problem.corank, problem.rank, method, seed, problem.limits, problem.tolerances,
        q=q if problem.limits else into_one_turn(problem.robot, q),
        sigma=np.concatenate([*(part[1] for part in parts), nothing]),
        outcome=np.concatenate([*(part[2] for part in parts), not_run]),
        iterations=np.concatenate([*(part[3] for part in parts), np.zeros(len(rest), np.int32)]),
        history=history,
    )


def descend_to_minimum(problem: Problem, q: Array) -> tuple[Array, Array]:
    """Where the descents from (N, n) configurations end, known as well as `Tolerances.stationary` says, and σ there."""
    tolerances = problem.tolerances
    settings = _core.SearchSettings(
        method=0, rank=problem.rank, iterations=MOST, singular=tolerances.singular, target=tolerances.target,
        stationary=tolerances.stationary, seed=0, scale=problem.scale,
        limits=None if problem.walls is None else np.stack(problem.walls), tie=TIE, kicks=0,
    )  # fmt: skip
    robot = problem.robot
    minima = _core.search(chain_of(robot), task_view(robot, problem.task), np.ascontiguousarray(q), settings, threads=1)
    return minima[0], minima[1]


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
        return Unseen(1.0, 1.0, Estimator.NO_POINT)
    once, twice = met.count(1), met.count(2)
    estimate = once / total
    upper = min(1.0, estimate + hypot(binomial_upper(once, total) - estimate, NORMAL * sqrt(2 * twice) / total))
    return Unseen(estimate, upper, Estimator.GOOD_TURING, once, len(met), total)


def none_found(starts: int) -> Unseen:
    """When no start converged: the share of starts that would is below the rule-of-three bound."""
    return Unseen(0.0, binomial_upper(0, starts), Estimator.NO_START, number=starts)


def binomial_upper(successes: int, trials: int, confidence: float = 0.95) -> float:
    """Exact (Clopper–Pearson) one-sided upper bound on a probability; 1 without trials."""
    if successes >= trials:
        return 1.0
    low, high = 0.0, 1.0
    for _ in range(60):  # the chance of so few successes falls with p: bisection to the last bit
        middle = (low + high) / 2
        if _at_most(successes, trials, middle) > 1 - confidence:
            low, high = (middle, high)
        else:
            low, high = (low, middle)
    return high


def _at_most(successes: int, trials: int, p: float) -> float:
    """Chance of at most so many successes, each trial succeeding with probability p in (0, 1)."""
    choose = [lgamma(trials + 1) - lgamma(k + 1) - lgamma(trials - k + 1) for k in range(successes + 1)]
    return sum(exp(choose[k] + k * log(p) + (trials - k) * log1p(-p)) for k in range(successes + 1))
