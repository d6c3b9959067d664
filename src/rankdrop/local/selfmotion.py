"""Self-motions: curves through q on which the end effector stands still, traced and measured.

A step along the tangent, then Gauss–Newton on the task's own error until the end effector is back where it was,

    q ← q − Jᵀ(JJᵀ + λ1)⁻¹ e(q),   e = (p − p₀ ; rotation vector of R R₀ᵀ), rows of the task only,

with λ far below σ² of any step that matters. Whether the result is a self-motion is told by e and by how far it went.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rankdrop.frames import BASE, TIP, WORLD_ALIGNED
from rankdrop.kinematics import pose, task_jacobian
from rankdrop.local.block import singular_values
from rankdrop.local.place import Place
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task

STILL = 1e-10
"""Task error (translations over the length scale) up to which the end effector counts as standing still."""
_STEPS = 4
_CORRECTIONS = 5
_DAMPING = 1e-14  # σ of 1e-6 is still followed


@dataclass(frozen=True, slots=True)
class Trace:
    """Self-motions from q, one per tangent.

    Attributes:
        q: (c, steps + 1, n) configurations, the first is q itself [rad, m].
        sigma: (c, steps + 1) σ_r there, r the generic rank.
        ranks: (c,) rank at the last one.
        error: (c,) largest task error on the way.
        length: (c,) how far the last one is from q, in scaled coordinates.
        valid: (c,) the end effector stood still and the arm did move.
    """

    q: Array
    sigma: Array
    ranks: NDArray[np.intp]
    error: Array
    length: Array
    valid: NDArray[np.bool_]


def followed(task: Task) -> Task | None:
    """The task in a frame where its error is known in closed form, or None.

    All six rows, or the three of the orientation, mean the same in every frame; three translations in every axes at a
    point of the tip. Other rows are followed in base or tip axes; single translations in base axes only, since axes
    that turn make of them a condition on velocities.
    """
    whole = task.rows in ((0, 1, 2, 3, 4, 5), (3, 4, 5))
    if whole:
        return replace(task, frame=WORLD_ALIGNED)
    if task.frame.origin != TIP:
        return None
    if task.rows == (0, 1, 2):
        return replace(task, frame=replace(task.frame, axes=BASE))
    sliding = tuple(row for row in task.rows if row < 3)
    fits = task.frame.axes == BASE or (task.frame.axes == TIP and sliding in ((), (0, 1, 2)))
    return task if fits else None


def trace(place: Place, task: Task, tangents: Array, length: float) -> Trace:
    """Follow self-motions with the given tangents.

    Args:
        place: where they start; its own task says what σ is.
        task: what stands still, from `followed`.
        tangents: (c, n) unit vectors in scaled coordinates, in the null space of J.
        length: how far to go, in scaled coordinates.

    Returns:
        What came of each; `valid` is False where the corrector did not bring the end effector back.
    """
    ahead = tangents * (length / _STEPS)
    rows = np.broadcast_to(place.q, tangents.shape)
    path, errors = [rows], [np.zeros(len(tangents))]
    home = pose(place.robot, place.q)
    for _ in range(_STEPS):
        start, aim = path[-1], path[-1] + ahead * place.scale
        reached, error = _corrected(place, task, home, aim)
        path.append(reached)
        errors.append(error)
        ahead = _resized((reached - start) / place.scale, length / _STEPS)
    q = np.stack(path, axis=1)
    sigma = singular_values(place.robot, q, place.task)[..., : place.generic]
    gone = np.linalg.norm((q[:, -1] - place.q) / place.scale, axis=1)
    worst = np.max(errors, axis=0)
    return Trace(
        q=q,
        sigma=sigma[..., -1],
        ranks=(sigma[:, -1] > place.floor).sum(axis=-1),
        error=worst,
        length=gone,
        valid=(worst <= STILL) & (gone >= 0.6 * length),
    )


def _corrected(place: Place, task: Task, home: Array, aim: Array) -> tuple[Array, Array]:
    """Configurations near `aim` (c, n) with the end effector at home, and the task error left."""
    q = aim
    for _ in range(_CORRECTIONS):
        error = task_error(place.robot, task, home, q)
        jac = task_jacobian(place.robot, q, task) * place.scale
        square = jac @ np.swapaxes(jac, -1, -2) + _DAMPING * np.eye(jac.shape[-2])
        step = np.swapaxes(jac, -1, -2) @ np.linalg.solve(square, error[..., None])
        shrink = np.minimum(1.0, 0.05 / np.maximum(np.linalg.norm(step[..., 0], axis=-1), 1e-300))
        q = q - shrink[:, None] * step[..., 0] * place.scale
    return q, np.linalg.norm(task_error(place.robot, task, home, q), axis=-1)


def task_error(robot: Robot, task: Task, home: Array, q: Array) -> Array:
    """(c, m) how far the task is from where it was, translations over the length scale, in the task's axes.

    Args:
        robot: the arm.
        task: from `followed`.
        home: (4, 4) pose of the tip to keep.
        q: (c, n) configurations.
    """
    now, frame = pose(robot, q), task.frame
    point = np.array(frame.point) if frame.origin == TIP else np.zeros(3)
    shift = now[..., :3, :3] @ point + now[..., :3, 3] - home[:3, :3] @ point - home[:3, 3]
    turned = frame.axes == TIP
    rotation = home[:3, :3].T @ now[..., :3, :3] if turned else now[..., :3, :3] @ home[:3, :3].T
    if turned:
        shift = np.einsum("cji,cj->ci", now[..., :3, :3], shift)
    error = np.concatenate([shift / task.scale(robot), _rotation_vector(rotation)], axis=-1)
    return np.asarray(error[:, list(task.rows)])


def _rotation_vector(rotation: Array) -> Array:
    """(c, 3) axis times angle of rotations up to half a turn, well away from it."""
    skew = (rotation - np.swapaxes(rotation, -1, -2)) / 2
    vector = np.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], axis=-1)  # sin(angle) · axis
    sine = np.linalg.norm(vector, axis=-1)
    angle = np.arctan2(sine, (np.trace(rotation, axis1=-2, axis2=-1) - 1) / 2)
    return np.asarray(vector * np.where(sine > 1e-8, angle / np.maximum(sine, 1e-300), 1.0)[..., None])


def _resized(vectors: Array, length: float) -> Array:
    return np.asarray(length * vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300))
