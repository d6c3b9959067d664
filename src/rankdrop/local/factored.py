"""One decomposition behind every inverse: J = S⁻¹ U Σ Vᵀ W⁻¹, with the rank decided on σ.

S divides translation rows by the length scale ℓ, W multiplies prismatic joints by it (`joint_scale`), so that Ĵ = S J W
has no unit, and neither have its singular values. Twists are then measured as ‖(v/ℓ; ω)‖, joint rates as ‖W⁻¹q̇‖.
A length scale of 1 m measures both in plain metres and radians.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rankdrop import _core
from rankdrop.kinematics import task_jacobian
from rankdrop.local.block import decompose, joint_scale, row_scale, singular_values
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances


@dataclass(frozen=True, slots=True)
class Factored:
    """S J W = U Σ Vᵀ at a batch of configurations.

    Attributes:
        u: (..., m, m) left singular vectors as columns.
        sigma: (..., min(m, n)) singular values, descending; those beyond the rank are exactly zero [1].
        v: (..., n, n) right singular vectors as columns.
        rank: (...) number of singular values of the task Jacobian above the tolerance.
        rows: (m,) diagonal of S [1/m or 1].
        joints: (n,) diagonal of W [1 or m].
    """

    u: Array
    sigma: Array
    v: Array
    rank: Array
    rows: Array
    joints: Array

    def inverse(self, gains: Array) -> Array:
        """(..., n, m) the matrix W V diag(gains) Uᵀ S, from SI twists to rates in rad/s and m/s."""
        count = self.sigma.shape[-1]
        v, u = self.v[..., :count], self.u[..., :count]
        return np.asarray((self.joints[:, None] * v * gains[..., None, :]) @ (u * self.rows[:, None]).swapaxes(-1, -2))

    @property
    def reciprocal(self) -> Array:
        """(..., min(m, n)) 1/σ, zero beyond the rank: the gains of the pseudo-inverse."""
        safe = np.where(self.sigma > 0.0, self.sigma, 1.0)
        return np.where(self.sigma > 0.0, 1.0 / safe, 0.0)


def factor(robot: Robot, q: ArrayLike, task: Task, tolerances: Tolerances = DEFAULT) -> Factored:
    """Decompose the task Jacobian with the length scale on both sides.

    The rank is that of `rank_at`: singular values of the task Jacobian (W = 1) at or below `tolerances.singular` are
    zero. With prismatic joints Σ belongs to S J W, and as many of its last values are zero.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].
        task: from `resolve_task`.
        tolerances: `singular` decides.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
    """
    joints = joint_scale(robot, task)
    parts = decompose(robot, q, task)
    u, sigma, v = parts.u, parts.sigma, parts.v
    rank = (sigma > tolerances.singular).sum(axis=-1)
    if (joints != 1.0).any():
        scaled = np.ascontiguousarray(task_jacobian(robot, q, task) * joints)
        batch = scaled.shape[:-2]
        found = _core.svd(scaled.reshape(-1, task.m, robot.n))
        u, sigma, v = (part.reshape(batch + part.shape[1:]) for part in found)
    sigma = np.where(np.arange(sigma.shape[-1]) < rank[..., None], sigma, 0.0)
    return Factored(u, sigma, v, rank, row_scale(robot, task), joints)


def task_sigma(robot: Robot, q: ArrayLike, task: Task) -> Array:
    """(..., min(m, n)) singular values of S J W; those of the task Jacobian where no joint is prismatic."""
    joints = joint_scale(robot, task)
    if (joints == 1.0).all():
        return singular_values(robot, q, task)
    scaled = np.ascontiguousarray(task_jacobian(robot, q, task) * joints)
    sigma = _core.svd(scaled.reshape(-1, task.m, robot.n), False)
    return sigma.reshape(*scaled.shape[:-2], sigma.shape[-1])
