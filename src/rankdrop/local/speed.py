"""The largest speed along a direction that bounded joint rates allow: a small linear programme, solved exactly.

    maximise s  subject to  A ẋ = s d,  |ẋ_i| ≤ l_i

All solutions are ẋ = s (b + N z), b = A⁺d, N a basis of the null space, so that 1/s = min_z max_i |b_i + N_i z| / l_i:
the best approximation of b in the maximum norm. Its dual is a maximum over the vertices of
{y : Σ_i y_i N_i / l_i = 0, Σ|y_i| ≤ 1}. These are the circuits of the weighted rows of N: minimal sets of rows that are
dependent, at most k + 1 of them for k null motions. For a handful of joints all are listed, and serve every d.
"""

from __future__ import annotations

from itertools import combinations
from math import comb

import numpy as np

from rankdrop.robot.model import Array

MOST = 200_000  # vertices that are listed at most; 8 joints need 70
_FLAT = 1e-12  # singular values of weighted null motions below this share are zero: rounding of unit vectors


def largest_speeds(particular: Array, null: Array, limits: Array) -> tuple[Array, bool]:
    """Largest s with ẋ = s (b + N z) inside |ẋ_i| ≤ l_i, for many b at once.

    Args:
        particular: (k, n) joint rates b for unit speed along each direction, any solution of A b = d.
        null: (n, p) basis of the null space of A; p = 0 allowed.
        limits: (n,) l_i ≥ 0, inf allowed. A joint with l_i = 0 stands still.

    Returns:
        (k,) speeds: 0 where only motion of a joint with limit 0 would do it, inf where no limit holds it back. Then
        whether they are the exact maxima; if there were too many vertices, they are those of the best of b alone.

    Example:
        >>> speeds, exact = largest_speeds(np.array([[0.5, 0.5]]), np.array([[1.0], [-1.0]]), np.array([1.0, 3.0]))
        >>> speeds.round(9).tolist(), exact  # two joints in line: their limits add
        ([4.0], True)
    """
    stuck = limits == 0.0
    reachable = np.ones(len(particular), dtype=bool)
    if stuck.any():
        particular, null, reachable = _standing(particular, null, stuck)
    bounded = np.isfinite(limits) & ~stuck
    wanted = particular[:, bounded] / limits[bounded]
    rows = null[bounded] / limits[bounded, None]
    vertices, exact = _vertices(rows)
    needed = np.abs(wanted @ vertices.T).max(axis=1, initial=0.0)
    noise = 1e-14 * np.abs(wanted).max(axis=1, initial=0.0)  # what remains of a rate that others take over completely
    speeds = np.where(needed > noise, 1.0 / np.where(needed > noise, needed, 1.0), np.inf)
    return np.where(reachable, speeds, 0.0), exact


def _vertices(rows: Array) -> tuple[Array, bool]:
    """(c, n) vertices y of the dual, Σ|y| = 1, up to sign; and whether they are all."""
    count = len(rows)
    if rows.shape[1] == 0 or count == 0:
        return np.eye(count), True
    u, sigma, _ = np.linalg.svd(rows, full_matrices=False)
    rank = int((sigma > _FLAT * max(sigma[0], np.finfo(float).tiny)).sum())
    if rank == 0:
        return np.eye(count), True
    if rank == count:
        return np.zeros((1, count)), True  # every rate can be taken over by null motion
    if comb(count, rank + 1) > MOST:
        return np.eye(count), False
    chosen = np.array(list(combinations(range(count), rank + 1)))
    circuits = np.linalg.svd(u[:, :rank][chosen].swapaxes(1, 2))[2][:, -1]  # dependency of the rank + 1 rows
    vertices = np.zeros((len(chosen), count))
    np.put_along_axis(vertices, chosen, circuits / np.abs(circuits).sum(axis=1, keepdims=True), axis=1)
    return vertices, True


def _standing(particular: Array, null: Array, stuck: Array) -> tuple[Array, Array, Array]:
    """Solutions in which the stuck joints stand still: new b and N, and where there are any."""
    u, sigma, vt = np.linalg.svd(null[stuck])
    rank = int((sigma > _FLAT).sum())
    z = -(particular[:, stuck] @ u[:, :rank] / sigma[:rank]) @ vt[:rank]
    moved = particular + z @ null.T
    size = np.abs(particular).max(axis=1, initial=0.0)
    reachable = np.abs(moved[:, stuck]).max(axis=1, initial=0.0) <= 1e-9 * np.maximum(size, np.finfo(float).tiny)
    return moved, null @ vt[rank:].T, reachable
