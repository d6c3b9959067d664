"""Onto the singular set along chosen directions: Gauss–Newton on the block F with D as its derivative."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rankdrop.family.system import shortest
from rankdrop.local.block import block, joint_scale, singular_values
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances

ITERATIONS = 30
STEP = 0.3  # longest step [rad; slides in length scales]


def onto(
    robot: Robot,
    task: Task,
    starts: Array,
    rank: int,
    along: Array,
    *,
    iterations: int = ITERATIONS,
    tolerances: Tolerances = DEFAULT,
) -> tuple[Array, NDArray[np.bool_]]:
    """Move configurations within q + span(along) until the rank is at most `rank`.

    Each step is the shortest least-squares solution of D(Δ) = −F with Δ in the span, measured in scaled joint
    coordinates. A start near which the span does not meet the set does not arrive, and says so.

    Args:
        robot: the arm.
        task: from `resolve_task`.
        starts: (N, n) configurations [rad, m].
        rank: the rank that is kept, generic rank − k for corank k.
        along: (n, d) orthonormal directions in scaled joint coordinates (`joint_scale`).
        iterations: at most.
        tolerances: `singular` decides what has arrived, `target` where a start stops.

    Returns:
        (N, n) end points and (N,) whether σ beyond the rank is zero there.

    Raises:
        ConfigurationError: starts have the wrong shape.
        OptionError: there is no block beyond that rank.
    """
    scale = joint_scale(robot, task)
    q = np.array(starts, dtype=np.float64)
    active = np.arange(len(q))
    for _ in range(iterations):
        here = block(robot, q[active], task, rank)
        going = here.sigma[:, rank] > tolerances.target
        active = active[going]
        if not len(active):
            break
        f = here.f[going].reshape(len(active), -1)
        d = here.d[going].reshape(len(active), f.shape[1], robot.n)
        delta = -shortest((d * scale) @ along, f) @ along.T
        length = np.linalg.norm(delta, axis=1, keepdims=True)
        q[active] += scale * delta * np.minimum(1.0, STEP / np.maximum(length, 1e-300))
        active = active[length[:, 0] > 1e-15]
    return q, np.asarray(singular_values(robot, q, task)[:, rank] <= tolerances.singular)
