"""Where an arm with joints to spare bears the failure of any one of them best.

    maximise over q    min_j σ_r(J₋j(q)),      or, relative,      min_j σ_r(J₋j(q)) / σ_1(J(q))

J₋j is the task Jacobian without the column of a joint that stands still, r the generic rank of the whole arm. At the
best place several failures are equally bad, so that the worst case has creases there: `local.minimax` climbs from many
starts with all of them in view. What is found are local maxima; of the relative measure none is above √((n − r)/n)
(`local.failures`), and one that reaches it is the best there is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from rankdrop import _core
from rankdrop.families.searching import Progress
from rankdrop.kinematics import check_robot, task_jacobian
from rankdrop.local.block import structural_sample
from rankdrop.local.failures import Failures, failure_model, failures_at, worst_case
from rankdrop.local.minimax import Evaluate, Lowest, descend
from rankdrop.options import takes
from rankdrop.problem import Mask, Problem, whole_turns
from rankdrop.questions import TolerantOptions
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_units, out_of_units, task_in_units

_PART = 50  # starts climbed from at once: progress moves, Ctrl-C is heard
_FIRST, _QUICK = 30, 2  # steps from every start, and the effort spent on each
_LAST = 400  # steps from the best of them
_APART = 0.05  # two places closer than this are climbed from once [rad]
_CHOSEN = 3  # times as many as are asked for are climbed to the end
_SAME = 1e-6  # two maxima closer than this in value and in joints are one [1, rad]
_REACHED = 1e-6  # of the bound


@dataclass(frozen=True, eq=False)
class Place:
    """One local maximum of the worst case.

    Attributes:
        q: (n,) configuration [rad or m]; joints that do not matter stand at 0, or in the middle of their limits.
        value: the measure: the least σ_r over all failures [1], divided by σ_1 where it is relative.
        slope: how much it can still grow to first order [1/rad]: near 0.
        failures: what each failure leaves there.
    """

    q: Array
    value: float
    slope: float
    failures: Failures


@dataclass(frozen=True, eq=False)
class Tolerant:
    """What was found.

    Attributes:
        robot, task: what was asked about.
        generic_rank: r.
        relative, limits, seed, starts, tolerances: how.
        done: starts that were climbed from; fewer than `starts` after Ctrl-C, 0 where nothing can be found.
        places: the best local maxima that differ, best first; empty where every one loses a freedom.
        free: numbers of the joints that change no σ of any J₋j.
        crucial: numbers of the joints whose failure costs a freedom at every configuration.
    """

    robot: Robot
    task: Task
    generic_rank: int
    relative: bool
    limits: bool
    seed: int
    starts: int
    tolerances: Tolerances
    done: int
    places: tuple[Place, ...]
    free: tuple[int, ...]
    crucial: tuple[int, ...]

    @property
    def spare(self) -> int:
        """n − r: how many joints the arm has to spare."""
        return self.robot.n - self.generic_rank

    @property
    def bound(self) -> float:
        """√((n − r)/n): no relative worst case is above it, at any configuration."""
        return float(np.sqrt(self.spare / self.robot.n))

    @property
    def optimal(self) -> bool:
        """Whether the best place reaches the bound, so that no configuration does better by the relative measure."""
        return bool(self.relative and self.places and self.places[0].value >= self.bound * (1.0 - _REACHED))

    @property
    def complete(self) -> bool:
        """Whether every start was climbed from, or none had to be."""
        return bool(self.done == self.starts or self.crucial)


@takes(TolerantOptions)
def most_tolerant(
    robot: Robot,
    task: Task | str | None = None,
    options: TolerantOptions | None = None,
    *,
    progress: Progress | None = None,
    tolerances: Tolerances = DEFAULT,
    **given: Any,
) -> Tolerant:
    """Find the configurations whose worst single joint failure leaves most.

    Args:
        robot: the arm.
        task: name, `Task`, or None for the task the arm is made for.
        options: the measure, the starts and how many maxima to keep; or its fields as keywords.
        progress: called now and then with (done, total).
        tolerances: σ ≤ `singular` is zero.
        given: fields of the options.

    Raises:
        OptionError: starts, seed or show outside what is allowed.
        RobotError: not a Robot.
        TaskError: there is no such task.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> arm = open_robot("almarkhi4")
        >>> found = most_tolerant(arm, resolve_task("position", arm, length_scale=1.0), relative=True, starts=50)
        >>> round(found.places[0].value, 6), found.bound, found.optimal, found.free
        (0.5, 0.5, True, (1,))
    """
    check_robot(robot)
    how = TolerantOptions.of(options, given)
    resolved, done = resolve_task(task, robot), 0
    problem = Problem(in_units(robot), task_in_units(resolved, robot), 0, tolerances, how.limits)
    crucial, free = _crucial(problem), _free(problem)
    places: tuple[Place, ...] = ()
    if not crucial:
        model, box = failure_model(problem.robot, problem.task, relative=how.relative), _box(problem)
        starts = problem.sample(how.starts, how.seed) / problem.scale
        done, climbed = _climbed(model, starts, box, progress)
        best = _polished(problem, model, climbed, box, how.show, free)
        at = [(out_of_units(robot, q), value, slope) for q, value, slope in best if value > tolerances.singular]
        places = tuple(
            Place(q, value, slope, failures_at(robot, q, resolved, tolerances=tolerances)) for q, value, slope in at
        )
    numbers = tuple(int(j) + 1 for j in np.flatnonzero(free))
    return Tolerant(
        robot, resolved, problem.generic_rank, how.relative, how.limits, how.seed, how.starts, tolerances, done, places,
        numbers, crucial,
    )  # fmt: skip


def _crucial(problem: Problem) -> tuple[int, ...]:
    """Joints without which the rank is below r at random configurations, and so at all of them."""
    robot, task, full = problem.robot, problem.task, problem.generic_rank
    if robot.n <= full:
        return tuple(range(1, robot.n + 1))
    jacobian = task_jacobian(robot, structural_sample(robot, task, 16), task) * problem.scale
    without = [np.ascontiguousarray(np.delete(jacobian, j, axis=2)) for j in range(robot.n)]
    least = [float(_core.svd(one, False)[:, full - 1].max()) for one in without]
    return tuple(j for j, sigma in enumerate(least, start=1) if sigma <= problem.tolerances.singular)


def _free(problem: Problem) -> Mask:
    """(n,) joints on which no worst case depends, absolute or relative."""
    robot, task = problem.robot, problem.task
    base, other = np.split(structural_sample(robot, task, 32), 2)
    free = np.zeros(robot.n, dtype=np.bool_)
    for j in range(robot.n):
        moved = base.copy()
        moved[:, j] = other[:, j]
        differ = [np.abs(worst_case(robot, moved, task, relative=one) - worst_case(robot, base, task, relative=one))
                  for one in (False, True)]  # fmt: skip
        free[j] = max(float(one.max()) for one in differ) < 1e-10
    return free


def _box(problem: Problem) -> tuple[Array, Array]:
    """Corners in scaled joints: the limits; else turning joints go round, and slides keep their ends."""
    turns = problem.robot.periodic
    low, high = problem.walls or problem.box
    if problem.walls is None:
        low, high = np.where(turns, -np.inf, low), np.where(turns, np.inf, high)
    return low / problem.scale, high / problem.scale


def _climbed(
    model: Evaluate, starts: Array, box: tuple[Array, Array], progress: Progress | None
) -> tuple[int, Array]:
    """How many starts were climbed from, and (done, n) where they came to, best first."""
    found: list[Lowest] = []
    done = 0
    try:
        while done < len(starts):
            found.append(descend(model, starts[done : done + _PART], box, iterations=_FIRST, effort=_QUICK))
            done += len(found[-1].q)
            if progress is not None:
                progress(done, len(starts))
    except KeyboardInterrupt:
        pass
    if not found:
        return 0, starts[:0]
    order = np.argsort(np.concatenate([one.value for one in found]), kind="stable")
    return done, np.concatenate([one.q for one in found])[order]


def _polished(
    problem: Problem, model: Evaluate, q: Array, box: tuple[Array, Array], show: int, free: Mask
) -> list[tuple[Array, float, float]]:
    """(configuration, value, slope) of the best maxima that differ, climbed to the end."""
    robot, scale = problem.robot, problem.scale
    chosen: list[Array] = []
    for row in q * scale:  # in order, those that are not near one before in the joints that matter
        if all(np.where(free, 0.0, _difference(robot, row, other)).max() > _APART for other in chosen):
            chosen.append(row)
    if not chosen:
        return []
    found = descend(model, np.array(chosen[: _CHOSEN * show]) / scale, box, iterations=_LAST)
    order = np.argsort(found.value, kind="stable")
    turned = _settled(robot, found.q[order] * scale, box, scale, free)
    kept: list[tuple[Array, float, float]] = []
    for at, value, slope in zip(turned, -found.value[order], found.slope[order], strict=True):
        near = (_difference(robot, at, other[0]).max() < 1e-3 and abs(value - other[1]) < _SAME for other in kept)
        if not any(near):
            kept.append((at, float(value), float(slope)))
    return kept[:show]


def _difference(robot: Robot, q: Array, other: Array) -> Array:
    """|q − other|, angles modulo whole turns."""
    return np.abs(q - other - whole_turns(robot, q - other))


def _settled(robot: Robot, q: Array, box: tuple[Array, Array], scale: Array, free: Mask) -> Array:
    """Joints that do not matter at 0, or in the middle of where they may go; angles in (−π, π] where no limit binds."""
    low, high = box[0] * scale, box[1] * scale
    bounded = np.isfinite(low) & np.isfinite(high)
    middle = np.where(bounded, 0.5 * (np.where(bounded, low, 0.0) + np.where(bounded, high, 0.0)), 0.0)
    wrapped = q - 2 * np.pi * np.ceil((q - np.pi - _SAME) / (2 * np.pi))
    turned = np.where(~bounded & robot.periodic, wrapped, q)
    return np.where(free, middle, turned)
