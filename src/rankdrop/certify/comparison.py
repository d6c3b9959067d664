"""The test that ends every proof: is a matrix regular, however its entries may be off?"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rankdrop.robot.model import Array


def regular(sigma: Array, bound: Array) -> NDArray[np.bool_]:
    """(P,) is Σ + E regular for every |E| ≤ bound: is the matrix with Σ_ii − B_ii and −B_ij an M-matrix?

    It is one if it maps some positive vector to a positive one; the vector is found by elimination and multiplied out.

    Example:
        >>> sigma, half = np.ones((1, 2)), np.full((1, 2, 2), 0.5)
        >>> bool(regular(sigma, 0.99 * half)[0]), bool(regular(sigma, half)[0])
        (True, False)
    """
    rank = sigma.shape[1]
    matrix = -bound
    matrix[:, np.arange(rank), np.arange(rank)] += sigma
    ok = np.asarray(np.isfinite(matrix).all(axis=(1, 2)))
    rows = np.where(ok[:, None, None], matrix, np.eye(rank))
    y = np.ones((len(rows), rank))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        left = rows.copy()
        for p in range(rank):
            ok &= left[:, p, p] > 0.0
            pivot = np.where(ok, left[:, p, p], 1.0)
            for a in range(p + 1, rank):
                times = left[:, a, p] / pivot
                left[:, a] -= times[:, None] * left[:, p]
                y[:, a] -= times * y[:, p]
        for a in range(rank - 1, -1, -1):
            y[:, a] -= (left[:, a, a + 1 :] * y[:, a + 1 :]).sum(axis=1)
            y[:, a] /= np.where(ok, left[:, a, a], 1.0)
        ok = np.asarray(ok & (y > 0.0).all(axis=1) & np.isfinite(y).all(axis=1))
        y = np.where(ok[:, None], y, 1.0)
        product = np.einsum("pab,pb->pa", rows, y)
        size = np.einsum("pab,pb->pa", np.abs(rows), y)
    return np.asarray(ok & (product > 1e-14 * size).all(axis=1))
