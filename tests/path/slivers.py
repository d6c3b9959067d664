"""Proofs of a path, singular configurations to aim it at, and a path that dips towards the wrist singularity."""

from __future__ import annotations

import numpy as np

from rankdrop.cover.setting import settings_for
from rankdrop.families.searching import Outcome, search
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.path.check.prove import Proof, prove
from rankdrop.path.curve import Curve
from rankdrop.robot.model import Robot
from rankdrop.task import Task


def proven(robot: Robot, task: Task, path: Curve, evaluations: int = 2_000_000) -> Proof:
    return prove(robot, settings_for(robot, task), path, singular=1e-9, evaluations=evaluations)


def singular(robot: Robot, task: Task, corank: int, count: int) -> np.ndarray:
    """Exact singular configurations, to rounding."""
    found = search(robot, corank, task=task, starts=3 * count, seed=5)
    q = found.q[found.outcome == Outcome.CONVERGED]
    rank = generic_rank(robot, task) - corank
    q = q[singular_values(robot, q, task)[:, rank] < 1e-13]
    return q[:count]


def dip(depth: float, seconds: float = 5.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """PUMA: θ5 = 0.05 (t − 2.5)² − depth, the others on their way."""
    start, end = np.array([0.1, -1.2, 1.0, 0.5, 0.0, 0.2]), np.array([0.5, -1.0, 1.3, 0.2, 0.0, 0.1])
    v = np.stack([(end - start) / seconds] * 2)
    q = np.stack([start, end])
    q[:, 4], v[:, 4] = 0.05 * (seconds / 2) ** 2 - depth, [-0.05 * seconds, 0.05 * seconds]
    return q, v, np.array([0.0, seconds])
