"""How the rank comes back along a straight motion: which singular values leave zero, at which order, how fast.

J(q + t Δ) = Σ J_p t^p has a local Smith form: min(m, n) exponents, one for each singular value, that say at which power
of t it leaves zero (or never). They are read from ranks of block Toeplitz matrices,

    T_p = [[J_0], [J_1, J_0], …, [J_p, …, J_0]],   rank T_p − rank T_{p−1} = how many exponents are ≤ p.

How far p has to go: a motion of one joint carries screws by Ad(exp(S_j t)), and the minors of J are entries of its
exterior powers. A turning joint has the weights 0, 0, ±1, ±1 (i times), so minors are trigonometric polynomials of
degree 2: five coefficients, and one that vanishes to order 5 is zero for ever. A slide is unipotent: polynomials of
degree 2. A helical joint gives e^{±2it}, e^{±it}(1, t), 1, t, t²: nine functions, order 8. Other motions (mimic joints,
several joints, tasks that pick single rows) have no such small bound; 8 is where the product stops, and says so.

Near a second family the small singular values of T_p are products of small numbers and its rank hangs on the cut. Then
the series is summed up at a finite t instead, and the gain is what exceeds the cut there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rankdrop.local.place import Place, judge_steps
from rankdrop.local.taylor import taylor
from rankdrop.robot.model import Array, JointKind

HIGHEST = 8
"""Largest order looked for along any motion."""
_WHOLE = ((0, 1, 2), (3, 4, 5), (0, 1, 2, 3, 4, 5))
_LONG = 12  # terms after which the series is exact to 1e-11 for the longest of them
_DOUBT = 100.0  # a singular value of T_p nearer to the cut than this factor, either way, is in doubt
_NEAR = 0.02  # finite motion that measures a rate of order 3 and more: t⁴ is still far above rounding [rad]


@dataclass(frozen=True, slots=True)
class Departure:
    """What one straight motion does to the rank.

    Attributes:
        gain: rank regained for small t ≠ 0.
        order: power of t at which the slowest of all lost singular values leaves zero; None where one never does.
        rate: σ_r ≈ rate · t^order; 0.0 where order is None.
        first: (corank,) singular values of D(Δ), descending.
    """

    gain: int
    order: int | None
    rate: float
    first: tuple[float, ...]


def departures(place: Place, directions: Array) -> tuple[Departure, ...]:
    """Gain, order and rate along each direction.

    order 1: the k-th singular value of D(Δ) = U₂ᵀ J_1 V₂; order 2: with W, Z the left and right null spaces of D(Δ),
    r₁ its rank, the (k − r₁)-th singular value of Wᵀ(U₂ᵀ J_2 V₂ − U₂ᵀ J_1 J⁺ J_1 V₂)Z; higher: σ_r/t^p of a short
    finite motion, extrapolated to t = 0.

    Args:
        place: a configuration of corank ≥ 1.
        directions: (d, n) in scaled joint coordinates; t is measured so, and so are the rates.

    Returns:
        One departure per direction.
    """
    highest = np.array([_highest(place, direction) for direction in directions])
    series = taylor(place.robot, place.q, place.task, directions * place.scale, int(highest.max(initial=2)))
    series[0] = place.kept()
    counts, doubtful = _counts(series, highest, place)
    gained = counts[:, -1] - place.rank
    if doubtful.any():
        gained[doubtful] = _summed(place, directions[doubtful])
    first = place.u2.T @ series[1] @ place.v2
    schur = place.u2.T @ (series[2] - series[1] @ place.inverse() @ series[1]) @ place.v2
    out = []
    for d, direction in enumerate(directions):
        gains = counts[d] - place.rank
        order = None
        if gained[d] >= place.corank:
            order = next((p for p, gain in enumerate(gains) if gain >= place.corank), None)
            order = _slope(place, direction) if order is None else order
        sigma = np.linalg.svd(first[d], compute_uv=False)[: place.corank]
        rate = 0.0
        if order == 1:
            rate = float(sigma[-1])
        elif order == 2:
            rate = _second(first[d], schur[d], int(gains[1]), place.corank)
        elif order is not None:
            rate = _finite(place, direction, order)
        out.append(Departure(int(gained[d]), order, rate, tuple(float(s) for s in sigma)))
    return tuple(out)


def _highest(place: Place, direction: Array) -> int:
    """How far the orders can go along a direction, see the module's text."""
    moving = np.flatnonzero(direction)
    variables = place.robot.variables
    if len(moving) != 1 or place.task.rows not in _WHOLE:
        return HIGHEST
    joint = variables[int(moving[0])]
    leads = any(other.mimic is not None and other.mimic.leader == joint.name for other in place.robot.joints)
    if leads or joint.kind is JointKind.HELICAL:
        return HIGHEST
    return 4


def _counts(series: Array, highest: Array, place: Place) -> tuple[Array, NDArray[np.bool_]]:
    """(d, P + 1) number of singular values whose order is at most p, from the ranks of T_p; and (d,) whether one of
    those ranks hangs on where exactly the cut is."""
    powers, count = len(series), series.shape[1]
    numbers = np.full((count, powers), place.rank)
    before = np.full(count, place.rank)
    doubtful = np.full(count, bool(_close(place.sigma[: place.rank], place.floor).any()))
    left = np.arange(count)
    for p in range(1, powers):
        left = left[(highest[left] >= p) & (numbers[left, p - 1] < place.generic)]
        if not len(left):
            break
        sigma = np.linalg.svd(_toeplitz(series[:, left], p), compute_uv=False)
        ranks = (sigma > place.floor).sum(axis=-1)
        doubtful[left] |= _close(np.asarray(sigma, dtype=np.float64), place.floor).any(axis=-1)
        # the count never falls with p, nor is it above the generic rank: what a cut makes of rounding is put right
        numbers[left, p:] = np.clip(ranks - before[left], numbers[left, p - 1], place.generic)[:, None]
        before[left] = ranks
    return numbers, doubtful


def _close(sigma: Array, floor: float) -> NDArray[np.bool_]:
    return (sigma > floor / _DOUBT) & (sigma < floor * _DOUBT)


def _summed(place: Place, directions: Array) -> NDArray[np.intp]:
    """(d,) rank regained, from the Taylor series summed up at a finite t: what counts there is the size of σ."""
    series = taylor(place.robot, place.q, place.task, directions * place.scale, _LONG)
    powers = judge_steps(place, directions)[..., None] ** np.arange(_LONG + 1)
    moved = np.einsum("tdp,pdmn->tdmn", powers, series)
    ranks = (np.linalg.svd(moved, compute_uv=False) > place.floor).sum(axis=-1).max(axis=0)
    return np.asarray(np.clip(ranks, place.rank, place.generic) - place.rank)


def _slope(place: Place, direction: Array) -> int:
    """The order as a finite motion shows it, where the series cannot tell."""
    steps = _NEAR * np.array([1.0, -1.0, 2.0, -2.0])
    near, far = place.last(place.q + steps[:, None] * direction * place.scale).reshape(2, 2).mean(axis=1)
    return int(np.clip(round(np.log2(max(far, 1e-300) / max(near, 1e-300))), 1, HIGHEST))


def _toeplitz(series: Array, p: int) -> Array:
    """(d, (p + 1) m, (p + 1) n) T_p of each direction."""
    _, count, m, n = series.shape
    matrix = np.zeros((count, (p + 1) * m, (p + 1) * n))
    for row in range(p + 1):
        for column in range(row + 1):
            matrix[:, row * m : (row + 1) * m, column * n : (column + 1) * n] = series[row - column]
    return matrix


def _second(first: Array, schur: Array, rank: int, corank: int) -> float:
    """The coefficient of t² of the slowest singular value: Schur complement on the null spaces of D(Δ)."""
    u, _, vt = np.linalg.svd(first)
    left, right = u[:, rank:], vt[rank:].T
    return float(np.linalg.svd(left.T @ schur @ right, compute_uv=False)[corank - rank - 1])


def _finite(place: Place, direction: Array, order: int) -> float:
    """σ_r/|t|^order as t → 0, from ±h and ±2h: the mean is even in t, so one step of Richardson takes t² off."""
    steps = _NEAR * np.array([1.0, -1.0, 2.0, -2.0])
    sigma = place.last(place.q + steps[:, None] * direction * place.scale) / np.abs(steps) ** order
    near, far = sigma[:2].mean(), sigma[2:].mean()
    return float((4 * near - far) / 3)
