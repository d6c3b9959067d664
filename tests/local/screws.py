"""Screws that meet, are parallel, or only slide."""

from __future__ import annotations

import numpy as np
from reference import arms

from rankdrop.robot.model import Array
from rankdrop.robot.screws import prismatic, revolute

Z = (0.0, 0.0, 1.0)
C = (0.3, -0.2, 0.5)  # where axes meet


def other(count: int, seed: int = 5) -> list[Array]:
    """Axes in general position."""
    return [joint.screw for joint in arms.random_chain(np.random.default_rng(seed), "r" * count).joints]


def concurrent(count: int, seed: int = 6) -> list[Array]:
    return [revolute(axis, C) for axis in np.random.default_rng(seed).normal(size=(count, 3))]


def parallel(count: int, seed: int = 7) -> list[Array]:
    return [revolute(Z, point) for point in np.random.default_rng(seed).normal(size=(count, 3))]


def slides(count: int, seed: int = 8) -> list[Array]:
    return [prismatic(axis) for axis in np.random.default_rng(seed).normal(size=(count, 3))]
