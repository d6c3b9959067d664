"""The singular set in a slice of joint space: some joints vary, the others stand where they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.errors import OptionError
from rankdrop.families.onto import onto
from rankdrop.local.block import generic_rank, sampling_box, singular_values
from rankdrop.local.verdict import one_configuration
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances

MOST_STARTS = 200_000


@dataclass(frozen=True, eq=False)
class SlicePoints:
    """Singular configurations in a slice.

    Attributes:
        joints: numbers (from 1) of the joints that vary.
        q: (N, n) configurations [rad, m]; turning joints in (−π, π] unless limits were asked for.
        corank: (N,) at each of them.
        starts: how many starts there were; those that did not arrive are not in q.
    """

    joints: tuple[int, ...]
    q: Array
    corank: NDArray[np.int64]
    starts: int


def in_slice(
    robot: Robot,
    task: Task,
    q: ArrayLike,
    joints: Sequence[int],
    *,
    starts: int = 2000,
    limits: bool = False,
    seed: int = 0,
    tolerances: Tolerances = DEFAULT,
) -> SlicePoints:
    """Points of the singular set in the slice through q along some joints.

    Uniform starts in the slice are driven onto corank 1 by Gauss–Newton on the block, moving the chosen joints only
    (`onto`). A slice of two joints shows curves where the set has codimension 1 and points where it has 2; where q
    itself is singular whatever the chosen joints do, the whole slice is. Nothing found is not a proof of absence.

    Args:
        robot: the arm.
        task: from `resolve_task`.
        q: (n,) the other joints stand here [rad, m].
        joints: numbers from 1 of the joints that vary.
        starts: how many.
        limits: only points within the joint limits.
        seed: of the starts.
        tolerances: `singular` decides.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
        OptionError: joints that do not exist or are named twice, or a number of starts outside what is allowed.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("scara")
        >>> found = in_slice(arm, resolve_task(None, arm), [0.0] * 4, (1, 2), starts=50)
        >>> bool(abs(np.sin(found.q[:, 1])).max() < 1e-9)  # sin θ2 = 0
        True
    """
    centre = one_configuration(robot, q)
    chosen = [joint - 1 for joint in joints]
    if not chosen or len(set(chosen)) != len(chosen) or not all(0 <= j < robot.n for j in chosen):
        raise OptionError("these joints span no slice", got=list(joints), allowed=f"different numbers, 1 … {robot.n}")
    if not 1 <= starts <= MOST_STARTS:
        raise OptionError("starts is outside the range", got=starts, allowed=f"1 … {MOST_STARTS}")
    low, high = sampling_box(robot, task, limits=limits)
    rows = np.repeat(centre[None], starts, axis=0)
    rows[:, chosen] = np.random.default_rng(seed).uniform(low[chosen], high[chosen], (starts, len(chosen)))
    full = generic_rank(robot, task)
    if full == 0:
        return SlicePoints(tuple(joints), rows[:0], np.zeros(0, dtype=np.int64), starts)
    ends, arrived = onto(robot, task, rows, full - 1, np.eye(robot.n)[:, chosen], tolerances=tolerances)
    ends = ends[arrived]
    if not limits:
        turning = robot.periodic & np.isin(np.arange(robot.n), chosen)
        ends = np.where(turning, np.pi - np.mod(np.pi - ends, 2 * np.pi), ends)
    slack = tolerances.value
    inside = ((ends[:, chosen] >= low[chosen] - slack) & (ends[:, chosen] <= high[chosen] + slack)).all(axis=1)
    ends = ends[inside]
    rank = np.minimum((singular_values(robot, ends, task) > tolerances.singular).sum(axis=1), full)
    return SlicePoints(tuple(joints), ends, np.asarray(full - rank, dtype=np.int64), starts)
