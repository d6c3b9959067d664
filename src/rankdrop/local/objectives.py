"""Ready secondary objectives for `null_space_motion`: joint rates to climb along, batched over q."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rankdrop._handles import configurations
from rankdrop.errors import ConfigurationError
from rankdrop.local.block import block, generic_rank, joint_scale
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task


def away_from_limits(robot: Robot, q: ArrayLike) -> Array:
    """Towards the middle of every joint's range: the gradient of −½ Σ ((q_i − middle_i)/(range_i/2))².

    In joint rates, metric taken out: q̇_i = −(q_i − middle_i), weighted with 1 for every joint, so that slides need no
    length scale: each joint returns to its middle at the same relative pace. Joints without both limits rest.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].

    Returns:
        (..., n) [rad/s, m/s], zero where a joint is in its middle or has no limits.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
    """
    rows, batch = configurations(robot, q)
    bounded = np.isfinite(robot.lower) & np.isfinite(robot.upper)
    middle = np.where(bounded, 0.5 * (np.where(bounded, robot.lower, 0.0) + np.where(bounded, robot.upper, 0.0)), 0.0)
    return np.where(bounded, middle - rows, 0.0).reshape(*batch, robot.n)


def away_from_singularity(robot: Robot, q: ArrayLike, task: Task | str | None = None) -> Array:
    """Gradient of the smallest singular value that is not always zero: ∂σ_r/∂q_j = u_rᵀ (∂J/∂q_j) v_r (AM eq. 7).

    r is the generic rank. At a singular configuration σ_r has a kink: σ_r grows along the result and along its
    opposite alike, and the sign is arbitrary; where several σ are equal, so is the choice among them; where all first
    derivatives vanish (PA-10 at its zero pose, say) the result is zero, and second order decides.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].
        task: name, `Task`, or None for the task the arm is made for.

    Returns:
        (..., n) joint rates of steepest ascent in scaled coordinates: gradient times `joint_scale`².

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
        TaskError: there is no such task.
    """
    resolved = resolve_task(task, robot)
    found = block(robot, q, resolved, generic_rank(robot, resolved) - 1)
    left, _, right = np.linalg.svd(found.f)  # u_r and v_r in the bases of the block
    gradient = np.einsum("...a,...abj,...b->...j", left[..., :, 0], found.d, right[..., 0, :])
    return np.asarray(gradient * joint_scale(robot, resolved) ** 2)


def towards(robot: Robot, q: ArrayLike, preferred: ArrayLike) -> Array:
    """Towards a preferred configuration: q̇ = preferred − q, whole turns of periodic joints left out.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].
        preferred: (n,) configuration [rad, m].

    Returns:
        (..., n) [rad/s, m/s].

    Raises:
        ConfigurationError: q or preferred has the wrong shape or is not finite.
    """
    rows, batch = configurations(robot, q)
    goal, extra = configurations(robot, preferred)
    if extra:
        raise ConfigurationError("one preferred configuration is needed", got=np.shape(preferred), allowed=(robot.n,))
    way = goal - rows
    turns = np.where(robot.periodic, 2 * np.pi * np.round(way / (2 * np.pi)), 0.0)
    return np.asarray(way - turns).reshape(*batch, robot.n)
