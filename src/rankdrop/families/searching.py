"""Search: drive many starts into singularities of one corank, and say of each how it ended.

The block F = U₂ᵀJV₂ is driven to zero by Levenberg–Marquardt with D as its derivative (`method="lm"`). Steepest descent
of a single singular value (AM eq. 11, `"gradient"`) and AM's own method, which turns the singular subspaces where
singular values tie (AM eqs 12–14, `"almarkhi"`), are there for comparison.

AM do not print their rule for the length of a step, α_k. There are two here: an exact line search, and

    α = f σ/‖∇σ‖       a share f of the step at whose end σ would be zero, were it linear (f = 1: Polyak's step)

`method="reciprocal"` searches nothing: it draws exact singular configurations (`rankdrop.families.reciprocal`).

With the line search successive gradients are at right angles where σ is smooth, so that the angles of 120° to 180° in
AM's figures come from steps that go beyond the minimum, as those of the other rule do.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop import _core
from rankdrop.errors import OptionError
from rankdrop.families.reciprocal import drawn
from rankdrop.families.search_record import (
    AM_THRESHOLD,
    LOWEST,
    MOST,
    History,
    Outcome,
    Search,
    to_the_ground,
)
from rankdrop.kinematics import LARGEST_SEED, chain_of, check_robot, configurations, task_view, whole_number
from rankdrop.local.block import generic_rank, sample
from rankdrop.local.minimax import stays_up
from rankdrop.options import takes
from rankdrop.problem import Problem
from rankdrop.questions import SearchOptions
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_units, into_units, out_of_units, task_in_units

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
MOST_THREADS = 1024
_Part = tuple[Array, Array, NDArray[np.int8], NDArray[np.int32], Array | None, Array | None, bool]
"""What the core hands back: q, sigma, outcome, iterations, history, turning, whether Ctrl-C came."""
_ITERATIONS = {"lm": MOST, "gradient": 3000, "almarkhi": 3000}
SHARE = 0.5
"""Default share of the step to linearised zero. Of 2,000 starts on PA-10, at most 3,000 iterations, it reaches corank 2
from 1,843 and corank 3 from 2,000; an exact line search from 1,679 and 431 (docs/mathematics/driving.md)."""
MOST_SHARE = 2.0  # of the step to linearised zero: from there on σ grows where it is linear


@takes(SearchOptions)
def search(
    robot: Robot,
    corank: int,
    options: SearchOptions | None = None,
    *,
    task: Task | str | None = None,
    step: float | None = None,
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
        options: method, starts, limits and seed; or its fields as keywords. Same seed, same result, on any threads.
        step: of descents: share f of the step to linearised zero, up to 2; 0: exact line search; None: `SHARE`.
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
        if (how.iterations, step, history) != (None, None, False):
            raise OptionError("nothing is iterated with reciprocal wrenches", where="method", got=how.method,
                              allowed="no iterations, step or history")  # fmt: skip
        return _drawn(robot, resolved, corank, how, progress, tolerances)
    q0 = sample(in_units(robot), task_in_units(resolved, robot), how.starts, how.seed, limits=how.limits)
    problem = Problem(in_units(robot), task_in_units(resolved, robot), corank, tolerances, how.limits)
    found = _refined(problem, q0, how, step=step, history=history, progress=progress, first=None)
    return _out_of_units(found, robot, resolved)


@takes(SearchOptions)
def refine(
    robot: Robot,
    q0: ArrayLike,
    corank: int,
    options: SearchOptions | None = None,
    *,
    task: Task | str | None = None,
    step: float | None = None,
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
    here = robot.exponent is not None
    problem = Problem(in_units(robot), task_in_units(resolved, robot), corank, tolerances, how.limits)
    rows = rows if here else into_units(robot, rows)
    found = _refined(problem, rows, how, step=step, history=history, progress=progress, first=first)
    return found if here else _out_of_units(found, robot, resolved)


def _refined(
    problem: Problem, q0: Array, how: SearchOptions, *, step: float | None, history: bool, progress: Progress | None,
    first: int | None,
) -> Search:  # fmt: skip
    """`refine` of an arm in its own unit of length; `search`, which is sparing, where no first start has a number.

    Sparing: where none of the first starts converges, those after them end at the first local minimum they meet; as
    soon as one of them does converge all of them are run as ever. Where none does, the lowest are followed on.
    """
    method, sparing, robot = how.method, first is None, problem.robot
    _check(method, problem.corank, problem.generic_rank)
    most, step = _check_steps(how, step)
    tolerances = problem.tolerances
    box = None if problem.walls is None else np.stack(problem.walls)
    rows = q0 if box is None else np.ascontiguousarray(np.clip(q0, box[0], box[1]))
    singular = tolerances.singular if method == "lm" else max(tolerances.singular, AM_THRESHOLD)

    def run(begin: int, end: int, kicks: int = _KICKS, met: float = _MET) -> tuple[list[_Part], bool]:
        settings = _core.SearchSettings(
            method=METHODS.index(method), rank=problem.rank, iterations=most, singular=singular,
            target=tolerances.target, stationary=max(tolerances.stationary, met), seed=how.seed, scale=problem.scale,
            limits=box, tie=how.tie, share=step or 0.0, kicks=kicks,
        )  # fmt: skip

        def one(part: Array, done: int) -> _Part:
            return _core.search(
                chain_of(robot), task_view(robot, problem.task), part, settings, first=(first or 0) + begin + done,
                history=history, threads=how.threads,
            )  # fmt: skip

        report = None if progress is None else lambda done, total: progress(begin + done, len(rows))
        return _in_parts(one, rows[begin:end], report)

    count = len(rows)
    first_part = min(count, _TRIED) if sparing and method == "lm" else count
    parts, whole = run(0, first_part)
    if whole and first_part < count:
        barren = not _any_converged(parts)
        rest, whole = run(first_part, count, 0, _PASSED) if barren else run(first_part, count)
        if whole and barren and _any_converged(rest):
            rest, _ = run(first_part, count)
        parts += rest
        if whole and not _any_converged(parts):
            _followed(problem, parts)
    found = _assemble(problem, method, how.seed, rows, parts)
    return replace(_creases_told(found), step=step, tie=how.tie, most=most)


def _any_converged(parts: list[_Part]) -> bool:
    return any(bool((part[2] == Outcome.CONVERGED).any()) for part in parts)


def _followed(problem: Problem, parts: list[_Part]) -> None:
    """Where none converged: follow the lowest near misses on, and take those for converged that go down to zero."""
    places = [(part, row) for part in parts for row in np.flatnonzero(part[2] == Outcome.NEAR_MISS)]
    places = sorted(places, key=lambda place: float(place[0][1][place[1], problem.rank]))[:LOWEST]
    if not places:
        return
    q, sigma = to_the_ground(problem, np.array([part[0][row] for part, row in places]))
    for (part, row), at, values in zip(places, q, sigma, strict=True):
        if values[problem.rank] <= problem.tolerances.singular:
            part[0][row], part[1][row], part[2][row] = at, values, Outcome.CONVERGED


def _drawn(
    robot: Robot, task: Task, corank: int, how: SearchOptions, progress: Progress | None, tolerances: Tolerances
) -> Search:
    """Configurations drawn by reciprocal wrenches, as a search in which every start converged at once."""
    there, there_task = in_units(robot), task_in_units(task, robot)
    corank = whole_number("corank", corank, 1, max(generic_rank(there, there_task), 1))
    found = drawn(Problem(there, there_task, corank, tolerances, how.limits), how.starts, how.seed, progress)
    for name in ("sigma", "outcome", "iterations", "stratum"):
        getattr(found, name).flags.writeable = False
    return _out_of_units(found, robot, task)


def _creases_told(cloud: Search) -> Search:
    """Descents that ended for want of a fall: at a local minimum, or on a crease where another direction leads on."""
    stuck = np.flatnonzero(cloud.outcome == Outcome.NEAR_MISS)
    if cloud.method == "lm" or not len(stuck):
        return cloud
    least = stays_up(cloud.problem, cloud.q[stuck])
    outcome = cloud.outcome.copy()
    outcome[stuck[~least]] = Outcome.CREASE
    return replace(cloud, outcome=_frozen(outcome))


def _out_of_units(cloud: Search, robot: Robot, task: Task) -> Search:
    """A search made in the arm's own unit of length, told in that of `robot`."""
    return replace(cloud, robot=robot, task=task, q=_frozen(out_of_units(robot, cloud.q)))


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


def check_numbers(starts: int, seed: int, threads: int) -> tuple[int, int, int]:
    """The three as whole numbers of Python.

    Raises:
        OptionError: one of them is not a whole number, or outside what is allowed.
    """
    return (
        whole_number("starts", starts, 1, MOST_STARTS), whole_number("seed", seed, 0, LARGEST_SEED),
        whole_number("threads", threads, 0, MOST_THREADS),
    )  # fmt: skip


def _check(method: str, corank: int, full: int) -> None:
    if method not in METHODS:
        raise OptionError("there is no such method", got=repr(method), allowed=", ".join((*METHODS, RECIPROCAL)))
    if not 1 <= corank <= full:
        raise OptionError("there is no such corank for this arm and task", got=corank, allowed=f"1 … {full}")


def _check_steps(how: SearchOptions, step: float | None) -> tuple[int, float | None]:
    if how.method != "lm":
        step = SHARE if step is None else _real("step", step, 0.0, MOST_SHARE)
    elif step is not None:
        raise OptionError(
            "block Levenberg-Marquardt chooses its own steps", where="step", got=step,
            allowed="a rule of the steps with the methods gradient and almarkhi",
        )  # fmt: skip
    return _ITERATIONS[how.method] if how.iterations is None else how.iterations, step


def _real(name: str, value: object, least: float, most: float) -> float:
    number = float(value) if isinstance(value, int | float | np.number) and not isinstance(value, bool) else np.nan
    if not least <= number <= most:
        raise OptionError(f"{name} is outside the range", got=repr(value), allowed=f"{least:g} … {most:g}")
    return number


def _assemble(
    problem: Problem, method: str, seed: int, starts: Array, parts: list[_Part]
) -> Search:
    """What the parts of the core say, and for starts that were not run that they were not."""
    done = sum(len(part[0]) for part in parts)
    left = len(starts) - done
    values = min(problem.task.m, problem.n)
    q = np.concatenate([*(part[0] for part in parts), starts[done:]])
    if not problem.limits:
        turns = problem.robot.periodic
        wrapped = q[:, turns] - 2 * np.pi * np.ceil((q[:, turns] - np.pi) / (2 * np.pi))
        q[:, turns] = np.clip(wrapped, -np.pi, np.pi)
    history = None
    if parts and parts[0][4] is not None:
        sigma = [part[4] for part in parts if part[4] is not None]
        turning = [part[5] for part in parts if part[5] is not None]
        history = History(_frozen(np.concatenate(sigma)), _frozen(np.concatenate(turning)))
    return Search(
        problem.robot, problem.task, problem.corank, problem.rank, method, seed, problem.limits, problem.tolerances,
        q=_frozen(q),
        sigma=_frozen(np.concatenate([*(part[1] for part in parts), np.full((left, values), np.nan)])),
        outcome=_frozen(np.concatenate([*(part[2] for part in parts), np.full(left, Outcome.NOT_RUN, np.int8)])),
        iterations=_frozen(np.concatenate([*(part[3] for part in parts), np.zeros(left, np.int32)])),
        history=history,
    )


_Scalar = TypeVar("_Scalar", bound=np.generic)


def _frozen(array: NDArray[_Scalar]) -> NDArray[_Scalar]:
    array.flags.writeable = False
    return array
