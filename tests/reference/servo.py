"""The rule of MoveIt Servo (moveit_servo, `velocityScalingFactorForSingularity`) as it is described, for comparison.

κ is the ratio of the largest to the smallest singular value of the Jacobian in metres and radians. One direction,
the left singular vector of the smallest, is turned to where κ grows; a twist along it is one towards the singularity.
Between a lower threshold and the hard stop the twist is scaled down, more gently when leaving; from the hard stop on it
halts whatever the direction. Defaults: 17, 30, factor 2 for leaving. Arms with fewer than six joints are taken with as
many singular values as they have (pull request 3750 of moveit2); before, memory beyond the last was read.
"""

from __future__ import annotations

import numpy as np

import rankdrop
from rankdrop.robot.model import Array, Robot

LOWER, HARD_STOP, LEAVING, STEP = 17.0, 30.0, 2.0, 0.01


def condition(robot: Robot, q: Array) -> float:
    """κ at q (n,)."""
    sigma = np.linalg.svd(rankdrop.jacobian(robot, q), compute_uv=False)
    return float(sigma[0] / sigma[-1]) if sigma[-1] > 0 else np.inf


def servo_scaling(robot: Robot, q: Array, twist: Array) -> float:
    """What the rule multiplies a twist (6,) by at q (n,)."""
    j = rankdrop.jacobian(robot, q)
    u, sigma, vt = np.linalg.svd(j, full_matrices=False)
    kappa = sigma[0] / sigma[-1] if sigma[-1] > 0 else np.inf
    if kappa >= HARD_STOP:
        return 0.0
    if kappa <= LOWER:
        return 1.0
    towards = u[:, -1]
    if condition(robot, q + vt.T @ (u.T @ towards * STEP / sigma)) <= kappa:
        towards = -towards
    width = (HARD_STOP - LOWER) * (1.0 if towards @ twist > 0 else LEAVING)
    return float(1.0 - (kappa - LOWER) / width)
