"""Product of exponentials, Jacobian and bracket in plain NumPy, batched over leading axes of q.

Twists are (v; ω), linear part first. N counts the moving joints (mimic joints included), n the variables.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.robot.model import Array, Robot
from rankdrop.task import WORLD_ALIGNED, Frame, Task, link_index


def cross(a: Array, b: Array) -> Array:
    """a × b along the last axis (np.cross does the same, several times slower on small batches)."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def bracket(a: Array, b: Array) -> Array:
    """Lie product of two screws: [A, B] = (ω_A × v_B + v_A × ω_B ; ω_A × ω_B)."""
    linear = cross(a[..., 3:], b[..., :3]) + cross(a[..., :3], b[..., 3:])
    return np.concatenate([linear, cross(a[..., 3:], b[..., 3:])], axis=-1)


def exponential(screw: Array, x: ArrayLike) -> Array:
    """exp([S] x) for a screw with |ω| = 1, or ω = 0: R by Rodrigues, p = (1 − R)(ω × v) + ω (ω·v) x, or p = v x."""
    x = np.asarray(x, dtype=float)
    v, omega = screw[:3], screw[3:]
    pose = np.broadcast_to(np.eye(4), (*x.shape, 4, 4)).copy()
    if not omega.any():
        pose[..., :3, 3] = v * x[..., None]
        return pose
    hat = np.cross(np.eye(3), omega)  # hat @ a == ω × a
    sine, versine = np.sin(x)[..., None, None], (1.0 - np.cos(x))[..., None, None]
    turn = sine * hat + versine * (hat @ hat)
    pose[..., :3, :3] += turn
    pose[..., :3, 3] = -turn @ np.cross(omega, v) + omega * (omega @ v) * x[..., None]
    return pose


def coupling(robot: Robot) -> tuple[Array, Array]:
    """Joint values from variables: x = C q + c. A mimic joint is one more entry in its leader's column.

    Returns:
        C (N, n) and c (N,).
    """
    column = {joint.name: a for a, joint in enumerate(robot.variables)}
    matrix, offset = np.zeros((len(robot.joints), robot.n)), np.zeros(len(robot.joints))
    for i, joint in enumerate(robot.joints):
        if joint.mimic is None:
            matrix[i, column[joint.name]] = 1.0
        else:
            matrix[i, column[joint.mimic.leader]] = joint.mimic.multiplier
            offset[i] = joint.mimic.offset
    return matrix, offset


def carried(robot: Robot, q: ArrayLike) -> Array:
    """(..., N + 1, 4, 4) motions E_i = exp(S_1 x_1) … exp(S_i x_i) of everything fixed after joint i; E_0 = 1."""
    matrix, offset = coupling(robot)
    x = np.asarray(q, dtype=float) @ matrix.T + offset
    motions = [np.broadcast_to(np.eye(4), (*x.shape[:-1], 4, 4))]
    for i, joint in enumerate(robot.joints):
        motions.append(motions[-1] @ exponential(joint.screw, x[..., i]))
    return np.stack(motions, axis=-3)


def pose(robot: Robot, q: ArrayLike) -> Array:
    """(..., 4, 4) pose of the tip."""
    return carried(robot, q)[..., -1, :, :] @ robot.home


def screws(robot: Robot, motions: Array) -> Array:
    """(..., N, 6) joint screws at q in the base frame: those of q = 0 carried by everything before each joint."""
    home = np.stack([joint.screw for joint in robot.joints])
    turn, shift = motions[..., :-1, :3, :3], motions[..., :-1, :3, 3]
    omega = (turn @ home[:, 3:, None])[..., 0]
    v = (turn @ home[:, :3, None])[..., 0] + cross(shift, omega)
    return np.concatenate([v, omega], axis=-1)


def screw_derivative(s: Array) -> Array:
    """(..., N, N, 6) with [..., i, k, :] = ∂S_i/∂x_k = [S_k, S_i] for k < i, else 0."""
    before = np.tril(np.ones((s.shape[-2], s.shape[-2])), -1)  # [i, k] = 1 for k < i
    return before[..., None] * bracket(s[..., None, :, :], s[..., :, None, :])


def link_pose(robot: Robot, motions: Array, link: int) -> tuple[Array, int]:
    """Pose of a link's frame at q, and how many joints move it."""
    index, joints = link_index(link, len(robot.joints), "frame"), len(robot.joints)
    if index == joints + 1:
        return motions[..., joints, :, :] @ robot.home, joints
    at_home = np.eye(4) if index == 0 else robot.joints[index - 1].frame
    return motions[..., index, :, :] @ at_home, index


def jacobian(robot: Robot, q: ArrayLike, frame: Frame = WORLD_ALIGNED) -> Array:
    """(..., 6, n) geometric Jacobian: columns (Rᵀ(v + ω × p); Rᵀω), R the axes' link, p the reference point."""
    motions = carried(robot, q)
    s = screws(robot, motions)
    axes = link_pose(robot, motions, frame.axes)[0][..., None, :3, :3]
    origin = link_pose(robot, motions, frame.origin)[0]
    point = (origin[..., :3, :3] @ np.array(frame.point) + origin[..., :3, 3])[..., None, :]
    v, omega = s[..., :3] + cross(s[..., 3:], point), s[..., 3:]
    columns = np.concatenate([_in_axes(axes, v), _in_axes(axes, omega)], axis=-1)
    return np.swapaxes(columns, -1, -2) @ coupling(robot)[0]


def jacobian_derivative(robot: Robot, q: ArrayLike, frame: Frame = WORLD_ALIGNED) -> Array:
    """(..., 6, n, n) with [..., :, i, k] = ∂J[:, i]/∂q_k, by the bracket and the product rule.

    With w = v + ω × p: ∂_k w_i = ∂_k v_i + ∂_k ω_i × p + ω_i × ∂_k p, ∂_k p = v_k + ω_k × p where joint k moves the
    point; and ∂_k(Rᵀa) = Rᵀ(∂_k a − ω_k × a) where joint k moves the axes.
    """
    motions = carried(robot, q)
    s = screws(robot, motions)
    ds = screw_derivative(s)  # (..., i, k, 6)
    axes_pose, moved_axes = link_pose(robot, motions, frame.axes)
    origin, moved_point = link_pose(robot, motions, frame.origin)
    point = (origin[..., :3, :3] @ np.array(frame.point) + origin[..., :3, 3])[..., None, :]
    at_point, omega = s[..., :3] + cross(s[..., 3:], point), s[..., 3:]

    moves_point, moves_axes = (np.arange(s.shape[-2])[:, None] < last for last in (moved_point, moved_axes))
    dv = ds[..., :3] + cross(ds[..., 3:], point[..., None, :])
    dv = dv + cross(omega[..., :, None, :], (moves_point * at_point)[..., None, :, :])
    turning = (moves_axes * omega)[..., None, :, :]  # ω_k, or 0 where joint k does not move the axes
    dv = dv - cross(turning, at_point[..., :, None, :])
    dw = ds[..., 3:] - cross(turning, omega[..., :, None, :])

    axes = axes_pose[..., None, None, :3, :3]
    full = np.concatenate([_in_axes(axes, dv), _in_axes(axes, dw)], axis=-1)  # (..., i, k, 6)
    matrix = coupling(robot)[0]
    return matrix.T @ np.moveaxis(full, -1, -3) @ matrix


def task_jacobian(robot: Robot, q: ArrayLike, task: Task) -> Array:
    """(..., m, n) rows of the task, translation rows divided by the length scale."""
    return _weights(robot, task)[:, None] * jacobian(robot, q, task.frame)[..., list(task.rows), :]


def task_jacobian_derivative(robot: Robot, q: ArrayLike, task: Task) -> Array:
    """(..., m, n, n) derivative of `task_jacobian`."""
    return _weights(robot, task)[:, None, None] * jacobian_derivative(robot, q, task.frame)[..., list(task.rows), :, :]


def _weights(robot: Robot, task: Task) -> Array:
    return np.array([1.0 / task.scale(robot) if row < 3 else 1.0 for row in task.rows])


def _in_axes(axes: Array, vector: Array) -> Array:
    return (np.swapaxes(axes, -1, -2) @ vector[..., None])[..., 0]
