"""Families where the derivative D has too low a rank: its tangent spaces say too little, and other evidence is used.

Families on which D vanishes more than it should are recognised by the values their points share. Where the condition is
a square, D does not see it (det J of the Stanford arm is q3²·sin θ2·sin θ5 up to a constant: D = 0 all over q3 = 0).
Tangent spaces are of no use there, and points are known to √`target` only. But the values that unit covectors and small
whole-number covectors take do not scatter: those that many points share are conditions, and a direct test of the rank
at these values decides.

Where the rank drops twice over the second derivative says the rest. Near a configuration q0 of rank r let J = U Σ Vᵀ
there, and A = Uᵀ J(q) V in blocks about row and column r. The Schur complement

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
from functools import partial

import numpy as np
from numpy.typing import NDArray

from rankdrop.families.linear import SIMPLE, Linear, Values, boxes, canonical, grow
from rankdrop.families.row import Row, verified
from rankdrop.families.signature import (
    APART,
    Covector,
    Inspection,
    Signature,
    candidates,
    independent,
    joined,
    signatures_of,
)
from rankdrop.family.equation import Mask
from rankdrop.kinematics import task_jacobian, task_jacobian_derivative
from rankdrop.local.block import decompose
from rankdrop.problem import Problem
from rankdrop.robot.model import Array
from rankdrop.solve import iterate

WIDTH = 3e-5  # values closer than this are shared [rad or length scales]
SHARED = 5  # points that must share a value
TRIES = 8  # groups of points that are tried, large ones first


def recognised(problem: Problem, q: Array, rng: np.random.Generator) -> list[Row]:
    """Rows with linear conditions only, from the values that points share.

    Args:
        problem: the arm, and the corank.
        q: (N, n) singular points that no row explains.
        rng: for the direct tests.
    """
    if len(q) < SHARED:
        return []
    n = problem.n
    moving = [int(j) for j in np.flatnonzero(~problem.idle)]
    units = np.eye(n, dtype=np.int64)[moving]
    angles = [j for j in moving if problem.robot.periodic[j]]
    covectors = np.concatenate([units, candidates(tuple(angles), n)])
    shared = np.stack([_shared(Linear.of(problem.robot, [tuple(m)]).values(q)[:, 0]) for m in covectors], axis=1)
    patterns, inverse, counts = np.unique(shared, axis=0, return_inverse=True, return_counts=True)
    rows: list[Row] = []
    for label in np.argsort(-counts, kind="stable")[:TRIES]:
        conditions = independent(covectors[patterns[label]])
        if conditions and counts[label] >= SHARED:
            rows += _rows(problem, conditions, q[inverse.reshape(-1) == label], rng)
    return rows


def _rows(problem: Problem, conditions: tuple[Covector, ...], q: Array, rng: np.random.Generator) -> list[Row]:
    linear = Linear.of(problem.robot, conditions)
    met = linear.combinations(q, np.ones(len(q)), WIDTH)
    sharp = [_solved_values(problem, linear, values, q[members]) for values, members in met.items()]
    found = grow(sharp, linear, partial(verified, problem, linear, (), 0, rng=rng))
    signature = _signature(linear)
    return [Row(linear, sets, (), signature, "shared values, verified") for sets in boxes(found)]


def _solved_values(problem: Problem, linear: Linear, values: Values, q: Array) -> Values:
    """The values that are not simple, right to rounding: solved for with the simple ones put at their places.

    Where D is not zero but of too low a rank, σ is of first order in some combination of the errors.
    """
    vague = [i for i, v in enumerate(values) if linear.periodic[i] and abs(v / SIMPLE - round(v / SIMPLE)) > 1e-12]
    if not vague:
        return values
    rng = np.random.default_rng(0)
    at = linear.place(q[:16].copy(), np.repeat(np.array([values]), len(q[:16]), axis=0), rng)
    pivots = [linear.pivots[i] for i in range(len(linear))]
    moves = np.zeros((problem.n, len(vague)))  # what one value drags along
    moves[pivots] = np.linalg.inv(linear.covectors[:, pivots].astype(np.float64))[:, vague]
    for _ in range(4):
        local = problem.block(at)
        f = np.asarray(local.f).reshape(-1)
        slope = np.asarray(local.d).reshape(len(f), problem.n) @ moves
        at = at - np.linalg.lstsq(slope, f, rcond=1e-6)[0] @ moves.T
    sharp = linear.values(at[:1])[0]
    return tuple(canonical(float(sharp[i])) if i in vague else v for i, v in enumerate(values))


def _signature(linear: Linear) -> Signature:
    n = linear.covectors.shape[1]
    single = np.count_nonzero(linear.covectors, axis=1) == 1
    pinned = tuple(int(np.flatnonzero(m)[0]) for m in linear.covectors[single])
    coupled = tuple(int(j) for j in np.flatnonzero(linear.covectors[~single].any(axis=0)))
    free = tuple(j for j in range(n) if j not in pinned and j not in coupled)
    relations = tuple(tuple(int(x) for x in m) for m in linear.covectors[~single])
    return Signature(len(linear), pinned, free, coupled, relations, ())


def _shared(values: Array) -> Mask:
    """(N,) whether at least `SHARED` points have a value within `WIDTH`."""
    order = np.argsort(values, kind="stable")
    labels: NDArray[np.int64] = np.empty(len(values), dtype=np.int64)
    labels[order] = np.concatenate([[0], np.cumsum(np.diff(values[order]) > WIDTH)])
    ends = labels[order[0]] != labels[order[-1]] and values[order[0]] + 2 * np.pi - values[order[-1]] < WIDTH
    if ends:
        labels[labels == labels[order[-1]]] = labels[order[0]]
    return np.asarray(np.bincount(labels)[labels] >= SHARED)


STEP = 1e-4  # of the differences of dS, of fourth order: rounding leaves 1e-12, and 1e-9 of an angle where it counts
ROUNDS = 5  # of Newton's method, from 1e-6 off
FAR = 1e-3  # a point that moves farther was not near such a family [rad, length scales]
CLEAR = 1e-3  # singular values of dS, or of the second derivative, above this are not zero [1/rad, 1/rad²]
NONE = 1e-5  # … and below this are: points are 1e-6 off at most before Newton's method
SETTLED = 1e-9  # the last step of Newton's method [rad, length scales]
_ENTRIES = 20_000_000  # entries of the left vectors of dS that are held at once, 160 MB
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


def inspect_doubled(problem: Problem, q: Array) -> tuple[Inspection, Mask]:
    """Points moved onto families where the rank drops twice over, and what kind of family each lies on.

    Args:
        problem: the arm, and the corank.
        q: (N, n) singular points, within 1e-6 of the family.

    Returns:
        Inspection, at the points where Newton's method ended; regular where second derivatives were needed and settle
        the tangent space. And (N,) which of `q` have come to rest near where they were.
    """
    scale = problem.scale
    entries = (problem.task.m - problem.rank) * (problem.n - problem.rank)
    each = max(_ENTRIES // entries**2, 1)
    if len(q) > each:  # of a long arm: so many points at once
        parts = [inspect_doubled(problem, q[first : first + each]) for first in range(0, len(q), each)]
        return joined([part for part, _ in parts]), np.concatenate([good for _, good in parts])
    length = np.zeros(len(q))  # of the last step of each

    def step(at: Array, moving: NDArray[np.intp]) -> Array:
        slopes, values = _equations(_second(problem, at, scale))
        delta = -(np.linalg.pinv(slopes, rcond=CLEAR) @ values[..., None])[..., 0]
        length[moving] = np.linalg.norm(delta, axis=1)
        return np.asarray(delta)

    at = iterate(step, q, iterations=ROUNDS, longest=FAR, still=SETTLED, scale=scale)
    sigma = problem.sigma(at)
    good = (length <= SETTLED) & (np.linalg.norm((at - q) / scale, axis=1) < FAR)
    good &= sigma[:, problem.rank] <= problem.tolerances.singular
    at = np.where(good[:, None], at, q)
    sigma = np.where(good[:, None], sigma, problem.sigma(q))
    return _inspection(problem, at, sigma, good, scale), good


def _inspection(problem: Problem, q: Array, sigma: Array, good: Mask, scale: Array) -> Inspection:
    count, n = q.shape
    exact = sigma[:, problem.rank - 1] > APART if problem.rank else np.ones(count, dtype=np.bool_)
    if not count:
        return Inspection(q, sigma, exact, good, np.zeros(0), (), np.zeros((0, n, n)))
    local = _second(problem, q, scale)
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
    signatures = signatures_of(problem.robot, conormal, tangent, ranks, regular, problem.tolerances)
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


def _second(problem: Problem, q: Array, scale: Array) -> _Second:
    count, n, r = len(q), problem.n, problem.rank
    parts = decompose(problem.robot, q, problem.task)
    s, first = _schur(problem, q, parts.u, parts.v, scale)
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
            _, slope = _schur(problem, there, parts.u, parts.v, scale)
            second[:, j] += weight / (12 * STEP) * (left[:, None, :] @ slope)[:, 0]
    clear = np.asarray(((size > CLEAR) | (size < NONE)).all(axis=1))
    return _Second(s, first, left, (second + second.swapaxes(1, 2)) / 2, vt, size[:, :n] <= CLEAR, clear)


def _schur(problem: Problem, q: Array, u: Array, v: Array, scale: Array) -> tuple[Array, Array]:
    """(N, e) S and (N, e, n) dS at q, in the frames of the points where u and v were taken."""
    r = problem.rank
    a = u.swapaxes(1, 2) @ task_jacobian(problem.robot, q, problem.task) @ v
    inverse = np.linalg.inv(a[:, :r, :r])
    below, beside = a[:, r:, :r] @ inverse, inverse @ a[:, :r, r:]
    left = u[:, :, r:] - u[:, :, :r] @ below.swapaxes(1, 2)  # (N, m, p)
    right = v[:, :, r:] - v[:, :, :r] @ beside  # (N, n, s)
    s = a[:, r:, r:] - below @ a[:, :r, r:]
    turned = left.swapaxes(1, 2) @ task_jacobian_derivative(problem.robot, q, problem.task).reshape(*left.shape[:2], -1)
    slope = right.swapaxes(1, 2)[:, None] @ turned.reshape(len(q), -1, problem.n, problem.n)  # (N, p, s, n)
    return s.reshape(len(q), -1), slope.reshape(len(q), -1, problem.n) * scale
