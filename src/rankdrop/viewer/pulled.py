"""Inverse kinematics of the handle at the tip: the damped inverse of the product, step by step after the hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rankdrop.kinematics import pose
from rankdrop.local import damped_inverse
from rankdrop.robot import Array, Robot
from rankdrop.task import WORLD_ALIGNED, Task

STEPS = 12  # of one pull: what a hand moves in a thirtieth of a second takes three
DAMPING, THRESHOLD = 0.08, 0.12  # λ₀ and ε of `damped_inverse`: no damping away from singularities
_MOST = 0.25  # of one step, in joints [rad] and lengths per length scale
_THERE = 1e-6  # what may be missing at the end [length scales, rad]


def pulled(robot: Robot, task: Task, q: Array, target: Array) -> tuple[Array, float]:
    """From q towards a pose of the tip, inside the joint limits.

        q ← q + J⁺(λ) e,  e = (Δp; θ u)

    with the damped inverse of `rankdrop.local.damped_inverse`. Only what the task asks for is followed: an arm for
    positions keeps its orientation free.

    Args:
        robot, task: the arm.
        q: (n,) where it is [rad, m].
        target: (4, 4) pose of the tip in the base frame.

    Returns:
        (n,) the nearest configuration met, and what is missing there: ‖(Δp / length scale; θ)‖ of the task's rows.
    """
    along = replace(task, frame=WORLD_ALIGNED)
    lower, upper = np.minimum(robot.lower, q), np.maximum(robot.upper, q)  # where it stands beyond a limit it may stay
    best, missing = q, _missing(robot, along, q, target)
    for _ in range(STEPS):
        if missing <= _THERE:
            break
        twist = _twist(robot, best, target)[list(along.rows)]
        step = damped_inverse(robot, best, along, damping=DAMPING, threshold=THRESHOLD) @ twist
        step *= min(1.0, _MOST / max(float(np.abs(step).max()), 1e-12))
        further = np.clip(best + step, lower, upper)
        left = _missing(robot, along, further, target)
        if left >= missing:
            break
        best, missing = further, left
    return best, missing


def _twist(robot: Robot, q: Array, target: Array) -> Array:
    """(6,) what is missing from the pose at q to the target, in the axes of the base [m, rad]."""
    at = pose(robot, q)
    turned = target[:3, :3] @ at[:3, :3].T
    axis = 0.5 * np.array([turned[2, 1] - turned[1, 2], turned[0, 2] - turned[2, 0], turned[1, 0] - turned[0, 1]])
    sine = float(np.linalg.norm(axis))
    angle = np.arctan2(sine, 0.5 * (np.trace(turned) - 1.0))
    turn = axis * (angle / sine) if sine > 1e-12 else axis
    return np.concatenate([target[:3, 3] - at[:3, 3], turn])


def _missing(robot: Robot, task: Task, q: Array, target: Array) -> float:
    twist = _twist(robot, q, target) / np.array([task.scale(robot)] * 3 + [1.0] * 3)
    return float(np.linalg.norm(twist[list(task.rows)]))
