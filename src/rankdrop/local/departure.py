"""How the rank comes back along a straight motion: which singular values leave zero, at which order, how fast.

J(q + t Δ) = Σ J_p t^p has a local Smith form: min(m, n) exponents, one for each singular value, that say at which power
of t it leaves zero (or never). They are read from ranks of block Toeplitz matrices,

    T_p = [[J_0], [J_1, J_0], …, [J_p, …, J_0]],   rank T_p − rank T_{p−1} = how many exponents are ≤ p.

How far p has to go: a motion of one joint carries screws by Ad(exp(S_j t)), and the minors of J are entries of its
exterior powers. A turning joint has the weights 0, 0, ±1, ±1 (i times), so minors are trigonometric polynomials of
degree 2: five coefficients, and one that vanishes to order 5 is zero for ever. A slide is unipotent: polynomials of
degree 2. A helical joint gives e^{±2it}, e^{±it}(1, t), 1, t, t²: nine functions, order 8. Other motions (mimic joints,
several joints, tasks that pick single rows) have no such small bound; 8 is where the product stops, and says so.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop.local.block import singular_values
from rankdrop.local.taylor import taylor
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.task import Task

HIGHEST = 8
"""Largest order looked for along any motion."""
_WHOLE = ((0, 1, 2), (3, 4, 5), (0, 1, 2, 3, 4, 5))
_NEAR = 0.02  # finite motion that measures a rate of order 3 and more: t⁴ is still far above rounding [rad]


@dataclass(frozen=True, slots=True)
class Place:
    """A configuration, its singular value decomposition split at its rank, and what counts as zero there.

    Attributes:
        robot, q, task: what and where; q is (n,).
        rank, generic: rank at q, and almost everywhere.
        sigma: (min(m, n),) singular values at q.
        u, v: (m, m), (n, n) singular vectors as columns; the first `rank` belong to what is kept.
        scale: (n,) what one unit of joint motion is measured by [rad, m].
        floor: a singular value at or below it is not a rank regained.
    """

    robot: Robot
    q: Array
    task: Task
    rank: int
    generic: int
    sigma: Array
    u: Array
    v: Array
    scale: Array
    floor: float

    @property
    def corank(self) -> int:
        """Task freedoms lost at q."""
        return self.generic - self.rank

    @property
    def u2(self) -> Array:
        """(m, m − rank) lost directions of the task."""
        return self.u[:, self.rank :]

    @property
    def v2(self) -> Array:
        """(n, n − rank) null space of the Jacobian."""
        return self.v[:, self.rank :]

    def kept(self) -> Array:
        """(m, n) the Jacobian without the singular values that count as zero."""
        r = self.rank
        return np.asarray((self.u[:, :r] * self.sigma[:r]) @ self.v[:, :r].T)

    def inverse(self) -> Array:
        """(n, m) its pseudo-inverse J⁺."""
        r = self.rank
        return np.asarray((self.v[:, :r] / self.sigma[:r]) @ self.u[:, :r].T)

    def last(self, configurations: Array) -> Array:
        """(...) σ_r at other configurations (..., n), r the generic rank."""
        return singular_values(self.robot, configurations, self.task)[..., self.generic - 1]


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
    cut = 3 * place.floor
    counts = _counts(series, highest, place, cut)
    first = place.u2.T @ series[1] @ place.v2
    schur = place.u2.T @ (series[2] - series[1] @ place.inverse() @ series[1]) @ place.v2
    out = []
    for d, direction in enumerate(directions):
        gains = counts[d] - place.rank
        order = next((p for p, gain in enumerate(gains) if gain >= place.corank), None)
        sigma = np.linalg.svd(first[d], compute_uv=False)[: place.corank]
        rate = 0.0
        if order == 1:
            rate = float(sigma[-1])
        elif order == 2:
            rate = _second(first[d], schur[d], int(gains[1]), place.corank)
        elif order is not None:
            rate = _finite(place, direction, order)
        out.append(Departure(int(gains[-1]), order, rate, tuple(float(s) for s in sigma)))
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


def _counts(series: Array, highest: Array, place: Place, cut: float) -> Array:
    """(d, P + 1) number of singular values whose order is at most p, from the ranks of T_p."""
    powers, count = len(series), series.shape[1]
    numbers = np.full((count, powers), place.rank)
    before = np.full(count, place.rank)
    open_ = np.arange(count)
    for p in range(1, powers):
        open_ = open_[(highest[open_] >= p) & (numbers[open_, p - 1] < place.generic)]
        if not len(open_):
            break
        ranks = (np.linalg.svd(_toeplitz(series[:, open_], p), compute_uv=False) > cut).sum(axis=-1)
        # the count never falls with p, nor is it above the generic rank: what a cut makes of rounding is put right
        found = np.clip(ranks - before[open_], numbers[open_, p - 1], place.generic)
        before[open_] = ranks
        numbers[open_, p:] = found[:, None]
    return numbers


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
