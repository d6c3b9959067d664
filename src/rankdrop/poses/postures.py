"""The posture of a solution in words: the signs of the factors of det J, or of det J itself."""

from __future__ import annotations

from itertools import compress

import numpy as np

from rankdrop.errors import MissingExtraError, RobotError, TaskError
from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.posture_changes import OPEN, SIGNS, Decision, decide_postures
from rankdrop.exact.signs import Signs, configuration_flags, signs_of
from rankdrop.local.block import generic_rank
from rankdrop.local.pointing import fitting_task
from rankdrop.poses.inverse import determinants
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task
from rankdrop.units import in_metres, into_metres, task_in_metres


def decide_exactly(robot: Robot, task: Task) -> tuple[Decision, Signs | None, Chain | None]:
    """What is known without a search, the signs that tell solutions apart, and the exact arm where there is one."""
    try:
        chain = exact_chain(robot, task)
        decision = decide_postures(chain)
    except (RobotError, TaskError, MissingExtraError) as error:
        return Decision(OPEN, f"not decided exactly: {error}"), None, None
    return decision, signs_of(chain) if decision.kind == SIGNS else None, chain


def _task_of_all_joints(robot: Robot, task: Task) -> Task | None:
    """Of an arm with fewer joints than rows a task with as many rows that it can do in full; None where none is known.

    That is the task the arm is made for, position and yaw of a SCARA, or position and tool axis of five joints.
    """
    if robot.n >= task.m:
        return None
    made_for = resolve_task(None, robot, frame=task.frame)
    for other in (made_for, fitting_task(robot, task)):
        if other is not None and other.m == robot.n == generic_rank(robot, other):
            return other
    return None


def _parts_alone(chain: Chain | None, q: Array) -> tuple[tuple[str, ...], ...]:
    """The signs of those factors of det J that are about a part of the arm; none where det J is not known or zero."""
    if chain is None:
        return ((),) * len(q)
    try:
        signs = signs_of(chain)
    except TaskError:
        return ((),) * len(q)
    named = [name is not None and bool(name.parts) for name in signs.names]
    postures = []
    for row in q:
        flags = compress(configuration_flags(chain, row, signs=signs).flags, named)
        postures.append(tuple(flag.label for flag in flags))
    return tuple(postures)


def _determinant_signs(robot: Robot, task: Task, q: Array) -> tuple[tuple[str, ...], ...]:
    """The sign of det J at each configuration (N, n)."""
    there = in_metres(robot), task_in_metres(task, robot)
    values = determinants(*there, np.stack([into_metres(robot, row) for row in q]))
    return tuple((f"det J {'+' if value > 0 else '−'}",) for value in values)


def posture_names(robot: Robot, task: Task, q: Array) -> tuple[tuple[str, ...], ...]:
    """The posture of each configuration (N, n): the signs of the factors of det J where they tell solutions apart.

    An arm with fewer joints than the task has rows has the posture that it has in a task of as many rows; of factors
    that do not tell all solutions apart those of a part of the arm are taken.

    Returns:
        For each row such as ("elbow +", "wrist −"); else the sign of det J; empty for arms that have no determinant.
    """
    square = _task_of_all_joints(robot, task) or task
    if not len(q) or robot.n != square.m:
        return ((),) * len(q)
    _, signs, chain = decide_exactly(robot, square)
    if signs is None and square is not task:
        return _parts_alone(chain, q)
    if signs is None:
        return _determinant_signs(robot, task, q)
    flags = (configuration_flags(signs.chain, row, signs=signs).flags for row in q)
    return tuple(tuple(flag.label for flag in some) for some in flags)
