"""Families on which the rank drops twice over: where D has too low a rank, and the second derivative says the rest.

Near a configuration q0 of rank r let J = U Σ Vᵀ there, and A = Uᵀ J(q) V in blocks about row and column r. The Schur
complement

    S(q) = A₂₂ − A₂₁ A₁₁⁻¹ A₁₂

is smooth, vanishes exactly where rank J ≤ r, and has the derivative dS = D at q0. On {θ5 = 0, a1 + a2 c2 + a3 c23 = 0}
of many 7R arms S is (x, y²) in suitable coordinates: D has rank 1 where the family has codimension 2, ker D is not its
tangent space, and a search ends at y of the square root of rounding. But λᵀS = y² for the λ with λᵀD = 0, and y is what
its gradient vanishes on. So on the family

    S = 0,   λᵀ dS = 0   for one λ ≠ 0,

which has simple roots: Newton's method on it (A. Leykin, J. Verschelde, A. Zhao, Newton's method with deflation, 2006)
brings points to rounding, and the rows of dS with those of λᵀd²S on ker dS span the conormal space.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop.families.sampling import Setting
from rankdrop.families.signature import APART, Inspection, signatures_of
from rankdrop.family.system import Mask
from rankdrop.kinematics import task_jacobian, task_jacobian_derivative
from rankdrop.local.block import decompose, joint_scale, singular_values
from rankdrop.robot.model import Array

STEP = 1e-4  # of the differences of dS, of fourth order: rounding leaves 1e-12, and 1e-9 of an angle where it counts
ROUNDS = 5  # of Newton's method, from 1e-6 off
FAR = 1e-3  # a point that moves farther was not near such a family [rad, length scales]
CLEAR = 1e-3  # singular values of dS, or of the second derivative, above this are not zero [1/rad, 1/rad²]
NONE = 1e-5  # … and below this are: points are 1e-6 off at most before Newton's method
SETTLED = 1e-9  # the last step of Newton's method [rad, length scales]
RESTED = 1e-7  # singular values of the second derivative below this are zero at the end


@dataclass(frozen=True, eq=False)
class _Second:
    """S and its derivatives at points, in joint variables divided by their scale.

    Attributes:
        s: (N, e) S, its entries in a row; e = (m − r)(n − r).
        first: (N, e, n) dS.
        left: (N, e) λ of length one with λᵀdS = 0, one by chance of all there are.
        second: (N, n, n) λᵀ d²S.
        normal, tangent: (N, n, n) right singular vectors of dS as rows; whether they belong to its zeros.
        clear: (N,) whether every singular value of dS is zero or clearly not.
    """

    s: Array
    first: Array
    left: Array
    second: Array
    normal: Array
    tangent: Mask
    clear: Mask


def inspect_doubled(setting: Setting, q: Array) -> tuple[Inspection, Mask]:
    """Points moved onto families where the rank drops twice over, and what kind of family each lies on.

    Args:
        setting: arm, task, corank.
        q: (N, n) singular points, within 1e-6 of the family.

    Returns:
        Inspection, at the points where Newton's method ended; regular where second derivatives were needed and settle
        the tangent space. And (N,) which of `q` have come to rest near where they were.
    """
    scale = joint_scale(setting.robot, setting.task)
    at, step = np.array(q, dtype=np.float64), np.zeros(len(q))
    for _ in range(ROUNDS if len(q) else 0):
        local = _second(setting, at, scale)
        slopes, values = _equations(local)
        delta = -(np.linalg.pinv(slopes, rcond=CLEAR) @ values[..., None])[..., 0]
        step = np.linalg.norm(delta, axis=1)
        at += delta * np.minimum(1.0, FAR / np.maximum(step, 1e-300))[:, None] * scale
    sigma = singular_values(setting.robot, at, setting.task)
    good = (step < SETTLED) & (np.linalg.norm((at - q) / scale, axis=1) < FAR)
    good &= sigma[:, setting.rank] <= setting.tolerances.singular
    at = np.where(good[:, None], at, q)
    sigma = np.where(good[:, None], sigma, singular_values(setting.robot, q, setting.task))
    return _inspection(setting, at, sigma, good, scale), good


def _inspection(setting: Setting, q: Array, sigma: Array, good: Mask, scale: Array) -> Inspection:
    count, n = q.shape
    exact = sigma[:, setting.rank - 1] > APART if setting.rank else np.ones(count, dtype=np.bool_)
    if not count:
        return Inspection(q, sigma, exact, good, np.zeros(0), (), np.zeros((0, n, n)))
    local = _second(setting, q, scale)
    ranks_first = (~local.tangent).sum(axis=1)
    slopes, _ = _equations(local)
    _, s, vt = np.linalg.svd(slopes / scale, full_matrices=True)
    ranks = (s > CLEAR).sum(axis=1)
    settled = ((s > CLEAR) | (s < RESTED)).all(axis=1)
    smallest = np.where(ranks > 0, s[np.arange(count), np.maximum(ranks - 1, 0)], 0.0)
    regular = good & exact & local.clear & settled & (ranks > ranks_first)
    inside = (np.arange(n)[None, :] < ranks[:, None]).astype(np.float64)
    conormal = np.einsum("nij,ni,nik->njk", vt, inside, vt)
    tangent = np.einsum("nij,ni,nik->njk", vt, 1.0 - inside, vt)
    signatures = signatures_of(setting.robot, conormal, tangent, ranks, regular, setting.tolerances)
    return Inspection(q, sigma, exact, regular, smallest, signatures, tangent)


def _equations(local: _Second) -> tuple[Array, Array]:
    """(N, n + n, n) and (N, n + n) what Newton's method solves: the clear part of dS·x = −S, and on its kernel
    λᵀd²S·x = −λᵀdS."""
    keep, rest = (~local.tangent).astype(np.float64), local.tangent.astype(np.float64)
    away = np.linalg.pinv(local.first, rcond=CLEAR)  # (N, n, e)
    across = local.normal * keep[:, :, None]
    along = local.normal * rest[:, :, None]
    first = across, -(across @ away @ -local.s[..., None])[..., 0]
    second = along @ local.second, (along @ (local.left[:, None, :] @ local.first)[:, 0, :, None])[..., 0]
    return np.concatenate([first[0], second[0]], axis=1), np.concatenate([first[1], second[1]], axis=1)


def _second(setting: Setting, q: Array, scale: Array) -> _Second:
    count, n, r = len(q), setting.robot.n, setting.rank
    parts = decompose(setting.robot, q, setting.task)
    s, first = _schur(setting, q, parts.u, parts.v, scale)
    u, size, vt = np.linalg.svd(first)
    size = np.concatenate([size, np.zeros((count, n))], axis=1)
    entries = first.shape[1]
    null = size[:, :entries] <= CLEAR if entries <= n else np.concatenate([size[:, :n] <= CLEAR, np.ones(
        (count, entries - n), dtype=np.bool_)], axis=1)
    chance = np.random.default_rng(r).standard_normal((count, entries)) * null
    left = (u @ chance[..., None])[..., 0]
    left /= np.maximum(np.linalg.norm(left, axis=1, keepdims=True), 1e-300)
    second = np.zeros((count, n, n))
    for j in range(n):
        for times, weight in ((1, 8.0), (-1, -8.0), (2, -1.0), (-2, 1.0)):
            there = q.copy()
            there[:, j] += times * STEP * scale[j]
            _, slope = _schur(setting, there, parts.u, parts.v, scale)
            second[:, j] += weight / (12 * STEP) * (left[:, None, :] @ slope)[:, 0]
    clear = np.asarray(((size > CLEAR) | (size < NONE)).all(axis=1))
    return _Second(s, first, left, (second + second.swapaxes(1, 2)) / 2, vt, size[:, :n] <= CLEAR, clear)


def _schur(setting: Setting, q: Array, u: Array, v: Array, scale: Array) -> tuple[Array, Array]:
    """(N, e) S and (N, e, n) dS at q, in the frames of the points where u and v were taken."""
    r = setting.rank
    a = u.swapaxes(1, 2) @ task_jacobian(setting.robot, q, setting.task) @ v
    inverse = np.linalg.inv(a[:, :r, :r])
    below, beside = a[:, r:, :r] @ inverse, inverse @ a[:, :r, r:]
    left = u[:, :, r:] - u[:, :, :r] @ below.swapaxes(1, 2)  # (N, m, p)
    right = v[:, :, r:] - v[:, :, :r] @ beside  # (N, n, s)
    s = a[:, r:, r:] - below @ a[:, :r, r:]
    slope = np.einsum("nap,nabj,nbs->npsj", left, task_jacobian_derivative(setting.robot, q, setting.task), right)
    return s.reshape(len(q), -1), slope.reshape(len(q), -1, setting.robot.n) * scale
