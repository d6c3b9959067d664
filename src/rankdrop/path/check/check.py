"""Is a path of joint values free of singularities, clear of them, and within limits, between its samples too?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.cover.setting import settings_for
from rankdrop.errors import ConfigurationError
from rankdrop.kinematics import check_robot, configurations
from rankdrop.local.pointing import asked_task
from rankdrop.options import takes
from rankdrop.path.check.crossings import crossings
from rankdrop.path.check.prove import prove
from rankdrop.path.check.record import (
    CROSSING,
    FREE,
    OUTSIDE,
    TOO_FAST,
    TOO_NEAR,
    TOUCHING,
    UNDECIDED,
    PathCheck,
    Remark,
    Stretch,
    Verdict,
    Violation,
)
from rankdrop.path.check.survey import Survey
from rankdrop.path.check.turns import jump
from rankdrop.path.curve import Curve, Place, curve
from rankdrop.path.read.trajectory import check_times, check_values, rows_of, unit_hint
from rankdrop.questions import PathOptions
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import known_families
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.transform import as_numbers
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_metres, into_metres, out_of_metres, task_in_metres


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
    times = checked_times(t, len(rows), "row")
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


def checked_times(t: ArrayLike | None, count: int, what: str) -> Array | None:
    """The times (count,) of rows or poses, rising [s]; None for none.

    Raises:
        ConfigurationError: not one number for each `what`, or a time that is not after the one before.
    """
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

    def out(values: Array) -> Array:
        if len(values):
            return out_of_metres(robot, values)
        return values

    closest = replace(stretch.closest, q=out(stretch.closest.q), foot=out(stretch.closest.foot))
    return replace(stretch, closest=closest, rates=out(stretch.rates))


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
