"""The bracket of two screws: what one joint's motion does to another's, ∂S_i/∂q_k = [S_k, S_i] for k < i.

Twists are (v; ω), all in one frame. GR write the same product with the direction first: `lie_product`.
"""

from __future__ import annotations

import numpy as np

from rankdrop.robot.model import Array


def cross(a: Array, b: Array) -> Array:
    """(..., 3) a × b; several times faster than NumPy's on small arrays."""
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    u, v, w = b[..., 0], b[..., 1], b[..., 2]
    first = y * w - z * v
    out = np.empty((*first.shape, 3))
    out[..., 0], out[..., 1], out[..., 2] = first, z * u - x * w, x * v - y * u
    return out


def hat(a: Array) -> Array:
    """(..., 3, 3) [a] with [a] b = a × b."""
    matrix = np.zeros((*a.shape[:-1], 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        matrix[..., k, j], matrix[..., j, k] = a[..., i], -a[..., i]
    return matrix


def unit(vectors: Array) -> Array:
    """(..., n) the same directions with length 1; zero stays zero."""
    squares = np.add.reduce(vectors * vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.maximum(np.sqrt(squares), 1e-300))


def bracket(left: Array, right: Array) -> Array:
    """(..., 6) [A, B] = (ω_A × v_B + v_A × ω_B ; ω_A × ω_B) of twists (..., 6), broadcast."""
    va, wa, vb, wb = left[..., :3], left[..., 3:], right[..., :3], right[..., 3:]
    return np.concatenate([cross(wa, vb) + cross(va, wb), cross(wa, wb)], axis=-1)


def brackets(screws: Array) -> Array:
    """Every bracket of two joint screws that a motion makes: [S_a, S_i] for i > a, else 0.

    Args:
        screws: (6, N) columns (v; ω), all in one frame.

    Returns:
        (N, 6, N): [a, :, i].
    """
    columns = screws.T
    every = bracket(columns[:, None, :], columns[None, :, :])  # (N, N, 6)
    later = np.triu(np.ones((len(columns), len(columns))), 1)
    return np.swapaxes(every * later[..., None], -1, -2)
