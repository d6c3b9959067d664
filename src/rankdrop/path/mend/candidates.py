"""Other joint paths for a tool path: other branches, other self-motions, the base or the tool moved.

Each is a start and what follows from it. They are followed at some places of the path first, and ranked by how far
they stay from a singularity to first order; whoever takes one checks it.

Those of a redundant arm are planned as well, over the whole of its self-motions. At every place of the tool's path the
configurations that reach it are one or more curves (surfaces, with two joints to spare). From the configurations that
can be begun at, layers of them are made place by place,

    q′ = the solution of the pose k + 1 that Newton's method comes to from q + δ·w,   δ ∈ {−h, 0, h}, w a null motion,

so that every layer holds, a spacing apart, what can be reached from the start without leaving the tool path; dynamic
programming over them finds the joint path with the least

    ∑ ‖Δq‖²/(h·room²),   room = σ_r/‖∇σ_r‖,

short in the metric in which singular configurations are far away. It is global where following a gradient is not: a
singular set of codimension two is passed on either side, whatever the slope says at the start. What no layer reaches at
this spacing may be there all the same.

Source: dynamic programming over path parameter and redundancy is by Pashkevich, Dolgui and Chumakov, Int. J. Computer
Integrated Manufacturing 17 (2004), and Ferrentino and Chiacchio, J. Mechanisms Robotics 12 (2020).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import product
from typing import Self

import numpy as np

from rankdrop import _core
from rankdrop.errors import RankdropError
from rankdrop.kinematics import pose
from rankdrop.local.block import block, generic_rank, joint_scale, sampling_box, singular_values
from rankdrop.local.orientation import orientation_coordinates
from rankdrop.local.self_motions import CLOSED, self_motion
from rankdrop.path.check.follow import Pull, follow
from rankdrop.path.check.tool_branch import Followed
from rankdrop.path.curve import Curve, Index, number_parts
from rankdrop.path.read.trajectory import Trajectory, regular_times
from rankdrop.poses.inverse import Aim, distinct, near_and_within, within_limits
from rankdrop.problem import Mask
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.transform import about_axis, translation
from rankdrop.task import Task

Run = Callable[["JointToolPath"], Followed]
"""A joint path at the places of a tool path, however many."""
Progress = Callable[[int, int], None]
"""report(done, all)."""
Parameter = tuple[str, float | tuple[float, ...], str]
"""A number, or some, that a remedy is made with: name, value, and unit ("rad, m": joint values; "": none)."""
Start = tuple["JointToolPath", Array | None, Pull | None, str, tuple[Parameter, ...]]
"""Tool path, start (None: the first pose is not reached), null-space motion, what is done, and with which numbers."""
Layer = tuple[Array, Array, Index]
"""Configurations (M, n) at one place, what they cost from the start, and which of the layer before each is from."""

_FINE = 0.01  # joint motion between two places of a new joint path [rad; slides divided by the length scale]
_RESOLVED = 0.5  # … and in shares of the way to the nearest singularity, to first order
_TOO_NEAR = 2e-4  # paths nearer to a singularity than this are none [rad]
_REACHED = 1.0  # of a start that was not followed to [rad]
_COARSE = 200  # places of a first look
_REFINED, _MOST = 8, 200_000  # rounds of putting places in between, and places at most

_STARTS, _SEED = 600, 20241  # of Newton's method, for the branches at the first pose
_SAME = 1e-5  # configurations nearer to each other are one [rad; slides divided by the length scale]
_APART = 0.1  # … and of redundant arms, points nearer than this to a self-motion are on it
_BRANCHES = 16  # that are followed of a redundant arm
_ALONG = 9  # points of a self-motion that paths begin at
_PULLS = (0.0, 1.0, 3.0)  # null-space motion per joint motion that the tool needs, where σ is small
_PULLED = 0.3  # σ_r at which the pull has its full size
_SHARES = (1.0, 0.5)  # of a bound
_ENOUGH = 0.05  # first-order distance at which a path that keeps its start goes before wider ones that do not [rad]

_STEP = 0.09  # h, of a null motion between two layers [rad; slides divided by the length scale]
_SPACING = 0.06  # of configurations in a layer [rad]; both with one joint to spare, five times that with more
_WIDEST = 600  # configurations of a layer, the cheapest
_LAYERS = (40, 160)  # at least, at most
_LONG = 0.03  # joint motion of the old path from layer to layer that is aimed at [rad]
_JUMP = 3.0  # of one configuration from layer to layer at most, as a multiple of h
_FAR = 0.5  # room beyond which more is no better [rad]
_NEAR = 0.01  # … and below which a configuration is not taken
_ROUNDS = 40  # of smoothing
_KEPT = 0.8  # share of the least room that smoothing leaves
_OFF = 0.1  # of a configuration between layers from the curve through them [rad]


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
        else:
            times = times
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
        turn = orientation_coordinates(now[:, :3, :3] @ wanted[:, :3, :3].swapaxes(1, 2), "rotvec")
        apart = np.linalg.norm(now[:, :3, 3] - wanted[:, :3, 3], axis=1)
        return float(apart.max(initial=0.0)), float(np.linalg.norm(turn, axis=1).max(initial=0.0))

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


def start_moved(tool: JointToolPath) -> Array | None:
    """(n,) a configuration at the first pose as it is moved: followed to from the path's first one, else the one that
    Newton's method finds near it; None where neither gets there.
    """
    way = np.stack([pose(tool.robot, tool.q[0]), tool.poses[0]])
    lead = follow(tool.robot, way, tool.q[0], tool.task, limits=tool.limits)
    if lead.complete:
        return np.asarray(lead.q[-1])
    solved, arrived = tool.aim.solve(tool.poses[:1], tool.q[:1])
    near = float(np.linalg.norm((solved[0] - tool.q[0]) / tool.aim.joints)) < _REACHED
    if arrived[0] and near and tool.in_limits(solved)[0]:
        return np.asarray(solved[0])
    return None


@dataclass(frozen=True, eq=False)
class Candidate:
    """A joint path to be tried.

    Attributes:
        tool: the tool's path, moved or not.
        run: the joint path at the places of such a tool path.
        how: what is done.
        parameters: what with.
        room: the least first-order distance from a singularity at these places [rad].
        kept: it begins where the path does.
    """

    tool: JointToolPath
    run: Run
    how: str
    parameters: tuple[Parameter, ...]
    room: float
    kept: bool = False


Ranking = tuple[list[Candidate], Counter[str]]
"""Candidates that run the whole tool path, widest first; and how many of the others end for each reason."""


def rank_starts(starts: Iterable[Start], count: int, report: Progress) -> Ranking:
    """Each start followed on some places of its path.

    Args:
        starts: worked out as they are followed.
        count: how many there will be.
        report: how many are done.
    """
    candidates: list[Candidate] = []
    ended: Counter[str] = Counter()
    for k, (tool, start, pull, how, parameters) in enumerate(starts):
        report(k, count)
        if start is None:
            ended["start"] += 1
            continue
        look = tool.coarse()
        run, start = _begin_turn_away(look, start, pull, look.follow_branch(start, pull))
        if not run.complete:
            ended[run.reason] += 1
            continue
        unchanged = bool((start == tool.q[0]).all())
        followed_from = partial(JointToolPath.follow_branch, start=start, pull=pull)
        candidates.append(Candidate(tool, followed_from, how, parameters, float(tool.room(run.q).min()), unchanged))
    candidates.sort(key=lambda candidate: -candidate.room)
    report(count, count)
    return candidates, ended


def _begin_turn_away(
    tool: JointToolPath, start: Array, pull: Pull | None, followed: Followed
) -> tuple[Followed, Array]:
    """The same branch with a joint that reaches its limit begun a whole turn away, where there is room."""
    robot = tool.robot
    over = np.flatnonzero((followed.last > robot.upper - 1e-4) | (followed.last < robot.lower + 1e-4))
    for joint in over[robot.periodic[over]] if followed.reason == "limit" else ():
        other = start.copy()
        other[joint] -= 2 * np.pi * np.sign(followed.last[joint] - start[joint])
        if robot.lower[joint] <= other[joint] <= robot.upper[joint]:
            followed_other = tool.follow_branch(other, pull)
            if followed_other.complete:
                return followed_other, other
    return followed, start


def branches(tool: JointToolPath, report: Progress) -> Ranking:
    """Other branches of the inverse kinematics at the first pose."""
    starts = other_branches(tool)
    if tool.robot.n > tool.task.m:
        pull = _pull(tool, 1.0)
    else:
        pull = None
    tried = ((tool, start, pull, "branch", (joint_values("start", start),)) for start in starts)
    ranking = rank_starts(tried, len(starts), report)
    if starts and not ranking[0] and tool.redundant:
        _plan(ranking, tool, starts, report, around=True)
    return ranking


def joint_values(name: str, values: Array, unit: str = "rad, m") -> Parameter:
    """Numbers that a remedy is made with: joint values, or others with their unit."""
    return name, tuple((values + 0.0).tolist()), unit


def other_branches(tool: JointToolPath) -> list[Array]:
    """Configurations at the first pose on other branches than the path's, near to it in whole turns."""
    robot, task = tool.robot, tool.task
    low, high = sampling_box(robot, task, limits=tool.limits)
    starts = np.random.default_rng(_SEED).uniform(low, high, (_STARTS, robot.n))
    branches = near_and_within(robot, tool.aim.solve_from(tool.poses[0], starts), tool.q[0], limits=tool.limits)
    if tool.redundant:
        known = _self_motion(tool)
    else:
        known = tool.q[:1]
    if known is None:
        return []
    sigma = singular_values(robot, branches, task)[:, tool.rank - 1]
    if tool.redundant:
        near, most = (_APART, _BRANCHES)
    else:
        near, most = (_SAME, None)
    return list(distinct(robot, task, branches[sigma > _SAME], near, known, most))


def _self_motion(tool: JointToolPath) -> Array | None:
    """(N, n) points of the self-motion through the beginning; None where there is more than one, or none is traced."""
    if tool.robot.n - tool.rank != 1:
        return None
    null = np.asarray(tool.aim.joints * np.linalg.svd(tool.aim.jacobian(tool.q[:1])[0])[2][tool.rank])
    parts = []
    for direction in (null, -null):
        try:
            traced = self_motion(
                tool.robot, tool.q[0], tool.task, length=30.0, direction=direction, limits=tool.limits
            )
        except RankdropError:  # the start is singular, or the task is not determined by the pose
            return None
        parts.append(traced.q)
        if traced.ended == CLOSED:
            break
    return np.concatenate(parts)


def _pull(tool: JointToolPath, strength: float) -> Pull | None:
    """Towards larger σ_r, the stronger the smaller it is."""
    if strength == 0.0:
        return None
    scale = joint_scale(tool.robot, tool.task)

    def pull(q: Array) -> Array:
        sigma, slopes = tool.rising(q[None])
        slope, size = slopes[0], float(np.linalg.norm(slopes[0]))
        weak = min(1.0, (_PULLED / max(float(sigma[0]), 1e-12)) ** 2)
        return np.asarray(strength * weak * scale * slope / max(size, 1e-12))

    return pull


def null_spaces(tool: JointToolPath, report: Progress) -> Ranking:
    """The same tool path with other null-space motion: from the same start, planned over the self-motions; pulled to
    larger σ; begun elsewhere on the self-motion.
    """
    if not tool.redundant:
        return [], Counter()
    traced = _self_motion(tool)
    starts = [(tool.q[0], "same start")]
    if traced is not None:
        rows = np.unique(np.linspace(0, len(traced) - 1, _ALONG).astype(int))[1:]
        starts += [(start, "elsewhere") for start in traced[rows]]
    ranking = rank_starts(
        ((tool, start, _pull(tool, strength), how, (joint_values("start", start), ("pull to larger σ", strength, "")))
         for (start, how), strength in product(starts, _PULLS)), len(starts) * len(_PULLS), report,
    )  # fmt: skip
    if not _plan(ranking, tool, [tool.q[0]], report, around=False) and not ranking[0]:
        _plan(ranking, tool, [tool.q[0]], report, around=True)
    ranking[0].sort(key=lambda one: (not (one.kept and one.room >= _ENOUGH), -one.room))
    return ranking


def shifts(tool: JointToolPath, most: float, report: Progress) -> Ranking:
    """The base moved by up to a length [m], in directions that the task knows."""
    steps = [most * share * way for way, share in product(_ways([row for row in tool.task.rows if row < 3]), _SHARES)]
    moved = ((tool.shift(translation(*(-step)), np.eye(4)), (joint_values("base shift", step, "m"),)) for step in steps)
    starts = ((path, start_moved(path), None, "shift", numbers) for path, numbers in moved)
    return rank_starts(starts, len(steps), report)


def tilts(tool: JointToolPath, most: float, report: Progress) -> Ranking:
    """The tool tilted about its tip by up to an angle [rad]: about axes square to Z of the tip, where the task allows.
    """
    rows = [row - 3 for row in tool.task.rows if row >= 3]
    turns = [(way, most * share) for way, share in product(_ways([row for row in rows if row < 2] or rows), _SHARES)]
    moved = (
        (tool.shift(np.eye(4), about_axis(way, angle)), (("tool tilt", angle, "rad"), joint_values("axis", way, "")))
        for way, angle in turns
    )
    starts = ((path, start_moved(path), None, "tilt", numbers) for path, numbers in moved)
    return rank_starts(starts, len(turns), report)


def _ways(axes: Sequence[int]) -> Iterator[Array]:
    """Unit vectors (3,) in the directions whose parts along the axes given are −1, 0 or 1."""
    for signs in product((-1.0, 0.0, 1.0), repeat=len(axes)):
        if any(signs):
            way = np.zeros(3)
            way[list(axes)] = signs
            yield way / np.linalg.norm(way)


def _plan(ranking: Ranking, tool: JointToolPath, starts: Sequence[Array], report: Progress, *, around: bool) -> bool:
    """One more for a ranking, planned over all self-motions; whether there is one."""
    remedy, ended = ranking
    place, plan, free = plan_path(tool, np.array(starts), report, around=around)
    if not len(plan):
        ended["plan"] += 1
        return False
    if around:
        how = "planned elsewhere"
    else:
        how = "planned"
    remedy.append(Candidate(tool, plan_as_run(place, plan), how, (joint_values("start", plan[0]),), free, not around))
    return True


def plan_path(tool: JointToolPath, starts: Array, report: Progress, *, around: bool) -> tuple[Array, Array, float]:
    """The best joint path that was found for a tool path of a redundant arm.

    Args:
        tool: the tool's path.
        starts: (S, n) configurations at its first pose.
        report: how many layers are done, of how many.
        around: begin anywhere on their self-motions.

    Returns:
        (K,) places of the layers up to the last one reached, (K, n) the path there, empty where no path of this spacing
        reaches the end of the tool's path, and the least room on it [rad].
    """
    layers = tool.spread(int(np.clip(np.ceil(float(tool.lengths[-1]) / _LONG), *_LAYERS)))
    now = _cheapest(layers, starts, np.zeros(len(starts)), np.full(len(starts), -1))
    if around:
        now = _self_motion_layer(layers, now)
    reached = [now]
    for k in range(1, len(layers.place)):
        report(k, len(layers.place))
        now = _next_layer(layers, now, k)
        if not len(now[0]):
            return layers.place[:k], np.empty((0, tool.robot.n)), 0.0
        reached.append(now)
    rows = [int(now[1].argmin())]
    for _, _, parent in reached[:0:-1]:
        rows.append(int(parent[rows[-1]]))
    q = np.array([layer[0][row] for layer, row in zip(reached, rows[::-1], strict=True)])
    q = _smooth(layers, q, fixed=not around)
    return layers.place, q, float(_room(layers, q).min())


def plan_as_run(place: Array, plan: Array) -> Run:
    """A plan (K, n) at places (K,) as a joint path at the places of any tool path, polished to the poses there."""

    def run(tool: JointToolPath) -> Followed:
        guess = _interpolate_plan(place, plan, tool.place)
        q, arrived = tool.aim.solve(tool.poses, guess)
        off = np.linalg.norm((q - guess) / tool.aim.joints, axis=1)
        good = arrived & (off <= _OFF) & tool.in_limits(q)
        if good.all():
            return Followed(q, tool.place + 1.0, True, float(len(q)), q[-1])
        count = int(good.argmin())
        return Followed(q[:count], tool.place[:count] + 1.0, False, float(count), q[max(0, count - 1)], "stuck")

    return run


def _interpolate_plan(place: Array, q: Array, wanted: Array) -> Array:
    """(N, n) at places (N,) of the cubics through the layers with the slopes of their neighbours (Catmull and Rom)."""
    k = np.clip(np.searchsorted(place, wanted, side="right") - 1, 0, len(place) - 2)
    slope = np.gradient(q, place, axis=0)
    h = (place[k + 1] - place[k])[:, None]
    t = (wanted - place[k])[:, None] / h
    a, b = (1 + 2 * t) * (1 - t) ** 2, t**2 * (3 - 2 * t)
    return np.asarray(
        a * q[k] + b * q[k + 1] + h * (t * (1 - t) ** 2 * slope[k] - t**2 * (1 - t) * slope[k + 1])
    )  # fmt: skip


def _room(tool: JointToolPath, q: Array) -> Array:
    """(N,) first-order distance from the singular set, no more than is of use."""
    return np.minimum(_FAR, tool.room(q))


def _next_layer(tool: JointToolPath, now: Layer, k: int) -> Layer:
    aim, (before, paid, _) = tool.aim, now
    guess, origin = _null_motion_guesses(aim, before)
    q, arrived = aim.solve(np.broadcast_to(tool.poses[k], (len(guess), 4, 4)), guess)
    far = np.linalg.norm((q - before[origin]) / aim.joints, axis=1)
    good = arrived & (far <= _JUMP * _sizes(aim)[0]) & tool.in_limits(q)
    q, origin, far = q[good], origin[good], far[good]
    if not len(q):
        return q, far, origin
    free = _room(tool, q)
    good = (free > _NEAR) & (far <= 2 * free)
    q, origin, far, free = q[good], origin[good], far[good], free[good]
    return _cheapest(tool, q, paid[origin] + far**2 / (_sizes(aim)[0] * free**2), origin)


def _self_motion_layer(tool: JointToolPath, now: Layer) -> Layer:
    """All of the self-motions of the first layer, as far as they are inside the limits and regular."""
    q = fresh = now[0]
    while len(fresh) and len(q) < _WIDEST:
        guess, _ = _null_motion_guesses(tool.aim, fresh)
        moved, arrived = tool.aim.solve(np.broadcast_to(tool.poses[0], (len(guess), 4, 4)), guess)
        moved = moved[arrived & tool.in_limits(moved)]
        if len(moved):
            moved = moved[_room(tool, moved) > _NEAR]
        else:
            moved = moved
        both = np.concatenate([q, moved])
        both, _, _ = _cheapest(tool, both, np.arange(len(both), dtype=np.float64), np.zeros(len(both), dtype=np.int64))
        fresh, q = both[len(q) :], both
    return q, np.zeros(len(q)), np.full(len(q), -1)


def _cheapest(tool: JointToolPath, q: Array, cost: Array, parent: Index) -> Layer:
    """The cheapest of configurations that are nearer to each other than the spacing."""
    robot, spacing = tool.robot, _sizes(tool.aim)[1]
    bounded = tool.limits & np.isfinite(robot.upper - robot.lower)
    turning = np.flatnonzero(robot.periodic & ~bounded)
    order = np.argsort(cost, kind="stable")
    places = q[order] / tool.aim.joints
    taken: list[int] = []
    left = np.ones(len(q), dtype=np.bool_)
    for i in range(len(q)):
        if not left[i]:
            continue
        taken.append(i)
        if len(taken) == _WIDEST:
            break
        gap = places[i:] - places[i]
        gap[:, turning] -= 2 * np.pi * np.round(gap[:, turning] / (2 * np.pi))
        left[i:] &= (gap * gap).sum(axis=1) > spacing**2
    rows = order[np.array(taken, dtype=np.int64)]
    return q[rows], cost[rows], parent[rows]


def _smooth(tool: JointToolPath, q: Array, *, fixed: bool) -> Array:
    """The path drawn straight as far as it does not come much nearer to a singularity."""
    least = _KEPT * float(_room(tool, q).min())
    first = 1 if fixed else 0
    for _ in range(_ROUNDS):
        padded = np.concatenate([q[:1], q, q[-1:]])
        wanted = (padded[:-2] + 2 * q + padded[2:]) / 4
        moved, arrived = tool.aim.solve(tool.poses[first:], wanted[first:])
        if not arrived.all() or not tool.in_limits(moved).all() or float(_room(tool, moved).min()) < least:
            break
        q = np.concatenate([q[:first], moved])
    return q


def _sizes(aim: Aim) -> tuple[float, float]:
    """Of a null motion between layers, and between the configurations of one [rad]."""
    if aim.robot.n - aim.rank == 1:
        return (_STEP, _SPACING)
    return (5 * _STEP, 5 * _SPACING)


def _null_motion_guesses(aim: Aim, q: Array) -> tuple[Array, Index]:
    """Guesses (G, n): each as it is, and a step along every null motion, both ways; and which each is of."""
    _, _, v = _core.svd(np.ascontiguousarray(aim.jacobian(q)))
    null = v[:, :, aim.rank :] * aim.joints[:, None] * _sizes(aim)[0]
    ways = [q, *(q + sign * null[:, :, i] for i in range(null.shape[2]) for sign in (1.0, -1.0))]
    return np.concatenate(ways), np.tile(np.arange(len(q)), len(ways))
