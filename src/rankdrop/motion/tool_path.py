"""The tool's path of a joint path, at places close enough together, and joint paths made anew from it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from rankdrop.kinematics import pose
from rankdrop.local.block import block, generic_rank, joint_scale
from rankdrop.local.orientation import orientation_coordinates
from rankdrop.motion.curve import Curve, numbered
from rankdrop.motion.follow import Followed, Pull, follow
from rankdrop.motion.inverse import Aim
from rankdrop.motion.trajectory import ROW_SECONDS, Trajectory
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task

Run = Callable[["ToolPath"], Followed]
"""A joint path at the places of a tool path, however many."""

_FINE = 0.01  # joint motion between two places of a new joint path [rad; slides divided by the length scale]
_RESOLVED = 0.5  # … and in shares of the way to the nearest singularity, to first order
_TOO_NEAR = 2e-4  # paths nearer to a singularity than this are none [rad]
_NEAR = 1.0  # of a start that was not followed to [rad]
_COARSE = 200  # places of a first look
_ROUNDS = 8  # of putting places in between
_MOST = 200_000  # places


@dataclass(frozen=True, eq=False)
class ToolPath:
    """Where the tool is at places of a joint path, all samples among them.

    Attributes:
        robot, task: the arm and its task.
        path: the curve in joint space.
        place: (K,) stretch and share of it, counted from 0.
        q: (K, n) configurations of the path there.
        poses: (K, 4, 4) of the tip; moved ones where the tool or the base is.
        limits: joint limits count: they do where the path itself keeps them.
        moved: (4, 4) left and right factors that the poses have been multiplied by.
    """

    robot: Robot
    task: Task
    path: Curve
    place: Array
    q: Array
    poses: Array
    limits: bool
    moved: tuple[Array, Array] = (np.eye(4), np.eye(4))

    def coarse(self) -> ToolPath:
        """Some places, evenly along the length of the joint path, the ends among them."""
        if len(self.place) <= _COARSE:
            return self
        until = self.lengths
        rows = np.unique(np.searchsorted(until, np.linspace(0.0, until[-1], _COARSE)).clip(0, len(until) - 1))
        return self._with(self.place[rows])

    def spread(self, count: int) -> ToolPath:
        """So many places, evenly along the length of the joint path, samples or not."""
        return self._with(np.interp(np.linspace(0.0, self.lengths[-1], count), self.lengths, self.place))

    @property
    def lengths(self) -> Array:
        """(K,) of the joint path up to each place, increasing [rad; slides divided by the length scale]."""
        return np.concatenate([[0.0], np.cumsum(self._steps(self.q) + 1e-9)])

    def shifted(self, left: Array, right: Array) -> ToolPath:
        """The tool's path left · T · right: the base moved by left⁻¹, or the tool held in another way."""
        return replace(self, poses=left @ self.poses @ right, moved=(left @ self.moved[0], self.moved[1] @ right))

    def followed(self, start: Array, pull: Pull | None = None) -> Followed:
        """The joint path on the branch of a start."""
        return follow(self.robot, self.poses, start, self.task, limits=self.limits, pull=pull)

    def refined(self, run: Run) -> tuple[ToolPath, Followed]:
        """A joint path at more places where it moves far between two, or far for how near it is to a
        singularity: a path that bounces off one comes nearer with every place, and is not complete.
        """
        tool, rank = self, generic_rank(self.robot, self.task)
        for _ in range(_ROUNDS):
            found = run(tool)
            if not found.complete:
                break
            far = room(self.robot, self.task, found.q, rank)
            if far.min() < _TOO_NEAR:
                break
            wanted = np.minimum(_FINE, _RESOLVED * np.minimum(far[1:], far[:-1]))
            parts = np.minimum(np.ceil(tool._steps(found.q) / np.maximum(wanted, 1e-12)), 16).astype(np.int64)
            if (parts <= 1).all():
                return tool, found
            if len(tool.place) + int(parts.sum()) > _MOST:
                break
            added = [
                tool.place[k] + np.arange(1, n) / n * (tool.place[k + 1] - tool.place[k])
                for k, n in enumerate(parts.tolist()) if n > 1
            ]  # fmt: skip
            tool = tool._with(np.unique(np.concatenate([tool.place, *added])))
        return tool, replace(found, complete=False)

    def trajectory(self, q: Array, interpolate: str) -> Trajectory:
        """A joint path (K, n) at the places, with the times of the old one, and rates where cubics need them."""
        timed = self.path.times is not None
        times = self.path.time(*self.path.split(self.place))
        times = ROW_SECONDS * np.arange(len(q), dtype=np.float64) if times is None else times
        velocities = None if interpolate == "linear" else _slope(q, times)
        accelerations = _slope(velocities, times) if interpolate == "quintic" and velocities is not None else None
        return Trajectory("", times, q, timed, (), velocities, accelerations)

    def deviation(self, made: Trajectory, interpolate: str) -> tuple[float, float]:
        """How far the tool is from its path in the middle between two places of a new joint path, at most: [m], [rad].

        A measurement at the middles; at the places themselves the path is kept to rounding.
        """
        new = made.curve(interpolate)
        k = np.arange(len(made.q) - 1)
        middle = (self.place[:-1] + self.place[1:]) / 2
        now = pose(self.robot, new.at(k, np.full(len(k), 0.5)))
        wanted = self.moved[0] @ pose(self.robot, joints_at(self.path, middle)) @ self.moved[1]
        turn = orientation_coordinates(now[:, :3, :3] @ wanted[:, :3, :3].swapaxes(1, 2), "rotvec")
        apart = np.linalg.norm(now[:, :3, 3] - wanted[:, :3, 3], axis=1)
        return float(apart.max(initial=0.0)), float(np.linalg.norm(turn, axis=1).max(initial=0.0))

    def _with(self, place: Array) -> ToolPath:
        q = joints_at(self.path, place)
        return replace(self, place=place, q=q, poses=self.moved[0] @ pose(self.robot, q) @ self.moved[1])

    def _steps(self, q: Array) -> Array:
        return np.asarray(np.linalg.norm(np.diff(q, axis=0) / joint_scale(self.robot, self.task), axis=1))


def tool_path(robot: Robot, task: Task, path: Curve) -> ToolPath:
    """The tool's path of a joint path: at all samples, and between samples that are far apart.

    Args:
        robot: the arm.
        task: from `resolve_task`.
        path: the curve.
    """
    scale = joint_scale(robot, task)
    length = np.linalg.norm(np.diff(path.control, axis=1) / scale, axis=2).sum(axis=1)
    parts = np.maximum(1, np.ceil(length / _FINE)).astype(np.int64)
    if int(parts.sum()) > max(_MOST, 2 * len(parts)):
        parts = np.ones(len(parts), dtype=np.int64)
    stretch, part = numbered(parts)
    place = np.append(stretch + part / parts[stretch], float(len(parts)))
    low, high = path.control.min(axis=(0, 1)), path.control.max(axis=(0, 1))
    limits = bool((low >= robot.lower - 1e-9).all() and (high <= robot.upper + 1e-9).all())
    q = joints_at(path, place)
    return ToolPath(robot, task, path, place, q, pose(robot, q), limits)


def room(robot: Robot, task: Task, q: Array, rank: int) -> Array:
    """(N,) σ_r/‖∇σ_r‖: distance from a singularity to first order [rad; slides divided by the length scale].

    Args:
        robot, task: the arm and its task.
        q: (N, n) configurations.
        rank: r, the generic rank.
    """
    sigma, slope = rising(robot, task, q, rank)
    return np.asarray(sigma / np.maximum(np.linalg.norm(slope, axis=1), 1e-2))


def rising(robot: Robot, task: Task, q: Array, rank: int) -> tuple[Array, Array]:
    """(N,) σ_r and (N, n) its gradient by scaled joint variables, aᵀ D b with F = a σ_r bᵀ + …: the bases of the block
    of a redundant arm are no singular vectors.

    Args:
        robot, task, q, rank: as in `room`.
    """
    parts = block(robot, q, task, rank - 1)
    a, _, b = np.linalg.svd(parts.f, full_matrices=False)
    slope = np.einsum("np,npsk,ns->nk", a[:, :, 0], parts.d, b[:, 0])
    return parts.sigma[:, rank - 1], slope * joint_scale(robot, task)


def joints_at(path: Curve, place: Array) -> Array:
    """(K, n) configurations at places (K,)."""
    return path.at(*path.split(place))


def _slope(values: Array, times: Array) -> Array:
    """(K, n) derivative by time, of second order."""
    return np.asarray(np.gradient(values, times, axis=0, edge_order=2 if len(times) > 2 else 1))


def start_moved(tool: ToolPath) -> Array | None:
    """(n,) a configuration at the first pose as it is moved: followed to from the path's first one, else the one that
    Newton's method finds near it; None where neither gets there.
    """
    way = np.stack([pose(tool.robot, tool.q[0]), tool.poses[0]])
    lead = follow(tool.robot, way, tool.q[0], tool.task, limits=tool.limits)
    if lead.complete:
        return np.asarray(lead.q[-1])
    found, arrived = Aim(tool.robot, tool.task).solve(tool.poses[:1], tool.q[:1])
    near = float(np.linalg.norm((found[0] - tool.q[0]) / joint_scale(tool.robot, tool.task))) < _NEAR
    inside = not tool.limits or bool(((found[0] >= tool.robot.lower) & (found[0] <= tool.robot.upper)).all())
    return np.asarray(found[0]) if arrived[0] and near and inside else None
