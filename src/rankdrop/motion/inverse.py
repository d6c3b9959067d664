"""Solutions of the inverse of an arm without redundancy, by Newton's method from many starts.

    e(q) = (p* − p(q); log(R* R(q)ᵀ)) in the rows of the task,    (JᵀJ + λ) Δ = Jᵀ e,    λ = |e|²

The damping dies out with the error, so that the last steps are Newton's. A solution that no start leads to is missed:
the list is what was found. What is found is a solution, to rounding.
"""

from __future__ import annotations

import numpy as np

from rankdrop.errors import TaskError
from rankdrop.frames import WORLD_ALIGNED
from rankdrop.kinematics import pose, task_jacobian
from rankdrop.local.block import joint_scale, sample, singular_values
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task

_ITERATIONS = 60
_LONGEST = 0.5  # of a step [rad; slides scaled]: a quarter of the way between neighbouring solutions
_CLOSE = 1e-11  # |e| of a solution: rounding of a pose leaves 1e-15
_SAME = 1e-6  # solutions nearer than this are one [rad]
_REGULAR = 1e-5  # σ_r of a solution that counts: nearer to the singular set pairs of solutions cannot be told apart


def check_square(robot: Robot, task: Task) -> None:
    """Refuse tasks whose inverse is no list of solutions.

    Raises:
        TaskError: the arm has more or fewer joints than the task rows, or the rows are not in the base's axes.
    """
    if robot.n != task.m:
        raise TaskError(
            "postures are solutions of the inverse, which are a list only without redundancy",
            got=f"{task.m} rows, {robot.n} joints", allowed="as many joints as rows",
            mend="choose a task with as many rows as joints" if robot.n <= 6 else "",
        )  # fmt: skip
    check_axes(task)


def check_axes(task: Task) -> None:
    """Refuse rows that are not of the tip in the axes of the base.

    Raises:
        TaskError: they are not.
    """
    if task.frame != WORLD_ALIGNED:
        raise TaskError("poses are those of the tip, in the axes of the base", got=task.frame,
                        allowed="WORLD_ALIGNED")  # fmt: skip


def error(robot: Robot, task: Task, q: Array, target: Array) -> Array:
    """(N, m) what is missing from the pose at q (N, n) to the target (4, 4), or to one each (N, 4, 4), lengths divided
    by the length scale.
    """
    at = pose(robot, q)
    moved = (target[..., :3, 3] - at[:, :3, 3]) / task.scale(robot)
    turned = target[..., :3, :3] @ at[:, :3, :3].transpose(0, 2, 1)
    axis = 0.5 * np.stack([turned[:, 2, 1] - turned[:, 1, 2], turned[:, 0, 2] - turned[:, 2, 0],
                           turned[:, 1, 0] - turned[:, 0, 1]], axis=1)  # fmt: skip
    sine = np.linalg.norm(axis, axis=1)
    angle = np.arctan2(sine, 0.5 * (np.trace(turned, axis1=1, axis2=2) - 1.0))
    safe = np.where(sine > 1e-12, sine, 1.0)
    rotation = axis * np.where(sine > 1e-12, angle / safe, 1.0)[:, None]
    return np.concatenate([moved, rotation], axis=1)[:, list(task.rows)]


def solutions(robot: Robot, task: Task, target: Array, *, starts: int, seed: int, also: Array | None = None) -> Array:
    """Regular solutions of the inverse that Newton's method finds.

    Args:
        robot, task: as many joints as rows, in the unit of length that is wanted.
        target: (4, 4) pose of the tip; rows that the task leaves free are not looked at.
        starts, seed: random starts; the same seed gives the same solutions.
        also: (k, n) further starts.

    Returns:
        (k, n), angles in (−π, π], in lexicographic order of rounded values. Limits are not looked at.
    """
    q = sample(robot, task, starts, seed, limits=False)
    if also is not None:
        q = np.concatenate([np.atleast_2d(also), q])
    scale, identity = joint_scale(robot, task), np.eye(robot.n)
    going = np.arange(len(q))
    found: list[Array] = []
    for _ in range(_ITERATIONS):
        e = error(robot, task, q[going], target)
        size = np.linalg.norm(e, axis=1)
        done = size <= _CLOSE
        found.append(q[going[done]])
        going, e, size = going[~done], e[~done], size[~done]
        if not len(going):
            break
        jacobian = task_jacobian(robot, q[going], task) * scale
        transposed = jacobian.transpose(0, 2, 1)
        damped = transposed @ jacobian + np.minimum(size**2, 1.0)[:, None, None] * identity
        with np.errstate(all="ignore"):
            step = _solved(damped, (transposed @ e[:, :, None])[:, :, 0])
        length = np.linalg.norm(step, axis=1)
        step = step * np.minimum(1.0, _LONGEST / np.maximum(length, 1e-300))[:, None]
        q[going] += step * scale
    return _different(robot, task, np.concatenate(found))


def regular(robot: Robot, task: Task, q: Array) -> bool:
    """Whether a configuration (n,) is far enough from the singular set for its solution to be told from others."""
    return bool(singular_values(robot, q, task)[-1] > _REGULAR)


def determinants(robot: Robot, task: Task, q: Array) -> Array:
    """(N,) det J of the task, without unit."""
    return np.asarray(np.linalg.det(task_jacobian(robot, q, task) * joint_scale(robot, task)))


def wrapped(robot: Robot, q: Array) -> Array:
    """Turning joints in (−π, π]."""
    turned = q - 2 * np.pi * np.ceil((q - np.pi - _SAME) / (2 * np.pi))
    return np.where(robot.periodic, turned, q)


def apart(robot: Robot, one: Array, other: Array) -> Array:
    """other − one, turning joints the short way."""
    gap = other - one
    return np.where(robot.periodic, gap - 2 * np.pi * np.round(gap / (2 * np.pi)), gap)


def _solved(matrices: Array, right: Array) -> Array:
    """Solutions of positive definite systems; where one is too near to singular for that, a tiny bit more damping."""
    n = matrices.shape[-1]
    return np.asarray(np.linalg.solve(matrices + 1e-15 * np.eye(n), right[:, :, None])[:, :, 0])


def _different(robot: Robot, task: Task, q: Array) -> Array:
    kept: list[Array] = []
    if len(q):
        q = wrapped(robot, q[singular_values(robot, q, task)[:, -1] > _REGULAR])
        scale = joint_scale(robot, task)
        for row in q:
            if all(np.abs(apart(robot, row, other) / scale).max() > _SAME for other in kept):
                kept.append(row)
    kept.sort(key=lambda row: [round(float(x), 6) for x in row])
    return np.array(kept).reshape(-1, robot.n)
