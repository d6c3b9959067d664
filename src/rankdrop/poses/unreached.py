"""How far a pose without solution is from the poses that the arm reaches.

‖W e(q)‖ is minimised with Levenberg's method: the position alone; the position with the orientation kept; the
orientation with the position kept.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop.kinematics import pose as pose_of
from rankdrop.local.block import sampling_box
from rankdrop.local.pointing import TILTED, level_task, tilt_is_fixed, tilts_off
from rankdrop.poses.inverse import Aim, wrap_joints
from rankdrop.poses.solution_search import SolutionSearch
from rankdrop.questions import InverseOptions
from rankdrop.robot.model import Array

POSITION, ORIENTATION, JOINTS, TILT, EDGE = "position", "orientation", "joints", "tilt", "edge"
"""Why a pose has no solution: its position is out of reach; it is in reach, but not with this orientation; the arm has
too few joints to give every orientation; no joint tilts the tool, and the pose is tilted; the pose misses the edge of
reach by as little as poses are rounded."""
_LEAST_STARTS, _ROUNDS, _HEAVY = 128, 150, 1e3  # of Levenberg's method; weight of what is kept
ROUNDED = 2e-6
"""Error of the printed digits of a pose [rad; lengths divided by the length scale]."""
_NONE = 1e-5  # of what is kept: what may be missing [rad; lengths divided by the length scale]
_UNREACHED = 1e-6  # a distance below it is none [length scales]


@dataclass(frozen=True, eq=False)
class Unreached:
    """How far a pose without solution is from poses that the arm reaches, joint limits ignored.

    Attributes:
        kind: `POSITION`, `ORIENTATION`, `JOINTS` or `TILT`.
        position: least distance of the tip from the position, whatever the orientation [m].
        shift: … with the orientation kept [m]; None where the arm does not make it.
        turn: least angle of the tool from the orientation, the position kept [rad]; None where it is not reached. Of
            `TILT` the angle between the tilt of the pose and that of the tool.
        tip: (4, 4) the reachable pose of the least distance: with the orientation kept where the arm makes it.
        near: (n,) a configuration that takes it [rad, m].
        turned: (4, 4) the reachable pose of the least angle; None where there is none.
    """

    kind: str
    position: float
    shift: float | None
    turn: float | None
    tip: Array
    near: Array
    turned: Array | None


def tilt_missing(search: SolutionSearch, how: InverseOptions) -> Unreached | None:
    """How far the pose is tilted, where an arm that never tilts its tool is asked for yaw; else None."""
    aim, robot, goal = search.aim, search.robot, search.goal
    never = tilt_is_fixed(robot, search.task) or level_task(robot, search.task) is not None
    if not never:
        return None
    off = float(tilts_off(robot, goal[None])[0])
    if off <= TILTED:
        return None
    weights = np.where(np.array(aim.rows) < 3, 1.0, 0.0)
    near = nearest_configurations(aim, goal, weights, _descent_starts(search, how))[0]
    tip = pose_of(robot, near)
    position = float(np.linalg.norm(tip[:3, 3] - goal[:3, 3]))
    return Unreached(TILT, position, None, off, tip, near, None)


def _descent_starts(search: SolutionSearch, how: InverseOptions) -> Array:
    """(S, n) random configurations, joint limits ignored."""
    low, high = sampling_box(search.robot, search.task, limits=False)
    return np.random.default_rng(how.seed).uniform(low, high, (_LEAST_STARTS, search.robot.n))


def why_unreached(search: SolutionSearch, how: InverseOptions) -> Unreached:
    """How far the pose is from those that the arm reaches."""
    aim, robot, goal = search.aim, search.robot, search.goal
    rows = np.array(aim.rows)
    moves = rows < 3
    starts = _descent_starts(search, how)

    def least(position: float, turning: float) -> tuple[float, float, Array]:
        """Least distance [length scales] and angle [rad] with these weights, and where."""
        q = nearest_configurations(aim, goal, np.where(moves, position, turning), starts)[0]
        error = aim.error(goal, q[None])[0]
        return float(np.linalg.norm(error[moves])), float(np.linalg.norm(error[~moves])), q

    if moves.any():
        position, _, near = least(1.0, 0.0)
    else:
        position, _, near = (0.0, 0.0, starts[0])
    shift = turn = None
    tip, turned = pose_of(robot, near), None
    if moves.any() and not moves.all():
        away, angle, q = least(1.0, _HEAVY)
        if angle <= _NONE:
            shift, tip, near = away * aim.length, pose_of(robot, q), q
        away, angle, q = least(_HEAVY, 1.0)
        if away <= _NONE:
            turn, turned = angle, pose_of(robot, q)
    elif moves.all():
        shift = position * aim.length
    else:
        _, turn, q = least(0.0, 1.0)
        turned = pose_of(robot, q)
    kind = _kind_of(aim, position * aim.length, shift)
    return Unreached(kind, position * aim.length, shift, turn, tip, wrap_joints(robot, near), turned)


def _kind_of(aim: Aim, position: float, shift: float | None) -> str:
    """Why a pose has no solution, by the least distances from its position, the orientation free and kept [m]."""
    if aim.square and shift is not None and shift <= ROUNDED * aim.length:
        return EDGE
    if position > _UNREACHED * aim.length:
        return POSITION
    if aim.rank < aim.task.m:
        return JOINTS
    return ORIENTATION


def nearest_configurations(aim: Aim, goal: Array, weights: Array, starts: Array) -> Array:
    """(S, n) the configurations that Levenberg's method ends at, those with the least ‖W e‖ first.

    Args:
        aim: the arm and its task.
        goal: (4, 4) the pose.
        weights: (m,) diagonal of W.
        starts: (S, n) configurations that it begins at.
    """
    q = starts.copy()
    error = aim.error(goal, q) * weights
    cost = (error * error).sum(axis=1)
    size = float(weights.max()) ** 2
    damping = np.full(len(q), 1e-2 * size)
    for _ in range(_ROUNDS):
        j = aim.jacobian(q) * weights[:, None]
        square = j.swapaxes(1, 2) @ j + damping[:, None, None] * np.eye(q.shape[1])
        step = np.linalg.solve(square, j.swapaxes(1, 2) @ error[:, :, None])[:, :, 0]
        length = np.linalg.norm(step, axis=1)
        step *= np.minimum(1.0, 0.5 / np.maximum(length, 1e-300))[:, None]
        tried = q + step * aim.joints
        new = aim.error(goal, tried) * weights
        now = (new * new).sum(axis=1)
        better = now < cost
        q[better], error[better], cost[better] = tried[better], new[better], now[better]
        damping = np.clip(np.where(better, damping / 4, damping * 4), 1e-12 * size, 1e12 * size)
    return np.asarray(q[np.argsort(cost, kind="stable")])
