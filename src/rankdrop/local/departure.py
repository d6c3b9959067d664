"""How the rank comes back along a straight motion of the joints: a power series of J, and finite motions that judge it.

Let the joints move as q + t Δ, and let every screw be written in the task's own frame F. With Ŝ_i the screw of joint i
in F, ρ_k the rate of joint k,

    dŜ_i/dt = [Ŵ_i − V̂, Ŝ_i],   Ŵ_i = Σ_{k<i} ρ_k Ŝ_k,   V̂ = (Σ_{k≤b} ρ_k v̂_k ; Σ_{k≤a} ρ_k ω̂_k)

V̂ being the twist of F, whose reference point is fixed in link b and whose axes turn with link a: earlier joints carry
a screw along (bracket rule), the frame's own motion is taken off. Comparing powers of t gives a recursion,

    (p + 1) Ŝ_i^(p+1) = Σ_{a+b=p} [Ŵ_i^(a) − V̂^(a), Ŝ_i^(b)],

valid for turning, sliding and helical joints, in every frame. A mimic joint is a joint with the rate of its leader
times the multiplier. In the frame SPACE and with Δ = e_j this is ad_{S_j}^p S_i / p! for i > j (GR section 2).

J(q + t Δ) = Σ J_p t^p has a local Smith form: min(m, n) exponents, one for each singular value: the power of t at which
it leaves zero (or never). They are read from ranks of block Toeplitz matrices,

    T_p = [[J_0], [J_1, J_0], …, [J_p, …, J_0]],   rank T_p − rank T_{p−1} = how many exponents are ≤ p.

How far p has to go: a motion of one joint carries screws by Ad(exp(S_j t)), and the minors of J are entries of its
exterior powers. A turning joint has the weights 0, 0, ±1, ±1 (i times), so minors are trigonometric polynomials of
degree 2: five coefficients, and one that vanishes to order 5 is zero for ever. A slide is unipotent: polynomials of
degree 2. A helical joint gives e^{±2it}, e^{±it}(1, t), 1, t, t²: nine functions, order 8. Other motions (mimic joints,
several joints, tasks that pick single rows) have no such small bound; the search for orders stops at 8.

Near a second family the small singular values of T_p are products of small numbers and its rank depends on the cut.
Then the series is summed up at a finite t instead, and the gain is what exceeds the cut there.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop import _core
from rankdrop.configuration import Configuration
from rankdrop.kinematics import jacobian
from rankdrop.local.block import row_scale
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.transform import unit
from rankdrop.task import Task, link_index

HIGHEST = 8
"""Largest order looked for along any motion."""
_WHOLE = ((0, 1, 2), (3, 4, 5), (0, 1, 2, 3, 4, 5))
_LONG = 12  # terms after which the series is exact to 1e-11 for the longest of them
_DOUBT = 100.0  # a singular value of T_p nearer to the cut than this factor, either way, is in doubt
_NEAR = 0.02  # finite motion that measures a rate of order 3 and more: t⁴ is still far above rounding [rad]

Departure = tuple[int, int | None, float, tuple[float, ...]]
"""What one straight motion does to the rank: rank regained for small t ≠ 0; power of t at which the slowest of all lost
singular values leaves zero, None where one never does; its rate, σ_r ≈ rate · t^order, 0.0 where it has no order; the
singular values of D(Δ), descending."""

_Indices = NDArray[np.intp]

_ANGLES = 16  # directions tried per pair, then refined
_CLIMBS = 6  # steps of the climb towards the best direction
_SOFT = 8  # power by which the smallest of the lost singular values weighs more than the next
_RANDOM = 24  # random starts of it


def release_mimics(robot: Robot, q: Array) -> tuple[Robot, Array, Array]:
    """The same chain with every mimic joint a variable of its own.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].

    Returns:
        The chain with N variables; its configurations (..., N); the share (N, n) each variable of `robot` has in it.
    """
    if robot.n == len(robot.joints):
        return robot, q, np.eye(robot.n)
    index = {joint.name: i for i, joint in enumerate(robot.variables)}
    share, offset = np.zeros((len(robot.joints), robot.n)), np.zeros(len(robot.joints))
    for row, joint in enumerate(robot.joints):
        if joint.mimic is None:
            share[row, index[joint.name]] = 1.0
        else:
            share[row, index[joint.mimic.leader]], offset[row] = joint.mimic.multiplier, joint.mimic.offset
    free = replace(robot, joints=tuple(replace(joint, mimic=None) for joint in robot.joints))
    return free, q @ share.T + offset, share


def taylor(robot: Robot, q: ArrayLike, task: Task, directions: ArrayLike, order: int) -> Array:
    """Taylor coefficients of the task Jacobian along straight motions: J(q + t Δ) = Σ_p J_p t^p.

    Args:
        robot: the arm.
        q: (n,) configuration [rad, m].
        task: rows, frame and length scale.
        directions: (d, n) motions Δ, [rad, m] per unit of t.
        order: the highest power P wanted.

    Returns:
        (P + 1, d, m, n) the coefficients J_0 … J_P; J_1 is dJ(Δ), J_2 half the second derivative.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("pa10")
        >>> taylor(arm, [0.1] * 7, resolve_task(None, arm), np.eye(7), 4).shape
        (5, 7, 6, 7)
    """
    chain, values, share = release_mimics(robot, np.asarray(q, dtype=np.float64))
    joints = len(chain.joints)
    axes, origin = (link_index(link, joints, "frame") for link in (task.frame.axes, task.frame.origin))
    rates = np.asarray(directions, dtype=np.float64) @ share.T  # (d, N)
    screws = jacobian(chain, values, task.frame).T  # (N, 6)
    terms = _core.series(np.ascontiguousarray(screws), np.ascontiguousarray(rates), axes, origin, order)
    columns = terms[..., list(task.rows)]  # (P + 1, d, N, m)
    return np.asarray(np.swapaxes(columns * row_scale(robot, task), -1, -2) @ share)


def departures(place: Configuration, directions: Array) -> tuple[Departure, ...]:
    """Gain, order and rate along each direction.

    order 1: the k-th singular value of D(Δ) = U₂ᵀ J_1 V₂; order 2: with W, Z the left and right null spaces of D(Δ),
    r₁ its rank, the (k − r₁)-th singular value of Wᵀ(U₂ᵀ J_2 V₂ − U₂ᵀ J_1 J⁺ J_1 V₂)Z; higher: σ_r/t^p of a short
    finite motion, extrapolated to t = 0.

    Args:
        place: where; at a regular configuration the rate is dσ_r/dt, with its sign (AM eq. 7), and the order 1.
        directions: (d, n) in scaled joint coordinates; t is measured so, and so are the rates.

    Returns:
        One departure per direction.
    """
    if not place.corank:
        r, first = place.generic - 1, place.derivative_along(directions)
        return tuple((0, 1, slope, ()) for slope in (place.u[:, r] @ first @ place.v[:, r]).tolist())
    highest = _highest(place, directions)
    series = taylor(place.robot, place.q, place.task, directions * place.scale, int(highest.max(initial=2)))
    series[0] = place.kept_jacobian()
    counts, doubtful = _counts(series, highest, place)
    gained = counts[:, -1] - place.rank
    if doubtful.any():
        gained[doubtful] = _rank_by_series(place, directions[doubtful])
    first = place.u2.T @ series[1] @ place.v2
    rates = np.linalg.svd(first, compute_uv=False)[:, : place.corank].tolist()
    schur = place.u2.T @ (series[2] - series[1] @ place.inverse() @ series[1]) @ place.v2
    out = []
    for d, direction in enumerate(directions):
        gains = counts[d] - place.rank
        order = None
        if gained[d] >= place.corank:
            order = next((p for p, gain in enumerate(gains) if gain >= place.corank), None)
            if order is None:  # the series cannot tell: as a finite motion shows it
                near, far = _near_and_far(place, direction)
                order = int(np.clip(round(np.log2(max(far, 1e-300) / max(near, 1e-300))), 1, HIGHEST))
        rate = 0.0
        if order == 1:
            rate = rates[d][-1]
        elif order == 2:
            rate = _second(first[d], schur[d], int(gains[1]), place.corank)
        elif order is not None:
            near, far = _near_and_far(place, direction) / np.array([_NEAR, 2 * _NEAR]) ** order
            rate = float((4 * near - far) / 3)  # the mean is even in t, so one step of Richardson takes t² off
        out.append((int(gained[d]), order, rate, tuple(rates[d])))
    return tuple(out)


def _highest(place: Configuration, directions: Array) -> NDArray[np.intp]:
    """(d,) how far the orders can go along directions (d, n), see the module's text."""
    highest = np.full(len(directions), HIGHEST)
    if place.task.rows not in _WHOLE:
        return highest
    leaders = {joint.mimic.leader for joint in place.robot.joints if joint.mimic is not None}
    bounded = np.array([
        joint.kind is not JointKind.HELICAL and joint.name not in leaders for joint in place.robot.variables
    ])  # fmt: skip
    moving = directions != 0.0
    highest[(moving.sum(axis=1) == 1) & (moving & bounded).any(axis=1)] = 4
    return highest


def _counts(series: Array, highest: NDArray[np.intp], place: Configuration) -> tuple[Array, NDArray[np.bool_]]:
    """(d, P + 1) number of singular values whose order is at most p, from the ranks of T_p; and (d,) whether one of
    those ranks hangs on where exactly the cut is."""
    powers, count = series.shape[:2]
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


def _rank_by_series(place: Configuration, directions: Array) -> NDArray[np.intp]:
    """(d,) rank regained, from the Taylor series summed up at a finite t: what counts there is the size of σ."""
    series = taylor(place.robot, place.q, place.task, directions * place.scale, _LONG)
    powers = place.judge_steps(directions)[..., None] ** np.arange(_LONG + 1)
    moved = np.einsum("tdp,pdmn->tdmn", powers, series)
    ranks = (np.linalg.svd(moved, compute_uv=False) > place.floor).sum(axis=-1).max(axis=0)
    return np.asarray(np.clip(ranks, place.rank, place.generic) - place.rank)


def _toeplitz(series: Array, p: int) -> Array:
    """(d, (p + 1) m, (p + 1) n) T_p of each direction."""
    _, count, m, n = series.shape
    powers = np.subtract.outer(np.arange(p + 1), np.arange(p + 1))
    blocks = np.where((powers >= 0)[..., None, None, None], series[powers], 0.0)  # (p + 1, p + 1, d, m, n)
    return blocks.transpose(2, 0, 3, 1, 4).reshape(count, (p + 1) * m, (p + 1) * n)


def _second(first: Array, schur: Array, rank: int, corank: int) -> float:
    """The coefficient of t² of the slowest singular value: Schur complement on the null spaces of D(Δ)."""
    u, _, vt = np.linalg.svd(first)
    left, right = u[:, rank:], vt[rank:].T
    return float(np.linalg.svd(left.T @ schur @ right, compute_uv=False)[corank - rank - 1])


def _near_and_far(place: Configuration, direction: Array) -> Array:
    """(2,) means of σ_r after motions by ±h and ±2h."""
    steps = _NEAR * np.array([1.0, -1.0, 2.0, -2.0])
    return np.asarray(place.last(place.q + steps[:, None] * direction * place.scale).reshape(2, 2).mean(axis=1))


def measured_gains(place: Configuration, directions: Array) -> Array:
    """(d,) rank after a finite motion along each direction (d, n), minus the rank before: the largest of several."""
    motions = place.judge_steps(directions)[..., None] * directions  # (4, d, n)
    sigma = place.singular_values(place.q + motions * place.scale)
    ranks = np.minimum((sigma > place.floor).sum(axis=-1), place.generic)
    return np.asarray(ranks.max(axis=0) - place.rank)


def single_motions(place: Configuration, step: float) -> tuple[Array, Array]:
    """The better of the two motions of each joint by `step`, cut off at its limits.

    Returns:
        (n,) signed motion in scaled coordinates, and (n,) σ_r after it.
    """
    down, up = place.room
    steps = np.stack([np.minimum(step, up), -np.minimum(step, down)])  # (2, n)
    sigma = place.last(place.q + steps[..., None] * np.diag(place.scale))
    better = np.argmax(sigma - 1e-12 * np.array([[0.0], [1.0]]), axis=0)  # ties go up
    joints = np.arange(len(place.q))
    return steps[better, joints], sigma[better, joints]


def fit_to_limits(place: Configuration, motions: Array) -> Array:
    """Motions (..., n) in scaled coordinates, cut off at the limits."""
    down, up = place.room
    return np.minimum(np.maximum(motions, -down), up)


@lru_cache(maxsize=64)
def _pairs(n: int) -> _Indices:
    """(P, 2) all pairs of n joints, from 0."""
    pairs = np.array(list(combinations(range(n), 2)))
    pairs.flags.writeable = False
    return pairs


def best_pair(place: Configuration, step: float) -> Array:
    """The motion (n,) of two joints, of length `step` at most, that restores most; inside the limits.

    All pairs and a circle of directions in one call, then the best few pairs again, finer and finer.
    """
    n = len(place.q)
    pairs = _pairs(n)
    angles = np.arange(_ANGLES) * 2 * np.pi / _ANGLES
    motions = _on_circle(place, pairs[:, None, :], np.broadcast_to(angles, (len(pairs), _ANGLES)), step)
    best, order = _best_of_each(place, motions)
    chosen, centre = pairs[order[:3]], angles[best[order[:3]]]
    width = 2 * np.pi / _ANGLES
    for _ in range(4):
        fine = centre[:, None] + width * np.linspace(-1, 1, 9)
        motions = _on_circle(place, chosen[:, None, :], fine, step)
        best, order = _best_of_each(place, motions)
        centre, width = fine[np.arange(len(chosen)), best], width / 4
    return np.asarray(motions[order[0], best[order[0]]])


def best_motion(place: Configuration, step: float, seed: int, tried: Array) -> Array:
    """The motion (n,) of all joints, of length `step` at most, that restores most; inside the limits.

    Candidates are the motions handed in, the leading directions of D, and random ones. Each climbs by
    x ← step · g/‖g‖, g the gradient of σ_r at q + x: where it stands still, x is the best of its length. Random steps
    of falling width end it, for ridges where singular values tie. Against 20 000 random directions at coranks 1 to 3
    of five arms the outcome is 2 % worse at most; it is a search, not a proof.

    Args:
        place: where.
        step: length in scaled coordinates.
        seed: of the random candidates.
        tried: (t, n) motions already known to be good.
    """
    rng = np.random.default_rng(seed)
    random = rng.normal(size=(_RANDOM, len(place.q)))
    candidates = np.concatenate([tried, _leading(place), random])
    motions = fit_to_limits(place, step * unit(candidates))
    here = _decomposed(place, motions)
    best = _Best(motions, _scores_of(place, here.sigma))
    for turn in range(_CLIMBS):
        ahead = unit(_gradient(place, here))
        if place.corank > 1 and turn:  # half the way: between ties the whole way swings from side to side
            ahead = unit(ahead + unit(motions))
        motions = fit_to_limits(place, step * ahead)
        if turn == 0:  # after the first step half of the field tells enough
            reached = scores(place, motions)
            best.compare(motions, reached)
            motions = motions[_order(reached)[:12]]
            here = _decomposed(place, motions)
        elif turn + 1 < _CLIMBS:
            here = _decomposed(place, motions)
            best.compare(motions, _scores_of(place, here.sigma))
        else:
            best.compare(motions, scores(place, motions))
    widths = (0.3, 0.1, 0.03) if place.corank < 2 else (0.5, 0.3, 0.2, 0.1, 0.05, 0.02)  # ridges where σ's tie
    n = len(place.q)
    for width in widths:
        around = unit(unit(best.motion[None]) + width * rng.normal(size=(32, n)) / np.sqrt(n))
        motions = fit_to_limits(place, step * around)
        best.compare(motions, scores(place, motions))
    return best.motion


class _Best:
    """The best of motions (c, n) by their scores (c, 2), and of those it is compared with; of equals the first."""

    def __init__(self, motions: Array, reached: Array) -> None:
        first = _order(reached)[0]
        self.motion: Array = motions[first]
        self.reached: Array = reached[first]

    def compare(self, motions: Array, reached: Array) -> None:
        first = _order(reached)[0]
        if tuple(reached[first]) > tuple(self.reached):
            self.motion, self.reached = motions[first], reached[first]


def scores(place: Configuration, motions: Array) -> Array:
    """(..., 2) what motions (..., n) reach: rank, and the singular value that holds it."""
    return _scores_of(place, place.singular_values(place.q + motions * place.scale))


def _scores_of(place: Configuration, singular_values: Array) -> Array:
    sigma = singular_values[..., : place.generic]
    out = np.empty((*sigma.shape[:-1], 2))
    if (sigma[..., -1] > place.floor).all():  # most often
        out[..., 0], out[..., 1] = place.generic, sigma[..., -1]
        return out
    ranks = (sigma > place.floor).sum(axis=-1)
    out[..., 0] = ranks
    out[..., 1] = np.take_along_axis(sigma, np.maximum(ranks - 1, 0)[..., None], axis=-1)[..., 0]
    return out


def _order(reached: Array) -> _Indices:
    return np.lexsort((-reached[:, 1], -reached[:, 0]))


def _best_of_each(place: Configuration, motions: Array) -> tuple[_Indices, _Indices]:
    """Of motions (p, a, n): the best a of each p, and the p from the best to the worst."""
    reached = scores(place, motions)
    value = reached[..., 0] * 1e6 + reached[..., 1]  # σ of scaled Jacobians is far below 1e6
    best = np.argmax(value, axis=1)
    return best, np.argsort(-value[np.arange(len(best)), best], kind="stable")


def _on_circle(place: Configuration, pairs: _Indices, angles: Array, step: float) -> Array:
    motions = np.zeros((*angles.shape, len(place.q)))
    row, column = np.arange(angles.shape[0])[:, None], np.arange(angles.shape[1])
    motions[row, column, pairs[..., 0]] = step * np.cos(angles)
    motions[row, column, pairs[..., 1]] = step * np.sin(angles)
    return fit_to_limits(place, motions)


def _leading(place: Configuration) -> Array:
    """± the right singular vectors of D as a matrix: for corank 1 the first is the best there is to first order."""
    n = len(place.q)
    if place.corank:
        rank = place.rank
    else:
        rank = place.generic - 1
    slopes = np.moveaxis(place.derivative * place.scale, -1, 0)  # (n, m, n)
    d = (place.u[:, rank:].T @ slopes @ place.v[:, rank:]).transpose(1, 2, 0)
    if not place.corank:  # the gradient of σ_r itself
        d = d[:1, :1]
    _, sigma, vt = np.linalg.svd(d.reshape(-1, n), full_matrices=False)
    leading = vt[sigma > place.floor]
    return np.concatenate([leading, -leading])


class _Decomposed(NamedTuple):
    """u, σ and v of the Jacobians at configurations q (c, n)."""

    u: Array
    sigma: Array
    v: Array
    q: Array


def _decomposed(place: Configuration, motions: Array) -> _Decomposed:
    rows = np.ascontiguousarray(place.q + motions * place.scale)
    return _Decomposed(*_core.decompose(place.chain, place.view, rows), rows)


def _gradient(place: Configuration, here: _Decomposed) -> Array:
    """(c, n) ascent direction of σ_r there, in scaled coordinates: Σ (σ_r/σ_i)^8 u_iᵀ dJ v_i (AM eq. 7).

    The sum is over the lost singular values. For one of them it is the gradient; where several tie the gradient jumps
    and this does not.
    """
    u, sigma, v, rows = here.u, here.sigma, here.v, here.q
    derivative = _core.derivative(place.chain, place.view, rows)
    derivative = derivative.reshape(len(rows), place.task.m, place.robot.n, place.robot.n)
    lost = slice(min(place.rank, place.generic - 1), place.generic)
    sigma = np.maximum(sigma[:, lost], 1e-12)
    weights = (sigma[:, -1:] / sigma) ** _SOFT
    left, right = u[..., lost].swapaxes(1, 2), v[..., lost].swapaxes(1, 2)  # (c, k, m), (c, k, n)
    turned = (left @ derivative.reshape(len(rows), place.task.m, -1)).reshape(*right.shape, place.robot.n)
    slopes = (right[:, :, None] @ turned)[:, :, 0]  # (c, k, n)
    return np.asarray((weights[:, None] @ slopes)[:, 0] * place.scale)
