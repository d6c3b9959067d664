"""Rotations: exact where they can be, and made of what is nearly one."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rankdrop.robot.transform import cos_sin, rigid


@given(st.integers(-40, 40))
def test_cos_sin_is_exact_at_quarter_turns_and_near_the_library_elsewhere(quarter: int) -> None:
    assert set(map(abs, cos_sin(quarter * (pi / 2)))) == {0.0, 1.0}
    assert cos_sin(quarter * 0.1 + 0.01) == (cos(quarter * 0.1 + 0.01), sin(quarter * 0.1 + 0.01))


def test_a_matrix_that_is_nearly_a_rotation_becomes_one() -> None:
    """By Newton's step, to the rotation that is nearest: that of the singular value decomposition."""
    rng = np.random.default_rng(0)
    for _ in range(50):
        u, _, vt = np.linalg.svd(rng.normal(size=(3, 3)))
        given = np.eye(4)
        given[:3, :3] = u @ vt * np.sign(np.linalg.det(u @ vt)) + rng.uniform(-1e-7, 1e-7, (3, 3))
        u, _, vt = np.linalg.svd(given[:3, :3])
        made = rigid(given, "here")[:3, :3]
        np.testing.assert_allclose(made, u @ vt, rtol=0, atol=2e-15)
        np.testing.assert_allclose(made.T @ made, np.eye(3), rtol=0, atol=1e-15)
