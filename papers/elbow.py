"""The elbow arm with spherical wrist that ML and JL speak of, and what both need of it."""

from __future__ import annotations

from functools import cache

import numpy as np

from papers.formula import value
from rankdrop import conditions
from rankdrop.exact import Decoupling, decouple, exact_chain
from rankdrop.kinematics import jacobian
from rankdrop.local import sample, singular_values
from rankdrop.robot import Array, Robot, from_dh
from rankdrop.task import Task, resolve_task

LENGTHS = {"a2": 0.5, "a3": 0.4}
"""Lengths for the letters of the lectures [m]."""
FOREARM_LINE = "a2 c2 + a3 c23"
"""Distance of the wrist centre from axis 1 of the elbow arm."""


def angles(robot: Robot, count: int, seed: int) -> Array:
    """(count, n) random configurations."""
    return sample(robot, resolve_task(None, robot), count, seed)


def worst(one: Array, other: Array) -> float:
    """Largest difference."""
    return float(np.abs(np.asarray(one) - np.asarray(other)).max())


@cache
def elbow_arm() -> Robot:
    """The lectures' elbow arm with spherical wrist: a2 = 0.5 m, a3 = 0.4 m, wrist centre to tip 0.1 m.

    The origins of frames 3, 4, 5 are in the wrist centre, and θ3 = 0 is the straight arm.
    """
    rows = [(0, "pi/2", 0, 0), (LENGTHS["a2"], 0, 0, 0), (LENGTHS["a3"], "pi/2", 0, 0),
            (0, "-pi/2", 0, 0), (0, "pi/2", 0, 0), (0, 0, 0.1, 0)]  # fmt: skip
    return from_dh(rows, convention="standard", name="elbow arm")


@cache
def decoupled() -> Decoupling:
    """The elbow arm with spherical wrist taken apart into arm and wrist."""
    found = decouple(exact_chain(elbow_arm(), lengths=LENGTHS))
    assert found is not None
    return found


@cache
def shoulder_text() -> str:
    """The exact condition of the elbow arm that ties joints 2 and 3."""
    found = conditions(elbow_arm(), lengths=LENGTHS, coranks=1, points=0, special=False)
    return next(family.texts[0] for family in found.families if family.coupled)


def arm_sign(alpha: str) -> Array:
    """(20,) det J11 of the elbow arm divided by a2 a3 s3 (a2 c2 + a3 c23): its sign for α1 = ±π/2."""
    rows = [(0, alpha, 0, 0), (LENGTHS["a2"], 0, 0, 0), (LENGTHS["a3"], 0, 0, 0)]
    arm = from_dh(rows, convention="standard", task="position")
    q = angles(arm, 20, 5)
    return np.asarray(np.linalg.det(jacobian(arm, q)[:, :3]) / value(f"a2 a3 s3 ({FOREARM_LINE})", q, LENGTHS))


def on_shoulder() -> Array:
    """(B, 6) configurations of the elbow arm with a2 c2 + a3 c23 = 0, clear of the elbow singularity: θ3 from θ2."""
    q = angles(elbow_arm(), 80, 7)
    ratio = -LENGTHS["a2"] * np.cos(q[:, 1]) / LENGTHS["a3"]
    q, ratio = q[np.abs(ratio) < 0.9], ratio[np.abs(ratio) < 0.9]
    q[:, 2] = np.arccos(ratio) - q[:, 1]
    return np.asarray(q[np.abs(np.sin(q[:, 2])) > 0.2])


def rank_of(robot: Robot, q: Array, task: str | Task | None = None) -> int:
    """Singular values above 1e-9."""
    return int((singular_values(robot, q, resolve_task(task, robot)) > 1e-9).sum())
