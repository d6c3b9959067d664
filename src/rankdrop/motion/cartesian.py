"""`check_poses`: a tool path judged, poses or straight moves between them, through the arm's own inverse kinematics.

The tip goes straight from pose to pose and turns about one axis, as a linear move of a controller does. Joint values
are found pose by pose on one branch (`follow`), at places so close that the joints, going straight between them, keep
the tip on its line; that joint path is judged as any other (`check_path`). Where the branch ends, the part up to there
is judged, and why it ends is told.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from math import ceil

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import ConfigurationError
from rankdrop.kinematics import check_robot, pose
from rankdrop.local.block import joint_scale, sampling_box
from rankdrop.local.orientation import orientation_coordinates
from rankdrop.motion.check import EVALUATIONS, check_path
from rankdrop.motion.data import FREE, UNDECIDED, Place, ToolMotion
from rankdrop.motion.follow import Followed, between, follow
from rankdrop.motion.inverse import Aim, distinct
from rankdrop.motion.result import PathCheck
from rankdrop.motion.trajectory import checked_times
from rankdrop.results.analysis import Analysis
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.numbers import reach
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT, Tolerances

STARTS = 512
"""Random configurations, and the one nearest to zero, that solutions at the first pose are sought from."""
_APART, _TURN = 0.02, 0.05  # places of a first try: so far apart [reaches], [rad]
_OFF = 1e-4  # the tip may leave its line by so much [reaches; rad]
_ROUNDS = 7  # of halving where it leaves it farther
_MOST = 200_000  # places
_SAME = 1e-4  # solutions nearer to each other are one [rad]
_NAMED = 10  # meetings whose poses are told


def check_poses(
    robot: Robot,
    poses: ArrayLike,
    t: ArrayLike | None = None,
    *,
    start: ArrayLike | None = None,
    task: Task | str | None = None,
    min_distance: float = 0.0,
    limits: bool = False,
    analysis: Analysis | None = None,
    evaluations: int = EVALUATIONS,
    length_scale: float | None = None,
    tolerances: Tolerances = DEFAULT,
    frame: str = "base",
    progress: Callable[[int, int], None] | None = None,
) -> PathCheck:
    """Judge a tool path: straight moves of the tip from pose to pose, on one branch of the inverse kinematics.

    Args:
        robot: the arm.
        poses: (P, 4, 4) of the tip in the base frame [m]; what the task leaves free is not looked at.
        t: (P,) times [s], increasing; None where there are none. The tip keeps its speed between two poses.
        start: (n,) configuration near the first pose: which branch; None: of the solutions found within the joint
            limits the one nearest to q = 0, or to what the limits allow of it.
        task, min_distance, limits, analysis, evaluations, length_scale, tolerances, frame, progress: as in
            `check_path`; the arm itself never leaves its joint limits.

    Returns:
        The path in joint space, judged; `tool` says which branch was taken, how far it could be followed, why it ended,
        and which pose each row is. One that ends early is never called free.

    Raises:
        ConfigurationError: poses, t or start have the wrong shape or are not finite, or the first pose is not reached.
        OptionError, TaskError: as `check_path`.

    Example:
        >>> from rankdrop.kinematics import pose
        >>> from rankdrop.robot.open import open_robot
        >>> arm = open_robot("ur5")
        >>> ends = pose(arm, [[0, -1, 1, 0.3, 0.8, 0], [0.2, -1.1, 1.2, 0.3, 0.8, 0]])
        >>> found = check_poses(arm, ends, start=[0, -1, 1, 0.3, 0.8, 0])
        >>> found.verdict, found.tool.complete, found.tool.poses
        ('free', True, 2)
    """
    check_robot(robot)
    wanted, times = _checked(poses, t)
    resolved = resolve_task(task, robot, length_scale=length_scale)
    first, chosen = _start(robot, wanted[0], resolved, start)
    made = _Made(robot, wanted, resolved, first)
    found = made.found
    q, place = found.q, made.place[: len(found.q)]
    if not found.complete:
        reached = float(np.interp(found.row - 1.0, np.arange(len(made.place)), made.place))
        if reached > place[-1]:
            q, place = np.concatenate([q, found.last[None]]), np.append(place, reached)
    when = None if times is None else np.interp(place, np.arange(len(wanted)), times)
    judged = check_path(
        robot, q, when, task=resolved, min_distance=min_distance, limits=limits, analysis=analysis,
        evaluations=evaluations, tolerances=tolerances, frame=frame, progress=progress,
    )  # fmt: skip
    words = "" if found.complete else _why(robot, wanted, resolved, found, float(place[-1]))
    place = place + 1.0
    place.flags.writeable = False
    tool = ToolMotion(
        len(wanted), found.complete, float(place[-1]), found.reason, words, tuple(q[0].tolist()), chosen, place,
        made.off,
    )  # fmt: skip
    return _told(judged, tool)


def _checked(poses: ArrayLike, t: ArrayLike | None) -> tuple[Array, Array | None]:
    wanted = np.asarray(poses, dtype=np.float64)
    if wanted.ndim != 3 or wanted.shape[1:] != (4, 4) or not len(wanted):
        raise ConfigurationError("a tool path has one matrix for each pose", where="poses",
                                 got=f"shape {wanted.shape}", allowed="shape (P, 4, 4), P ≥ 1")  # fmt: skip
    for i in np.flatnonzero(~np.isfinite(wanted).all(axis=(1, 2)))[:1]:
        raise ConfigurationError("the pose is not finite", where=f"poses, pose {i + 1}")
    turn = wanted[:, :3, :3]
    right = np.abs(turn @ turn.swapaxes(1, 2) - np.eye(3)).max(axis=(1, 2)) <= 1e-6
    for i in np.flatnonzero(~right | (np.linalg.det(turn) < 0.0))[:1]:
        raise ConfigurationError("the pose is no rotation with a translation", where=f"poses, pose {i + 1}")
    if t is None:
        return wanted, None
    times = np.asarray(t, dtype=np.float64)
    if times.shape != (len(wanted),):
        raise ConfigurationError("there is one time for each pose", where="t", got=f"shape {times.shape}",
                                 allowed=f"shape ({len(wanted)},)")  # fmt: skip
    return wanted, checked_times(times, [f"t, pose {row + 1}" for row in range(len(wanted))])


def within_limits(robot: Robot, goal: Array, task: Task) -> Array:
    """(S, n) configurations at a pose (4, 4) within the joint limits, nearest to q = 0 first, of those found.

    Newton's method from `STARTS` random configurations and from the one nearest to zero; a redundant arm has more.
    """
    low, high = sampling_box(robot, task, limits=True)
    home = np.clip(np.zeros(robot.n), robot.lower, robot.upper)
    starts = np.concatenate([home[None], np.random.default_rng(0).uniform(low, high, (STARTS, robot.n))])
    q = Aim(robot, task).reached(goal, starts)
    q = q - 2 * np.pi * np.where(robot.periodic, np.round((q - home) / (2 * np.pi)), 0.0)
    for turn in (-2 * np.pi, 2 * np.pi):  # limits may want the next turn
        moved = np.where(robot.periodic, q + turn, q)
        bad = (q < robot.lower - 1e-9) | (q > robot.upper + 1e-9)
        q = np.where(bad & (moved >= robot.lower) & (moved <= robot.upper), moved, q)
    q = q[((q >= robot.lower - 1e-9) & (q <= robot.upper + 1e-9)).all(axis=1)]
    far = np.linalg.norm((q - home) / joint_scale(robot, task), axis=1)
    return distinct(robot, task, q[np.argsort(far, kind="stable")], _SAME)


def _start(robot: Robot, goal: Array, task: Task, start: ArrayLike | None) -> tuple[Array, str]:
    """A configuration at the first pose, and in words which."""
    if start is not None:
        given = np.asarray(start, dtype=np.float64)
        if given.shape != (robot.n,) or not np.isfinite(given).all():
            raise ConfigurationError("the start is one configuration", where="start", got=f"shape {given.shape}",
                                     allowed=f"{robot.n} finite numbers")  # fmt: skip
        found = follow(robot, goal[None], given, task)
        if not found.complete:
            raise ConfigurationError(f"pose 1 is not reached: {found.words}", where="start",
                                     mend="a start nearer to it, or none")  # fmt: skip
        return found.q[0], "of the start that was given"
    found_ = within_limits(robot, goal, task)
    if not len(found_):
        raise ConfigurationError(
            "pose 1 is out of reach: no configuration within the joint limits was found", where="poses",
            got=f"{STARTS + 1} starts of Newton's method", mend="look at its units and its frame, or give a start",
            typed="look at its units and its frame, or give --start",
        )  # fmt: skip
    count = f"one of {len(found_)} found" if robot.n <= task.m else f"of {len(found_)} found, and there are more"
    return found_[0], f"nearest to q = 0 ({count})"


class _Made:
    """The joint path of a tool path, at places close enough together.

    Attributes:
        place: (K,) poses counted from 0, with shares of the way.
        found: what `follow` reached of them.
        off: farthest that the tip leaves its line between two places [m].
    """

    def __init__(self, robot: Robot, poses: Array, task: Task, start: Array) -> None:
        self._robot, self._poses, size = robot, poses, reach(robot) or 1.0
        away = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1) / (_APART * size)
        turn = orientation_coordinates(poses[1:, :3, :3] @ poses[:-1, :3, :3].swapaxes(1, 2), "rotvec")
        parts = np.maximum(1, np.ceil(np.maximum(away, np.linalg.norm(turn, axis=1) / _TURN))).astype(np.int64)
        self.off = 0.0
        for _ in range(_ROUNDS):
            self.place = _places(parts)
            self.found = follow(robot, self._at(self.place), start, task)
            off, self.off = self._leaves(task, size)
            wide = np.zeros(len(parts), dtype=np.bool_)
            wide[np.floor(self.place[: len(off)][off > _OFF]).astype(np.int64)] = True
            if not wide.any() or int(parts.sum() + parts[wide].sum()) > _MOST:
                break
            parts = np.where(wide, 2 * parts, parts)

    def _at(self, place: Array) -> Array:
        """(K, 4, 4) poses at places."""
        if len(self._poses) == 1:
            return self._poses
        k = np.clip(np.floor(place), 0, len(self._poses) - 2).astype(np.int64)
        return between(self._poses[k], self._poses[k + 1], place - k)

    def _leaves(self, task: Task, size: float) -> tuple[Array, float]:
        """How far the tip is from its line half way between places: (K − 1,) of the larger of [reaches] and [rad] as
        far as the task counts them, and the most in metres."""
        q = self.found.q
        if len(q) < 2:
            return np.zeros(0), 0.0
        now = pose(self._robot, (q[1:] + q[:-1]) / 2)
        wanted = self._at((self.place[1 : len(q)] + self.place[: len(q) - 1]) / 2)
        apart = np.linalg.norm(now[:, :3, 3] - wanted[:, :3, 3], axis=1) * (min(task.rows) < 3)
        turn = orientation_coordinates(now[:, :3, :3] @ wanted[:, :3, :3].swapaxes(1, 2), "rotvec")
        turned = np.linalg.norm(turn, axis=1) * ({3, 4, 5} <= set(task.rows))
        return np.maximum(apart / size, turned), float(apart.max())


def _places(parts: Array) -> Array:
    """(K,) places: each way between two poses in so many parts."""
    ways = [k + np.arange(int(n)) / int(n) for k, n in enumerate(parts)]
    return np.concatenate([*ways, [float(len(parts))]])


def _why(robot: Robot, poses: Array, task: Task, followed: Followed, place: float) -> str:
    """Why the branch ends, poses counted as they were given; and whether the next pose is reached in another way."""
    at = place + 1.0
    words = re.sub(r"at pose [\d.]+", f"at pose {at:.5g}", followed.words)
    ahead = min(ceil(place + 1e-9), len(poses) - 1)
    if len(within_limits(robot, poses[ahead], task)):
        return f"{words}; pose {ahead + 1} is within reach, by other configurations"
    return f"{words}; pose {ahead + 1} is out of reach: no configuration within the joint limits was found for it"


def _told(judged: PathCheck, tool: ToolMotion) -> PathCheck:
    """The judgement with what is known of the tool path in its words."""
    notes = [f"branch: {tool.chosen}"]
    if tool.off > 0.0:
        notes.append(f"the joints go straight between {len(tool.place)} rows; half way between two the tip is "
                     f"{1e3 * tool.off:.3g} mm off its line at most")  # fmt: skip
    notes += [
        f"row {_number(one.closest.place)} is pose {tool.pose_at(one.closest.place):.6g}" for one in judged.crossings
    ][:_NAMED]
    verdict, sentence = judged.verdict, judged.sentence
    if not tool.complete:
        verdict = UNDECIDED if verdict == FREE else verdict
        up = sentence[0].lower() + sentence[1:]
        sentence = f"Cannot be followed beyond pose {tool.reached:.5g} of {tool.poses}: {tool.words}. Up to there {up}"
    return replace(judged, verdict=verdict, sentence=sentence, notes=(*judged.notes, *notes), tool=tool)


def _number(place: Place) -> str:
    return f"{place.row}" if place.share == 0.0 else f"{place.row + place.share:.2f}"
