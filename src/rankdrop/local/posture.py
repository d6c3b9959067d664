"""Where to draw an arm, and which posture to show: a skeleton of links and axes, and what speaks against a posture.

`Drawn` has one point on each axis, from the numbers of the joints alone, and these points at q. `fault` is the one home
of "a good posture", one that people would choose to look at: inside the limits, above the base, not folded into itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rankdrop.kinematics import check_robot, link_poses, pose
from rankdrop.local.block import generic_rank, sampling_box, singular_values
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.task import Task

_ALONG = 1e-9  # a point this near an axis, per length of the way, is on it

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
    slides = tuple(joint.kind is JointKind.PRISMATIC for joint in robot.joints)
    held = _link_motions(robot, q)[:-1]  # joint i rides on link i − 1
    screws = np.stack([joint.screw for joint in robot.joints])
    axes = np.where(np.array(slides)[:, None], screws[:, :3], screws[:, 3:])
    names = [joint.name for joint in robot.variables]
    return Drawn(
        spine(robot, np.asarray(q)[None])[0], _carry_points(held, skeleton(robot)[1]),
        np.einsum("nij,nj->ni", held[:, :3, :3], axes), slides,
        tuple(names.index(joint.mimic.leader if joint.mimic else joint.name) + 1 for joint in robot.joints),
    )  # fmt: skip


def _link_motions(robot: Robot, q: Array) -> Array:
    """(..., N + 1, 4, 4) how base and links have moved from where they are at q = 0."""
    frames = np.stack([np.eye(4), *(joint.frame for joint in robot.joints)])
    return np.asarray(link_poses(robot, q)[..., :-1, :, :] @ np.linalg.inv(frames))


def _carry_points(motions: Array, points: Array) -> Array:
    """(..., N, 3) points (N, 3) carried along by motions (..., N, 4, 4)."""
    return np.asarray((motions[..., :3, :3] @ points[..., None])[..., 0] + motions[..., :3, 3])


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
        off, way = (float(np.linalg.norm(end - before[i])) for end in (_foot(robot, i, before[i]), points[i]))
        if joint.kind is not JointKind.PRISMATIC and off <= _ALONG + 1e-6 * way:
            drawn[i] = (points[i] + before[i]) / 2
    return points, drawn


def _foot(robot: Robot, i: int, point: Array) -> Array:
    joint = robot.joints[i]
    if joint.kind is JointKind.PRISMATIC:
        return np.array(point)
    axis = joint.screw[3:]
    origin = np.cross(axis, joint.screw[:3])
    return np.asarray(origin + axis * (axis @ (point - origin)))


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
    return np.asarray(_LIMIT * outside + _UNDER * low / (_DEEP + _TIP) + _FOLDED * _fold_share(points) + _CLOSE * close)


def by_habit(robot: Robot, task: Task, q: Array) -> NDArray[np.int64]:
    """(N,) order of the solutions of one pose, those first that people use.

    Nothing speaks against the posture (`fault`), the elbow is up, the joints are near the maker's zero, and no
    singularity is near. No numbers of makers are used.

    Args:
        robot, task: the arm.
        q: (N, n) configurations with the same tip [rad, m].
    """
    rank = generic_rank(robot, task)
    if rank:
        sigma = singular_values(robot, q, task)[:, rank - 1]
    else:
        sigma = np.ones(len(q))
    height = spine(robot, q)[:, :, 2].mean(axis=1) / max(reach(robot), 1e-9)
    turned = np.where(robot.periodic, np.abs(q) / np.pi, 0.0).mean(axis=1)
    clear = sigma / max(float(sigma.max(initial=0.0)), 1e-12)
    against = 2.0 * fault(robot, q) - 3.0 * height + 0.8 * turned - 0.5 * clear
    return np.asarray(np.argsort(np.round(against, 6), kind="stable"))


def spine(robot: Robot, q: Array) -> Array:
    """(N, P, 3) points from the base to the tip, joined by the links, at configurations q (N, n) [m]."""
    points, motions = skeleton(robot)[0], _link_motions(robot, q)
    pairs = np.stack([_carry_points(motions[:, :-1], points), _carry_points(motions[:, 1:], points)], axis=2)
    base, tip = np.zeros((len(q), 1, 3)), pose(robot, q)[:, None, :3, 3]
    return np.concatenate([base, pairs.reshape(len(q), -1, 3), tip], axis=1)


def _fold_share(points: Array) -> Array:
    """(N,) 0 … 1 how much of the arm is in the way of another part of it; points (N, P, 3) in units of the reach."""
    ways = np.diff(points, axis=1)
    longest = np.linalg.norm(ways, axis=2).max(axis=0)
    kept = np.flatnonzero(longest > _LONG)
    share = np.zeros(len(points))
    inside = points[:, kept, None] + _POINTS[:, None] * ways[:, kept, None]  # (N, S, T, 3)
    units = ways[:, kept] / np.maximum(np.linalg.norm(ways[:, kept], axis=2, keepdims=True), 1e-12)
    for a in range(len(kept)):
        for b in range(a + 1, len(kept)):
            between = float(longest[kept[a] + 1 : kept[b]].sum())
            if b == a + 1:
                back = -(units[:, a] * units[:, b]).sum(axis=1)
                share += np.clip((back - _SHARP) / (1.0 - _SHARP), 0.0, 1.0)
            room = min(_APART, 0.5 * between)
            if room > 0.01:
                apart = np.linalg.norm(inside[:, a, :, None] - inside[:, b, None], axis=3).min(axis=(1, 2))
                share += np.clip(1.0 - apart / room, 0.0, 1.0) ** 2
    return np.minimum(share, 1.0)


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
    if rank:
        sigma = singular_values(robot, q, task)[:, rank - 1]
    else:
        sigma = np.ones(len(q))
    turned = np.where(robot.periodic, np.abs(q) / np.pi, 0.0).mean(axis=1)
    turned = turned + 0.5 * np.abs(q[:, 0]) / np.pi * bool(robot.periodic[0])  # joint 1 looks towards the reader
    worth = 2.0 * fault(robot, q) - sigma / max(float(sigma.max()), 1e-12) + 0.8 * turned
    return np.asarray(q[int(worth.argmin())])
