"""The axes of an arm's joints at some configurations, and which of them are parallel, aligned, or meet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from rankdrop.kinematics import jacobian, pose
from rankdrop.local.departure import release_mimics
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.transform import cross
from rankdrop.task import SPACE
from rankdrop.tolerances import ALIGNED

Verdicts = NDArray[np.bool_]  # one per configuration
_KEPT = 16
"""Scenes of one configuration that are kept: an explanation asks for one several times."""


@dataclass(frozen=True, eq=False)
class Scene:
    """Joint axes at N configurations, in the base frame. Joints are numbered from 0 here.

    An axis (revolute joint) is the line p_i + s z_i with z = ω, p = ω × v.
    """

    robot: Robot
    q: Array  # (N, n)
    tolerance: float = ALIGNED

    @classmethod
    def of_joints(cls, robot: Robot, q: Array, tolerance: float = ALIGNED) -> Scene:
        """The scene at configurations (N, n) in which every mimic joint is a joint of its own."""
        free, values, _ = release_mimics(robot, q)
        return cls(free, values, tolerance)

    @staticmethod
    def at(robot: Robot, q: Array, tolerance: float = ALIGNED, *, every_joint: bool = False) -> Scene:
        """The scene at one configuration (n,), the same one for the next who asks; `every_joint`: as `of_joints`."""
        split = every_joint and robot.n < len(robot.joints)
        return _scene_at(robot, np.asarray(q, dtype=np.float64).tobytes(), tolerance, split)

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
    def slides(self) -> Verdicts:
        """(n,) which joints are prismatic."""
        return np.array([kind is JointKind.PRISMATIC for kind in self.kinds])

    @cached_property
    def z(self) -> Array:
        """(n, N, 3) unit directions of the axes; those of the slides for prismatic joints."""
        columns = np.moveaxis(self.screws, -1, 0)
        return np.where(self.slides[:, None, None], columns[..., :3], columns[..., 3:])

    @cached_property
    def p(self) -> Array:
        """(n, N, 3) the points of the axes nearest to the base origin [m]."""
        columns = np.moveaxis(self.screws, -1, 0)
        return cross(columns[..., 3:], columns[..., :3])

    @cached_property
    def _projected(self) -> tuple[Array, Array]:
        """(n, N, 3, 3) projectors 1 − z zᵀ along the axes, and (n, N, 3, 1) what they make of the points p."""
        normal = np.eye(3) - self.z[..., :, None] * self.z[..., None, :]
        return normal, normal @ self.p[..., None]

    @cached_property
    def tip(self) -> Array:
        """(N, 3) the tip [m]."""
        return pose(self.robot, self.q)[..., :3, 3]

    @cached_property
    def length(self) -> float:
        """Reach of the arm [m]; distances are judged against it."""
        return reach(self.robot)

    @cached_property
    def parallel(self) -> Verdicts:
        """(n, n, N) |z_i × z_j| = 0."""
        return self.small(cross(self.z[:, None], self.z[None]))

    @cached_property
    def perpendicular(self) -> Verdicts:
        """(n, n, N) z_i · z_j = 0."""
        return np.asarray(np.abs(inner_product(self.z[:, None], self.z[None])) < self.tolerance)

    @cached_property
    def aligned(self) -> Verdicts:
        """(n, n, N) whether axes i and j are one line, parallel and with (p_j − p_i) × z_i = 0."""
        return self.parallel & self.on_axis(self.p[None], np.arange(len(self.p))[:, None])

    @cached_property
    def crossings(self) -> tuple[Verdicts, Verdicts]:
        """(n, n, N) whether axes i and j meet in one point, and (n, n, n, N) which axes go through it.

        They meet at p_i + s z_i, s from (p_j − p_i) × z_j = s z_i × z_j.
        """
        skew, apart = cross(self.z[:, None], self.z[None]), self.p[None] - self.p[:, None]
        meet = ~self.parallel & (np.abs(inner_product(apart, skew)) <= self.tolerance * self.length)
        s = inner_product(cross(apart, self.z[None]), skew) / np.where(meet, inner_product(skew, skew), 1.0)
        points = self.p[:, None] + s[..., None] * self.z[:, None]
        number = np.arange(len(self.p))
        on = self.on_axis(points[:, :, None], number)
        return meet & on[number[:, None], number, number], on

    def after_motion(self, joint: int, by: float) -> Scene:
        """The scene after one joint has moved by `by` [rad, m]."""
        q = self.q.copy()
        q[:, joint] += by
        return Scene(self.robot, q, self.tolerance)

    def on_axis(self, point: Array, i: int | NDArray[np.intp]) -> Verdicts:
        """(point − p_i) × z_i = 0 for points (..., N, 3)."""
        return self.small(cross(point - self.p[i], self.z[i]) / self.length)

    def meeting(self, i: int, j: int) -> Verdicts:
        """Not parallel and in one plane: (p_j − p_i) · (z_i × z_j) = 0."""
        volume = inner_product(self.p[j] - self.p[i], cross(self.z[i], self.z[j]))
        return np.asarray(~self.parallel[i, j] & (np.abs(volume) < self.tolerance * self.length))

    def common_point(self, axes: Sequence[int]) -> tuple[Array, Verdicts]:
        """(N, 3) the point nearest to some axes, Σ (1 − z zᵀ)(x − p) = 0, and whether it is on all of them."""
        members, (normal, foot) = np.array(axes), self._projected
        total, right = normal[members].sum(axis=0), foot[members].sum(axis=0)
        regular = np.linalg.eigvalsh(total)[:, 0] > self.tolerance  # 0 where all are parallel
        point = np.linalg.solve(np.where(regular[:, None, None], total, np.eye(3)), right)[..., 0]
        return point, self.on_axis(point, members).all(axis=0) & regular

    def in_plane(self, point: Array, i: int, direction: Array) -> Verdicts:
        """In the plane through axis i along `direction` (N, 3): (point − p_i) · (z_i × direction) = 0."""
        return np.abs(inner_product(point - self.p[i], cross(self.z[i], direction))) < self.tolerance * self.length

    def coplanar(self, axes: Sequence[int], point: Array | None = None) -> Verdicts:
        """All axes (and the point) in one plane."""
        first, members = axes[0], np.array(axes)
        if point is None:
            points = self.p[members[1:]]
        else:
            points = np.concatenate([self.p[members[1:]], point[None]])
        spans = np.concatenate([self.z[members], (points - self.p[first]) / self.length])  # (s, N, 3)
        # remove the freedom along the first axis from the points: only their offset from it counts
        spans = spans - self.z[first] * inner_product(spans, self.z[first])[..., None]
        return np.linalg.svd(spans.swapaxes(0, 1), compute_uv=False)[:, 1] < self.tolerance

    def small(self, vector: Array) -> Verdicts:
        """Vectors (..., 3) that are zero."""
        return np.asarray(np.linalg.norm(vector, axis=-1) < self.tolerance)


@lru_cache(maxsize=_KEPT)
def _scene_at(robot: Robot, q: bytes, tolerance: float, split: bool) -> Scene:
    row = np.frombuffer(q)[None]
    if split:
        return Scene.of_joints(robot, row, tolerance)
    return Scene(robot, row, tolerance)


def inner_product(a: Array, b: Array) -> Array:
    """(...) a · b of vectors (..., 3)."""
    return np.asarray(np.einsum("...i,...i->...", a, b))


def indices(mask: Verdicts) -> tuple[int, ...]:
    """Indices of the joints for which a verdict (n,) is true."""
    return tuple(mask.nonzero()[0].tolist())


def numbers(members: Sequence[int]) -> str:
    """ "2–6" for a run of four or more, "1, 3, 4" otherwise, numbers from 1."""
    if len(members) > 3 and members[-1] - members[0] == len(members) - 1:
        return f"{members[0] + 1}–{members[-1] + 1}"
    return ", ".join(str(i + 1) for i in members)
