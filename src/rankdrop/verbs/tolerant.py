"""The configurations that bear the failure of a joint best, and what the self-motions of a pose leave."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from rankdrop.distance.tolerant import Tolerant, climb_to_tolerant
from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.families.searching import Progress
from rankdrop.kinematics import check_robot, one_configuration
from rankdrop.options import takes
from rankdrop.problem import Problem
from rankdrop.questions import TolerantOptions
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_units, task_in_units
from rankdrop.verbs.self_motions import self_motions

_SAME = 1e-6  # beyond a joint limit by less is at it [rad, m]


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
        OptionError: starts, seed or show outside what is allowed; a configuration without `self_motion`; self-motions
            of an arm with none, or with more than one joint to spare.
        ConfigurationError: `q` is not one configuration of this arm, or is outside the limits that count.
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
    resolved = resolve_task(task, robot)
    start = _pose_asked(robot, resolved, how, tolerances)
    climbed = climb_to_tolerant(robot, resolved, how, progress=progress, tolerances=tolerances)
    if start is None and climbed.places:
        start = climbed.places[0].q
    if not how.self_motion or start is None:
        return climbed
    motions = self_motions(robot, start, resolved, relative=how.relative, limits=how.limits, seed=how.seed)
    return replace(climbed, self_motion=motions)


def _pose_asked(robot: Robot, task: Task, how: TolerantOptions, tolerances: Tolerances) -> Array | None:
    """The configuration that gives the pose of the self-motions; None for the best one found.

    Raises:
        OptionError, ConfigurationError: as `most_tolerant`.
    """
    if how.q is not None and not how.self_motion:
        raise OptionError("a configuration is for the self-motions of its pose", where="q", got=how.q,
                          mend="ask for self_motion as well")  # fmt: skip
    rank = Problem(in_units(robot), task_in_units(task, robot), 0, tolerances).generic_rank
    if how.self_motion and robot.n != rank + 1:
        raise OptionError(
            "self-motions are followed as curves, which arms with one joint to spare have", where="self_motion",
            got=f"{robot.name}: {robot.n} joints, rank {rank}", allowed="one joint more than the rank",
            mend="take a task with one row less than the arm has joints",
        )  # fmt: skip
    if how.q is None:
        return None
    if isinstance(how.q, str):
        raise OptionError("a configuration is a list of joint values", where="q", got=how.q,
                          allowed="[q1, q2, …] [rad, m]")  # fmt: skip
    q = one_configuration(robot, how.q)
    outside = np.flatnonzero((q < robot.lower - _SAME) | (q > robot.upper + _SAME)) + 1
    if how.limits and len(outside):
        raise ConfigurationError(
            "the configuration is outside the joint limits", where="q", got=q.tolist(),
            mend=f"change joints {', '.join(map(str, outside))}, or leave the limits out",
        )  # fmt: skip
    return q
