"""The number of aspects of an arm: exact chain, signs of its factors, their count, within a limit of work."""

from __future__ import annotations

from rankdrop.algebra.work import OutOfTime, Work, calling_in_loops
from rankdrop.aspects.count import AspectCount, Left, count_aspects, walls_of
from rankdrop.errors import MissingExtraError, RobotError, TaskError
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.signs import Signs, signs_of
from rankdrop.results.aspect_summary import AspectSummary
from rankdrop.robot.model import Robot
from rankdrop.task import Task

COUNTING = 20.0
"""Work that counting the aspects may take [s of an idle machine]."""


def count_of_arm(robot: Robot, task: Task) -> tuple[AspectCount, Signs | None]:
    """How many aspects the arm has, joint limits ignored, with the factors that separate them in numbers.

    Args:
        robot: any arm.
        task: from `resolve_task`.

    Returns:
        The count says in `left` why nothing was counted; the signs are None then.
    """
    work = Work(COUNTING)
    try:
        with calling_in_loops(work.check):
            chain = exact_chain(robot, task, lengths="numbers")
            if chain.n == chain.task.m:
                signs: Signs | None = signs_of(chain)
            else:
                signs = walls_of(chain, work)
            if signs is None:
                return AspectCount(left=Left.WORK), None
            return count_aspects(signs, work), signs
    except OutOfTime:
        return AspectCount(left=Left.WORK), None
    except (RobotError, TaskError, MissingExtraError):
        return AspectCount(left=Left.CONDITIONS), None


def summary_of(count: AspectCount, posture_change: str | None = None) -> AspectSummary:
    """The summary of a count.

    Args:
        count: from `count_of_arm`.
        posture_change: the verdict on changes of posture, where it is known.
    """
    if count.left is not None:
        return AspectSummary(None, None, False, posture_change)
    return AspectSummary(count.at_least, count.at_most, count.proven, posture_change)
