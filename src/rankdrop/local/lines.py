"""The arm as lines in space, at one configuration and at many, and what the lines have in common; where to draw it.

`Lines` are those of one configuration, mimic joints too; `Scene` asks the same of many configurations at once, about
the variables. `Drawn` has one point on each axis, from the numbers of the joints alone, and these points at q.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rankdrop.kinematics import check_robot, jacobian, link_poses, pose
from rankdrop.local.bracket import cross
from rankdrop.local.taylor import unlocked
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.numbers import reach
from rankdrop.task import SPACE
from rankdrop.tolerances import ALIGNED


class Lines:
    """Axes and slides of every joint, mimic joints too, at one configuration."""

    def __init__(self, robot: Robot, q: Array, tolerance: float = ALIGNED) -> None:
        """Directions z (N, 3), points p (N, 3), pitches h (N,) [m/rad] in the base frame."""
        free, values, _ = unlocked(robot, q)
        screws = jacobian(free, values, SPACE).T
        self.tolerance, self.length = tolerance, reach(robot)
        self.slides = [i for i, joint in enumerate(free.joints) if joint.kind is JointKind.PRISMATIC]
        self.turns = [i for i in range(free.n) if i not in self.slides]
        self.z = np.where(np.isin(np.arange(free.n), self.slides)[:, None], screws[:, :3], screws[:, 3:])
        self.p = cross(screws[:, 3:], screws[:, :3])
        self.h = np.einsum("ni,ni->n", screws[:, :3], screws[:, 3:])
        self.cross = np.linalg.norm(cross(self.z[:, None], self.z[None, :]), axis=-1)
        self.dot = np.abs(self.z @ self.z.T)
        offset = cross(self.p[None, :] - self.p[:, None], self.z[:, None]) / self.length
        parallel = self.cross < tolerance
        self._line = ((np.linalg.norm(offset, axis=-1) < tolerance) & parallel).tolist()
        self._parallel, self._normal = parallel.tolist(), (self.dot < tolerance).tolist()

    def parallel(self, i: int, j: int) -> bool:
        """|z_i × z_j| = 0."""
        known: bool = self._parallel[i][j]
        return known

    def normal(self, i: int, j: int) -> bool:
        """z_i · z_j = 0."""
        known: bool = self._normal[i][j]
        return known

    def one_line(self, i: int, j: int) -> bool:
        """Parallel, and p_j on axis i."""
        known: bool = self._line[i][j]
        return known

    def one_pitch(self, i: int, j: int) -> bool:
        """h_i = h_j."""
        return bool(abs(self.h[i] - self.h[j]) < self.tolerance * self.length)

    def through_meeting(self, i: int, j: int) -> list[bool] | None:
        """Of every joint: its axis goes through the point where axes i and j meet; None where they do not meet in one.

        They meet at p_i + s z_i, s from (p_j − p_i) × z_j = s z_i × z_j.
        """
        met, on = self._meetings
        return on[i][j] if met[i][j] else None

    @cached_property
    def _meetings(self) -> tuple[list[list[bool]], list[list[list[bool]]]]:
        """Of every two joints whether they meet in one point (N, N), and which axes go through it (N, N, N)."""
        skew, apart = cross(self.z[:, None], self.z[None]), self.p[None] - self.p[:, None]
        met = self.cross >= self.tolerance
        met &= np.abs((apart * skew).sum(axis=-1)) <= self.tolerance * self.length  # at least distance · |z_i × z_j|
        size = (skew * skew).sum(axis=-1)
        s = (cross(apart, self.z[None]) * skew).sum(axis=-1) / np.where(met, size, 1.0)
        points = self.p[:, None] + s[..., None] * self.z[:, None]
        offset = cross(points[:, :, None] - self.p, self.z) / self.length
        on = np.linalg.norm(offset, axis=-1) < self.tolerance
        number = np.arange(len(self.p))
        met &= on[number[:, None], number, number]
        return met.tolist(), on.tolist()


Verdicts = NDArray[np.bool_]  # one per configuration


@dataclass(frozen=True, eq=False)
class Scene:
    """Joint axes at N configurations, in the base frame. Joints are numbered from 0 here.

    An axis (revolute joint) is the line p_i + s z_i with z = ω, p = ω × v. The questions below take axes only.
    """

    robot: Robot
    q: Array  # (N, n)
    tolerance: float = ALIGNED

    @cached_property
    def screws(self) -> Array:
        """(N, 6, n) joint screws about the base origin."""
        return jacobian(self.robot, self.q, SPACE)

    @cached_property
    def kinds(self) -> tuple[JointKind | None, ...]:
        """Kind of each variable; None where a mimic joint follows: then it is not one screw."""
        leaders = {joint.mimic.leader for joint in self.robot.joints if joint.mimic is not None}
        return tuple(None if joint.name in leaders else joint.kind for joint in self.robot.variables)

    @cached_property
    def axes(self) -> tuple[int, ...]:
        """Indices of the revolute joints."""
        return tuple(i for i, kind in enumerate(self.kinds) if kind is JointKind.REVOLUTE)

    @cached_property
    def z(self) -> Array:
        """(n, N, 3) unit directions of the axes; those of the slides for prismatic joints."""
        slides = [kind is JointKind.PRISMATIC for kind in self.kinds]
        parts = [self.screws[:, :3, i] if slide else self.screws[:, 3:, i] for i, slide in enumerate(slides)]
        return np.stack(parts)

    @cached_property
    def p(self) -> Array:
        """(n, N, 3) the points of the axes nearest to the base origin [m]."""
        return np.stack([np.cross(self.screws[:, 3:, i], self.screws[:, :3, i]) for i in range(self.robot.n)])

    @cached_property
    def tip(self) -> Array:
        """(N, 3) the tip [m]."""
        return pose(self.robot, self.q)[..., :3, 3]

    @cached_property
    def length(self) -> float:
        """Reach of the arm [m]; distances are judged against it."""
        return reach(self.robot)

    def moved(self, joint: int, by: float) -> Scene:
        """The scene after one joint has moved by `by` [rad, m]."""
        q = self.q.copy()
        q[:, joint] += by
        return Scene(self.robot, q, self.tolerance)

    def parallel(self, i: int, j: int) -> Verdicts:
        """|z_i × z_j| = 0."""
        return self._small(np.cross(self.z[i], self.z[j]))

    def perpendicular(self, i: int, j: int) -> Verdicts:
        """z_i · z_j = 0."""
        return np.abs(_dot(self.z[i], self.z[j])) < self.tolerance

    def aligned(self, i: int, j: int) -> Verdicts:
        """One line: parallel, and (p_j − p_i) × z_i = 0."""
        return self.parallel(i, j) & self.on_axis(self.p[j], i)

    def on_axis(self, point: Array, i: int) -> Verdicts:
        """(point − p_i) × z_i = 0 for a point (N, 3)."""
        return self._small(np.cross(point - self.p[i], self.z[i]) / self.length)

    def meeting(self, i: int, j: int) -> Verdicts:
        """Not parallel and in one plane: (p_j − p_i) · (z_i × z_j) = 0."""
        volume = _dot(self.p[j] - self.p[i], np.cross(self.z[i], self.z[j]))
        return ~self.parallel(i, j) & (np.abs(volume) < self.tolerance * self.length)

    def common_point(self, axes: Sequence[int]) -> tuple[Array, Verdicts]:
        """(N, 3) the point nearest to some axes, Σ (1 − z zᵀ)(x − p) = 0, and whether it is on all of them."""
        normal = np.eye(3) - self.z[list(axes)][..., :, None] * self.z[list(axes)][..., None, :]  # (a, N, 3, 3)
        total = normal.sum(axis=0)
        right = (normal @ self.p[list(axes)][..., None]).sum(axis=0)
        regular = np.linalg.eigvalsh(total)[:, 0] > self.tolerance  # 0 where all are parallel
        point = np.linalg.solve(np.where(regular[:, None, None], total, np.eye(3)), right)[..., 0]
        on = np.stack([self.on_axis(point, i) for i in axes]).all(axis=0)
        return point, on & regular

    def in_plane(self, point: Array, i: int, direction: Array) -> Verdicts:
        """In the plane through axis i along `direction` (N, 3): (point − p_i) · (z_i × direction) = 0."""
        return np.abs(_dot(point - self.p[i], np.cross(self.z[i], direction))) < self.tolerance * self.length

    def coplanar(self, axes: Sequence[int], point: Array | None = None) -> Verdicts:
        """All axes (and the point) in one plane."""
        first = axes[0]
        spans = [self.z[i] for i in axes] + [(self.p[i] - self.p[first]) / self.length for i in axes[1:]]
        if point is not None:
            spans.append((point - self.p[first]) / self.length)
        # remove the freedom along the first axis from the points: only their offset from it counts
        stacked = np.stack([s - self.z[first] * _dot(s, self.z[first])[:, None] for s in spans], axis=1)  # (N, s, 3)
        return np.linalg.svd(stacked, compute_uv=False)[:, 1] < self.tolerance

    def _small(self, vector: Array) -> Verdicts:
        return np.asarray(np.linalg.norm(vector, axis=-1) < self.tolerance)


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("...i,...i->...", a, b))


_ALONG = 1e-9  # a point this near an axis, per length of the way, is on it


@dataclass(frozen=True, eq=False)
class Drawn:
    """An arm at one configuration, ready to be drawn, in the base frame.

    Attributes:
        links: (P, 3) points from the base to the tip, joined by the links [m].
        middles: (N, 3) where the joints are drawn, on their axes [m].
        axes: (N, 3) unit directions of the axes.
        slides: (N,) whether a joint is prismatic.
        numbers: (N,) number of the variable that drives a joint, from 1; a mimic joint has that of its leader.
    """

    links: Array
    middles: Array
    axes: Array
    slides: tuple[bool, ...]
    numbers: tuple[int, ...]


def drawn_at(robot: Robot, q: Array) -> Drawn:
    """Where the arm is drawn at q, joint by joint on the points of `skeleton`.

    Args:
        robot: the arm.
        q: (n,) configuration [rad, m].
    """
    check_robot(robot)
    at_home, drawn = skeleton(robot)
    poses = link_poses(robot, q)
    frames = [np.eye(4), *(joint.frame for joint in robot.joints)]
    moved = [poses[i] @ np.linalg.inv(frames[i]) for i in range(len(robot.joints) + 1)]
    links, middles, axes = [np.zeros(3)], [], []
    for i, joint in enumerate(robot.joints):
        held, carried = moved[i], moved[i + 1]
        links += [_apply(held, at_home[i]), _apply(carried, at_home[i])]
        middles.append(_apply(held, drawn[i]))
        axis = joint.screw[:3] if joint.kind is JointKind.PRISMATIC else joint.screw[3:]
        axes.append(held[:3, :3] @ axis)
    links.append(pose(robot, q)[:3, 3])
    names = [joint.name for joint in robot.variables]
    return Drawn(
        np.array(links), np.array(middles), np.array(axes),
        tuple(joint.kind is JointKind.PRISMATIC for joint in robot.joints),
        tuple(names.index(joint.mimic.leader if joint.mimic else joint.name) + 1 for joint in robot.joints),
    )  # fmt: skip


def _apply(moved: Array, point: Array) -> Array:
    return np.asarray(moved[:3, :3] @ point + moved[:3, 3])


def skeleton(robot: Robot) -> tuple[Array, Array]:
    """Points to draw the arm through, at q = 0 in the base frame.

    Point i lies on axis i, nearest to point i + 1 (the last one to the tip), so that the links are the common normals
    and the pieces of the axes between them. A slide has its point where the next one is.

    Returns:
        (N, 3) points p_i, fixed on axis i; and (N, 3) where the joint itself is drawn: half way between p_{i−1} and p_i
        where that way runs along axis i, else at p_i. Both ride on link i − 1 [m].
    """
    count = len(robot.joints)
    points = np.zeros((count, 3))
    following = robot.home[:3, 3]
    for i in range(count - 1, -1, -1):
        points[i] = following = _foot(robot, i, following)
    before = np.vstack([np.zeros(3), points[:-1]])
    drawn = points.copy()
    for i, joint in enumerate(robot.joints):
        way = float(np.linalg.norm(points[i] - before[i]))
        if (
            joint.kind is not JointKind.PRISMATIC
            and np.linalg.norm(_foot(robot, i, before[i]) - before[i]) <= _ALONG + 1e-6 * way
        ):
            drawn[i] = (points[i] + before[i]) / 2
    return points, drawn


def _foot(robot: Robot, i: int, point: Array) -> Array:
    joint = robot.joints[i]
    if joint.kind is JointKind.PRISMATIC:
        return np.array(point)
    axis = joint.screw[3:]
    origin = np.cross(axis, joint.screw[:3])
    return np.asarray(origin + axis * (axis @ (point - origin)))
