"""`check_path`: does a path reach a singularity between its samples, come too near to one, or break a joint limit?

That every point of a path is at least so far from every singular configuration is proven by balls that cover it. A
piece of the path lies within ρ of its middle; a ball of radius d + ρ around the middle that is proven free keeps the
distance d on all of the piece. One enclosure is tried first, branch and bound on short pieces.

`check_poses`: straight moves between poses of the tip, through the arm's own inverse kinematics.

The tip goes straight from pose to pose and turns about one axis, as a linear move of a controller does. Joint values
are solved along this curve on one branch (`follow`), at rows so close that the joints, going straight between them, are
proven to keep the tip within a tolerance of the curve (`TipDeviation`). That joint path is checked as any other
(`check_path`), with the joint rates of the curve itself at both ends of every piece. Where the branch ends, the part up
to there is checked.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.certify.ball import LARGEST, certified_radius, settings_of
from rankdrop.certify.setting import Setting, enclose
from rankdrop.errors import ConfigurationError
from rankdrop.kinematics import check_robot, configurations
from rankdrop.local.block import joint_scale, sampling_box
from rankdrop.local.orientation import orientation_coordinates
from rankdrop.motion.crossings import Crossing, crossings
from rankdrop.motion.curve import Curve, boxes, curve, halves
from rankdrop.motion.follow import Followed, follow, poses_at
from rankdrop.motion.inverse import Aim, TipDeviation, distinct
from rankdrop.motion.options import PathOptions
from rankdrop.motion.prove import centred, prove, stretches_left
from rankdrop.motion.record import (
    CROSSING,
    FREE,
    NOT_FOLLOWED,
    OUTSIDE,
    TOO_FAST,
    TOO_NEAR,
    TOUCHING,
    UNDECIDED,
    VERDICTS,
    PathCheck,
    Remark,
    Stretch,
    ToolMotion,
    Verdict,
    Violation,
)
from rankdrop.motion.survey import Survey
from rankdrop.motion.trajectory import checked, checked_times, unit_hint
from rankdrop.options import takes
from rankdrop.results.analysis import Analysis
from rankdrop.results.explanation.parts import checked_frame, known_families
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import counted_length, in_metres, into_metres, out_of_metres, task_in_metres

_BALL = 20_000  # enclosures of branch and bound for one ball
_SHORT = 0.5  # pieces with ρ below this share of the distance get branch and bound
_SHORTEST = 0.05  # … and below this are given up
_OUTRIGHT = 1e-9  # of a radius: what bisection leaves open
STARTS = 512
"""Random configurations, and the one nearest to zero, that solutions at the first pose are searched from."""
_SAME = 1e-4  # solutions nearer to each other are one [rad]


def margin(
    robot: Robot, task: Task, setting: Setting, path: Curve, distance: float, evaluations: int
) -> tuple[int, int]:
    """Try to prove that no singular configuration is nearer to the path than a distance.

    Args:
        robot, task: the arm and its task.
        setting: that the path was proven free from.
        path: the curve.
        distance: d > 0 [rad; slides divided by the length scale]; beyond π it is not tried.
        evaluations: enclosures to be spent at most.

    Returns:
        A stretch for which it could not be proven, −1 where it is proven; and the enclosures spent.
    """
    if distance >= LARGEST:
        return 0, 0
    spent = 0

    def kept(low: Array, high: Array) -> NDArray[np.bool_]:
        nonlocal spent
        spent += len(low)
        return _kept(robot, setting, *_ball(low, high, setting), distance)

    stretch = stretches_left(path, kept)
    control = path.control[stretch]
    while len(control):
        centre, rho = _ball(*boxes(control), setting)
        spent += len(control)
        if spent > evaluations:
            return int(stretch[0]), spent
        done = _kept(robot, setting, centre, rho, distance)
        for i in np.flatnonzero(~done & (rho < _SHORT * distance)):
            radius = min((distance + float(rho[i])) * (1 + _OUTRIGHT), LARGEST)
            ball = certified_radius(robot, centre[i], task, at_most=radius, evaluations=_BALL)
            spent += ball.evaluations
            done[i] = ball.radius == ball.at_most
            if spent > evaluations or (not done[i] and rho[i] < _SHORTEST * distance):
                return int(stretch[i]), spent
        control, stretch = halves(control[~done]), np.repeat(stretch[~done], 2)
    return -1, spent


def _ball(low: Array, high: Array, setting: Setting) -> tuple[Array, Array]:
    """Middles of boxes, and how far their corners are [rad; slides scaled]."""
    centre, half = centred(low, high, setting)
    return centre, np.linalg.norm(half[:, setting.matters], axis=1)


def _kept(robot: Robot, setting: Setting, centre: Array, rho: Array, distance: float) -> NDArray[np.bool_]:
    kept = np.zeros(len(centre), dtype=np.bool_)
    tried = np.flatnonzero(distance + rho < LARGEST)
    if len(tried):
        radius = enclose(robot, setting, np.ascontiguousarray(centre[tried]), radius=LARGEST)[1]
        kept[tried] = radius * (1 - _OUTRIGHT) >= distance + rho[tried]
    return kept


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

    Nothing is sampled: boxes and curves are enclosed (`motion.prove`), and halved until every piece of the path is
    proven free or so narrow that double precision decides. The rest is decided by signs (`motion.crossings`): a
    *crossing* is proven by the intermediate value theorem; where σ_r is within the tolerance without a change of sign
    the path is *touching*, which is a measurement; anything else is *undecided*. A path that is free but leaves the
    range of a joint, or its largest rate, is *outside limits* or *too fast*.

    Args:
        robot: the arm.
        q: (T, n) samples, in order [rad, m].
        t: (T,) times [s], increasing; None where there are none.
        velocities, accelerations: (T, n) of the samples, for cubic and quintic interpolation.
        task: name, rows or Task; None is the task the arm is made for.
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
    rows, times = _samples(robot, q, t)
    rates, accelerations_ = (_shaped(robot, one, rows, name) for one, name in
                             ((velocities, "velocities"), (accelerations, "accelerations")))  # fmt: skip
    how = PathOptions.of(options, given)
    path = curve(rows, times, rates, accelerations_, how.interpolate)
    remarks: tuple[tuple[Remark, Any], ...] = ()
    if (hint := unit_hint(path.control.reshape(-1, robot.n), robot)) is not None:
        remarks += (("degrees", hint),)
    if rates is not None and how.interpolate == "linear":
        remarks += (("velocities", None),)
    check = check_curve(robot, path, resolve_task(task, robot), how, analysis, tolerances, progress)
    return replace(check, rows=len(rows), remarks=(*check.remarks, *remarks))


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
    checked_frame(options.frame)
    resolved = replace(task, length_scale=float(task.scale(robot)))
    arm, arm_task = in_metres(robot), task_in_metres(resolved, robot)
    moved = path if arm is robot else replace(path, control=into_metres(robot, path.control), speeds=(
        None if path.speeds is None else into_metres(robot, path.speeds)))  # fmt: skip
    proof = prove(
        arm, settings_of(arm, arm_task), moved, singular=tolerances.singular, evaluations=options.evaluations,
        progress=progress,
    )  # fmt: skip
    survey = Survey(arm, arm_task, moved, families, source, robot, options, tolerances)
    parts = crossings(arm, arm_task, moved, proof.slivers, survey.families, tolerances)
    stretches, violations = survey.stretches(parts), survey.violations()
    spent, kept, remarks = proof.evaluations, None, survey.remarks
    if options.min_distance > 0.0:
        nearest = min((one.closest.distance for one in stretches), default=np.inf)
        kept = "violated" if nearest < options.min_distance else "not proven"
        if kept == "not proven" and proof.complete and not proof.slivers:
            row, more = margin(arm, arm_task, proof.setting, moved, options.min_distance, options.evaluations)
            spent, kept = spent + more, "kept" if row < 0 else kept
            remarks += (("distance open", row + 1),) if row >= 0 else ()
    length, undecided, time, free = _shares(moved, proof.setting.scale, parts)
    if arm is not robot:
        stretches = tuple(_out_of_metres(one, robot) for one in stretches)
    return PathCheck(
        robot=robot, task=resolved, curve=path, rows=len(path.control) + 1, options=options, tolerances=tolerances,
        verdict=_verdict(parts, violations, kept, proof.complete), stretches=stretches, violations=violations,
        free_share=free, undecided_share=undecided, undecided_length=length, undecided_time=time, margin=kept,
        evaluations=spent, source=source, remarks=remarks, complete=proof.complete, profile=survey.profile,
    )  # fmt: skip


def _samples(robot: Robot, q: ArrayLike, t: ArrayLike | None) -> tuple[Array, Array | None]:
    given = np.asarray(q, dtype=np.float64)
    if given.ndim != 2 or not len(given):
        raise ConfigurationError(
            "a path has one row for each sample", where="q", got=f"shape {given.shape}",
            allowed=f"shape (T, {robot.n}), T ≥ 1",
        )  # fmt: skip
    if given.shape[1] == robot.n:
        checked(given, "q", robot)
    rows, _ = configurations(robot, given)
    if t is None:
        return rows.copy(), None
    times = np.asarray(t, dtype=np.float64)
    if times.shape != (len(rows),):
        raise ConfigurationError("there is one time for each row", where="t", got=f"shape {times.shape}",
                                 allowed=f"shape ({len(rows)},)")  # fmt: skip
    return rows.copy(), checked_times(times, [f"t, row {row + 1}" for row in range(len(rows))])


def _shaped(robot: Robot, values: ArrayLike | None, rows: Array, name: str) -> Array | None:
    if values is None:
        return None
    array = np.asarray(values, dtype=np.float64)
    if array.shape != rows.shape:
        raise ConfigurationError(f"{name} have the shape of q", where=name, got=f"shape {array.shape}",
                                 allowed=f"shape {rows.shape}")  # fmt: skip
    return checked(array, name, robot)


def _verdict(
    parts: tuple[Crossing, ...], violations: tuple[Violation, ...], kept: str | None, complete: bool
) -> Verdict:
    """The worst of all that is known; what is not proven either way is undecided."""
    kinds = {one.kind for one in parts} | {
        (TOO_FAST if one.what == "rate" else OUTSIDE) if one.proven else UNDECIDED for one in violations
    }
    if kept in ("violated", "not proven"):
        kinds.add(TOO_NEAR if kept == "violated" else UNDECIDED)
    if not complete:
        kinds.add(UNDECIDED)
    return next((one for one in Verdict if one in kinds), FREE)


def _shares(path: Curve, scale: Array, parts: tuple[Crossing, ...]) -> tuple[float, float, float | None, float]:
    """Undecided length in joint space, its share of the whole, its time; and the share that is proven free."""
    lengths = np.linalg.norm(np.diff(path.control, axis=1) / scale, axis=2).sum(axis=1)
    if not lengths.any():  # the arm stands still: stretches count
        lengths = np.ones(len(lengths))
    until = np.concatenate([[0.0], np.cumsum(lengths)])

    def between(part: Crossing, values: Array) -> float:
        low, high = (values[k] + share * (values[k + 1] - values[k]) for k, share in (part.start, part.end))
        return float(high - low)

    open_ = [one for one in parts if one.kind == UNDECIDED]
    length = sum(between(one, until) for one in open_)
    singular = sum(between(one, until) for one in parts if one.kind in (CROSSING, TOUCHING))
    total = float(until[-1])
    time = None if path.times is None else float(sum(between(one, path.times) for one in open_))
    return length, length / total, time, max(0.0, 1.0 - length / total - singular / total)  # rounding


def _out_of_metres(stretch: Stretch, robot: Robot) -> Stretch:
    closest = stretch.closest
    foot = out_of_metres(robot, closest.foot) if len(closest.foot) else closest.foot
    rates = out_of_metres(robot, stretch.rates) if len(stretch.rates) else stretch.rates
    return replace(stretch, closest=replace(closest, q=out_of_metres(robot, closest.q), foot=foot), rates=rates)


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
    check = check_curve(robot, path, resolved, how, analysis, tolerances, progress)
    ended = FREE if branch.complete else UNDECIDED if branch.reason == "stuck" else NOT_FOLLOWED
    worst = min(check.verdict, ended, key=VERDICTS.index)
    return replace(check, rows=len(branch.q), tool=tool, verdict=worst)


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
