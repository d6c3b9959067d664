"""The arm as lines in space, at one configuration and at many, and what the lines have in common; where to draw it.

`Lines` are those of one configuration, mimic joints too; `Scene` asks the same of many configurations at once, about
the variables. `Drawn` has one point on each axis, from the numbers of the joints alone, and these points at q.

Last the one home of "a good posture", one that people would choose to look at: inside the limits, above the base, not
folded into itself. Start poses, pictures and the witnesses that pages show are chosen by `fault`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rankdrop.kinematics import check_robot, jacobian, link_poses, pose
from rankdrop.local.block import generic_rank, sampling_box, singular_values
from rankdrop.local.bracket import cross
from rankdrop.local.taylor import unlocked
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.numbers import reach
from rankdrop.task import SPACE, Task
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


STEP = np.pi / 18
"""Turning joints of candidates stand at multiples of this, 10° [rad]."""
_STOPS = 8  # slides of candidates stand at eighths of their travel
_CANDIDATES = 512  # of a start; twice as many change no arm of the catalogue visibly
_LIMIT, _UNDER, _FOLDED, _CLOSE = 6.0, 3.0, 2.0, 0.5  # a joint beyond a limit weighs more than all the rest
_DEEP = 0.1  # this far below the base is as bad as farther [reach]
_TIP = 0.05  # the tip should be above the base by this [reach]
_APART = 0.12  # links this far apart are not in each other's way [reach]
_SHARP = 0.85  # cosine of the angle, 32°, from which a link that turns back onto the one before it counts as folded
_LONG = 0.08  # shorter pieces of the spine are flanges, not links [reach]
_POINTS = np.linspace(0.0, 1.0, 6)  # along a link, between which distances are measured


def fault(robot: Robot, q: Array) -> Array:
    """What speaks against showing an arm at some configurations: 0 for nothing, more for worse.

    Counted in this order: joints beyond a limit; links below the plane z = 0 of the base, and a tip that is not above
    it; links that touch or cross others, or turn back onto the one before; a tip that stands over the base.

    Args:
        robot: the arm.
        q: (N, n) configurations [rad, m].

    Returns:
        (N,) ≥ 0, without unit: 6 for each joint beyond a limit, less than that for all the rest together.
    """
    q = np.asarray(q, dtype=np.float64).reshape(-1, robot.n)
    size = max(reach(robot), 1e-9)
    points = spine(robot, q) / size
    outside = ((q < robot.lower - 1e-9) | (q > robot.upper + 1e-9)).sum(axis=1)
    low = np.clip(-points[:, :, 2].min(axis=1), 0.0, _DEEP) + np.clip(_TIP - points[:, -1, 2], 0.0, _TIP)
    beside = np.hypot(points[:, -1, 0], points[:, -1, 1])
    close = np.clip(0.3 - beside, 0.0, None)
    return np.asarray(_LIMIT * outside + _UNDER * low / (_DEEP + _TIP) + _FOLDED * _folded(points) + _CLOSE * close)


def spine(robot: Robot, q: Array) -> Array:
    """(N, P, 3) points from the base to the tip, joined by the links, at configurations q (N, n) [m]."""
    at_home, _ = skeleton(robot)
    poses = link_poses(robot, q)
    frames = [np.eye(4), *(joint.frame for joint in robot.joints)]
    moved = [poses[:, i] @ np.linalg.inv(frame) for i, frame in enumerate(frames)]
    points = [np.zeros((len(q), 3))]
    for i, point in enumerate(at_home):
        points += [carried[:, :3, :3] @ point + carried[:, :3, 3] for carried in (moved[i], moved[i + 1])]
    points.append(poses[:, -1, :3, 3])
    return np.stack(points, axis=1)


def _folded(points: Array) -> Array:
    """(N,) 0 … 1 how much of the arm is in the way of another part of it; points (N, P, 3) in units of the reach."""
    ways = np.diff(points, axis=1)
    longest = np.linalg.norm(ways, axis=2).max(axis=0)
    kept = np.flatnonzero(longest > _LONG)
    found = np.zeros(len(points))
    inside = points[:, kept, None] + _POINTS[:, None] * ways[:, kept, None]  # (N, S, T, 3)
    units = ways[:, kept] / np.maximum(np.linalg.norm(ways[:, kept], axis=2, keepdims=True), 1e-12)
    for a in range(len(kept)):
        for b in range(a + 1, len(kept)):
            between = float(longest[kept[a] + 1 : kept[b]].sum())
            if b == a + 1:
                back = -(units[:, a] * units[:, b]).sum(axis=1)
                found += np.clip((back - _SHARP) / (1.0 - _SHARP), 0.0, 1.0)
            room = min(_APART, 0.5 * between)
            if room > 0.01:
                apart = np.linalg.norm(inside[:, a, :, None] - inside[:, b, None], axis=3).min(axis=(1, 2))
                found += np.clip(1.0 - apart / room, 0.0, 1.0) ** 2
    return np.minimum(found, 1.0)


def candidates(robot: Robot, task: Task, count: int, seed: int) -> Array:
    """(count, n) configurations inside the limits at round values: turning joints at multiples of 10° [rad, m]."""
    low, high = sampling_box(robot, task, limits=True)
    turns = robot.periodic | (np.array(robot.units) == "rad")
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    middle = np.where(turns & (low < 0) & (high > 0), 0.0, middle)
    q = middle + np.random.default_rng(seed).uniform(-1.0, 1.0, (count, robot.n)) * np.minimum(half, np.pi)
    step = np.where(turns, STEP, np.maximum(high - low, 1e-9) / _STOPS)
    origin = np.where(turns, 0.0, low)
    rounded = origin + np.round((np.clip(q, low, high) - origin) / step) * step
    return np.asarray(np.where((rounded < low) | (rounded > high), middle, rounded))


def start_posture(robot: Robot, task: Task, seed: int = 0) -> Array:
    """(n,) where to begin with an arm: a good posture, far from singular, its joints at round values [rad, m].

    Args:
        robot: the arm.
        task: from `resolve_task`; its generic rank says which σ is to be large.
        seed: of the candidates.
    """
    q = candidates(robot, task, _CANDIDATES, seed)
    rank = generic_rank(robot, task)
    sigma = singular_values(robot, q, task)[:, rank - 1] if rank else np.ones(len(q))
    turned = np.where(robot.periodic, np.abs(q) / np.pi, 0.0).mean(axis=1)
    turned = turned + 0.5 * np.abs(q[:, 0]) / np.pi * bool(robot.periodic[0])  # joint 1 looks towards the reader
    worth = 2.0 * fault(robot, q) - sigma / max(float(sigma.max()), 1e-12) + 0.8 * turned
    return np.asarray(q[int(worth.argmin())])
