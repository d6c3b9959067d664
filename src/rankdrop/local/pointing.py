"""Arms of five joints: position and tool axis fix all joints, and the turn about that axis follows.

With five independent joints the six rows of a pose have rank 5 at best, and lose it only where five columns become
dependent. But the row that nobody can choose is the turn about the tool's axis (the z axis of the tip): a machine with
such an arm is programmed by position and tool axis. These five rows (`tool-axis-free`) lose rank wherever the columns
do, and elsewhere as well, such as at A5 = 0 of a KUKA without its joint 6.
"""

from __future__ import annotations

from dataclasses import replace

from rankdrop.local.block import generic_rank
from rankdrop.robot.model import Robot
from rankdrop.task import BODY, Task, resolve_task

POINTING = "tool-axis-free"
"""The task of a tool whose turn about its own axis is free."""
_ROWS = 5


def pointing_task(robot: Robot, task: Task) -> Task | None:
    """Position and tool axis in place of a pose that an arm has too few joints for; None for other arms and tasks.

    Args:
        robot: the arm.
        task: what it is asked for.

    Returns:
        The task `tool-axis-free` at the same point and on the same length scale, where the arm has five variables, the
        pose has rank 5 almost everywhere, and so have the five rows.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> px150, ur5e = open_robot("px150"), open_robot("ur5e")
        >>> pointing_task(px150, resolve_task("pose", px150)).name, pointing_task(ur5e, resolve_task("pose", ur5e))
        ('tool-axis-free', None)
    """
    if robot.n != _ROWS or task.m != _ROWS + 1:
        return None
    frame = replace(BODY, point=task.frame.point)
    found = replace(resolve_task(POINTING, robot, frame=frame), length_scale=task.length_scale)
    if generic_rank(robot, task) == _ROWS == generic_rank(robot, found):
        return found
    return None


def asked_task(robot: Robot, task: Task) -> Task:
    """Position and tool axis in place of an arm's pose where it has five joints, else the task itself."""
    return pointing_task(robot, task) or task


def turn_follows(robot: Robot, task: Task) -> bool:
    """Whether a task is position and tool axis of an arm of five joints, which fix the turn about that axis."""
    pose = Task("pose", (0, 1, 2, 3, 4, 5), length_scale=task.length_scale)
    other = pointing_task(robot, pose)
    return other is not None and (task.rows, task.frame.axes) == (other.rows, other.frame.axes)
