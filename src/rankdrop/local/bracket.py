"""The bracket of two screws: what one joint's motion does to another's, ∂S_i/∂q_k = [S_k, S_i] for k < i.

Twists are (v; ω), all in one frame. GR write the same product with the direction first: `lie_product`.
"""

from __future__ import annotations

import numpy as np

from rankdrop.local.vectors import cross
from rankdrop.robot.model import Array


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
