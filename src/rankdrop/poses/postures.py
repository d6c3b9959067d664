"""The posture of a solution in words: the signs of the factors of det J, or of det J itself."""

from __future__ import annotations

import numpy as np

from rankdrop.errors import MissingExtraError, RobotError, TaskError
from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.posture_changes import OPEN, SIGNS, Decision, decide_postures
from rankdrop.exact.signs import Signs, configuration_flags, signs_of
from rankdrop.poses.inverse import determinants
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.units import in_metres, into_metres, task_in_metres


def decide_exactly(robot: Robot, task: Task) -> tuple[Decision, Signs | None, Chain | None]:
    """What is known without a search, the signs that tell solutions apart, and the exact arm where there is one."""
    try:
        chain = exact_chain(robot, task)
        decision = decide_postures(chain)
    except (RobotError, TaskError, MissingExtraError) as error:
        return Decision(OPEN, f"not decided exactly: {error}"), None, None
    return decision, signs_of(chain) if decision.kind == SIGNS else None, chain


def posture_names(robot: Robot, task: Task, q: Array) -> tuple[tuple[str, ...], ...]:
    """The posture of each configuration (N, n): the signs of the factors of det J where they tell solutions apart.

    Returns:
        For each row such as ("elbow +", "wrist −"); else the sign of det J; empty for arms that have no determinant.
    """
    if not len(q) or robot.n != task.m:
        return ((),) * len(q)
    _, signs, _ = decide_exactly(robot, task)
    if signs is None:
        arm_and_task = in_metres(robot), task_in_metres(task, robot)
        values = determinants(*arm_and_task, np.stack([into_metres(robot, row) for row in q]))
        return tuple((f"det J {'+' if value > 0 else '−'}",) for value in values)
    flags = (configuration_flags(signs.chain, row, signs=signs).flags for row in q)
    return tuple(tuple(flag.label for flag in some) for some in flags)
