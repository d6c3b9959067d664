"""The slowest straight motion that the joint rates allow, translations and rotations apart.

It is min s(d) over unit d, s the largest speed of `rankdrop.local.rates`. Attainable twists form a zonotope, so that
min s(d) is its distance from the origin to the nearest facet, measured in the subspace of straight motions: with
A = J diag(l) and y normal to a facet, scaled so that Σ|Aᵀy| = 1,

    slowest translation = min over facets of 1/|y_v|,   in the direction y_v.

The vectors c = Aᵀy of facets are the circuits of the null space: c ⟂ N, at most p + 1 entries for p null motions. A
joint that enters c is at its limit there. For as many joints as rows c has one entry, and y is a row of A⁻¹.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.kinematics import configurations, task_jacobian
from rankdrop.local.rates import TINY, null_circuits, rate_limits
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.units import in_metres, into_metres, task_in_metres

MOST_FACETS = 1_000
"""Candidates for a facet that are listed at most; 8 joints have 56."""


@dataclass(frozen=True, eq=False)
class Slowest:
    """The slowest straight motions of one kind at N configurations.

    Attributes:
        unit: "m/s" or "rad/s".
        speed: (N,) largest speed in the slowest direction; inf where rate limits bind no direction.
        direction: (N, 3) that direction, a unit vector in the task's axes.
        joint: (N,) the joint, from 1, that limits it most.
        normal: (N, m) normal y of the facet in the task's rows: directions that are slow there.
        exact: False where the arm has too many joints to list facets: the slowest motion is no faster than `speed`.
    """

    unit: str
    speed: Array
    direction: Array
    joint: NDArray[np.intp]
    normal: Array
    exact: bool


@dataclass(frozen=True, slots=True)
class StraightMotion:
    """The slowest straight motion of one kind: the tool translates without turning, or turns about its point.

    Attributes:
        unit: of speeds: "m/s" or "rad/s".
        speed: the largest within the rate limits of the joints; `limit`: below it the motion is slow.
        direction: (3,) unit vector in the axes of the task.
        number, joint: the joint that limits it most, from 1, and its name.
        exact: False for an arm of so many joints that this is a bound: the slowest motion is no faster.
    """

    unit: str
    speed: float
    limit: float
    direction: tuple[float, ...]
    number: int
    joint: str
    exact: bool


def slowest_motions(robot: Robot, q: ArrayLike, task: Task) -> tuple[Slowest, ...]:
    """Slowest straight translation (the tool does not turn) and rotation (the tool point stands still), batched.

    Args:
        robot: the arm; `Joint.velocity` are its rate limits, those of mimic joints included.
        q: (..., n) configurations [rad, m].
        task: rows that count; a kind of motion without rows in the task is left out.

    Returns:
        One record per kind, translation first. None at all without rate limits, or with more rows than joints.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("gen3")
        >>> slow = slowest_motions(arm, [0.3, 0.5, 0.2, 0.02, 0.4, 0.8, 0.1], resolve_task(None, arm))[0]
        >>> f"{slow.speed[0]:.4f} {slow.unit}", int(slow.joint[0])
        ('0.0022 m/s', 4)
    """
    rows, _ = configurations(robot, q)
    here, inside = in_metres(robot), task_in_metres(task, robot)
    limits = rate_limits(here)
    bounded = np.flatnonzero(np.isfinite(limits))
    spare = robot.n - task.m
    if spare < 0 or len(bounded) <= spare:
        return ()
    columns = task_jacobian(here, into_metres(robot, rows), inside) * np.where(np.isfinite(limits), limits, 1.0)
    u, sigma, vt = np.linalg.svd(columns)
    facets = null_circuits(vt[:, task.m :], bounded, MOST_FACETS)
    exact = facets is not None
    if facets is None:  # directions that cost most stand in: each bounds the slowest speed from above
        facets = vt[:, : task.m] * np.isfinite(limits)
    facets = facets / np.maximum(np.abs(facets).sum(axis=-1, keepdims=True), TINY)
    normals = (facets @ vt[:, : task.m].swapaxes(1, 2) / np.maximum(sigma, TINY)[:, None]) @ u.swapaxes(1, 2)
    scale = np.array([inside.scale(here) if row < 3 else 1.0 for row in task.rows])
    normals = normals / scale  # of twists in m/s and rad/s
    parts = (("m/s", [i for i, row in enumerate(task.rows) if row < 3]),
             ("rad/s", [i for i, row in enumerate(task.rows) if row >= 3]))  # fmt: skip
    return tuple(_slowest(unit, part, facets, normals, task, exact) for unit, part in parts if part)


def _slowest(unit: str, part: list[int], facets: Array, normals: Array, task: Task, exact: bool) -> Slowest:
    """The nearest facet for motions in the rows `part` alone."""
    size = np.linalg.norm(normals[..., part], axis=-1)
    best = size.argmax(axis=1)
    each = np.arange(len(best))
    longest = size[each, best]
    normal = normals[each, best]
    direction = np.zeros((len(best), 3))
    direction[:, [task.rows[i] % 3 for i in part]] = normal[:, part] / np.maximum(longest, TINY)[:, None]
    speed = np.where(longest > 0.0, 1.0 / np.maximum(longest, TINY), np.inf)
    return Slowest(unit, speed, direction, np.abs(facets[each, best]).argmax(axis=1) + 1, normal, exact)
