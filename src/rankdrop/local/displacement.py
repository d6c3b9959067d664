"""How far the task has moved from where it was: the displacement from a start, its derivative, and the way back.

    d(q) = (Aᵀ(p(q) − p(q0)) ; Aᵀ log(R(q) R(q0)ᵀ)),  its task rows, translations divided by the length scale

A are the axes of the task's frame as they stand at the start, p its reference point. At q0 the derivative is the task
Jacobian. For a task that leaves some rotations free, `log` makes "no rotation about Z" a condition on where the arm is,
and not only on how it moves.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.errors import TaskError
from rankdrop.frames import BASE, TIP, Frame, link_index
from rankdrop.kinematics import jacobian, link_poses, pose
from rankdrop.local.block import joint_scale, row_scale
from rankdrop.local.orientation import orientation_coordinates, rate_matrix
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task

WEAK = 1e-6
"""σ below which the way back leaves a direction alone: what is off along it is of second order in σ."""
_GOAL = 1e-14  # rounding of a displacement
_ACCEPTED = 1e-11  # far above rounding, far below the 1e-10 that self-motions promise
_ROUNDS = 12  # Gauss–Newton converges in three or four


def told_by_pose(task: Task) -> bool:
    """Whether "these rows stand still" says where the arm is, and not only how it moves.

    All six rows, or the three of the orientation, do so in every frame; three translations in every axes at a point of
    the tip; other rows at a point of the tip in base or tip axes, single translations in base axes only: axes that turn
    make of them a condition on velocities.
    """
    if task.rows in ((0, 1, 2, 3, 4, 5), (3, 4, 5)):
        return True
    if task.frame.origin != TIP:
        return False
    sliding = tuple(row for row in task.rows if row < 3)
    return (
        task.rows == (0, 1, 2) or task.frame.axes == BASE or (task.frame.axes == TIP and sliding in ((), (0, 1, 2)))
    )


class Displacement:
    """The displacement from `start`; joint motions are measured in scaled coordinates q / `joint_scale`.

    Raises:
        TaskError: the task's reference point does not move with the tip.
    """

    def __init__(self, robot: Robot, start: Array, task: Task) -> None:
        last = len(robot.joints) + 1
        anywhere = task.rows in ((0, 1, 2, 3, 4, 5), (3, 4, 5))  # these stand still at any point, or have none
        if link_index(task.frame.origin, len(robot.joints), "point") != last and not anywhere:
            raise TaskError(
                "the reference point of this task does not move with the tip", got=f"link {task.frame.origin}",
                allowed="TIP", mend="give the task a frame with its origin at the tip",
            )  # fmt: skip
        self.robot, self.start = robot, start
        self.rows = list(task.rows)
        self.row_scale, self.joints = row_scale(robot, task), joint_scale(robot, task)
        point = (0.0, 0.0, 0.0) if anywhere else task.frame.point
        self._frame = Frame(BASE, TIP, point)
        self._point = np.array([*point, 1.0])
        self._home = pose(robot, start)
        self._axes = link_poses(robot, start)[link_index(task.frame.axes, len(robot.joints), "axes"), :3, :3]

    def error(self, q: Array) -> Array:
        """(..., m) displacement of the task's rows at configurations (..., n), without unit."""
        now = pose(self.robot, q)
        return self._error(now, self._turn(now))

    def derivative(self, q: Array) -> Array:
        """(..., m, n) of the error by scaled joint coordinates."""
        return self._derivative(q, self._turn(pose(self.robot, q)))

    def split(self, q: Array) -> tuple[Array, Array, Array]:
        """U, σ, V of the derivative at configurations (..., n)."""
        return _split(self.derivative(q))

    def back(self, q: Array) -> tuple[Array, NDArray[np.bool_]]:
        """The configurations without displacement nearest to q (..., n), by Gauss–Newton, and where it converged.

        Converged means an error of 1e-11 at most; the other configurations are worth nothing.
        """
        now = q.reshape(-1, q.shape[-1]).copy()
        arrived, size, left = np.zeros(len(now), dtype=bool), np.full(len(now), np.inf), np.arange(len(now))
        for _ in range(_ROUNDS):
            where = pose(self.robot, now[left])
            turn = self._turn(where)
            error = self._error(where, turn)
            last, new = size[left], np.linalg.norm(error, axis=-1)
            size[left] = new
            done = (new <= _GOAL) | ((new <= _ACCEPTED) & (new > 0.5 * last))
            arrived[left[done]] = True
            going = ~done & (new <= 10.0 * last)
            left, error = left[going], error[going]
            if not left.size:
                break
            u, sigma, v = _split(self._derivative(now[left], turn[going]))
            count = sigma.shape[-1]
            gains = np.divide(1.0, sigma, out=np.zeros_like(sigma), where=sigma > WEAK)
            steps = gains * np.einsum("cm,cmk->ck", error, u[..., :count])
            now[left] -= self.joints * np.einsum("cnk,ck->cn", v[..., :count], steps)
        else:
            arrived[left] = np.linalg.norm(self.error(now[left]), axis=-1) <= _ACCEPTED
        return now.reshape(q.shape), arrived.reshape(q.shape[:-1])

    def _turn(self, now: Array) -> Array:
        return orientation_coordinates(now[..., :3, :3] @ self._home[:3, :3].T, "rotvec")

    def _error(self, now: Array, turn: Array) -> Array:
        shift = (now - self._home)[..., :3, :] @ self._point
        both = np.concatenate([shift @ self._axes, turn @ self._axes], axis=-1)
        return np.asarray(both[..., self.rows] * self.row_scale)

    def _derivative(self, q: Array, turn: Array) -> Array:
        columns = jacobian(self.robot, q, self._frame) * self.joints
        turning = np.linalg.solve(rate_matrix(turn, "rotvec"), columns[..., 3:, :])
        both = np.concatenate([self._axes.T @ columns[..., :3, :], self._axes.T @ turning], axis=-2)
        return np.asarray(both[..., self.rows, :] * self.row_scale[:, None])


def _split(slopes: Array) -> tuple[Array, Array, Array]:
    batch = slopes.shape[:-2]
    u, sigma, v = _core.svd(np.ascontiguousarray(slopes.reshape(-1, *slopes.shape[-2:])))
    return u.reshape(batch + u.shape[1:]), sigma.reshape(batch + sigma.shape[1:]), v.reshape(batch + v.shape[1:])
