"""Where an arm with joints to spare bears the failure of any one of them best.

    maximise over q    min_j σ_r(J₋j(q)),      or, relative,      min_j σ_r(J₋j(q)) / σ_1(J(q))

J₋j is the task Jacobian without the column of a joint that stands still, r the generic rank of the whole arm. At the
best place several failures are equally bad, so that the worst case has creases there: `local.minimax` climbs from many
starts with all of them in view. What is found are local maxima; of the relative measure none is above √((n − r)/n)
(`local.failures`), and one that reaches it is the best there is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop import _core
from rankdrop.families.searching import Progress
from rankdrop.kinematics import task_jacobian
from rankdrop.local.block import structural_sample
from rankdrop.local.failures import Failures, failure_model, failures_at, worst_case
from rankdrop.local.minimax import Evaluate, Lowest, descend
from rankdrop.problem import Mask, Problem, whole_turns
from rankdrop.questions import TolerantOptions
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
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
class TolerantPlace:
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


@dataclass(frozen=True, slots=True)
class LockedJoint:
    """Where a joint may be locked for the tool still to reach a pose.

    Attributes:
        number, joint: which, from 1, and its name.
        ranges: its values on the self-motions of the pose, from, to [rad, m].
        share: of its range that these cover, of a whole turn where no limit counts; None for a slide without limits.
    """

    number: int
    joint: str
    ranges: tuple[tuple[float, float], ...]
    share: float | None


@dataclass(frozen=True, eq=False)
class SelfMotions:
    """The self-motions of one tool pose, as far as they bear the failure of a joint.

    Attributes:
        tool_pose: (4, 4) of the tip in the base frame [m].
        q, value: the configuration that gave the pose, and the measure there.
        best, best_value: the configuration on the self-motions at which the worst failure leaves most, and the measure.
        least_value: the smallest measure on them.
        curves: how many were followed; `usable` of them have configurations inside the limits, where limits count.
        complete: every curve that was found was followed to its end.
        joints: one for each joint.
    """

    tool_pose: Array
    q: Array
    value: float
    best: Array
    best_value: float
    least_value: float
    curves: int
    usable: int
    complete: bool
    joints: tuple[LockedJoint, ...]

    @property
    def weakest(self) -> LockedJoint:
        """The joint with the smallest share."""
        return min((joint for joint in self.joints if joint.share is not None), key=lambda joint: joint.share or 0.0)


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
        self_motion: the self-motions of one pose; None where they were not asked for, or no pose is known.
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
    places: tuple[TolerantPlace, ...]
    free: tuple[int, ...]
    crucial: tuple[int, ...]
    self_motion: SelfMotions | None = None

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


def climb_to_tolerant(
    robot: Robot,
    task: Task,
    how: TolerantOptions,
    *,
    progress: Progress | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Tolerant:
    """The maxima of what the worst single failure leaves, by climbing from random starts; without self-motions.

    Args:
        robot: the arm.
        task: the task.
        how: the measure, the starts and how many maxima to keep.
        progress: called now and then with (done, total).
        tolerances: σ ≤ `singular` is zero.
    """
    done = 0
    problem = Problem(in_units(robot), task_in_units(task, robot), 0, tolerances, how.limits)
    crucial, free = _crucial(problem), _free(problem)
    places: tuple[TolerantPlace, ...] = ()
    if not crucial:
        model, box = failure_model(problem.robot, problem.task, relative=how.relative), _box(problem)
        starts = problem.sample(how.starts, how.seed) / problem.scale
        done, climbed = _climb_from_starts(model, starts, box, progress)
        best = _polish_maxima(problem, model, climbed, box, how.show, free)
        at = [(out_of_units(robot, q), value, slope) for q, value, slope in best if value > tolerances.singular]
        places = tuple(
            TolerantPlace(q, value, slope, failures_at(robot, q, task, tolerances=tolerances)) for q, value, slope in at
        )
    numbers = tuple(int(j) + 1 for j in np.flatnonzero(free))
    return Tolerant(
        robot, task, problem.generic_rank, how.relative, how.limits, how.seed, how.starts, tolerances, done, places,
        numbers, crucial, None,
    )  # fmt: skip


def _crucial(problem: Problem) -> tuple[int, ...]:
    """Joints without which the rank is below r at random configurations, and so at all of them."""
    robot, task, full = problem.robot, problem.task, problem.generic_rank
    if robot.n <= full:
        return tuple(range(1, robot.n + 1))
    jacobian = task_jacobian(robot, structural_sample(robot, task, 16), task) * problem.scale
    without = [np.ascontiguousarray(np.delete(jacobian, j, axis=2)) for j in range(robot.n)]
    least = [float(_core.svd(jacobian, False)[:, full - 1].max()) for jacobian in without]
    return tuple(j for j, sigma in enumerate(least, start=1) if sigma <= problem.tolerances.singular)


def _free(problem: Problem) -> Mask:
    """(n,) joints on which no worst case depends, absolute or relative."""
    robot, task = problem.robot, problem.task
    base, other = np.split(structural_sample(robot, task, 32), 2)
    free = np.zeros(robot.n, dtype=np.bool_)
    for j in range(robot.n):
        moved = base.copy()
        moved[:, j] = other[:, j]
        changes = []
        for relative in (False, True):
            before = worst_case(robot, base, task, relative=relative)
            after = worst_case(robot, moved, task, relative=relative)
            changes.append(float(np.abs(after - before).max()))
        free[j] = max(changes) < 1e-10
    return free


def _box(problem: Problem) -> tuple[Array, Array]:
    """Corners in scaled joints: the limits; else turning joints go round, and slides keep their ends."""
    turns = problem.robot.periodic
    low, high = problem.walls or problem.box
    if problem.walls is None:
        low, high = np.where(turns, -np.inf, low), np.where(turns, np.inf, high)
    return low / problem.scale, high / problem.scale


def _climb_from_starts(
    model: Evaluate, starts: Array, box: tuple[Array, Array], progress: Progress | None
) -> tuple[int, Array]:
    """How many starts were climbed from, and (done, n) where they came to, best first."""
    climbs: list[Lowest] = []
    done = 0
    try:
        while done < len(starts):
            climbs.append(descend(model, starts[done : done + _PART], box, iterations=_FIRST, effort=_QUICK))
            done += len(climbs[-1].q)
            if progress is not None:
                progress(done, len(starts))
    except KeyboardInterrupt:
        pass
    if not climbs:
        return 0, starts[:0]
    order = np.argsort(np.concatenate([part.value for part in climbs]), kind="stable")
    return done, np.concatenate([part.q for part in climbs])[order]


def _polish_maxima(
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
    polished = descend(model, np.array(chosen[: _CHOSEN * show]) / scale, box, iterations=_LAST)
    order = np.argsort(polished.value, kind="stable")
    turned = _settle_idle_joints(robot, polished.q[order] * scale, box, scale, free)
    kept: list[tuple[Array, float, float]] = []
    for at, value, slope in zip(turned, -polished.value[order], polished.slope[order], strict=True):
        near = (_difference(robot, at, other[0]).max() < 1e-3 and abs(value - other[1]) < _SAME for other in kept)
        if not any(near):
            kept.append((at, float(value), float(slope)))
    return kept[:show]


def _difference(robot: Robot, q: Array, other: Array) -> Array:
    """|q − other|, angles modulo whole turns."""
    return np.abs(q - other - whole_turns(robot, q - other))


def _settle_idle_joints(robot: Robot, q: Array, box: tuple[Array, Array], scale: Array, free: Mask) -> Array:
    """Joints that do not matter at 0, or in the middle of where they may go; angles in (−π, π] where no limit binds."""
    low, high = box[0] * scale, box[1] * scale
    bounded = np.isfinite(low) & np.isfinite(high)
    middle = np.where(bounded, 0.5 * (np.where(bounded, low, 0.0) + np.where(bounded, high, 0.0)), 0.0)
    wrapped = q - 2 * np.pi * np.ceil((q - np.pi - _SAME) / (2 * np.pi))
    turned = np.where(~bounded & robot.periodic, wrapped, q)
    return np.where(free, middle, turned)
