"""Inverses of the task Jacobian: pseudo-inverse, damped and selectively damped.

One decomposition S J W = U Σ Vᵀ serves every inverse, with the rank decided on σ. S divides translation rows by the
length scale ℓ, W multiplies prismatic joints by it (`joint_scale`), so that neither Ĵ = S J W nor its singular values
have a unit. Twists are measured as ‖(v/ℓ; ω)‖, joint rates as ‖W⁻¹q̇‖. The inverses q̇ = W (Σ g_i v_i u_iᵀ) S ξ differ in
the gains g_i alone:

    pseudo-inverse        g_i = 1/σ_i, and 0 beyond the rank
    damped least squares  g_i = σ_i/(σ_i² + λ²)
    selective             g_i = σ_i/(σ_i² + λ_i²), λ_i = 0 for σ_i ≥ threshold

What depends on ℓ: which σ are small and how strongly a damping acts; at a singular configuration, which attainable
twist is nearest to one that is not; and with prismatic joints, which of many rates is smallest. At full row rank
without prismatic joints the pseudo-inverse is Jᵀ(JJᵀ)⁻¹ whatever ℓ is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.kinematics import task_jacobian
from rankdrop.local.block import decompose, generic_rank, joint_scale, row_scale, sigma_of, svd
from rankdrop.options import check_value, option
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT, Tolerances

_POSITIVE = Annotated[float, option("", gt=0)]
_NOT_NEGATIVE = Annotated[float, option("", ge=0)]


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

    def inverse(self, squared: Array | float = 0.0, kept: NDArray[np.bool_] | bool = True) -> Array:
        """(..., n, m) the matrix W V diag(g) Uᵀ S, from SI twists to rates in rad/s and m/s.

        Args:
            squared: λ² of the gains g = σ/(σ² + λ²), which are zero beyond the rank, even where λ is.
            kept: other directions have the gain zero.
        """
        count, safe = self.sigma.shape[-1], np.where(self.sigma > 0.0, self.sigma, 1.0)
        gains = np.where((self.sigma > 0.0) & kept, 1.0 / (safe + squared / safe), 0.0)
        v, u = self.v[..., :count], self.u[..., :count]
        return np.asarray((self.joints[:, None] * v * gains[..., None, :]) @ (u * self.rows[:, None]).swapaxes(-1, -2))


def factor(robot: Robot, q: ArrayLike, task: Task, tolerances: Tolerances = DEFAULT) -> Factored:
    """Decompose the task Jacobian with the length scale on both sides.

    Singular values of the task Jacobian (W = 1) at or below `tolerances.singular` are zero.
    With prismatic joints Σ belongs to S J W, and as many of its last values are zero.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].
        task: from `resolve_task`.
        tolerances: `singular` decides.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
    """
    parts, joints = decompose(robot, q, task), joint_scale(robot, task)
    rank = (parts.sigma > tolerances.singular).sum(axis=-1)
    u, sigma, v = parts.u, parts.sigma, parts.v
    if (joints != 1.0).any():
        u, sigma, v = svd(task_jacobian(robot, q, task) * joints)
    sigma = np.where(np.arange(sigma.shape[-1]) < rank[..., None], sigma, 0.0)
    return Factored(u, sigma, v, rank, row_scale(robot, task), joints)


def task_sigma(robot: Robot, q: ArrayLike, task: Task) -> Array:
    """(..., min(m, n)) singular values of S J W; those of the task Jacobian where no joint is prismatic."""
    return sigma_of(task_jacobian(robot, q, task) * joint_scale(robot, task))


def pseudo_inverse(
    robot: Robot, q: ArrayLike, task: Task | str | None = None, *, tolerances: Tolerances = DEFAULT
) -> Array:
    """J⁺: of all joint rates that come nearest to a twist, the smallest; right at singular configurations too.

    q̇ = J⁺ξ minimises ‖S(Jq̇ − ξ)‖ and among those ‖W⁻¹q̇‖. Directions with σ ≤ `tolerances.singular` are left out; just
    above it the rates are as large as they truly have to be, up to 1/σ. See `damped_inverse` for bounded ones.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].
        task: name, `Task`, or None for the task the arm is made for.
        tolerances: `singular` decides the rank.

    Returns:
        (..., n, m) from twists of the task's rows [m/s, rad/s] to joint rates [rad/s, m/s].

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
        TaskError: there is no such task.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> pseudo_inverse(open_robot("planar2r"), [0.0, 0.0]).round(4).tolist()  # stretched: no motion along x
        [[0.0, 0.503], [0.0, 0.2071]]
    """
    return factor(robot, q, resolve_task(task, robot), tolerances).inverse()


def damped_inverse(
    robot: Robot,
    q: ArrayLike,
    task: Task | str | None = None,
    *,
    damping: float = 0.05,
    threshold: float | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Array:
    """Damped least squares: q̇ = argmin ‖S(Jq̇ − ξ)‖² + λ²‖W⁻¹q̇‖², gains σ_i/(σ_i² + λ²) ≤ 1/(2λ).

    Every direction pays with a tracking error of the share λ²/(σ_i² + λ²), also those that are far from lost
    (Nakamura and Hanafusa; Wampler). With a `threshold` ε the damping follows the smallest singular value,

        λ² = (1 − (σ_r/ε)²) λ₀² for σ_r < ε, else 0,

    (form of Maciejewski and Klein), so that it vanishes, continuously, away from singularities. r is the generic rank:
    what an arm can never do does not damp the rest for ever.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].
        task: name, `Task`, or None for the task the arm is made for.
        damping: λ, or λ₀ with a threshold, compared with σ (without unit: translation divided by the length scale).
        threshold: ε on σ; None for constant damping.
        tolerances: `singular` decides the rank.

    Returns:
        (..., n, m) from twists [m/s, rad/s] to joint rates [rad/s, m/s].

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
        TaskError: there is no such task.
        OptionError: damping negative, or threshold not positive.
    """
    resolved = resolve_task(task, robot)
    check_value("damping", _NOT_NEGATIVE, damping)
    if threshold is not None:
        check_value("threshold", _POSITIVE, threshold)
    parts = factor(robot, q, resolved, tolerances)
    squared = np.full(parts.rank.shape, damping**2)
    if threshold is not None:
        weakest = parts.sigma[..., generic_rank(robot, resolved) - 1]
        squared *= np.maximum(0.0, 1.0 - (weakest / threshold) ** 2)
    return parts.inverse(squared[..., None])


def selective_inverse(
    robot: Robot,
    q: ArrayLike,
    task: Task | str | None = None,
    *,
    threshold: float = 0.05,
    damping: float | None = None,
    drop: bool = False,
    tolerances: Tolerances = DEFAULT,
) -> Array:
    """Direction-selective inverse: only directions with σ below the threshold are damped or dropped, the rest is exact.

        q̇ = Σ_i σ_i/(σ_i² + λ_i²) v_i (u_iᵀ ξ),  λ_i² = (1 − (σ_i/ε)²) λ₀² for σ_i < ε, else 0

    The tracking error S(Jq̇ − ξ) therefore has no component along any u_i with σ_i ≥ ε: what is not about to be lost is
    followed exactly, at any corank, for any n and m. The gains are continuous in σ; with the default λ₀ none of those
    below the threshold exceeds 2/(√3 ε). With `drop` the gain jumps from 1/ε to 0 at the threshold.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].
        task: name, `Task`, or None for the task the arm is made for.
        threshold: ε on σ (without unit: translation divided by the length scale).
        damping: λ₀ on the same scale; None for ε/2.
        drop: leave the directions below the threshold out instead of damping them.
        tolerances: `singular` decides the rank.

    Returns:
        (..., n, m) from twists [m/s, rad/s] to joint rates [rad/s, m/s].

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
        TaskError: there is no such task.
        OptionError: damping negative, or threshold not positive.
    """
    check_value("threshold", _POSITIVE, threshold)
    if damping is None:
        base = threshold / 2
    else:
        base = damping
    check_value("damping", _NOT_NEGATIVE, base)
    parts = factor(robot, q, resolve_task(task, robot), tolerances)
    if drop:
        return parts.inverse(kept=parts.sigma >= threshold)
    return parts.inverse(base**2 * np.maximum(0.0, 1.0 - (parts.sigma / threshold) ** 2))
