"""Other joint paths for a tool path: other branches, other self-motions, the base or the tool moved.

Each is a start and what follows from it. They are followed at some places of the path first, and ranked by how far
they stay from a singularity to first order; whoever takes one checks it.

Those of a redundant arm are planned as well, over the whole of its self-motions: `path.mend.self_motion_plan`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np

from rankdrop.errors import RankdropError
from rankdrop.kinematics import pose
from rankdrop.local.block import joint_scale, sampling_box, singular_values
from rankdrop.local.self_motions import CLOSED, self_motion
from rankdrop.path.check.follow import Pull, follow
from rankdrop.path.check.tool_branch import Followed
from rankdrop.path.mend.joint_tool_path import JointToolPath, Run
from rankdrop.path.mend.record import Parameter, joint_values
from rankdrop.path.mend.self_motion_plan import plan_as_run, plan_path
from rankdrop.poses.inverse import distinct, near_and_within
from rankdrop.robot.model import Array
from rankdrop.robot.transform import about_axis, translation

Progress = Callable[[int, int], None]
"""report(done, all)."""
Start = tuple[JointToolPath, Array | None, Pull | None, str, tuple[Parameter, ...]]
"""Tool path, start (None: the first pose is not reached), null-space motion, what is done, and with which numbers."""

_REACHED = 1.0  # of a start that was not followed to [rad]
_STARTS, _SEED = 600, 20241  # of Newton's method, for the branches at the first pose
_SAME = 1e-5  # configurations nearer to each other are one [rad; slides divided by the length scale]
_APART = 0.1  # … and of redundant arms, points nearer than this to a self-motion are on it
_BRANCHES = 16  # that are followed of a redundant arm
_ALONG = 9  # points of a self-motion that paths begin at
_PULLS = (0.0, 1.0, 3.0)  # null-space motion per joint motion that the tool needs, where σ is small
_PULLED = 0.3  # σ_r at which the pull has its full size
_SHARES = (1.0, 0.5)  # of a bound
_ENOUGH = 0.05  # first-order distance at which a path that keeps its start goes before wider ones that do not [rad]


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
    candidates, ended = ranking
    place, plan, free = plan_path(tool, np.array(starts), report, around=around)
    if not len(plan):
        ended["plan"] += 1
        return False
    if around:
        how = "planned elsewhere"
    else:
        how = "planned"
    start = joint_values("start", plan[0])
    candidates.append(Candidate(tool, plan_as_run(place, plan), how, (start,), free, not around))
    return True
