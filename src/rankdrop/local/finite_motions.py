"""Finite motions inside the joint limits, and the motion of a given length that restores most."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop._handles import chain_of, task_view
from rankdrop.local.block import decompose, singular_values
from rankdrop.local.place import Place, judge_steps, room
from rankdrop.local.taylor import taylor
from rankdrop.local.vectors import unit
from rankdrop.robot.model import Array

_Indices = NDArray[np.intp]

_ANGLES = 16  # directions tried per pair, then refined
_CLIMBS = 6  # steps of the climb towards the best direction
_SOFT = 8  # power by which the smallest of the lost singular values weighs more than the next
_RANDOM = 24  # random starts of it


def measured_gains(place: Place, directions: Array) -> Array:
    """(d,) rank after a finite motion along each direction (d, n), minus the rank before: the largest of several."""
    motions = judge_steps(place, directions)[..., None] * directions  # (4, d, n)
    sigma = singular_values(place.robot, place.q + motions * place.scale, place.task)
    ranks = np.minimum((sigma > place.floor).sum(axis=-1), place.generic)
    return np.asarray(ranks.max(axis=0) - place.rank)


def single_motions(place: Place, step: float) -> tuple[Array, Array]:
    """The better of the two motions of each joint by `step`, cut off at its limits.

    Returns:
        (n,) signed motion in scaled coordinates, and (n,) σ_r after it.
    """
    down, up = room(place)
    steps = np.stack([np.minimum(step, up), -np.minimum(step, down)])  # (2, n)
    sigma = place.last(place.q + steps[..., None] * np.diag(place.scale))
    better = np.argmax(sigma - 1e-12 * np.array([[0.0], [1.0]]), axis=0)  # ties go up
    joints = np.arange(len(place.q))
    return steps[better, joints], sigma[better, joints]


def fitted(place: Place, motions: Array) -> Array:
    """Motions (..., n) in scaled coordinates, cut off at the limits."""
    down, up = room(place)
    return np.asarray(np.clip(motions, -down, up))


def best_pair(place: Place, step: float) -> Array:
    """The motion (n,) of two joints, of length `step` at most, that restores most; inside the limits.

    All pairs and a circle of directions in one call, then the best few pairs again, finer and finer.
    """
    n = len(place.q)
    pairs = np.array(list(combinations(range(n), 2)))
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


def best_motion(place: Place, step: float, seed: int, tried: Array) -> Array:
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
    motions = fitted(place, step * unit(candidates))
    best = motions[_order(place, motions)[0]]
    for turn in range(_CLIMBS):
        if turn == 1:  # after the first step half of the field tells enough
            motions = motions[_order(place, motions)[:12]]
        ahead = unit(_gradient(place, motions))
        if place.corank > 1 and turn:  # half the way: between ties the whole way swings from side to side
            ahead = unit(ahead + unit(motions))
        motions = fitted(place, step * ahead)
        best = _better(place, best, motions)
    widths = (0.3, 0.1, 0.03) if place.corank < 2 else (0.5, 0.3, 0.2, 0.1, 0.05, 0.02)  # ridges where σ's tie
    for width in widths:
        around = unit(unit(best[None]) + width * rng.normal(size=(32, len(best))) / np.sqrt(len(best)))
        best = _better(place, best, fitted(place, step * around))
    return np.asarray(best)


def scores(place: Place, motions: Array) -> Array:
    """(..., 2) what motions (..., n) reach: rank, and the singular value that holds it."""
    sigma = singular_values(place.robot, place.q + motions * place.scale, place.task)[..., : place.generic]
    ranks = (sigma > place.floor).sum(axis=-1)
    held = np.take_along_axis(sigma, np.maximum(ranks - 1, 0)[..., None], axis=-1)[..., 0]
    return np.stack([ranks, held], axis=-1)


def _order(place: Place, motions: Array) -> _Indices:
    reached = scores(place, motions)
    return np.lexsort((-reached[:, 1], -reached[:, 0]))


def _better(place: Place, best: Array, motions: Array) -> Array:
    every = np.concatenate([best[None], motions])
    return np.asarray(every[_order(place, every)[0]])


def _best_of_each(place: Place, motions: Array) -> tuple[_Indices, _Indices]:
    """Of motions (p, a, n): the best a of each p, and the p from the best to the worst."""
    reached = scores(place, motions)
    value = reached[..., 0] * 1e6 + reached[..., 1]  # σ of scaled Jacobians is far below 1e6
    best = np.argmax(value, axis=1)
    return best, np.argsort(-value[np.arange(len(best)), best], kind="stable")


def _on_circle(place: Place, pairs: _Indices, angles: Array, step: float) -> Array:
    motions = np.zeros((*angles.shape, len(place.q)))
    every = np.broadcast_to(pairs, (*angles.shape, 2))
    np.put_along_axis(motions, every[..., :1], step * np.cos(angles)[..., None], axis=-1)
    np.put_along_axis(motions, every[..., 1:], step * np.sin(angles)[..., None], axis=-1)
    return fitted(place, motions)


def _leading(place: Place) -> Array:
    """± the right singular vectors of D as a matrix: for corank 1 the first is the best there is to first order."""
    n = len(place.q)
    rank = place.rank if place.corank else place.generic - 1
    series = taylor(place.robot, place.q, place.task, np.diag(place.scale), 1)
    d = np.einsum("mp,jmn,ns->psj", place.u[:, rank:], series[1], place.v[:, rank:])
    if not place.corank:  # the gradient of σ_r itself
        d = d[:1, :1]
    _, sigma, vt = np.linalg.svd(d.reshape(-1, n), full_matrices=False)
    leading = vt[sigma > place.floor]
    return np.concatenate([leading, -leading])


def _gradient(place: Place, motions: Array) -> Array:
    """(c, n) ascent direction of σ_r at q + motion, in scaled coordinates: Σ (σ_r/σ_i)^8 u_iᵀ dJ v_i (AM eq. 7).

    The sum is over the lost singular values. For one of them it is the gradient; where several tie the gradient jumps
    and this does not.
    """
    rows = np.ascontiguousarray(place.q + motions * place.scale)
    parts = decompose(place.robot, rows, place.task)
    derivative = _core.derivative(chain_of(place.robot), task_view(place.robot, place.task), rows)
    derivative = derivative.reshape(len(rows), place.task.m, place.robot.n, place.robot.n)
    lost = slice(min(place.rank, place.generic - 1), place.generic)
    sigma = np.maximum(parts.sigma[:, lost], 1e-12)
    weights = (sigma[:, -1:] / sigma) ** _SOFT
    slopes = np.einsum("cmk,cmij,cik->ckj", parts.u[..., lost], derivative, parts.v[..., lost], optimize=True)
    return np.asarray(np.einsum("ck,ckj->cj", weights, slopes) * place.scale)
