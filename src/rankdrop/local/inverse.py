"""Inverses of the task Jacobian, as functions of (robot, q): exact, damped, and damped only where something is lost.

All of them are q̇ = W (Σ g_i v_i u_iᵀ) S ξ with the decomposition S J W = U Σ Vᵀ of `rankdrop.local.factored`, and
differ in the gains g_i alone:

    pseudo-inverse        g_i = 1/σ_i, and 0 beyond the rank
    damped least squares  g_i = σ_i/(σ_i² + λ²)
    selective             g_i = σ_i/(σ_i² + λ_i²), λ_i = 0 for σ_i ≥ threshold

Twists go in, rates come out, in SI units. S and W carry the length scale ℓ of the task. What depends on ℓ: which σ are
small and how strongly a damping acts; at a singular configuration, which attainable twist counts as nearest to one that
is not; and with prismatic joints, which of many rates counts as smallest. At full row rank without prismatic joints
the pseudo-inverse is Jᵀ(JJᵀ)⁻¹ whatever ℓ is.
"""

from __future__ import annotations

from math import isfinite

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import OptionError
from rankdrop.local.block import generic_rank
from rankdrop.local.factored import Factored, factor
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT, Tolerances


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
    parts = factor(robot, q, resolve_task(task, robot), tolerances)
    return parts.inverse(parts.reciprocal)


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
    _not_negative("damping", damping)
    if threshold is not None:
        _positive("threshold", threshold)
    parts = factor(robot, q, resolved, tolerances)
    squared = np.full(parts.rank.shape, damping**2)
    if threshold is not None:
        weakest = parts.sigma[..., generic_rank(robot, resolved) - 1]
        squared *= np.maximum(0.0, 1.0 - (weakest / threshold) ** 2)
    return parts.inverse(_damped(parts, squared[..., None]))


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
    _positive("threshold", threshold)
    base = threshold / 2 if damping is None else damping
    _not_negative("damping", base)
    parts = factor(robot, q, resolve_task(task, robot), tolerances)
    if drop:
        return parts.inverse(np.where(parts.sigma >= threshold, parts.reciprocal, 0.0))
    squared = base**2 * np.maximum(0.0, 1.0 - (parts.sigma / threshold) ** 2)
    return parts.inverse(_damped(parts, squared))


def _damped(parts: Factored, squared: Array) -> Array:
    """σ/(σ² + λ²), zero beyond the rank even where λ is zero."""
    below = parts.sigma**2 + squared
    return np.where(parts.sigma > 0.0, parts.sigma / np.where(below > 0.0, below, 1.0), 0.0)


def _positive(name: str, value: float) -> None:
    if not (isfinite(value) and value > 0.0):
        raise OptionError(f"{name} must be positive", got=value, allowed="a finite number above 0")


def _not_negative(name: str, value: float) -> None:
    if not (isfinite(value) and value >= 0.0):
        raise OptionError(f"{name} must not be negative", got=value, allowed="a finite number, 0 or above")
