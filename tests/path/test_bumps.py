"""Bumps of the joints around a singular place of a path."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.path.mend.bumps import least_motion
from rankdrop.robot.model import Array


def test_no_joint_motion_along_the_normal_moves_the_tool_less(rng: np.random.Generator) -> None:
    """Against random changes of the motion; least squares with equal weights, the method before, move it farther."""
    ways, gains = np.arange(6) < 3, []

    def size(jacobian: Array, motion: Array) -> Array:
        moved = motion @ jacobian.T
        return np.linalg.norm(moved[..., :3], axis=-1) + np.linalg.norm(moved[..., 3:], axis=-1)

    for _ in range(10):
        jacobian, normal = rng.normal(size=(6, 6)), rng.normal(size=6)
        normal /= np.linalg.norm(normal)
        found = least_motion(jacobian, ways, normal)
        assert normal @ found == pytest.approx(1.0)
        change = rng.normal(size=(2000, 6)) * 10.0 ** rng.uniform(-3.0, 0.0, (2000, 1))
        change -= (change @ normal)[:, None] * normal
        assert size(jacobian, found + change).min() > 0.98 * size(jacobian, found)
        equal = np.linalg.solve(jacobian.T @ jacobian, normal)
        gains.append(size(jacobian, equal / (normal @ equal)) / size(jacobian, found))
    assert max(gains) > 1.1
