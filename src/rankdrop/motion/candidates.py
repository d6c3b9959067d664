"""Other joint paths for a tool path: other branches, self-motions at its beginning, the base or the tool moved.

Each is a start and what follows from it. They are followed at some places of the path first, and ranked by how far
they stay from a singularity to first order; whoever takes one judges it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np

from rankdrop.errors import RankdropError
from rankdrop.local.block import generic_rank, joint_scale, sampling_box, singular_values
from rankdrop.local.redundant import CLOSED, self_motion
from rankdrop.motion.follow import Followed, Pull
from rankdrop.motion.inverse import Aim, distinct
from rankdrop.motion.planning import along, planned
from rankdrop.motion.tool_path import Run, ToolPath, rising, room, start_moved
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.transform import about_axis, translation
from rankdrop.task import Task

_SAME_START = "from the same start"
_STARTS, _SEED = 600, 20241  # of Newton's method, for the branches at the first pose
_SAME = 1e-5  # configurations nearer to each other are one [rad; slides divided by the length scale]
_APART = 0.1  # … and of redundant arms, points nearer than this to a self-motion are on it
_BRANCHES = 16  # that are followed of a redundant arm
_ALONG = 9  # points of a self-motion that paths begin at
_PULLS = (0.0, 1.0, 3.0)  # null-space motion per joint motion that the tool needs, where σ is small
_PULLED = 0.3  # σ_r at which the pull has its full size
_SHARES = (1.0, 0.5)  # of a bound
_ENOUGH = 0.05  # first-order distance at which a path that keeps its start goes before wider ones that do not [rad]

Progress = Callable[[int, int], None]
"""report(done, all)."""


Parameter = tuple[str, float | tuple[float, ...], str]
"""A number, or some, that a remedy is made with: name, value, and unit ("rad, m": joint values; "": none)."""
Candidate = tuple[ToolPath, Array | None, Pull | None, str, tuple[Parameter, ...]]
"""Tool path, start (None: the first pose is not reached), null-space motion, what is done, and with which numbers."""


@dataclass(frozen=True, eq=False)
class Other:
    """A joint path to be tried.

    Attributes:
        tool: the tool's path, moved or not.
        run: the joint path at the places of such a tool path.
        words: what is done.
        parameters: what with.
        room: the least first-order distance from a singularity at these places [rad].
        kept: it begins where the path does.
    """

    tool: ToolPath
    run: Run
    words: str
    parameters: tuple[Parameter, ...]
    room: float
    kept: bool = False


@dataclass(eq=False)
class Ranking:
    """Those that run the whole tool path, widest first, and why the others do not."""

    tried: int
    found: list[Other]
    ended: dict[str, int]


def ranked(candidates: Iterable[Candidate], count: int, report: Progress) -> Ranking:
    """Each candidate followed on some places of its path.

    Args:
        candidates: worked out as they are followed.
        count: how many there will be.
        report: how many are done.
    """
    ranking = Ranking(0, [], {})
    for k, (tool, start, pull, words, parameters) in enumerate(candidates):
        report(k, count)
        ranking.tried += 1
        look = tool.coarse()
        rank = generic_rank(tool.robot, tool.task)
        found = None if start is None else look.followed(start, pull)
        if found is not None and start is not None and not found.complete:
            found, start = _turned(look, start, pull, found)
        if found is None or start is None or not found.complete:
            reason = "start" if found is None else found.reason
            ranking.ended[reason] = ranking.ended.get(reason, 0) + 1
            continue
        ranking.found.append(
            Other(tool, partial(ToolPath.followed, start=start, pull=pull), words, parameters,
                  float(room(tool.robot, tool.task, found.q, rank).min()), bool((start == tool.q[0]).all()))
        )  # fmt: skip
    ranking.found.sort(key=lambda one: -one.room)
    report(count, count)
    return ranking


def _plan(ranking: Ranking, tool: ToolPath, starts: Sequence[Array], report: Progress, *, around: bool) -> bool:
    """One more for a ranking, planned over all self-motions; whether there is one."""
    ranking.tried += 1
    place, plan, free = planned(tool, np.array(starts), report, around=around)
    if not len(plan):
        ranking.ended["plan"] = ranking.ended.get("plan", 0) + 1
        return False
    words = "from another start" if around else _SAME_START
    ranking.found.append(
        Other(tool, along(place, plan), f"the same tool path {words}, planned over the self-motions of every pose",
              (("start", tuple(plan[0].tolist()), "rad, m"),), free, not around)
    )  # fmt: skip
    return True


def _turned(tool: ToolPath, start: Array, pull: Pull | None, found: Followed) -> tuple[Followed, Array]:
    """The same branch with a joint that reaches its limit begun a whole turn away, where there is room."""
    robot = tool.robot
    if found.reason != "limit":
        return found, start
    over = np.flatnonzero((found.last > robot.upper - 1e-4) | (found.last < robot.lower + 1e-4))
    for joint in over[robot.periodic[over]]:
        other = start.copy()
        other[joint] -= 2 * np.pi * np.sign(found.last[joint] - start[joint])
        if robot.lower[joint] <= other[joint] <= robot.upper[joint]:
            again = tool.followed(other, pull)
            if again.complete:
                return again, other
    return found, start


def branches(tool: ToolPath, report: Progress) -> Ranking:
    """Other branches of the inverse kinematics at the first pose."""
    robot, task = tool.robot, tool.task
    starts = _branches(tool)
    pull = _pull(robot, task, 1.0) if robot.n > task.m else None
    words = "another branch of the inverse kinematics runs the same tool path"
    ranking = ranked(
        ((tool, start, pull, words, (("start", tuple(start.tolist()), "rad, m"),)) for start in starts),
        len(starts), report,
    )  # fmt: skip
    if starts and not ranking.found and robot.n > generic_rank(robot, task):
        _plan(ranking, tool, starts, report, around=True)
    return ranking


def _branches(tool: ToolPath) -> list[Array]:
    """Configurations at the first pose on other branches than the path's, near to it in whole turns."""
    robot, task = tool.robot, tool.task
    rng = np.random.default_rng(_SEED)
    low, high = sampling_box(robot, task, limits=tool.limits)
    starts = rng.uniform(low, high, (_STARTS, robot.n))
    found = Aim(robot, task).reached(tool.poses[0], starts)
    found = _nearest_turns(robot, found, tool.q[0], tool.limits)
    sigma = singular_values(robot, found, task)[:, generic_rank(robot, task) - 1]
    redundant = robot.n > generic_rank(robot, task)
    known = _self_motion(tool) if redundant else tool.q[:1]
    if known is None:
        return []
    near, most = (_APART, _BRANCHES) if redundant else (_SAME, None)
    return list(distinct(robot, task, found[sigma > _SAME], near, known, most))


def _nearest_turns(robot: Robot, q: Array, to: Array, limits: bool) -> Array:
    """Configurations (N, n) with whole turns added to come near another, inside the limits; those outside left out."""
    turns = np.where(robot.periodic, 2 * np.pi * np.round((to - q) / (2 * np.pi)), 0.0)
    near = q + turns
    if not limits:
        return near
    for sign in (1.0, -1.0):
        out = (near < robot.lower) if sign > 0 else (near > robot.upper)
        near = np.where(out & robot.periodic, near + sign * 2 * np.pi, near)
    return near[((near >= robot.lower) & (near <= robot.upper)).all(axis=1)]


def _self_motion(tool: ToolPath) -> Array | None:
    """(N, n) points of the self-motion through the beginning; None where there is more than one, or none is traced."""
    robot, task = tool.robot, tool.task
    if robot.n - generic_rank(robot, task) != 1:
        return None
    aim = Aim(robot, task)
    null = np.asarray(aim.joints * np.linalg.svd(aim.jacobian(tool.q[:1])[0])[2][aim.rank])
    parts = []
    for direction in (null, -null):
        try:
            traced = self_motion(robot, tool.q[0], task, length=30.0, direction=direction, limits=tool.limits)
        except RankdropError:  # the start is singular, or the task is not determined by the pose
            return None
        parts.append(traced.q)
        if traced.ended == CLOSED:
            break
    return np.concatenate(parts)


def _pull(robot: Robot, task: Task, strength: float) -> Pull | None:
    """Towards larger σ_r, the stronger the smaller it is."""
    if strength == 0.0:
        return None
    rank, scale = generic_rank(robot, task), joint_scale(robot, task)

    def pull(q: Array) -> Array:
        sigma, slopes = rising(robot, task, q[None], rank)
        slope, size = slopes[0], float(np.linalg.norm(slopes[0]))
        weak = min(1.0, (_PULLED / max(float(sigma[0]), 1e-12)) ** 2)
        return np.asarray(strength * weak * scale * slope / max(size, 1e-12))

    return pull


def null_spaces(tool: ToolPath, report: Progress) -> Ranking:
    """The same tool path with other null-space motion: from the same start, planned over the self-motions; pulled to
    larger σ; begun elsewhere on the self-motion.
    """
    robot, task = tool.robot, tool.task
    if robot.n <= generic_rank(robot, task):
        return Ranking(0, [], {})
    traced = _self_motion(tool)
    starts: Sequence[Array] = [tool.q[0]]
    if traced is not None:
        starts = [tool.q[0], *traced[np.unique(np.linspace(0, len(traced) - 1, _ALONG).astype(int))[1:]]]

    moved = (_SAME_START, *["begun elsewhere on its self-motion"] * (len(starts) - 1))
    ranking = ranked(
        ((tool, start, _pull(robot, task, strength), f"the same tool path {words}, by null-space motion",
          (("start", tuple(np.asarray(start).tolist()), "rad, m"), ("pull to larger σ", strength, "")))
         for (start, words), strength in product(zip(starts, moved, strict=True), _PULLS)),
        len(starts) * len(_PULLS), report,
    )  # fmt: skip
    if not _plan(ranking, tool, [tool.q[0]], report, around=False) and not ranking.found:
        _plan(ranking, tool, [tool.q[0]], report, around=True)
    ranking.found.sort(key=lambda one: (not (one.kept and one.room >= _ENOUGH), -one.room))
    return ranking


def shifts(tool: ToolPath, most: float, report: Progress) -> Ranking:
    """The base moved by up to a length [m], in directions that the task knows."""
    steps = [most * share * way for way, share in product(_ways([row for row in tool.task.rows if row < 3]), _SHARES)]
    moved = ((tool.shifted(translation(*(-shift)), np.eye(4)), shift) for shift in steps)
    return ranked(
        ((path, start_moved(path), None, "the base of the arm moved, in its own axes",
          (("base shift", tuple((shift + 0.0).tolist()), "m"),)) for path, shift in moved), len(steps), report,
    )  # fmt: skip


def tilts(tool: ToolPath, most: float, report: Progress) -> Ranking:
    """The tool tilted about its tip by up to an angle [rad]: about axes square to Z of the tip, where the task allows.
    """
    rows = [row - 3 for row in tool.task.rows if row >= 3]
    turns = [(way, most * share) for way, share in product(_ways([row for row in rows if row < 2] or rows), _SHARES)]
    moved = ((tool.shifted(np.eye(4), about_axis(way, angle)), way, angle) for way, angle in turns)
    return ranked(
        ((path, start_moved(path), None, "the tool tilted about an axis through its tip, in its own axes",
          (("tool tilt", angle, "rad"), ("axis", tuple((way + 0.0).tolist()), ""))) for path, way, angle in moved),
        len(turns), report,
    )  # fmt: skip


def _ways(axes: Sequence[int]) -> list[Array]:
    """Unit vectors (3,) in the directions whose parts along the axes given are −1, 0 or 1."""
    ways = []
    for signs in product((-1.0, 0.0, 1.0), repeat=len(axes)):
        if any(signs):
            way = np.zeros(3)
            way[list(axes)] = signs
            ways.append(way / np.linalg.norm(way))
    return ways
