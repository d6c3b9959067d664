"""Postures of an arm at poses in a box of the workspace, and the best of them: the one with the largest σ.

    σ(pose) = max over the solutions q of the inverse found, within the limits, of σ_r(J(q))

Solutions come from Newton's method with damping from random starts, all poses at once. A posture that was missed can
only make σ(pose) larger.
"""

from __future__ import annotations

import numpy as np

from rankdrop.local import sample, singular_values
from rankdrop.local.slowest import slowest_motions
from rankdrop.poses import Aim
from rankdrop.problem import Mask, Problem, into_limits
from rankdrop.robot import Array, from_xyz_rpy
from rankdrop.task import Task

EDGE = 1e-9
"""A joint this far beyond a limit stands at it [rad, m]."""
CLOSE = 1e-9
"""|e| at a solution: lengths divided by the length scale, angles in rad."""
ROWS_OF_POSITION = 3
_ITERATIONS = 40
_CLIMB = (0.6, 0.4, 0.25, 0.15, 0.1, 0.06, 0.04, 0.02)  # steps of self-motions tried [rad]


def targets_of(lower: Array, upper: Array, rpy: Array | None, count: int, seed: int) -> Array:
    """(count, 4, 4) poses in a box of the base frame [m]: the same for every arm that is asked."""
    return poses_at(np.random.default_rng([seed, 5]).uniform(lower, upper, (count, 3)), rpy)


def poses_at(places: Array, rpy: Array | None) -> Array:
    """(P, 4, 4) poses at places (P, 3) [m], all with one orientation."""
    turned = from_xyz_rpy([0.0, 0.0, 0.0], [0.0, 0.0, 0.0] if rpy is None else rpy.tolist())
    poses = np.repeat(turned[None], len(places), axis=0)
    poses[:, :3, 3] = places
    return poses


class Postures:
    """Postures of an arm at poses, found by Newton's method with damping.

    Args:
        problem: the arm, the task of which σ counts, and whether postures have to be inside the joint limits.
        oriented: the orientation is meant too, as far as the task has rows for it; else places alone.
    """

    def __init__(self, problem: Problem, *, oriented: bool) -> None:
        self.problem, self.robot, task = problem, problem.robot, problem.task
        rows = tuple(row for row in task.rows if oriented or row < ROWS_OF_POSITION)
        self.wanted = Task(",".join(map(str, rows)), rows, task.frame, task.scale(problem.robot))
        self.aim = Aim(problem.robot, self.wanted)

    def sigma(self, q: Array) -> Array:
        """(N,) σ_r of the task at q (N, n)."""
        return np.asarray(singular_values(self.robot, q, self.problem.task)[:, self.problem.generic_rank - 1])

    def solve(self, targets: Array, starts: Array) -> tuple[Array, Array]:
        """(N, n) where Newton's method ends, one start for each of the poses (N, 4, 4); (N,) σ_r, −inf: not reached."""
        q, step = self.aim.descend(targets, starts, close=CLOSE, rounds=_ITERATIONS)
        good = step >= 0
        if self.problem.limits:
            q = into_limits(self.robot, q)
            good &= ((q >= self.robot.lower - EDGE) & (q <= self.robot.upper + EDGE)).all(axis=1)
        return q, np.where(good, self.sigma(q), -np.inf)

    def sought(self, targets: Array, starts: int, seed: int) -> tuple[Array, Array]:
        """(P, starts, n) postures from random starts at poses (P, 4, 4), and (P, starts) their σ_r, −inf: none."""
        begin = sample(self.robot, self.problem.task, len(targets) * starts, seed, limits=self.problem.limits)
        q, sigma = self.solve(np.repeat(targets, starts, axis=0), begin)
        return q.reshape(-1, starts, self.robot.n), sigma.reshape(-1, starts)

    def climb(self, targets: Array, q: Array, sigma: Array, rng: np.random.Generator) -> tuple[Array, Array]:
        """Postures (P, K, n) moved along self-motions to a larger σ (P, K); as they are for an arm without any."""
        if self.robot.n == self.aim.rank:
            return q, sigma
        shape, goals = q.shape, np.repeat(targets, q.shape[1], axis=0)
        flat, best = q.reshape(-1, self.robot.n).copy(), sigma.reshape(-1).copy()
        rows = np.flatnonzero(np.isfinite(best))
        for length in _CLIMB:
            if not len(rows):
                break
            null = np.linalg.svd(self.aim.jacobian(flat[rows]))[2][:, self.aim.rank :]
            way = (rng.normal(size=(len(rows), 1, null.shape[1])) @ null)[:, 0]
            way *= length / np.maximum(np.linalg.norm(way, axis=1), 1e-300)[:, None]
            for sign in (1.0, -1.0):
                there, value = self.solve(goals[rows], flat[rows] + sign * way * self.aim.joints)
                better = value > best[rows]
                flat[rows[better]], best[rows[better]] = there[better], value[better]
        return flat.reshape(shape), best.reshape(shape[:2])


def best_postures(
    problem: Problem, targets: Array, *, oriented: bool, starts: int, seed: int
) -> tuple[Array, Array, float]:
    """The best posture found at every pose.

    Args:
        problem: the arm, the task of which σ counts, and whether solutions have to be inside the joint limits.
        targets: (P, 4, 4) [m].
        oriented: the orientation is meant too, as far as the task has rows for it; else places alone.
        starts: random starts for each pose.
        seed: of the starts.

    Returns:
        (P,) the largest σ_r of a solution, NaN where none was found; (P, n) that solution; the smallest σ_r of any
        solution, inf where there is none.
    """
    q, sigma = Postures(problem, oriented=oriented).sought(targets, starts, seed)
    best, every = sigma.argmax(axis=1), np.arange(len(targets))
    top, lowest = sigma[every, best], sigma[np.isfinite(sigma)].min(initial=np.inf)
    return np.where(np.isfinite(top), top, np.nan), q[every, best], float(lowest)


def slow_poses(
    problem: Problem, targets: Array, *, oriented: bool, speed: float, starts: int, seed: int
) -> tuple[Mask, Mask, bool] | None:
    """At which poses the tool is slow in some direction, by the joints' rate limits, whatever posture found it takes.

    Args:
        problem: the arm with its rate limits, its task, and whether postures have to be inside the joint limits.
        targets: (P, 4, 4) [m].
        oriented: the orientation is meant too; else places alone.
        speed: a straight translation slower than this is slow [m/s].
        starts: random starts for each pose.
        seed: of the starts.

    Returns:
        (P,) the poses that are reached, (P,) those of them that are slow, and whether speeds are upper bounds only;
        None without rate limits, or for a task without translations.
    """
    q, sigma = Postures(problem, oriented=oriented).sought(targets, starts, seed)
    kinds = [motion for motion in slowest_motions(problem.robot, q, problem.task) if motion.unit == "m/s"]
    if not kinds:
        return None
    there = np.isfinite(sigma)
    fastest = np.where(there, kinds[0].speed.reshape(there.shape), -np.inf).max(axis=1)
    reached = np.asarray(there.any(axis=1))
    return reached, np.asarray(reached & (fastest < speed)), not kinds[0].exact
