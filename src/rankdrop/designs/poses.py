"""How well an arm does its task over a region of its workspace: at seeded poses in it, the best posture found of each.

    σ(pose) = max over the solutions q of the inverse found, within the limits, of σ_r(J(q))

The smallest of these over the region says how near to singular the arm has to come there, whatever posture it takes; a
posture that was missed can only make it larger, so that it is a bound from below at the poses looked at, and says
nothing between them. Solutions come from Newton's method with damping from random starts, all poses at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rankdrop.local.block import joint_scale, sample, singular_values
from rankdrop.motion.inverse import Aim
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.transform import from_xyz_rpy
from rankdrop.task import Task

_ITERATIONS = 40
_LONGEST = 0.5  # of a step [rad; slides scaled]
_CLOSE = 1e-9  # |e| at a solution: lengths divided by the length scale, angles in rad
_ROWS_OF_POSITION = 3


@dataclass(frozen=True, eq=False)
class Reached:
    """What was found at the poses of a region.

    Attributes:
        targets: (P, 4, 4) poses [m]; without an orientation only their places are meant.
        sigma: (P,) largest σ_r of a solution, NaN where none was found.
        q: (P, n) that solution.
        lowest: smallest σ_r of any solution; NaN where there is none.
    """

    targets: Array
    sigma: Array
    q: Array
    lowest: float

    @property
    def found(self) -> NDArray[np.bool_]:
        """(P,) poses with a solution."""
        return np.isfinite(self.sigma)

    @property
    def worst(self) -> int | None:
        """The pose at which the best posture is worst; None where no pose is reached."""
        return int(np.nanargmin(self.sigma)) if self.found.any() else None


def targets_of(lower: Array, upper: Array, rpy: Array | None, count: int, seed: int) -> Array:
    """(count, 4, 4) poses in a box of the base frame [m]: the same for every arm that is asked."""
    places = np.random.default_rng([seed, 5]).uniform(lower, upper, (count, 3))
    turned = from_xyz_rpy([0.0, 0.0, 0.0], [0.0, 0.0, 0.0] if rpy is None else rpy.tolist())
    found = np.repeat(turned[None], count, axis=0)
    found[:, :3, 3] = places
    return found


def reached(
    robot: Robot, task: Task, rank: int, targets: Array, *, oriented: bool, starts: int, seed: int, limits: bool
) -> Reached:
    """The best posture found at every pose.

    Args:
        robot: the arm.
        task: whose σ counts.
        rank: r, of its Jacobian almost everywhere.
        targets: (P, 4, 4) [m].
        oriented: the orientation is meant too, as far as the task has rows for it; else places alone.
        starts: random starts for each pose.
        seed: of the starts.
        limits: solutions within the joint limits only.
    """
    rows = tuple(row for row in task.rows if oriented or row < _ROWS_OF_POSITION)
    inner = Task(",".join(map(str, rows)), rows, task.frame, task.scale(robot))
    count = len(targets)
    q = sample(robot, task, count * starts, seed, limits=limits)
    which = np.repeat(np.arange(count), starts)
    good = _solve(robot, inner, targets[which], q)
    if limits:
        q, inside = _inside(robot, q)
        good &= inside
    sigma = np.where(good, singular_values(robot, q, task)[:, rank - 1], -np.inf).reshape(count, starts)
    best = sigma.argmax(axis=1)
    top = sigma[np.arange(count), best]
    lowest = sigma[np.isfinite(sigma)]
    return Reached(
        targets, np.where(np.isfinite(top), top, np.nan), q.reshape(count, starts, -1)[np.arange(count), best],
        float(lowest.min()) if len(lowest) else float("nan"),
    )  # fmt: skip


def _solve(robot: Robot, task: Task, targets: Array, q: Array) -> NDArray[np.bool_]:
    """Damped steps from q (N, n), in place, each to its own target (N, 4, 4): (N,) which arrived."""
    aim, scale = Aim(robot, task), joint_scale(robot, task)
    good = np.zeros(len(q), dtype=np.bool_)
    going = np.arange(len(q))
    for _ in range(_ITERATIONS):
        e = aim.error(targets[going], q[going])
        size = np.linalg.norm(e, axis=1)
        done = size <= _CLOSE
        good[going[done]] = True
        going, e, size = going[~done], e[~done], size[~done]
        if not len(going):
            break
        step = aim.step(q[going], e, np.minimum(size**2, 1.0))
        length = np.linalg.norm(step / scale, axis=1)
        q[going] += step * np.minimum(1.0, _LONGEST / np.maximum(length, 1e-300))[:, None]
    return good


def _inside(robot: Robot, q: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Solutions turned by whole turns into their limits where that is possible, and (N,) which are inside."""
    moved = np.array(q)
    inside = np.ones(len(q), dtype=np.bool_)
    for j, (low, high) in enumerate(zip(robot.lower, robot.upper, strict=True)):
        if robot.periodic[j]:
            middle = 0.5 * (low + high) if np.isfinite(low) and np.isfinite(high) else 0.0
            moved[:, j] -= 2 * np.pi * np.round((moved[:, j] - middle) / (2 * np.pi))
            if np.isfinite(low):
                moved[:, j] += 2 * np.pi * np.maximum(0, np.ceil((low - 1e-9 - moved[:, j]) / (2 * np.pi)))
        inside &= (moved[:, j] >= low - 1e-9) & (moved[:, j] <= high + 1e-9)
    return moved, inside
