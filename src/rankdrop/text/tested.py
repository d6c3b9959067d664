"""What the search of an analysis says of the rank, in words."""

from __future__ import annotations

from collections.abc import Sequence

from rankdrop.robot.quantities import count
from rankdrop.task import Task


def rank_note(task: Task, joints: int, rank: int, served: Sequence[str]) -> str:
    """An arm that does not reach all rows of a task: its rank, and the tasks that it can do in full.

    Args:
        task: the rows.
        joints: how many the arm has.
        rank: at almost every configuration, below the number of rows.
        served: names of the tasks that it can do in full.
    """
    most = min(task.m, joints)
    if rank < most:
        note = (
            f"always singular for the task {task.name}: the rank is {rank} at every configuration, {most} would be full"
        )
    else:
        arm = count(joints, "joint")
        note = f"the task {task.name} has {task.m} rows and the arm {arm}: the rank is {rank} at most"
    note += f"; corank is counted from rank {rank}"
    if served:
        note += f"; tasks it can do in full: {', '.join(served)}"
    return note
