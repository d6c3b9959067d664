"""Singular configurations near a given one, and upper bounds on the distance to them."""

from __future__ import annotations

import numpy as np

from rankdrop.families.searching import Outcome, refine
from rankdrop.local.block import block, generic_rank, singular_values
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task


def wrapped(robot: Robot, difference: Array) -> Array:
    """Differences of configurations, whole turns taken out."""
    turns = robot.periodic
    out = difference.copy()
    out[..., turns] -= 2 * np.pi * np.round(out[..., turns] / (2 * np.pi))
    return out


def cloud(robot: Robot, task: Task, starts: Array, seed: int = 0) -> Array:
    """Singular configurations reached from the starts, polished; σ at most 1e-12."""
    found = refine(robot, starts, 1, task=task, seed=seed)
    q = found.q[found.outcome == Outcome.CONVERGED]
    return q[singular_values(robot, q, task)[:, generic_rank(robot, task) - 1] < 1e-12]


def distances(robot: Robot, q: Array, points: Array, scale: Array, matters: Array) -> Array:
    """(P,) distance of each point from q in the variables that matter, in units of scale."""
    return np.linalg.norm((wrapped(robot, points - q) / scale)[:, matters], axis=1)


def nearest(robot: Robot, task: Task, q: Array, points: Array, scale: Array, matters: Array, rounds: int = 30) -> float:
    """An upper bound on the distance: the cloud's nearest points, slid along the singular set towards q."""
    rank = generic_rank(robot, task) - 1
    order = np.argsort(distances(robot, q, points, scale, matters))[:24]
    x = q + wrapped(robot, points[order] - q)
    best = float(distances(robot, q, points[order], scale, matters).min())
    for _ in range(rounds):
        parts = block(robot, x, task, rank)
        slope = parts.d.reshape(len(x), -1, robot.n) * (scale * matters)
        value = parts.f.reshape(len(x), -1, 1)
        away = ((x - q) / scale * matters)[..., None]
        step = (np.linalg.pinv(slope, rcond=1e-6) @ (slope @ away - value))[..., 0] - away[..., 0]
        size = np.linalg.norm(step, axis=1, keepdims=True)
        x = x + step * np.minimum(1.0, 0.3 / np.maximum(size, 1e-12)) * scale
        good = singular_values(robot, x, task)[:, rank] < 1e-9
        if good.any():
            best = min(best, float(distances(robot, q, x[good], scale, matters).min()))
    return best
