"""The task: which of the six rows of the Jacobian matter, in which frame, at which point, on which length scale.

A frame says whose axes a twist is written in, and at which point its linear part is taken.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rankdrop.errors import TaskError
from rankdrop.named_tasks import BASE, BODY, ROWS, SPACE, TIP, WORLD_ALIGNED, Frame, task_names
from rankdrop.named_tasks import NAMED as _NAMED
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.model import Array, Robot

__all__ = ["BASE", "BODY", "FRAMES", "ROWS", "SPACE", "TIP", "WORLD_ALIGNED", "Frame", "Task", "frame_of", "link_index",
           "resolve_task", "six_rows", "task_names"]  # fmt: skip
FRAMES = {"base": WORLD_ALIGNED, "tip": BODY, "space": SPACE}
"""Frames by name, by their axes: a reference point at the tip, but for "space"."""

WIDEST = 100.0  # a length scale is at most so many times longer or shorter than the reach: σ keeps its meaning


def frame_of(frame: Frame | str) -> Frame:
    """A frame, or the one of that name.

    Raises:
        TaskError: neither a frame nor the name of one.
    """
    if isinstance(frame, Frame):
        return frame
    if isinstance(frame, str) and frame in FRAMES:
        return FRAMES[frame]
    if isinstance(frame, str):
        got = frame
    else:
        got = f"a {type(frame).__name__}"
    raise TaskError("there is no such frame", where="frame", got=got, allowed=f"{', '.join(FRAMES)}, or a Frame")


def link_index(link: int, joints: int, what: str) -> int:
    """Link number in 0 … joints + 1 (the last is the tip), from a number or TIP.

    Raises:
        TaskError: there is no such link.
    """
    if link == TIP:
        return joints + 1
    if 0 <= link <= joints:
        return link
    raise TaskError(f"there is no such link for the {what} of a frame", got=link, allowed=f"0 … {joints}, or TIP")


@dataclass(frozen=True, slots=True)
class Task:
    """What the end effector has to do, as rows of the twist (vx, vy, vz, wx, wy, wz).

    Attributes:
        name: `pose`, `position`, `orientation`, `planar` (vx, vy, wz), `planar-position` (vx, vy), `scara`
            (vx, vy, vz, wz); in tool axes `tool-axis-free` (all but the turning about the tool's z axis: welding,
            milling, gluing) and `across-tool-axis` (vx, vy: a beam whose distance does not matter); or the rows joined
            by commas.
        rows: indices of the rows, increasing.
        frame: axes and reference point in which the rows are taken.
        length_scale: translation rows are divided by it [m]; None means the arm's reach.
    """

    name: str
    rows: tuple[int, ...]
    frame: Frame = WORLD_ALIGNED
    length_scale: float | None = None

    @property
    def m(self) -> int:
        """Number of rows."""
        return len(self.rows)

    def scale(self, robot: Robot) -> float:
        """The length scale in use for `robot` [m]."""
        if self.length_scale is None:
            return reach(robot)
        return self.length_scale


def six_rows(values: Array, task: Task) -> Array:
    """Vectors (..., m) of a task's rows written in all six, (..., 6): zero in the rows that the task leaves free."""
    full = np.zeros((*values.shape[:-1], 6))
    full[..., list(task.rows)] = values
    return full


def resolve_task(
    task: str | Sequence[str] | Task | None,
    robot: Robot,
    *,
    frame: Frame | None = None,
    length_scale: float | None = None,
) -> Task:
    """Make a `Task` from a name, a list of rows, a Task, or None (the task the arm is made for).

    Args:
        task: "position", "vx,vy,wz", ["vx", "vy"], a Task, or None.
        robot: the arm; gives the default.
        frame: overrides the frame.
        length_scale: overrides the length scale [m]; 1.0 reproduces papers that mix metres and radians.

    Raises:
        TaskError: unknown name or row, empty or repeated rows, a length scale beyond 100 times the reach either way.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> resolve_task("wz,vx", open_robot("pa10")).rows
        (0, 5)
    """
    if length_scale is not None and not reach(robot) / WIDEST <= length_scale <= reach(robot) * WIDEST:
        low, high = reach(robot) / WIDEST, reach(robot) * WIDEST
        raise TaskError(
            "a length scale so far from the arm's reach would hide rotations or translations", got=f"{length_scale} m",
            allowed=f"{low:.4g} … {high:.4g} m",
        )
    if isinstance(task, Task):
        resolved = task
    else:
        resolved = _from_rows(robot.task if task is None else task)
    if frame is not None:
        resolved = replace(resolved, frame=frame)
    if length_scale is not None:
        resolved = replace(resolved, length_scale=length_scale)
    return resolved


def _no_task(task: object) -> TaskError:
    """The error for a value that is neither the name of a task nor rows."""
    return TaskError(
        "there is no such task", got=repr(task), allowed=", ".join(_NAMED) + ", or rows out of " + ",".join(ROWS)
    )


def _from_rows(task: str | Sequence[str]) -> Task:
    if isinstance(task, str) and task in _NAMED:
        return Task(task, *_NAMED[task])
    if isinstance(task, str):
        parts = task.split(",")
    elif isinstance(task, Sequence) and all(isinstance(part, str) for part in task):
        parts = list(task)
    else:
        raise _no_task(task)
    words = [part.strip() for part in parts]
    unknown = [word for word in words if word not in ROWS]
    if not unknown and len(set(words)) != len(words):
        raise TaskError("a row is named twice", where="task", got=repr(task), allowed="each row once")
    if unknown or not words:
        raise _no_task(task)
    rows = tuple(sorted(ROWS.index(word) for word in words))
    for name, named in _NAMED.items():
        if (rows, WORLD_ALIGNED) == named:
            return Task(name, rows)
    return Task(",".join(ROWS[row] for row in rows), rows)
