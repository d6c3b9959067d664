"""The task of arms with too few joints for a pose: position and tool axis, position and yaw, or position.

With five independent joints the six rows of a pose have rank 5 at best, and lose it only where five columns become
dependent. But the row that nobody can choose is the turn about the tool's axis (the z axis of the tip): a machine with
such an arm is programmed by position and tool axis. These five rows (`tool-axis-free`) lose rank wherever the columns
do, and elsewhere as well, such as at A5 = 0 of a KUKA without its joint 6.

Where the last joint turns the tool about that axis, or about one that is near to it, the five rows leave out what this
joint can do, and ask for what no joint can: such an arm keeps the pose, its rank 5, and what it can never do.

With four joints a palletiser holds its tool level: a parallelogram, or joints that follow others, cancel every tilt.
It is programmed by position and yaw (`scara`).

Two or three joints that place the tool leave none to turn it: such an arm is programmed by position. The six rows of a
pose have full rank there even where the arm is stretched, since the columns still turn the tool. Two joints with axes
that meet at the tip only turn it: such an arm keeps the pose.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rankdrop.kinematics import jacobian, pose
from rankdrop.local.block import generic_rank, sample
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.model import Array, Robot
from rankdrop.task import BODY, Task, resolve_task

POINTING = "tool-axis-free"
"""The task of a tool whose turn about its own axis is free."""
LEVEL = "scara"
"""The task of a tool that no joint tilts."""
PLACED = "position"
"""The task of three joints that place the tool."""
_ROWS = 5
_LEVEL_ROWS = 4
_PLACE_ROWS = 3
_SAMPLES = 8  # configurations at which the tool must not tilt
TILTED = 1e-3  # of a pose for a tool that no joint tilts: more is no rounding [rad]
_PARALLEL = 1e-3  # sine of the angle between the last axis and z of the tool
_BESIDE = 0.1  # distance of the two, in reaches of the arm
_TILT = 1e-12  # of a joint, below which it is rounding [rad/rad]


def pointing_task(robot: Robot, task: Task) -> Task | None:
    """Position and tool axis in place of a pose that an arm has too few joints for; None for other arms and tasks.

    Args:
        robot: the arm.
        task: what it is asked for.

    Returns:
        The task `tool-axis-free` at the same point and on the same length scale, where the arm has five variables, the
        pose has rank 5 almost everywhere, and so have the five rows, and the last joint does not turn the tool about z.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> px150, ur5e = open_robot("px150"), open_robot("ur5e")
        >>> pointing_task(px150, resolve_task("pose", px150)).name, pointing_task(ur5e, resolve_task("pose", ur5e))
        ('tool-axis-free', None)
    """
    if robot.n != _ROWS or task.m != _ROWS + 1:
        return None
    frame = replace(BODY, point=task.frame.point)
    pointing = replace(resolve_task(POINTING, robot, frame=frame), length_scale=task.length_scale)
    if generic_rank(robot, task) == _ROWS == generic_rank(robot, pointing) and not _rolls_tool(robot, task):
        return pointing
    return None


def _rolls_tool(robot: Robot, task: Task) -> bool:
    """Whether the last joint turns the tool about its z axis through the reference point, or one near to that."""
    last = jacobian(robot, np.zeros(robot.n), replace(BODY, point=task.frame.point))[:, -1]
    along, around = last[5], last[3:5]
    offset = np.hypot(last[0], last[1])
    return bool(np.hypot(*around) <= _PARALLEL * abs(along) and offset <= _BESIDE * reach(robot))


def level_task(robot: Robot, task: Task) -> Task | None:
    """Position and yaw in place of a pose, for an arm of four joints that never tilts its tool; None for other arms.

    Args:
        robot: the arm.
        task: what it is asked for.

    Returns:
        The task `scara` at the same point and on the same length scale, where the arm has four variables, none of which
        turns the tool about X or Y of the base anywhere, and pose and `scara` have rank 4 almost everywhere.
    """
    if robot.n != _LEVEL_ROWS or task.m != _ROWS + 1:
        return None
    tilts = jacobian(robot, sample(robot, task, _SAMPLES, 0))[..., 3:5, :]
    if np.abs(tilts).max() > _TILT:
        return None
    level = replace(resolve_task(LEVEL, robot, frame=task.frame), length_scale=task.length_scale)
    if generic_rank(robot, task) == _LEVEL_ROWS == generic_rank(robot, level):
        return level
    return None


def position_task(robot: Robot, task: Task) -> Task | None:
    """Position in place of a pose, for an arm of two or three joints that place its tool; None for other arms.

    Args:
        robot: the arm.
        task: what it is asked for.

    Returns:
        The task `position` at the same point and on the same length scale, where the arm has two or three variables,
        and pose and position have that rank almost everywhere.
    """
    if robot.n not in (_PLACE_ROWS - 1, _PLACE_ROWS) or task.m != _ROWS + 1:
        return None
    moved = jacobian(robot, sample(robot, task, _SAMPLES, 0))[..., :3, :]  # the tip, in m or m/rad
    if np.abs(moved).max() <= _TILT * max(1.0, reach(robot)):
        return None
    found = replace(resolve_task(PLACED, robot, frame=task.frame), length_scale=task.length_scale)
    if generic_rank(robot, task) == robot.n == generic_rank(robot, found):
        return found
    return None


def fitting_task(robot: Robot, task: Task) -> Task | None:
    """The task that an arm with too few joints for a pose can do in full; None where there is none, or no need."""
    return pointing_task(robot, task) or level_task(robot, task) or position_task(robot, task)


def asked_task(robot: Robot, task: Task) -> Task:
    """The task asked in place of a pose of an arm with two to five joints, else the task itself."""
    return fitting_task(robot, task) or task


def followed_task(robot: Robot, task: Task | str | None) -> Task:
    """The task in which poses of a file are followed: an arm that never tilts its tool follows position and yaw."""
    resolved = resolve_task(task, robot)
    if task is not None:
        return resolved
    return level_task(robot, resolved) or resolved


def own_tilt(robot: Robot) -> Array:
    """(3,) Z of the base in the axes of a tool that no joint tilts: the third row of its rotation, in every pose."""
    return pose(robot, np.zeros(robot.n))[2, :3]


def tilts_off(robot: Robot, goals: Array) -> Array:
    """Angles (N,) between the tilt of poses (N, 4, 4) and that of a tool which no joint tilts [rad].

    A turn about Z of the base keeps the third row of a rotation: it is the same in every pose of such an arm.
    """
    own = own_tilt(robot)
    rows = goals[:, 2, :3]
    across = np.linalg.norm(np.cross(rows, own), axis=1)
    return np.asarray(np.arctan2(across, rows @ own))


def tilt_is_fixed(robot: Robot, task: Task) -> bool:
    """Whether a task is position and yaw of an arm of four joints that never tilts its tool."""
    pose = Task("pose", (0, 1, 2, 3, 4, 5), length_scale=task.length_scale)
    other = level_task(robot, pose)
    return other is not None and task.rows == other.rows


def tool_stays_level(robot: Robot, task: Task) -> bool:
    """Whether position and yaw stand for the pose of an arm of four joints that never tilts its tool."""
    return robot.task != task.name and tilt_is_fixed(robot, task)


def place_alone(robot: Robot, task: Task) -> bool:
    """Whether position stands for the pose of an arm of two or three joints that place its tool."""
    pose = Task("pose", (0, 1, 2, 3, 4, 5), length_scale=task.length_scale)
    other = position_task(robot, pose)
    return other is not None and robot.task != task.name and task.rows == other.rows


def turn_follows(robot: Robot, task: Task) -> bool:
    """Whether a task is position and tool axis of an arm of five joints, which fix the turn about that axis."""
    pose = Task("pose", (0, 1, 2, 3, 4, 5), length_scale=task.length_scale)
    other = pointing_task(robot, pose)
    return other is not None and (task.rows, task.frame.axes) == (other.rows, other.frame.axes)
