"""The block U₂ᵀ J V₂ and its derivative D by np.linalg.svd."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from reference import kinematics


class Block(NamedTuple):
    """F = U₂ᵀ J V₂ and D = U₂ᵀ ∂J V₂, with p = m − rank and r = n − rank."""

    f: Array  # (..., p, r)
    d: Array  # (..., p, r, n)
    u2: Array  # (..., m, p)
    v2: Array  # (..., n, r)
    sigma: Array  # (..., min(m, n))


def singular_values(robot: Robot, q: ArrayLike, task: Task) -> Array:
    """(..., min(m, n)) singular values of the task Jacobian, descending."""
    return np.linalg.svd(kinematics.task_jacobian(robot, q, task), compute_uv=False)


def generic_rank(robot: Robot, task: Task, *, samples: int = 32, seed: int = 0) -> int:
    """Largest rank over random configurations."""
    q = np.random.default_rng(seed).uniform(-np.pi, np.pi, (samples, robot.n))
    return int((singular_values(robot, q, task) > 1e-9).sum(axis=-1).max())


def block(robot: Robot, q: ArrayLike, task: Task, rank: int) -> Block:
    """The block that vanishes exactly where the rank is at most `rank`, and its derivative."""
    jacobian = kinematics.task_jacobian(robot, q, task)
    derivative = kinematics.task_jacobian_derivative(robot, q, task)
    u, sigma, vt = np.linalg.svd(jacobian, full_matrices=True)
    u2, v2 = u[..., rank:], np.swapaxes(vt, -1, -2)[..., rank:]
    f = np.swapaxes(u2, -1, -2) @ jacobian @ v2
    return Block(f, contract(u2, derivative, v2), u2, v2, sigma)


def contract(u2: Array, derivative: Array, v2: Array) -> Array:
    """(..., p, r, n) with [..., k] = U₂ᵀ (∂J/∂q_k) V₂."""
    per_joint = np.moveaxis(derivative, -1, -3)  # (..., n, m, n)
    d = np.swapaxes(u2, -1, -2)[..., None, :, :] @ per_joint @ v2[..., None, :, :]
    return np.moveaxis(d, -3, -1)
