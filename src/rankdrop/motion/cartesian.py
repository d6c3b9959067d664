"""`check_poses`: a tool path checked, poses or straight moves between them, through the arm's own inverse kinematics.

The tip goes straight from pose to pose and turns about one axis, as a linear move of a controller does. Joint values
are solved along this curve on one branch (`follow`), at rows so close that the joints, going straight between them, are
proven to keep the tip within a tolerance of the curve (`deviation`). That joint path is checked as any other
(`check_path`), with the joint rates of the curve itself at both ends of every piece. Where the branch ends, the part up
to there is checked.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import ConfigurationError
from rankdrop.kinematics import check_robot
from rankdrop.local.block import joint_scale, sampling_box
from rankdrop.local.orientation import orientation_coordinates
from rankdrop.motion.check import check_curve
from rankdrop.motion.curve import Curve, curve
from rankdrop.motion.deviation import TipDeviation
from rankdrop.motion.follow import Followed, follow, poses_at
from rankdrop.motion.inverse import Aim, distinct
from rankdrop.motion.options import PathOptions
from rankdrop.motion.record import PathCheck, ToolMotion
from rankdrop.motion.trajectory import checked_times
from rankdrop.options import takes
from rankdrop.results.analysis import Analysis
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import counted_length

STARTS = 512
"""Random configurations, and the one nearest to zero, that solutions at the first pose are searched from."""
_SAME = 1e-4  # solutions nearer to each other are one [rad]


@takes(PathOptions)
def check_poses(
    robot: Robot,
    poses: ArrayLike,
    t: ArrayLike | None = None,
    *,
    start: ArrayLike | None = None,
    task: Task | str | None = None,
    analysis: Analysis | None = None,
    options: PathOptions | None = None,
    tolerances: Tolerances = DEFAULT,
    progress: Callable[[int, int], None] | None = None,
    **given: Any,
) -> PathCheck:
    """Check a tool path: straight moves of the tip from pose to pose, on one branch of the inverse kinematics.

    Args:
        robot: the arm.
        poses: (P, 4, 4) of the tip in the base frame [m]; what the task leaves free is ignored.
        t: (P,) times [s], increasing; None where there are none. The tip keeps its speed between two poses.
        start: (n,) configuration near the first pose, which decides the branch; None: of the solutions found within the
            joint limits the one nearest to q = 0, or to what the limits allow of it.
        task, analysis, options, tolerances, progress: as in `check_path`; the arm itself never leaves its joint limits.

    Returns:
        The path in joint space, checked; `tool` says which branch was taken, how far it could be followed, why it
        ended, how near the tip is proven to stay to its curve, and which pose each row is. A path that ends early is
        never free.

    Raises:
        ConfigurationError: poses, t or start have the wrong shape or are not finite, or the first pose is not reached.
        OptionError, TaskError: as `check_path`.

    Example:
        >>> from rankdrop.kinematics import pose
        >>> from rankdrop.robot.open import open_robot
        >>> arm = open_robot("ur5")
        >>> ends = pose(arm, [[0, -1, 1, 0.3, 0.8, 0], [0.2, -1.1, 1.2, 0.3, 0.8, 0]])
        >>> check = check_poses(arm, ends, start=[0, -1, 1, 0.3, 0.8, 0])
        >>> check.verdict.value, check.tool.complete, check.tool.poses, check.tool.off <= 1e-4
        ('free', True, 2, True)
    """
    check_robot(robot)
    how = PathOptions.of(options, given)
    wanted, times = _checked(poses, t)
    resolved = resolve_task(task, robot)
    first, solutions = _start(robot, wanted[0], resolved, start)
    tolerance = how.tip_tolerance * counted_length(robot), how.turn_tolerance
    branch = follow(robot, wanted, first, resolved, tolerance=tolerance)
    away, turned = TipDeviation(Aim(robot, resolved)).bound(branch.q, poses_at(wanted, branch.place))
    tool = ToolMotion(
        len(wanted), branch.complete, float(branch.place[-1]) + 1.0, branch.reason, branch.joint, branch.sigma,
        not branch.complete and _next_is_reachable(robot, wanted, branch, resolved), tuple(branch.q[0].tolist()),
        solutions, robot.n > resolved.m, branch.place + 1.0, float(away.max(initial=0.0)),
        float(turned.max(initial=0.0)),
    )  # fmt: skip
    path = _timed(robot, resolved, wanted, times, branch)
    return replace(check_curve(robot, path, resolved, how, analysis, tolerances, progress, tool), rows=len(branch.q))


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


def _start(robot: Robot, goal: Array, task: Task, start: ArrayLike | None) -> tuple[Array, int]:
    """A configuration at the first pose, and how many it was chosen from; 0: it was given."""
    if start is not None:
        given = np.asarray(start, dtype=np.float64)
        if given.shape != (robot.n,) or not np.isfinite(given).all():
            raise ConfigurationError("the start is one configuration", where="start", got=f"shape {given.shape}",
                                     allowed=f"{robot.n} finite numbers")  # fmt: skip
        reached = follow(robot, goal[None], given, task)
        if not reached.complete:
            raise ConfigurationError(
                "pose 1 is not reached from this start: " + (
                    f"joint {reached.joint} is beyond its limit there" if reached.joint else "Newton's method fails"
                ), where="start", mend="a start nearer to it, or none",
            )  # fmt: skip
        return reached.q[0], 0
    solutions = within_limits(robot, goal, task)
    if not len(solutions):
        raise ConfigurationError(
            "pose 1 is out of reach: no configuration within the joint limits was found", where="poses",
            got=f"{STARTS + 1} starts of Newton's method", mend="look at its units and its frame, or give a start",
            typed="look at its units and its frame, or give --start",
        )  # fmt: skip
    return solutions[0], len(solutions)


def _next_is_reachable(robot: Robot, poses: Array, branch: Followed, task: Task) -> bool:
    """Whether a configuration within the joint limits is found for the pose after the end of a branch."""
    ahead = min(ceil(branch.place[-1] + 1e-9), len(poses) - 1)
    return bool(len(within_limits(robot, poses[ahead], task)))


def _timed(robot: Robot, task: Task, poses: Array, times: Array | None, branch: Followed) -> Curve:
    """The joint path with its times, and with the joint rates J⁺ẋ that the curve needs at both ends of each piece."""
    when = None if times is None else np.interp(branch.place, np.arange(len(poses)), times)
    path = curve(branch.q, when)
    if times is None or len(branch.q) < 2:
        return path
    way = np.minimum(np.floor(branch.place[:-1]).astype(np.int64), len(poses) - 2)
    lasts = np.diff(times)[way][:, None]
    move = (poses[way + 1, :3, 3] - poses[way, :3, 3]) / lasts
    turn = poses[way + 1, :3, :3] @ poses[way, :3, :3].swapaxes(1, 2)
    omega = orientation_coordinates(turn, "rotvec") / lasts
    aim = Aim(robot, task)
    ends = (np.abs(aim.rates(q, move, omega)) for q in (branch.q[:-1], branch.q[1:]))
    return replace(path, speeds=np.maximum(*ends))
