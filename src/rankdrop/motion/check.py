"""`check_path`: does a path reach a singularity between its samples, come too near to one, or break a joint limit?

That every point of a path is at least so far from every singular configuration is proven by balls that cover it. A
piece of the path lies within ρ of its middle; a ball of radius d + ρ around the middle that is proven free keeps the
distance d on all of the piece. One enclosure is tried first, branch and bound on short pieces.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.certify.ball import LARGEST, certified_radius, settings_of
from rankdrop.certify.setting import Setting, enclose
from rankdrop.errors import ConfigurationError
from rankdrop.kinematics import check_robot, configurations
from rankdrop.motion.bound import ROUNDED
from rankdrop.motion.crossings import Crossing, crossings
from rankdrop.motion.curve import Curve, boxes, curve, halves
from rankdrop.motion.options import PathOptions
from rankdrop.motion.prove import prove, stretches_left
from rankdrop.motion.record import (
    CROSSING,
    FREE,
    NOT_FOLLOWED,
    OUTSIDE,
    TOO_FAST,
    TOO_NEAR,
    TOUCHING,
    UNDECIDED,
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
from rankdrop.units import in_metres, into_metres, out_of_metres, task_in_metres

_BALL = 20_000  # enclosures of branch and bound for one ball
_SHORT = 0.5  # pieces with ρ below this share of the distance get branch and bound
_SHORTEST = 0.05  # … and below this are given up
_OUTRIGHT = 1e-9  # of a radius: what bisection leaves open


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
            ball = certified_radius(robot, centre[i], task, at_most=_radius(distance, rho[i]), evaluations=_BALL)
            spent += ball.evaluations
            done[i] = ball.radius == ball.at_most
            if spent > evaluations or (not done[i] and rho[i] < _SHORTEST * distance):
                return int(stretch[i]), spent
        control, stretch = halves(control[~done]), np.repeat(stretch[~done], 2)
    return -1, spent


def _ball(low: Array, high: Array, setting: Setting) -> tuple[Array, Array]:
    """Middles of boxes, and how far their corners are [rad; slides scaled]."""
    centre = np.ascontiguousarray((low + high) / 2)
    half = ((high - low) / 2 + ROUNDED * (setting.scale + np.abs(centre))) / setting.scale
    return centre, np.linalg.norm(half[:, setting.matters], axis=1)


def _radius(distance: float, rho: float) -> float:
    return min((distance + float(rho)) * (1 + _OUTRIGHT), LARGEST)


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

    Nothing is sampled: boxes and curves are enclosed (`motion.bound`), and halved until every piece of the path is
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
    tool: ToolMotion | None = None,
) -> PathCheck:
    """As `check_path`, of a curve; `tool`: how it was made of poses."""
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
        verdict=_verdict(parts, violations, kept, proof.complete, tool), stretches=stretches, violations=violations,
        free_share=free, undecided_share=undecided, undecided_length=length, undecided_time=time, margin=kept,
        evaluations=spent, source=source, remarks=remarks, complete=proof.complete, profile=survey.profile, tool=tool,
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
    parts: tuple[Crossing, ...], violations: tuple[Violation, ...], kept: str | None, complete: bool,
    tool: ToolMotion | None,
) -> Verdict:  # fmt: skip
    """The worst of all that is known; what is not proven either way is undecided."""
    kinds = {one.kind for one in parts} | {
        (TOO_FAST if one.what == "rate" else OUTSIDE) if one.proven else UNDECIDED for one in violations
    }
    if tool is not None and not tool.complete:
        kinds.add(UNDECIDED if tool.reason == "stuck" else NOT_FOLLOWED)
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
