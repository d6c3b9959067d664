"""How far the task has moved from where it was: the displacement from a start, its derivative, and the way back.

    d(q) = (Aᵀ(p(q) − p(q0)) ; Aᵀ log(R(q) R(q0)ᵀ)),  its task rows, translations divided by the length scale

A are the axes of the task's frame as they stand at the start, p its reference point. At q0 the derivative is the task
Jacobian. For a task that leaves some rotations free, `log` makes "no rotation about Z" a condition on where the arm is,
and not only on how it moves.
"""

from __future__ import annotations

import numpy as np

from rankdrop import _core
from rankdrop.errors import TaskError
from rankdrop.frames import BASE, TIP, Frame, link_index
from rankdrop.kinematics import jacobian, link_poses, pose
from rankdrop.local.block import joint_scale
from rankdrop.local.factored import row_scale
from rankdrop.local.representation import orientation_coordinates, rate_matrix
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task

WEAK = 1e-6
"""σ below which the way back leaves a direction alone: what is off along it is of second order in σ."""
_GOAL = 1e-14  # rounding of a displacement
_ACCEPTED = 1e-11  # far above rounding, far below the 1e-10 that self-motions promise
_ROUNDS = 12  # Gauss–Newton converges in three or four


class Displacement:
    """The displacement from `start`; joint motions are measured in scaled coordinates q / `joint_scale`.

    Raises:
        TaskError: the task's reference point does not move with the tip.
    """

    def __init__(self, robot: Robot, start: Array, task: Task) -> None:
        last, whole = len(robot.joints) + 1, len(task.rows) == 6
        if link_index(task.frame.origin, len(robot.joints), "point") != last and not whole:
            raise TaskError(
                "the reference point of this task does not move with the tip", got=f"link {task.frame.origin}",
                allowed="TIP", mend="give the task a frame with its origin at the tip",
            )  # fmt: skip
        self.robot, self.start = robot, start
        self.rows = list(task.rows)
        self.row_scale, self.joints = row_scale(robot, task), joint_scale(robot, task)
        point = (0.0, 0.0, 0.0) if whole else task.frame.point  # the whole pose stands still at any point
        self._frame = Frame(BASE, TIP, point)
        self._point = np.array([*point, 1.0])
        self._home = pose(robot, start)
        self._axes = link_poses(robot, start)[link_index(task.frame.axes, len(robot.joints), "axes"), :3, :3]

    def error(self, q: Array) -> Array:
        """(m,) displacement of the task's rows, without unit."""
        now = pose(self.robot, q)
        shift = (now - self._home)[:3] @ self._point
        both = np.concatenate([shift @ self._axes, self._turn(now) @ self._axes])
        return np.asarray(both[self.rows] * self.row_scale)

    def derivative(self, q: Array) -> Array:
        """(m, n) of the error by scaled joint coordinates."""
        columns = jacobian(self.robot, q, self._frame) * self.joints
        turning = np.linalg.solve(rate_matrix(self._turn(pose(self.robot, q)), "rotvec"), columns[3:])
        both = np.concatenate([self._axes.T @ columns[:3], self._axes.T @ turning])
        return np.asarray(both[self.rows] * self.row_scale[:, None])

    def split(self, q: Array) -> tuple[Array, Array, Array]:
        """U, σ, V of the derivative."""
        u, sigma, v = _core.svd(np.ascontiguousarray(self.derivative(q))[None])
        return u[0], sigma[0], v[0]

    def back(self, q: Array) -> Array | None:
        """The configuration without displacement nearest to q, by Gauss–Newton; None where it does not converge."""
        now = q.copy()
        size = np.inf
        for _ in range(_ROUNDS):
            error = self.error(now)
            last, size = size, float(np.linalg.norm(error))
            if size <= _GOAL or (size <= _ACCEPTED and size > 0.5 * last):
                return now
            if size > 10.0 * last:
                return None
            u, sigma, v = self.split(now)
            kept = int((sigma > WEAK).sum())
            now = now - self.joints * (v[:, :kept] @ ((error @ u[:, :kept]) / sigma[:kept]))
        return now if float(np.linalg.norm(self.error(now))) <= _ACCEPTED else None

    def _turn(self, now: Array) -> Array:
        return orientation_coordinates(now[:3, :3] @ self._home[:3, :3].T, "rotvec")
