"""`check_path`: does a path meet a singularity between its samples, or come too near to one?

That every point of a path is at least so far from every singular configuration is proven by balls that cover it. A
piece of the path lies within ρ of its middle; a ball of radius d + ρ around the middle that is proven free keeps the
distance d on all of the piece. One enclosure is tried first, branch and bound on short pieces.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.certify.ball import LARGEST, certified_radius, settings_of
from rankdrop.certify.setting import Setting, enclose
from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.kinematics import check_robot, configurations
from rankdrop.motion.bound import ROUNDED
from rankdrop.motion.curve import Curve, boxes, curve, halves
from rankdrop.motion.data import CROSSING, FREE, TOO_NEAR, TOUCHING, UNDECIDED, PathSettings, Stretch
from rankdrop.motion.meets import Meeting, meetings
from rankdrop.motion.prove import box_tree, prove
from rankdrop.motion.result import PathCheck
from rankdrop.motion.stretches import Survey
from rankdrop.motion.trajectory import checked, checked_times, unit_hint
from rankdrop.results.analysis import Analysis
from rankdrop.results.explanation.parts import checked_frame, known_families
from rankdrop.results.explanation.words import angle, short
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_metres, into_metres, out_of_metres, task_in_metres
from rankdrop.version import VERSION

_BALL = 20_000  # enclosures of branch and bound for one ball
_SHORT = 0.5  # pieces with ρ below this share of the distance get branch and bound
_SHORTEST = 0.05  # … and below this are given up
_OUTRIGHT = 1e-9  # of a radius: what bisection leaves open


@dataclass(frozen=True, slots=True)
class Margin:
    """What is proven of a distance.

    Attributes:
        proven: the distance is kept everywhere.
        open: stretch where it could not be proven; −1 where it is.
        evaluations: enclosures spent.
    """

    proven: bool
    open: int
    evaluations: int


def margin(robot: Robot, task: Task, setting: Setting, path: Curve, distance: float, evaluations: int) -> Margin:
    """Try to prove that no singular configuration is nearer to the path than a distance.

    Args:
        robot, task: the arm and its task.
        setting: that the path was proven free from.
        path: the curve.
        distance: d > 0 [rad; slides divided by the length scale]; beyond π it is not tried.
        evaluations: enclosures to be spent at most.
    """
    if distance >= LARGEST:
        return Margin(False, 0, 0)
    spent = 0
    tree = box_tree(path)
    nodes = np.zeros(1, dtype=np.int64)
    for level in range(len(tree) - 1, -1, -1):
        low, high = tree[level]
        centre, rho = _ball(low[nodes], high[nodes], setting)
        spent += len(nodes)
        nodes = nodes[~_kept(robot, setting, centre, rho, distance)]
        if level:
            nodes = np.stack([2 * nodes, 2 * nodes + 1], axis=1).reshape(-1)
            nodes = nodes[nodes < len(tree[level - 1][0])]
    control, stretch = path.control[nodes], nodes
    while len(control):
        centre, rho = _ball(*boxes(control), setting)
        spent += len(control)
        if spent > evaluations:
            return Margin(False, int(stretch[0]), spent)
        kept = _kept(robot, setting, centre, rho, distance)
        for i in np.flatnonzero(~kept & (rho < _SHORT * distance)):
            ball = certified_radius(robot, centre[i], task, at_most=_radius(distance, rho[i]), evaluations=_BALL)
            spent += ball.evaluations
            kept[i] = ball.radius == ball.at_most
            if spent > evaluations or (not kept[i] and rho[i] < _SHORTEST * distance):
                return Margin(False, int(stretch[i]), spent)
        control, stretch = halves(control[~kept]), np.repeat(stretch[~kept], 2)
    return Margin(True, -1, spent)


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


_AT_ROW = 1e-6  # share of the way between two rows that is told as the row
EVALUATIONS = 2_000_000
"""Enclosures that a path may cost: some seconds. A path of a minute takes some hundred."""


def check_path(
    robot: Robot,
    q: ArrayLike,
    t: ArrayLike | None = None,
    *,
    velocities: ArrayLike | None = None,
    accelerations: ArrayLike | None = None,
    interpolate: str = "linear",
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
    """Judge a path at every one of its points, between its samples too.

    Nothing is sampled: boxes and curves are enclosed (`motion.bound`), and halved until every piece of the path is
    proven free or so narrow that double precision decides. What is left is judged by signs (`motion.meets`): a
    *crossing* is proven by the intermediate value theorem; where σ_r is within the tolerance without a change of sign
    the path is *touching*, which is a measurement; anything else is *undecided*.

    Args:
        robot: the arm.
        q: (T, n) samples, in order [rad, m].
        t: (T,) times [s], increasing; None where there are none.
        velocities, accelerations: (T, n) of the samples, for cubic and quintic interpolation.
        interpolate: "linear", "cubic" (Hermite) or "quintic": what the controller makes of the samples.
        task: name, rows or Task; None is the task the arm is made for.
        min_distance: distance to every singularity to be kept [rad; slides divided by the length scale]; 0: none.
        limits: distances to singularities within the joint limits only. A path is never excused by them.
        analysis: families of this arm and task; else from the catalogue, else found on the spot.
        evaluations: enclosures that may be spent.
        length_scale: translation is divided by it [m]; None is the task's, else the arm's reach.
        tolerances: `singular` decides what counts as touching.
        frame: in whose axes lost motions are told: "base", "tool", or "link", the one in which they are simplest.
        progress: told (stretches decided, stretches).

    Returns:
        The verdict, and every stretch, worst first.

    Raises:
        ConfigurationError: q, t, velocities or accelerations have the wrong shape, are not finite, or time goes back.
        OptionError: an option outside what is allowed, or a task that cannot be certified.
        TaskError: no such task.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = check_path(open_robot("planar3r"), [[0.3, 0.4, 0.1], [0.5, -0.2, 0.3]], [0.0, 2.0])
        >>> found.verdict, [round(float(x), 9) for x in found.crossings[0].closest.q]
        ('crossing', [0.433333333, 0.0, 0.233333333])
    """
    check_robot(robot)
    rows, times = _samples(robot, q, t)
    rates, accelerations_ = (_shaped(robot, one, rows, name) for one, name in
                             ((velocities, "velocities"), (accelerations, "accelerations")))  # fmt: skip
    resolved = resolve_task(task, robot, length_scale=length_scale)
    _check_options(min_distance, evaluations)
    families, source = known_families(robot, resolved, analysis, tolerances)
    path = curve(rows, times, rates, accelerations_, interpolate)
    settings = PathSettings(
        interpolate, float(min_distance), limits, int(evaluations), float(resolved.scale(robot)), tolerances, VERSION,
        checked_frame(frame),
    )  # fmt: skip
    resolved = replace(resolved, length_scale=settings.length_scale)
    there, there_task = in_metres(robot), task_in_metres(resolved, robot)
    there_path = path if there is robot else Curve(into_metres(robot, path.control), times)
    proof = prove(
        there, settings_of(there, there_task), there_path, singular=tolerances.singular, evaluations=evaluations,
        progress=progress,
    )  # fmt: skip
    survey = Survey(there, there_task, there_path, families, source, robot, settings)
    met = meetings(there, there_task, there_path, proof.slivers, survey.families, tolerances)
    stretches = survey.stretches(met)
    spent, kept, where = proof.evaluations, None, None
    if min_distance > 0.0:
        nearest = min((one.closest.distance for one in stretches), default=np.inf)
        if nearest < min_distance:
            kept = "violated"
        elif proof.slivers or not proof.complete:
            kept = "not proven"
        else:
            found = margin(there, there_task, proof.setting, there_path, min_distance, evaluations)
            spent, kept, where = spent + found.evaluations, "kept" if found.proven else "not proven", found.open
    verdict = _verdict(met, kept, proof.complete)
    shares = _Shares(there_path, proof.setting.scale, met)
    notes = (*_limit_notes(robot, path), *survey.notes, *_hints(robot, path, rates, interpolate))
    if where is not None and where >= 0:
        notes = (*notes, f"the distance {angle(min_distance)} could not be proven around row {where + 1}")
    if there is not robot:
        stretches = tuple(_out_of_metres(one, robot) for one in stretches)
    return PathCheck(
        robot=robot, task=resolved, curve=path, rows=len(rows), settings=settings, verdict=verdict,
        sentence=_sentence(verdict, stretches, settings, kept, spent, shares, proof.complete), stretches=stretches,
        free_share=shares.free, undecided_share=shares.undecided, undecided_length=shares.length,
        undecided_time=shares.time, margin=kept, evaluations=spent, source=source, notes=notes,
        complete=proof.complete, profile=survey.profile,
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


def _check_options(min_distance: float, evaluations: int) -> None:
    if isinstance(min_distance, bool) or not isinstance(min_distance, int | float | np.number) or not (
        0.0 <= min_distance < np.inf
    ):
        raise OptionError("this is a finite number from 0 up", where="min_distance", got=repr(min_distance))
    if isinstance(evaluations, bool) or not isinstance(evaluations, int | np.integer) or not evaluations >= 1:
        raise OptionError("this is a whole number from 1 up", where="evaluations", got=repr(evaluations))


def _verdict(met: tuple[Meeting, ...], kept: str | None, complete: bool) -> str:
    kinds = {one.kind for one in met}
    for kind in (CROSSING, TOUCHING):
        if kind in kinds:
            return kind
    if kept == "violated":
        return TOO_NEAR
    return UNDECIDED if kinds or kept == "not proven" or not complete else FREE


class _Shares:
    """How much of the path is free and how much is undecided, by length in joint space; time too."""

    def __init__(self, path: Curve, scale: Array, met: tuple[Meeting, ...]) -> None:
        lengths = np.linalg.norm(np.diff(path.control, axis=1) / scale, axis=2).sum(axis=1)
        self._until = np.concatenate([[0.0], np.cumsum(lengths)])
        self._path, total = path, float(self._until[-1])
        if total == 0.0:  # the arm stands still: stretches count
            self._until = np.arange(len(lengths) + 1.0)
            total = float(len(lengths))
        open_ = [one for one in met if one.kind == UNDECIDED]
        singular = [one for one in met if one.kind != UNDECIDED]
        self.length = sum(self._long(one) for one in open_)
        self.undecided = self.length / total
        self.free = max(0.0, 1.0 - self.undecided - sum(self._long(one) for one in singular) / total)  # rounding
        self.time = None if path.times is None else float(sum(self._lasts(one, path.times) for one in open_))

    def _long(self, meeting: Meeting) -> float:
        return self._at(meeting.end) - self._at(meeting.start)

    def _at(self, place: tuple[int, float]) -> float:
        stretch, share = place
        return float(self._until[stretch] + share * (self._until[stretch + 1] - self._until[stretch]))

    @staticmethod
    def _lasts(meeting: Meeting, times: Array) -> float:
        ends = [times[k] + share * (times[k + 1] - times[k]) for k, share in (meeting.start, meeting.end)]
        return float(ends[1] - ends[0])


def _sentence(
    verdict: str, stretches: tuple[Stretch, ...], settings: PathSettings, kept: str | None, spent: int, shares: _Shares,
    complete: bool,
) -> str:  # fmt: skip
    """One line for people."""
    met = {kind: [one for one in stretches if one.verdict == kind] for kind in (CROSSING, TOUCHING, UNDECIDED)}
    free = min((one for one in stretches if isfinite(one.closest.distance)), key=lambda one: one.closest.distance,
               default=None)  # fmt: skip
    near = ""
    if free is not None:
        near = f"; nearest: {short(free.closest.distance, 3)} rad from {free.name or 'a singularity'}, {_when(free)}"
    if verdict == FREE:
        held = f", and farther than {angle(settings.min_distance)} from any" if kept == "kept" else ""
        return f"Free: proven for every point of the path{held} ({spent:,} enclosure{'s' if spent != 1 else ''}){near}."
    parts = []
    if met[CROSSING]:
        parts.append(f"crosses a singularity {_times(len(met[CROSSING]))} (proven), first {_first(met[CROSSING])}")
    if met[TOUCHING]:
        parts.append(f"touches one {_times(len(met[TOUCHING]))}, first {_first(met[TOUCHING])}")
    if kept == "violated" and not met[CROSSING] and not met[TOUCHING]:
        parts.append(f"comes nearer than {angle(settings.min_distance)}{near.replace('; nearest', '')}")
    if kept == "not proven":
        parts.append(f"a distance of {angle(settings.min_distance)} could not be proven{near}")
    if met[UNDECIDED]:
        lasts = "" if shares.time is None else f", {shares.time:.3g} s"
        parts.append(f"{shares.length:.3g} rad of it{lasts} undecided")
    if not complete:
        parts.append("interrupted")
    text = "; ".join(parts)
    return text[0].upper() + text[1:] + "."


def _first(met: list[Stretch]) -> str:
    one = min(met, key=lambda one: (one.start.row, one.start.share))
    return f"{one.name or 'an unnamed family'}, {_when(one)}"


def _when(stretch: Stretch) -> str:
    place = stretch.closest.place
    near = min(place.share, 1.0 - place.share) < _AT_ROW
    at = f"row {round(place.row + place.share)}" if near else f"between rows {place.row} and {place.row + 1}"
    return at if place.time is None else f"{at} at {place.time:.4g} s"


def _times(count: int) -> str:
    return {1: "once", 2: "twice"}.get(count, f"{count} times")


def _limit_notes(robot: Robot, path: Curve) -> tuple[str, ...]:
    """Joints that leave their limits; control points enclose the path, so samples are named where they do."""
    samples = np.concatenate([path.control[:, 0], path.control[-1:, -1]])
    notes = []
    for j, joint in enumerate(robot.variables):
        out = np.flatnonzero((samples[:, j] < joint.lower - 1e-9) | (samples[:, j] > joint.upper + 1e-9))
        if len(out):
            rows = f"{len(out)} row{'' if len(out) == 1 else 's'}"
            notes.append(f"{joint.name} is outside its limits in {rows}, first in row {out[0] + 1}")
    return tuple(notes)


def _hints(robot: Robot, path: Curve, rates: Array | None, interpolate: str) -> tuple[str, ...]:
    hint = unit_hint(path.control.reshape(-1, robot.n), robot)
    notes = [] if hint is None else [hint]
    if rates is not None and interpolate == "linear":
        notes.append("velocities are given and not used: a controller that has them makes cubics of the samples")
    return tuple(notes)


def _out_of_metres(stretch: Stretch, robot: Robot) -> Stretch:
    closest = stretch.closest
    foot = out_of_metres(robot, closest.foot) if len(closest.foot) else closest.foot
    rates = out_of_metres(robot, stretch.rates) if len(stretch.rates) else stretch.rates
    return replace(stretch, closest=replace(closest, q=out_of_metres(robot, closest.q), foot=foot), rates=rates)
