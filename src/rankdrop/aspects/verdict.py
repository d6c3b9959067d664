"""The number of aspects of any arm with the verdict on changes of posture, within a budget.

Proofs without a search are tried first; where they decide nothing, the inverse is solved at `POSES` random poses.
"""

from __future__ import annotations

from rankdrop.aspects.arm import count_of_arm, summary_of
from rankdrop.aspects.posture_paths import aspects_of
from rankdrop.errors import RankdropError
from rankdrop.poses.postures import decide_exactly
from rankdrop.results.aspect_summary import NOT_ASKED, NOT_CUSPIDAL, POSES, AspectSummary
from rankdrop.robot.model import Robot
from rankdrop.task import Task

STARTS = 300
"""Of Newton's method for each pose."""


def judged_summary(robot: Robot, task: Task) -> AspectSummary:
    """How many aspects an arm has, and whether it can change its posture without a singularity; limits ignored.

    Args:
        robot: any arm.
        task: from `resolve_task`.

    Returns:
        `posture_change` is None where the arm is singular everywhere.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("planar2r")
        >>> judged_summary(arm, resolve_task(None, arm)).posture_change
        'not cuspidal'
    """
    count, _ = count_of_arm(robot, task)
    return summary_of(count, _verdict(robot, task))


def _verdict(robot: Robot, task: Task) -> str | None:
    if robot.n != task.m:
        return NOT_ASKED
    decision, _, _ = decide_exactly(robot, task)
    if decision.impossible:
        return NOT_CUSPIDAL
    try:
        return aspects_of(robot, task, poses=1, most=POSES, starts=STARTS).verdict
    except RankdropError:  # singular everywhere: no pose has regular solutions
        return None
