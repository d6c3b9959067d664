"""A readable basis of a subspace: orthonormal, with as many zeros as plane rotations find."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rankdrop import _core
from rankdrop.errors import OptionError
from rankdrop.robot.model import Array

_DEPENDENT = 1e-9  # columns of the input more dependent than this span nothing certain


def readable_basis(B: ArrayLike) -> Array:
    """Orthonormal basis of span(B) with the fewest non-zero entries, found by plane (Givens) rotations (AM 2.3).

    Among bases with as few entries it has the smallest sum of absolute values. Rotating columns a, b by φ changes that
    sum to Σ_i r_i (|cos(φ − α_i)| + |sin(φ − α_i)|) with r_i e^{jα_i} = a_i + j b_i. Each term is concave between the
    angles where an entry vanishes, so the best φ is one of these few angles: a plane step is exact and makes an entry
    exactly zero. Sweeps over all planes start from many bases that depend on the subspace only (zeros forced at every
    choice of rows), and the best result is kept. Then every basis is tried (with bounds) whose vectors, one after the
    other, vanish in as many rows as what is left of the space allows: a planted one of this kind is always found. For
    k = 2 the result is the global minimum; for k ≥ 3 it is a search.

    Sign: the largest entry of every column is positive (the first of them, if tied). Order: by the row of the largest
    entry. Ties (sums within 1e-6): the larger |entries| in the earlier rows; the choice is the same for every basis of
    one subspace, but jumps where the subspace passes through a tie, e.g. at a plane normal to (1, 1, 1).
    The result depends on the axes and on the unit of length, as every basis of mixed twists does.

    Args:
        B: (m, k) independent columns, k ≤ m; they need not be orthonormal.

    Returns:
        (m, k) orthonormal columns.

    Raises:
        OptionError: not a finite matrix, or its columns are dependent.

    Example:
        >>> readable_basis([[0.6, -0.8], [0.8, 0.6], [0, 0]]).round(9).tolist()
        [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]
    """
    columns = np.asarray(B, dtype=np.float64)
    if columns.ndim != 2 or not np.isfinite(columns).all():
        raise OptionError("a basis is a finite (m, k) matrix", got=columns.shape, allowed="shape (m, k), k ≤ m")
    rows, count = columns.shape
    if count == 0:
        return np.zeros((rows, 0))
    u, sigma, vt = np.linalg.svd(columns, full_matrices=False)
    if count > rows or sigma[-1] <= _DEPENDENT * sigma[0]:
        raise OptionError("the columns of a basis are independent", got=f"singular values {sigma.tolist()}")
    return np.asarray(readable_bases((u @ vt)[None])[0])


def readable_bases(orthonormal: Array) -> Array:
    """`readable_basis` of many subspaces at once.

    Args:
        orthonormal: (B, m, k) orthonormal columns, 1 ≤ k ≤ m.

    Returns:
        (B, m, k) orthonormal columns.
    """
    return _core.readable(np.ascontiguousarray(orthonormal))
