"""`check_path`: does a path reach a singularity between its samples, come too near to one, or break a joint limit?

`check_poses`: straight moves between poses of the tip, through the arm's own inverse kinematics.

The tip goes straight from pose to pose and turns about one axis, as a linear move of a controller does. Joint values
are solved along this curve on one branch (`poses.inverse`), at rows so close that the joints, going straight between
them, are proven to keep the tip within a tolerance of the curve (`Aim.deviation`). That joint path is checked as any
other (`check_path`), with the joint rates of the curve itself at both ends of every piece. Where the branch ends, the
part up to there is checked.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.cover.setting import settings_for
from rankdrop.errors import ConfigurationError, OptionError, TaskError
from rankdrop.kinematics import check_robot, configurations
from rankdrop.local.block import generic_rank, joint_scale, sampling_box, singular_values
from rankdrop.local.orientation import orientation_coordinates
from rankdrop.local.pointing import TILTED, asked_task, fitting_task, followed_task, tilt_is_fixed, tilts_off
from rankdrop.local.posture import by_habit
from rankdrop.options import takes
from rankdrop.path.check.follow import Followed, ToolBranch, follow, missed_start
from rankdrop.path.check.prove import Proof, prove
from rankdrop.path.check.record import (
    CROSSING,
    FREE,
    NOT_FOLLOWED,
    OUTSIDE,
    TOO_FAST,
    TOO_NEAR,
    TOUCHING,
    UNDECIDED,
    VERDICTS,
    GivenPoses,
    PathCheck,
    Remark,
    Stretch,
    Verdict,
    Violation,
)
from rankdrop.path.check.survey import Survey, crossings
from rankdrop.path.check.tool_line import half_turns, poses_at
from rankdrop.path.check.turns import jump
from rankdrop.path.curve import Curve, Place, curve
from rankdrop.path.read.files import read_trajectory
from rankdrop.path.read.matrices import REPORTED, poses_of
from rankdrop.path.read.poses import Poses, holds_poses, length_hint, read_poses
from rankdrop.path.read.trajectory import Trajectory, check_times, check_values, refuse_degrees, rows_of, unit_hint
from rankdrop.poses.arm_posture import arm_postures
from rankdrop.poses.inverse import Aim, distinct, joint_difference, near_and_within
from rankdrop.problem import whole_turns
from rankdrop.questions import PathOptions
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import known_families
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.numbers import reach
from rankdrop.robot.transform import as_numbers
from rankdrop.task import Task, resolve_task
from rankdrop.text.path_files import degrees_advice, reading_remarks
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import counted_length, in_metres, into_metres, out_of_metres, task_in_metres

MOST_POSES, MOST_BRANCHES = 300, 16
"""Of a tool path whose branches are all followed."""
_AT_ONE = 1e-5  # σ_r of a row below which it counts as singular: a pose there is reached to half the digits only
_FOR_BRANCH = 50_000  # enclosures of the proof of one of the other branches
_EDGE = 1e-9  # a joint this far beyond a limit stands at it [rad, m]
_NEAR_START = 0.5  # a start so far from where Newton's method ends may belong to another branch [rad]
STARTS = 512
"""Random configurations, and the one nearest to zero, that solutions at the first pose are searched from."""
_REGULAR = 1e-5  # σ_r below which a configuration may be on a self-motion
_SAME = 1e-4  # solutions nearer to each other are one [rad]


@takes(PathOptions)
def check_path(
    robot: Robot,
    q: ArrayLike,
    t: ArrayLike | None = None,
    *,
    velocities: ArrayLike | None = None,
    accelerations: ArrayLike | None = None,
    task: Task | str | None = None,
    analysis: Analysis | None = None,
    options: PathOptions | None = None,
    tolerances: Tolerances = DEFAULT,
    progress: Callable[[int, int], None] | None = None,
    **given: Any,
) -> PathCheck:
    """Check a path at every one of its points, between its samples too.

    Nothing is sampled: boxes and curves are enclosed (`path.check.prove`), and halved until every piece of the path is
    proven free or so narrow that double precision decides. The rest is decided by signs (`path.check.survey`): a
    *crossing* is proven by the intermediate value theorem; where σ_r is within the tolerance without a change of sign
    the path is *touching*, which is a measurement; anything else is *undecided*. A path that is free but leaves the
    range of a joint, or its largest rate, is *outside limits* or *too fast*.

    Args:
        robot: the arm.
        q: (T, n) samples, in order [rad, m].
        t: (T,) times [s], increasing; None where there are none.
        velocities, accelerations: (T, n) of the samples, for cubic and quintic interpolation.
        task: name, rows or Task; None is the task the arm is made for, or, of an arm of five joints that cannot do a
            pose, position and tool axis.
        analysis: families of this arm and task; else from the catalogue, else found on the spot.
        options: how it is checked; its fields are taken as keywords as well.
        tolerances: `singular` decides what counts as touching.
        progress: called with (stretches decided, stretches).

    Returns:
        The verdict, and every stretch, worst first.

    Raises:
        ConfigurationError: q, t, velocities or accelerations have the wrong shape, are not finite, or time goes back.
        OptionError: an option outside what is allowed, or a task that cannot be certified.
        TaskError: no such task.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = check_path(open_robot("planar3r"), [[0.3, 0.4, 0.1], [0.5, -0.2, 0.3]], [0.0, 2.0])
        >>> str(found.verdict), [round(float(x), 9) for x in found.crossings[0].closest.q]
        ('crossing', [0.433333333, 0.0, 0.233333333])
    """
    check_robot(robot)
    how = PathOptions.of(options, given)
    samples = as_numbers(q, "q", ConfigurationError)
    if samples.ndim != 2 or not len(samples):
        raise ConfigurationError(
            "a path has one row for each sample", where="q", got=f"shape {samples.shape}",
            allowed=f"shape (T, {robot.n}), T ≥ 1",
        )  # fmt: skip
    if samples.shape[1] == robot.n:
        check_values(samples, robot, rows_of("q", robot))
    rows = configurations(robot, samples)[0].copy()
    times = _times(t, len(rows), "row")
    rates, changes = (
        None if values is None else _like(rows, values, name, robot)
        for name, values in (("velocities", velocities), ("accelerations", accelerations))
    )
    path = curve(rows, times, rates, changes, how.interpolate)
    remarks: list[tuple[Remark, Any]] = []
    if (hint := unit_hint(path.control.reshape(-1, robot.n), robot)) is not None:
        remarks.append(("degrees", hint))
    if rates is not None and how.interpolate == "linear":
        remarks.append(("velocities", None))
    if (step := jump(robot, rows)) is not None:
        remarks.append(("jump", step))
    check = check_curve(robot, path, asked_for(robot, task, analysis), how, analysis, tolerances, progress)
    return replace(check, rows=len(rows), remarks=(*check.remarks, *remarks))


def asked_for(robot: Robot, task: Task | str | None, analysis: Analysis | None) -> Task:
    """The task that a path is checked for; the one that families are given for where none is named."""
    resolved = resolve_task(task, robot)
    if task is None and analysis is None:
        return asked_task(robot, resolved)
    return resolved


def _times(t: ArrayLike | None, count: int, what: str) -> Array | None:
    if t is None:
        return None
    times = as_numbers(t, "t", ConfigurationError)
    if times.shape != (count,):
        raise ConfigurationError(f"there is one time for each {what}", where="t", got=f"shape {times.shape}",
                                 allowed=f"shape ({count},)")  # fmt: skip
    return check_times(times, lambda row: f"t, {what} {row + 1}")


def _like(rows: Array, values: ArrayLike, name: str, robot: Robot) -> Array:
    array = as_numbers(values, name, ConfigurationError)
    if array.shape != rows.shape:
        raise ConfigurationError(f"{name} have the shape of q", where=name, got=f"shape {array.shape}",
                                 allowed=f"shape {rows.shape}")  # fmt: skip
    return check_values(array, robot, rows_of(name, robot))


def check_curve(
    robot: Robot,
    path: Curve,
    task: Task,
    options: PathOptions,
    analysis: Analysis | None = None,
    tolerances: Tolerances = DEFAULT,
    progress: Callable[[int, int], None] | None = None,
) -> PathCheck:
    """As `check_path`, of a curve."""
    families, source = known_families(robot, task, analysis, tolerances)
    resolved = replace(task, length_scale=float(task.scale(robot)))
    arm, arm_task = in_metres(robot), task_in_metres(resolved, robot)
    moved = path if arm is robot else _curve_in_metres(path, robot)
    proof = prove(
        arm, settings_for(arm, arm_task), moved, singular=tolerances.singular, evaluations=options.evaluations,
        progress=progress,
    )  # fmt: skip
    survey = Survey(arm, arm_task, moved, families, source, robot, options, tolerances)
    parts = crossings(arm, arm_task, moved, proof.slivers, survey.families, tolerances)
    stretches, violations = survey.stretches(parts), survey.violations()
    spent, distance_kept, remarks = proof.evaluations, None, survey.remarks
    if options.min_distance > 0.0:
        nearest = min((stretch.closest.distance for stretch in stretches), default=np.inf)
        distance_kept = "violated" if nearest < options.min_distance else "not proven"
        if distance_kept == "not proven" and proof.complete and not proof.slivers:
            from rankdrop.path.check.certificate import margin  # with the checker of proofs

            row, more = margin(arm, arm_task, proof.setting, moved, options.min_distance, options.evaluations)
            spent += more
            if row < 0:
                distance_kept = "kept"
            else:
                remarks += (("distance open", row + 1),)
    length, undecided, time, free = _shares(moved, proof.setting.scale, parts)
    if arm is not robot:
        stretches = tuple(_in_own_units(stretch, robot) for stretch in stretches)
    return PathCheck(
        robot=robot, task=resolved, curve=path, rows=len(path.control) + 1, options=options, tolerances=tolerances,
        verdict=_verdict(parts, violations, distance_kept, proof.complete), stretches=stretches, violations=violations,
        free_share=free, undecided_share=undecided, undecided_length=length, undecided_time=time, margin=distance_kept,
        evaluations=spent, source=source, remarks=remarks, complete=proof.complete, profile=survey.profile,
    )  # fmt: skip


def _curve_in_metres(path: Curve, robot: Robot) -> Curve:
    """A curve of an arm in other units, in metres."""
    speeds = None
    if path.speeds is not None:
        speeds = into_metres(robot, path.speeds)
    return replace(path, control=into_metres(robot, path.control), speeds=speeds)


def _in_own_units(stretch: Stretch, robot: Robot) -> Stretch:
    """A stretch that was found in metres, with its configurations and rates in the units of the arm."""

    def own(values: Array) -> Array:
        if len(values):
            return out_of_metres(robot, values)
        return values

    closest = replace(stretch.closest, q=own(stretch.closest.q), foot=own(stretch.closest.foot))
    return replace(stretch, closest=closest, rates=own(stretch.rates))


def _verdict(
    parts: tuple[Stretch, ...], violations: tuple[Violation, ...], kept: str | None, complete: bool
) -> Verdict:
    """The worst of all that is known; what is not proven either way is undecided."""
    kinds = {part.verdict for part in parts}
    for violation in violations:
        if not violation.proven:
            kinds.add(UNDECIDED)
        elif violation.what == "rate":
            kinds.add(TOO_FAST)
        else:
            kinds.add(OUTSIDE)
    if kept == "violated":
        kinds.add(TOO_NEAR)
    if kept == "not proven" or not complete:
        kinds.add(UNDECIDED)
    return next((verdict for verdict in Verdict if verdict in kinds), FREE)


def _shares(path: Curve, scale: Array, parts: tuple[Stretch, ...]) -> tuple[float, float, float | None, float]:
    """Undecided length in joint space, its share of the whole, its time; and the share that is proven free."""
    lengths = np.linalg.norm(np.diff(path.control, axis=1) / scale, axis=2).sum(axis=1)
    if not lengths.any():  # the arm stands still: stretches count
        lengths = np.ones(len(lengths))
    until = np.concatenate([[0.0], np.cumsum(lengths)])

    def sum_of(values: Array, *verdicts: Verdict) -> float:
        def value_at(place: Place) -> float:
            k, share = path.spot(place)
            return float(values[k] + share * (values[k + 1] - values[k]))

        chosen = [part for part in parts if part.verdict in verdicts]
        return float(sum(value_at(part.end) - value_at(part.start) for part in chosen))

    length, total = sum_of(until, UNDECIDED), float(until[-1])
    singular = sum_of(until, CROSSING, TOUCHING)
    if path.times is None:
        time = None
    else:
        time = sum_of(path.times, UNDECIDED)
    return length, length / total, time, max(0.0, 1.0 - length / total - singular / total)  # rounding


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
    times = _times(t, len(wanted), "pose")
    resolved = followed_task(robot, task)
    check_tilt(robot, resolved, wanted, "poses")
    tolerance = tip_tolerance(how, robot)
    first, solutions, moved = _first_configuration(robot, wanted, resolved, start, tolerance)
    branch = followed_branch(robot, wanted, first, resolved, tolerance, free=start is None)
    if not len(branch.q):
        raise ConfigurationError(
            "the first pose lies next to a singularity of the start, where the solver ends on no configuration of it",
            where="poses, pose 1", mend="write the pose with more digits, or begin a little farther on",
        )  # fmt: skip
    aim, targets = Aim(robot, resolved), poses_at(wanted, branch.place - 1.0)
    away, turned = tip_apart(aim, branch.q, targets)
    missed = aim.missed(targets, branch.q)
    ahead = wanted[min(ceil(branch.place[-1] - 1.0 + 1e-9), len(wanted) - 1)]
    isolated, self_motions = 0, 0
    if start is None:
        isolated, self_motions = _count_solutions(robot, wanted[0], resolved, solutions)
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
    return replace(check, rows=len(branch.q), tool=tool, verdict=worst, remarks=remarks,
                   poses=GivenPoses(wanted, times, resolved))  # fmt: skip


def tip_tolerance(options: PathOptions, robot: Robot) -> tuple[float, float]:
    """How far the tip may leave its curve between rows: [m, or what the arm counts in], [rad]."""
    return options.tip_tolerance * counted_length(robot), options.turn_tolerance


def _branches(
    robot: Robot, poses: Array, solutions: Array, first: Array, task: Task, asked: Task,
    tolerance: tuple[float, float], taken: Followed, check: PathCheck, tolerances: Tolerances,
) -> tuple[ToolBranch, ...]:  # fmt: skip
    """Every branch that begins at a solution of the first pose, each followed and proven for itself."""
    if len(taken.q):
        first = taken.q[0]
    away = np.linalg.norm(joint_difference(robot, first, solutions) / joint_scale(robot, task), axis=1)
    same = away <= _SAME
    if same.any():
        starts = solutions
        chosen = int(away.argmin())
    else:
        starts = np.concatenate([first[None], solutions])
        chosen = 0
    starts[chosen] = first
    if len(starts) > MOST_BRANCHES:  # a self-motion at a singular first pose: its points are no branches
        return ()
    from rankdrop.poses.postures import posture_names  # with the exact side, which a path of joint values does without

    branches = []
    for row, q in enumerate(starts):
        if row == chosen:
            branch, place = taken, _not_free_taken(taken, check)
        else:
            branch = follow(robot, poses, q, task, tolerance=tolerance, through=True)
            place = _not_free(robot, asked, branch, tolerances)
        branches.append(ToolBranch(
            q, posture_names(robot, task, q[None])[0], arm_postures(robot, q[None])[0], branch.complete, branch.reached,
            branch.reason, branch.joint, branch.folds, branch.turn, place == 0.0, place, row == chosen,
        ))  # fmt: skip
    return tuple(branches)


def _not_free_taken(taken: Followed, check: PathCheck) -> float:
    """The pose, from 1, from which on the branch that was taken and checked is not free; 0 where it is free."""
    if check.crossings:
        return min(float(_pose_at(taken, crossing.closest.place.position)) for crossing in check.crossings)
    if taken.passed:
        return min(point.place for point in taken.passed)
    if any(stretch.verdict == UNDECIDED for stretch in check.stretches):
        return 1.0
    return 0.0


def _pose_at(branch: Followed, row: float) -> float:
    """Number of the pose, with a share, of a place among the rows (from 1) of a branch."""
    return float(np.interp(row, np.arange(1, len(branch.place) + 1), branch.place))


def _not_free(robot: Robot, task: Task, branch: Followed, tolerances: Tolerances) -> float:
    """Pose at which the joint path of a branch is first not proven free of singularities; 0: it is."""
    if not len(branch.q):
        return 1.0
    arm, arm_task = in_metres(robot), task_in_metres(replace(task, length_scale=float(task.scale(robot))), robot)
    sigma = singular_values(arm, into_metres(robot, branch.q), arm_task)[:, generic_rank(arm, arm_task) - 1]
    if (sigma <= _AT_ONE).any():
        return float(branch.place[int((sigma <= _AT_ONE).argmax())])
    proof = proof_of(robot, task, branch.q, tolerances, _FOR_BRANCH)
    if not proof.slivers:
        return 0.0
    (row, share), *_ = proof.slivers[0]
    return _pose_at(branch, 1.0 + row + share)


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


def within_limits(robot: Robot, goal: Array, task: Task) -> Array:
    """(S, n) configurations at a pose (4, 4) within the joint limits, those first that people use, of those found.

    Newton's method from `STARTS` random configurations and from the one nearest to zero; a redundant arm has more.
    """
    low, high = sampling_box(robot, task, limits=True)
    home = np.clip(np.zeros(robot.n), robot.lower, robot.upper)
    starts = np.concatenate([home[None], np.random.default_rng(0).uniform(low, high, (STARTS, robot.n))])
    q = near_and_within(robot, Aim(robot, task).solve_from(goal, starts), home, limits=True)
    far = np.linalg.norm((q - home) / joint_scale(robot, task), axis=1)
    solutions = distinct(robot, task, q[np.argsort(far, kind="stable")], _SAME)
    if len(solutions) and robot.n <= task.m:
        return solutions[by_habit(robot, task, solutions)]
    return solutions


def _first_configuration(
    robot: Robot, poses: Array, task: Task, start: ArrayLike | None, tolerance: tuple[float, float]
) -> tuple[Array, Array, float]:
    """As `configuration_at`, and at a first pose that misses the singularity of the start by rounding this singularity,
    where the branch leads straight away from it.
    """
    if start is not None:
        given = _validate_start(robot, start)
        met = missed_start(Aim(robot, task), poses[0], given)
        if met is not None:
            left = follow(robot, poses[:2], met, task, tolerance=tolerance, through=True)
            if len(left.q) > 1 and np.linalg.norm(left.q[0] - met) <= _SAME:
                away = float(np.linalg.norm((met - given) / joint_scale(robot, task)))
                return met, within_limits(robot, poses[0], task), away
    return configuration_at(robot, poses[0], task, start)


def configuration_at(robot: Robot, goal: Array, task: Task, start: ArrayLike | None) -> tuple[Array, Array, float]:
    """A configuration at the first pose, all that were found, and how far it is from the start that was given."""
    if start is None:
        given = None
    else:
        given = _validate_start(robot, start)
    solutions = within_limits(robot, goal, task)
    if given is not None:
        near = _nearest_to_start(robot, goal, task, solutions, given)
        if near is not None:
            return near[0], solutions, near[1]
    if not len(solutions):
        raise _out_of_reach(robot, goal, task)
    return solutions[0], solutions, 0.0


def _count_solutions(robot: Robot, goal: Array, task: Task, solutions: Array) -> tuple[int, int]:
    """How many isolated configurations and how many self-motions at a pose were found within the joint limits.

    Newton's method ends on many points of a self-motion, which are no solutions of their own; `inverse` joins them.

    Args:
        robot, task: the arm.
        goal: (4, 4) the pose.
        found: (S, n) from `within_limits`.

    Returns:
        Of a redundant arm the number of points found, and 0.
    """
    if robot.n > task.m or not len(solutions):
        return len(solutions), 0
    arm, arm_task = in_metres(robot), task_in_metres(task, robot)
    sigma = singular_values(arm, into_metres(robot, solutions), arm_task)[:, generic_rank(arm, arm_task) - 1]
    singular = sigma < _REGULAR
    regular = int((~singular).sum())
    if singular.sum() < 2:
        return len(solutions), 0
    from rankdrop.poses.branches import inverse  # a path from a regular pose does without

    every = inverse(robot, goal, task)
    inside = [branch for branch in every.branches if not branch.beyond]
    isolated = sum(branch.sigma < _REGULAR for branch in inside)
    return regular + isolated, sum(not continuum.beyond for continuum in every.continua)


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


def _out_of_reach(robot: Robot, goal: Array, task: Task) -> ConfigurationError:
    """The error of a first pose without a configuration; with the task to ask for where the arm has too few joints."""
    other = fitting_task(robot, task)
    if other is not None and len(within_limits(robot, goal, other)):
        return ConfigurationError(
            f"{robot.n} joints cannot take pose 1 in full", where="poses", got="position and orientation",
            mend=f"task={other.name!r} leaves free what they cannot do",
            typed=f"--task {other.name} leaves free what they cannot do",
        )  # fmt: skip
    return ConfigurationError(
        "pose 1 is out of reach: no configuration within the joint limits was found", where="poses",
        got=f"{STARTS + 1} starts of Newton's method", mend="look at its units and its frame, or give a start",
        typed="look at its units and its frame, or give --start; explain with --pose prints how far it is off",
    )  # fmt: skip


def _validate_start(robot: Robot, start: ArrayLike) -> Array:
    """(n,) the start that was given [rad, m].

    Raises:
        ConfigurationError: it is no configuration.
    """
    given = as_numbers(start, "start", ConfigurationError)
    if given.shape != (robot.n,) or not np.isfinite(given).all():
        raise ConfigurationError("the start is one configuration", where="start", got=f"shape {given.shape}",
                                 allowed=f"{robot.n} finite numbers")  # fmt: skip
    return given


def _nearest_to_start(
    robot: Robot, goal: Array, task: Task, solutions: Array, given: Array
) -> tuple[Array, float] | None:
    """The configuration at the first pose that is nearest to the start, and how far it is; None where none is known.

    Raises:
        ConfigurationError: the pose is not reached from the start.
    """
    reached = follow(robot, goal[None], given, task)
    scale = joint_scale(robot, task)
    ends = solutions + whole_turns(robot, given - solutions)
    inside = np.asarray(((ends >= robot.lower - _EDGE) & (ends <= robot.upper + _EDGE)).all(axis=1))
    ends = np.where(inside[:, None], ends, solutions)  # whole turns as in the start, where the limits allow them
    if reached.complete:
        far = float(np.linalg.norm((reached.q[0] - given) / scale))
        if far <= _NEAR_START or not len(ends) or robot.n > task.m:
            return reached.q[0], far
        ends = np.concatenate([reached.q[:1], ends])
    if len(ends) and not reached.joint:
        away = np.linalg.norm((ends - given) / scale, axis=1)
        return ends[away.argmin()], float(away.min())
    if reached.complete:
        return None
    raise ConfigurationError(
        "pose 1 is not reached from this start: " + (
            f"joint {reached.joint} is beyond its limit there" if reached.joint else "Newton's method fails"
        ), where="start", mend="a start nearer to it, or none",
    )  # fmt: skip


def timed_branch(robot: Robot, task: Task, poses: Array, times: Array | None, branch: Followed) -> Curve:
    """The joint path with its times, and with the joint rates J⁺ẋ that the curve needs at both ends of each piece."""
    if times is None:
        when = None
    else:
        when = np.interp(branch.place, np.arange(1, len(poses) + 1), times)
    path = curve(branch.q, when)
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


@dataclass(frozen=True)
class PathQuestion:
    """What is asked of a path in a file.

    Attributes:
        task, analysis, options: as for `check_path`.
        deg: angles without a unit are in degrees.
        topic: of a bag in which several have joint values.
        start: configuration near the first pose, which decides the branch of the inverse kinematics.
    """

    task: Task | str | None
    analysis: Analysis | None
    options: PathOptions
    deg: bool = False
    topic: str | None = None
    start: tuple[float, ...] | None = None


def check_file(
    robot: Robot,
    file: Path,
    question: PathQuestion,
    *,
    say: Callable[[str], None] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> PathCheck:
    """Check one file: joint values, or poses of the tip.

    Args:
        robot: the arm.
        file: trajectory or poses.
        question: what is asked of it.
        say: called with what a reader of the file should know: columns that are ignored, angles in the wrong unit.
        progress: called with (stretches decided, stretches).

    Raises:
        RankdropError: the file cannot be read, with the place in it, or an option does not fit it.
    """
    wanted = resolve_task(question.task, robot)
    read, hint = _read_path(robot, file, question)
    if say is not None:
        for line in reading_remarks(read.name, hint, read.notes, read.unused):
            say(line)
    asked: dict[str, Any] = {
        "task": question.task, "analysis": question.analysis, "options": question.options, "progress": progress,
    }  # fmt: skip
    if isinstance(read, Trajectory):
        return check_path(robot, read.q, read.times if read.timed else None, velocities=read.velocities,
                          accelerations=read.accelerations, **asked)  # fmt: skip
    if not read.turned and max(wanted.rows) >= 3:
        raise TaskError("the file has positions alone, and the task wants orientations", got=wanted.name,
                        where=str(file),
                        mend="add qx, qy, qz, qw or roll, pitch, yaw, or use task='position'",
                        typed="add qx, qy, qz, qw or roll, pitch, yaw, or use --task position")  # fmt: skip
    try:
        return check_poses(robot, read.matrices, read.times, start=question.start, **asked)
    except ConfigurationError as error:
        raise ConfigurationError(**error.parts | {"where": f"{file}, {error.where}"}) from error


def _read_path(robot: Robot, file: Path, question: PathQuestion) -> tuple[Poses | Trajectory, str | None]:
    """The poses or joint values of a file, and a hint where their unit may be another one.

    Raises:
        RankdropError: the file cannot be read, or there is a start for joint values.
    """
    deg, start = question.deg, question.start
    if question.topic is None and holds_poses(file, robot):
        poses = read_poses(file, deg=deg, robot=robot)
        return poses, length_hint(poses, reach(robot))
    if start is not None:
        raise OptionError("a start is for poses of the tip, these are joint values", where="start",
                          got=", ".join(f"{x:.6g}" for x in start))  # fmt: skip
    trajectory = read_trajectory(file, robot, deg=deg, topic=question.topic)
    if not deg:
        refuse_degrees(trajectory, robot, file)
    hint = unit_hint(trajectory.q, robot, deg=deg)
    if hint is not None and not deg:
        hint = degrees_advice(hint)
    return trajectory, hint
