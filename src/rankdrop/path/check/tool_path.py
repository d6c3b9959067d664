"""Is a tool path free: straight moves between poses of the tip, through the arm's own inverse kinematics?

The tip goes straight from pose to pose and turns about one axis, as a linear move of a controller does. Joint values
are solved along this curve on one branch (`poses.inverse`), at rows so close that the joints, going straight between
them, are proven to keep the tip within a tolerance of the curve (`Aim.deviation`). That joint path is checked as any
other (`check_path`), with the joint rates of the curve itself at both ends of every piece. Where the branch ends, the
part up to there is checked.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import ceil, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.cover.setting import settings_for
from rankdrop.errors import ConfigurationError
from rankdrop.kinematics import check_robot, pose
from rankdrop.local.block import generic_rank, joint_scale, singular_values
from rankdrop.local.orientation import orientation_coordinates
from rankdrop.local.pointing import TILTED, followed_task, tilt_is_fixed, tilts_off
from rankdrop.options import takes
from rankdrop.path.check.check import asked_for, check_curve, checked_times
from rankdrop.path.check.first_pose import SAME_SOLUTION, count_solutions, first_configuration, within_limits
from rankdrop.path.check.follow import follow
from rankdrop.path.check.missed_singularity import missed_start
from rankdrop.path.check.prove import Proof, prove
from rankdrop.path.check.record import FREE, NOT_FOLLOWED, TOUCHING, UNDECIDED, VERDICTS, GivenPoses, PathCheck
from rankdrop.path.check.tool_branch import Followed, ToolBranch
from rankdrop.path.check.tool_line import half_turns, poses_at
from rankdrop.path.curve import Curve, curve
from rankdrop.path.read.matrices import REPORTED, poses_of
from rankdrop.poses.arm_posture import arm_postures
from rankdrop.poses.inverse import Aim, joint_difference
from rankdrop.questions import PathOptions
from rankdrop.results.analysis import Analysis
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.transform import as_numbers
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import counted_length, in_metres, into_metres, task_in_metres

MOST_POSES, MOST_BRANCHES = 300, 16
"""Of a tool path whose branches are all followed."""
_AT_ONE = 1e-5  # σ_r of a row below which it counts as singular: a pose there is reached to half the digits only
_FOR_BRANCH = 50_000  # enclosures of the proof of one of the other branches
_SAME_PLACE = 1e-3  # of a pose: a singularity that a branch passes, and where its proof stops


@takes(PathOptions)
def check_poses(
    robot: Robot,
    poses: ArrayLike,
    t: ArrayLike | None = None,
    *,
    start: ArrayLike | None = None,
    branches: bool = True,
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
        poses: (P, 4, 4) of the tip in the base frame [m]; what the task leaves free is ignored, but for the tilt of a
            tool that no joint tilts.
        t: (P,) times [s], increasing; None where there are none. The tip keeps its speed between two poses.
        start: (n,) configuration near the first pose, which decides the branch: the nearest solution is taken. None: of
            the solutions found within the joint limits the posture that people use (`by_habit`).
        branches: follow the other branches as well, of arms that are not redundant and at most `MOST_POSES` poses.
        task: that the poses are reached for; None is the task the arm is made for. The path is checked as in
            `check_path`.
        analysis, options, tolerances, progress: as in `check_path`; the arm itself never leaves its joint limits.

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
    wanted = _validate_poses(poses)
    times = checked_times(t, len(wanted), "pose")
    resolved = followed_task(robot, task)
    check_tilt(robot, resolved, wanted, "poses")
    tolerance = tip_tolerance(how, robot)
    first, solutions, moved = first_configuration(robot, wanted, resolved, start, tolerance)
    branch = followed_branch(robot, wanted, first, resolved, tolerance, free=start is None)
    beyond = None
    if not len(branch.q):
        beyond = _beyond_edge(Aim(robot, resolved), wanted[0], first)
    if beyond is not None:
        wanted = np.concatenate([pose(robot, first)[None], wanted[1:]])
        branch = followed_branch(robot, wanted, first, resolved, tolerance, free=False)
    if not len(branch.q):
        raise ConfigurationError(
            "the first pose lies next to a singularity of the start, where the solver ends on no configuration of it",
            where="poses, pose 1", mend="write the pose with more digits, or begin a little farther on",
        )  # fmt: skip
    aim, targets = Aim(robot, resolved), poses_at(wanted, branch.place - 1.0)
    away, turned = tip_apart(aim, branch.q, targets)
    if beyond is not None:
        away, turned = away + beyond[0], turned + beyond[1]
    missed = aim.missed(targets, branch.q)
    ahead = wanted[min(ceil(branch.place[-1] - 1.0 + 1e-9), len(wanted) - 1)]
    isolated, self_motions = 0, 0
    if start is None:
        isolated, self_motions = count_solutions(robot, wanted[0], resolved, solutions)
    tool = replace(
        branch, poses=len(wanted), solutions=isolated, self_motions=self_motions,
        more=robot.n > resolved.m, off=away, turned=turned,
        next_reachable=not branch.complete and len(within_limits(robot, ahead, resolved)) > 0,
        half_turns=half_turns(wanted) if any(row > 2 for row in resolved.rows) else (),
    )  # fmt: skip
    path = timed_branch(robot, resolved, wanted, times, branch)
    asked = asked_for(robot, task, analysis)
    check = check_curve(robot, path, asked, how, analysis, tolerances, progress)
    if branch.complete:
        ended = FREE
    elif branch.reason in ("stuck", "budget"):
        ended = UNDECIDED
    else:
        ended = NOT_FOLLOWED
    # a start on a singularity is found to half the digits only: its joints are free, and the tool path is not
    passed = TOUCHING if branch.passed else FREE
    worst = min(check.verdict, ended, passed, key=VERDICTS.index)
    tool = replace(tool, moved=moved)
    if branches and robot.n == resolved.m and len(wanted) <= MOST_POSES:
        tool = replace(tool, branches=_branches(
            robot, wanted, solutions, first, resolved, asked, tolerance, tool, check, tolerances))  # fmt: skip
    remarks = check.remarks
    if missed is not None:
        remarks += (("missed", missed),)
    if beyond is not None:
        remarks += (("edge", beyond),)
    return replace(check, rows=len(branch.q), tool=tool, verdict=worst, remarks=remarks,
                   poses=GivenPoses(wanted, times, resolved))  # fmt: skip


def _beyond_edge(aim: Aim, goal: Array, q: Array) -> tuple[float, float] | None:
    """How far a pose (4, 4) lies beyond the edge of reach that a configuration (n,) is at [m], [rad]; None where it is
    farther than poses are rounded, or not square.
    """
    if not aim.square or missed_start(aim, goal, q) is None:
        return None
    away, chord = aim.missing(goal[None], q[None])
    return float(away[0]), 2.0 * float(np.arcsin(chord[0] / 2.0))


def tip_tolerance(options: PathOptions, robot: Robot) -> tuple[float, float]:
    """How far the tip may leave its curve between rows: [m, or what the arm counts in], [rad]."""
    return options.tip_tolerance * counted_length(robot), options.turn_tolerance


def _branches(
    robot: Robot, poses: Array, solutions: Array, first: Array, task: Task, asked: Task,
    tolerance: tuple[float, float], taken: Followed, check: PathCheck, tolerances: Tolerances,
) -> tuple[ToolBranch, ...]:  # fmt: skip
    """Every branch that begins at a solution of the first pose, each followed and proven for itself.

    A branch that ends at the limit of a joint is followed from a whole turn away too, where that reaches farther.
    """
    if len(taken.q):
        first = taken.q[0]
    away = np.linalg.norm(joint_difference(robot, first, solutions) / joint_scale(robot, task), axis=1)
    same = away <= SAME_SOLUTION
    if same.any():
        starts = solutions
        chosen = int(away.argmin())
    else:
        starts = np.concatenate([first[None], solutions])
        chosen = 0
    starts[chosen] = first
    if len(starts) > MOST_BRANCHES:  # a self-motion at a singular first pose: its points are no branches
        return ()
    branches = []
    for row, q in enumerate(starts):
        if row == chosen:
            branch, not_free = taken, _not_free_taken(taken, check)
        else:
            branch = follow(robot, poses, q, task, tolerance=tolerance, through=True)
            not_free = _not_free(robot, asked, branch, tolerances)
        branches.append(_tool_branch(robot, task, q, branch, not_free, chosen=row == chosen))
        turned = _whole_turn_away(robot, q, branch)
        if turned is not None:
            farther = follow(robot, poses, turned, task, tolerance=tolerance, through=True)
            if farther.reached > branch.reached:
                not_free = _not_free(robot, asked, farther, tolerances)
                branches.append(_tool_branch(robot, task, turned, farther, not_free, chosen=False))
    return tuple(branches)


class NotFree(NamedTuple):
    """The first place at which a branch is not proven free of singularities.

    Attributes:
        place: pose, from 1, with the share of the way to the next; 0 where the branch is free.
        singular: it is known to be singular there.
    """

    place: float = 0.0
    singular: bool = False


def _tool_branch(
    robot: Robot, task: Task, q: Array, branch: Followed, not_free: NotFree, *, chosen: bool
) -> ToolBranch:
    """The record of a branch from a start (n,)."""
    from rankdrop.poses.postures import posture_names  # with the exact side, which a path of joint values does without

    return ToolBranch(
        q, posture_names(robot, task, q[None])[0], arm_postures(robot, q[None])[0], branch.complete, branch.reached,
        branch.reason, branch.joint, branch.folds, branch.turn, not_free.place == 0.0, not_free.place,
        not_free.singular, chosen,
    )  # fmt: skip


def _whole_turn_away(robot: Robot, start: Array, branch: Followed) -> Array | None:
    """(n,) the start with the joint that reaches its limit a whole turn away from that limit; None: no room for it."""
    joint = branch.joint - 1
    if branch.reason != "limit" or not robot.periodic[joint] or not len(branch.q):
        return None
    turned = start.copy()
    turned[joint] -= 2.0 * pi * float(np.sign(branch.q[-1, joint] - start[joint]))
    if not robot.lower[joint] <= turned[joint] <= robot.upper[joint]:
        return None
    return turned


def _not_free_taken(taken: Followed, check: PathCheck) -> NotFree:
    """Where the branch that was taken and checked is first not free."""
    if check.crossings:
        places = (_pose_at(taken, crossing.closest.place.position) for crossing in check.crossings)
        return NotFree(min(places), singular=True)
    if taken.passed:
        return NotFree(min(point.place for point in taken.passed), singular=True)
    if any(stretch.verdict == UNDECIDED for stretch in check.stretches):
        return NotFree(1.0)
    return NotFree()


def _pose_at(branch: Followed, row: float) -> float:
    """Number of the pose, with a share, of a place among the rows (from 1) of a branch."""
    return float(np.interp(row, np.arange(1, len(branch.place) + 1), branch.place))


def _not_free(robot: Robot, task: Task, branch: Followed, tolerances: Tolerances) -> NotFree:
    """Where the joint path of a branch is first not proven free of singularities."""
    if not len(branch.q):
        return NotFree(1.0)
    arm, arm_task = in_metres(robot), task_in_metres(replace(task, length_scale=float(task.scale(robot))), robot)
    sigma = singular_values(arm, into_metres(robot, branch.q), arm_task)[:, generic_rank(arm, arm_task) - 1]
    if (sigma <= _AT_ONE).any():
        return NotFree(float(branch.place[int((sigma <= _AT_ONE).argmax())]), singular=True)
    proof = proof_of(robot, task, branch.q, tolerances, _FOR_BRANCH)
    if not proof.slivers:
        return NotFree()
    (row, share), *_ = proof.slivers[0]
    place = _pose_at(branch, 1.0 + row + share)
    return NotFree(place, any(abs(point.place - place) <= _SAME_PLACE for point in branch.passed))


def proof_of(robot: Robot, task: Task, q: Array, tolerances: Tolerances, evaluations: int) -> Proof:
    """How far a straight joint path (K, n) is proven free of singularities."""
    arm, arm_task = in_metres(robot), task_in_metres(replace(task, length_scale=float(task.scale(robot))), robot)
    return prove(arm, settings_for(arm, arm_task), curve(into_metres(robot, q), None), singular=tolerances.singular,
                 evaluations=evaluations)  # fmt: skip


def followed_branch(
    robot: Robot, poses: Array, first: Array, task: Task, tolerance: tuple[float, float], *, free: bool
) -> Followed:
    """The branch of a configuration at the first pose.

    Args:
        robot, poses, first, task, tolerance: as for `follow`.
        free: the configuration may be turned with the tool held still: it was not asked for.
    """
    branch = follow(robot, poses, first, task, tolerance=tolerance, through=True)
    turn = branch.turn
    if turn is None:
        return branch
    k = int(turn.place) - 1
    rest = follow(robot, poses[k:], turn.to, task, tolerance=tolerance, through=True)
    if free and k == 0:
        return rest
    return replace(branch, turn=replace(turn, rest_complete=rest.complete, rest_reached=rest.reached + k))


def tip_apart(aim: Aim, q: Array, poses: Array) -> tuple[float, float]:
    """How far the tip leaves its curve at most, at the rows (K, n) and between them: [m], [rad]."""
    off, chord = aim.missing(poses, q)
    if len(q) > 1:
        away, turned = aim.deviation(q, poses)
    else:
        away, turned = off, 2 * np.arcsin(np.minimum(1.0, chord / 2))
    return float(away.max(initial=0.0)), float(turned.max(initial=0.0))


def _validate_poses(poses: ArrayLike) -> Array:
    wanted = as_numbers(poses, "poses", ConfigurationError)
    if wanted.ndim != 3 or wanted.shape[1:] != (4, 4) or not len(wanted):
        raise ConfigurationError("a tool path has one matrix for each pose", where="poses",
                                 got=f"shape {wanted.shape}", allowed="shape (P, 4, 4), P ≥ 1")  # fmt: skip
    return poses_of(wanted, lambda row: f"poses, pose {row + 1}", most=REPORTED)[0]


def check_tilt(robot: Robot, followed: Task, goals: Array, where: str) -> None:
    """Refuse poses (P, 4, 4) that are tilted, where an arm that never tilts its tool follows position and yaw.

    Raises:
        ConfigurationError: a pose is tilted by more than rounding.
    """
    if not tilt_is_fixed(robot, followed):
        return
    off = tilts_off(robot, goals)
    worst = int(off.argmax())
    if off[worst] > TILTED:
        raise ConfigurationError(
            f"{robot.n} joints never tilt the tool, and pose {worst + 1} is tilted", where=where,
            got=f"{np.degrees(off[worst]):.3g}° off", allowed=f"{np.degrees(TILTED):.2g}°",
            mend="give it the tilt of the tool; task='position' checks the position alone",
            typed="give it the tilt of the tool; --task position checks the position alone",
        )  # fmt: skip


def timed_branch(robot: Robot, task: Task, poses: Array, times: Array | None, branch: Followed) -> Curve:
    """The joint path with its times, and with the joint rates J⁺ẋ that the curve needs at both ends of each piece."""
    if times is None:
        when = None
    else:
        when = np.interp(branch.place, np.arange(1, len(poses) + 1), times)
    path = replace(curve(branch.q, when), poses=np.resize(branch.place, max(len(branch.place), 2)))
    if times is None or len(branch.q) < 2:
        return path
    way = np.minimum(np.floor(branch.place[:-1]).astype(np.int64) - 1, len(poses) - 2)
    lasts = np.diff(times)[way][:, None]
    move = (poses[way + 1, :3, 3] - poses[way, :3, 3]) / lasts
    turn = poses[way + 1, :3, :3] @ poses[way, :3, :3].swapaxes(1, 2)
    omega = orientation_coordinates(turn, "rotvec") / lasts
    aim = Aim(robot, task)
    ends = (np.abs(aim.rates(q, move, omega)) for q in (branch.q[:-1], branch.q[1:]))
    return replace(path, speeds=np.maximum(*ends))
