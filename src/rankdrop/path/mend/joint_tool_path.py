"""The tool path of a joint path, at places of it: where the tool is, and how new joint paths are made along it.

A new joint path is followed from its start at more and more places: close together where the joints move far between
two, and where they come near to a singularity.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from rankdrop.kinematics import pose
from rankdrop.local.block import block, generic_rank, joint_scale
from rankdrop.path.check.follow import Pull, follow
from rankdrop.path.check.tool_branch import Followed
from rankdrop.path.curve import Curve, number_parts
from rankdrop.path.mend.local_change import poses_off
from rankdrop.path.read.trajectory import Trajectory, regular_times
from rankdrop.poses.inverse import Aim, within_limits
from rankdrop.problem import Mask
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task

Run = Callable[["JointToolPath"], Followed]
"""A joint path at the places of a tool path, however many."""

_FINE = 0.01  # joint motion between two places of a new joint path [rad; slides divided by the length scale]
_RESOLVED = 0.5  # … and in shares of the way to the nearest singularity, to first order
_TOO_NEAR = 2e-4  # paths nearer to a singularity than this are none [rad]
_COARSE = 200  # places of a first look
_REFINED, _MOST = 8, 200_000  # rounds of putting places in between, and places at most


@dataclass(frozen=True, eq=False)
class JointToolPath:
    """Where the tool is at places of a joint path, all samples among them; joint paths made anew from it.

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

    @cached_property
    def aim(self) -> Aim:
        """Newton's method towards its poses; TaskError where they do not determine what the task wants."""
        return Aim(self.robot, self.task)

    @cached_property
    def rank(self) -> int:
        """r, the generic rank."""
        return generic_rank(self.robot, self.task)

    @property
    def redundant(self) -> bool:
        """The arm has self-motions."""
        return self.robot.n > self.rank

    def coarse(self) -> Self:
        """Some places, evenly along the length of the joint path, the ends among them."""
        if len(self.place) <= _COARSE:
            return self
        until = self.lengths
        rows = np.unique(np.searchsorted(until, np.linspace(0.0, until[-1], _COARSE)).clip(0, len(until) - 1))
        return self.at_places(self.place[rows])

    def spread(self, count: int) -> Self:
        """So many places, evenly along the length of the joint path, samples or not."""
        return self.at_places(np.interp(np.linspace(0.0, self.lengths[-1], count), self.lengths, self.place))

    @property
    def lengths(self) -> Array:
        """(K,) of the joint path up to each place, increasing [rad; slides divided by the length scale]."""
        return np.concatenate([[0.0], np.cumsum(self._steps(self.q) + 1e-9)])

    def shift(self, left: Array, right: Array) -> JointToolPath:
        """The tool's path left · T · right: the base moved by left⁻¹, or the tool held in another way."""
        return replace(self, poses=left @ self.poses @ right, moved=(left @ self.moved[0], self.moved[1] @ right))

    def follow_branch(self, start: Array, pull: Pull | None = None) -> Followed:
        """The joint path on the branch of a start."""
        return follow(self.robot, self.poses, start, self.task, limits=self.limits, pull=pull)

    def rising(self, q: Array) -> tuple[Array, Array]:
        """(N,) σ_r and (N, n) its gradient by scaled joint variables, aᵀ D b with F = a σ_r bᵀ + …: the bases of the
        block of a redundant arm are no singular vectors.
        """
        parts = block(self.robot, q, self.task, self.rank - 1)
        a, _, b = np.linalg.svd(parts.f, full_matrices=False)
        slope = np.einsum("np,npsk,ns->nk", a[:, :, 0], parts.d, b[:, 0])
        return parts.sigma[:, self.rank - 1], slope * joint_scale(self.robot, self.task)

    def room(self, q: Array) -> Array:
        """(N,) σ_r/‖∇σ_r‖: distance from a singularity to first order [rad; slides divided by the length scale]."""
        sigma, slope = self.rising(q)
        return np.asarray(sigma / np.maximum(np.linalg.norm(slope, axis=1), 1e-2))

    def in_limits(self, q: Array) -> Mask:
        """(N,) within the joint limits, where they count."""
        if self.limits:
            return within_limits(self.robot, q)
        return np.ones(len(q), dtype=np.bool_)

    def refine_run(self, run: Run) -> tuple[Self, Followed]:
        """A joint path at more places where it moves far between two, or far for how near it is to a
        singularity: a path that bounces off one comes nearer with every place, and is not complete.
        """
        tool = self
        for _ in range(_REFINED):
            followed = run(tool)
            if followed.complete:
                far = self.room(followed.q)
            else:
                far = np.zeros(1)
            if far.min() < _TOO_NEAR:
                break
            wanted = np.minimum(_FINE, _RESOLVED * np.minimum(far[1:], far[:-1]))
            parts = np.minimum(np.ceil(tool._steps(followed.q) / np.maximum(wanted, 1e-12)), 16).astype(np.int64)
            if (parts <= 1).all():
                return tool, followed
            if len(tool.place) + int(parts.sum()) > _MOST:
                break
            k, part = number_parts(np.maximum(parts, 1))
            added = tool.place[k] + part / np.maximum(parts, 1)[k] * (tool.place[k + 1] - tool.place[k])
            tool = tool.at_places(np.append(added, tool.place[-1]))
        return tool, replace(followed, complete=False)

    def trajectory(self, q: Array, interpolate: str) -> Trajectory:
        """A joint path (K, n) at the places, with the times of the old one, and rates where cubics need them."""
        timed = self.path.times is not None
        times = self.path.time(*self.path.split(self.place))
        if times is None:
            times = regular_times(len(q))
        if interpolate == "linear":
            velocities = None
        else:
            velocities = _slope(q, times)
        if interpolate == "quintic" and velocities is not None:
            accelerations = _slope(velocities, times)
        else:
            accelerations = None
        return Trajectory("", times, q, timed, (), velocities, accelerations)

    def deviation(self, trajectory: Trajectory, interpolate: str) -> tuple[float, float]:
        """How far the tool is from its path in the middle between two places of a new joint path, at most: [m], [rad].

        A measurement at the middles; at the places themselves the path is kept to rounding.
        """
        k = np.arange(len(trajectory.q) - 1)
        now = pose(self.robot, trajectory.curve(interpolate).at(k, np.full(len(k), 0.5)))
        wanted = self.at_places((self.place[:-1] + self.place[1:]) / 2).poses
        return poses_off(wanted, now, self.aim)

    def at_places(self, place: Array) -> Self:
        """The same tool path at other places (K,)."""
        q = self.path.at(*self.path.split(place))
        return replace(self, place=place, q=q, poses=self.moved[0] @ pose(self.robot, q) @ self.moved[1])

    def _steps(self, q: Array) -> Array:
        return np.asarray(np.linalg.norm(np.diff(q, axis=0) / joint_scale(self.robot, self.task), axis=1))


def _slope(values: Array, times: Array) -> Array:
    """(K, n) derivative by time, of second order."""
    return np.asarray(np.gradient(values, times, axis=0, edge_order=2 if len(times) > 2 else 1))


def tool_path(robot: Robot, task: Task, path: Curve) -> JointToolPath:
    """The tool's path of a joint path: at all samples, and between samples that are far apart.

    Args:
        robot: the arm.
        task: from `resolve_task`.
        path: the curve.
    """
    length = np.linalg.norm(np.diff(path.control, axis=1) / joint_scale(robot, task), axis=2).sum(axis=1)
    parts = np.maximum(1, np.ceil(length / _FINE)).astype(np.int64)
    if int(parts.sum()) > max(_MOST, 2 * len(parts)):
        parts = np.ones(len(parts), dtype=np.int64)
    stretch, part = number_parts(parts)
    place = np.append(stretch + part / parts[stretch], float(len(parts)))
    limits = bool(within_limits(robot, path.control.reshape(-1, robot.n)).all())
    q = path.at(*path.split(place))
    return JointToolPath(robot, task, path, place, q, pose(robot, q), limits)
