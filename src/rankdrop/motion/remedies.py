"""`mend_path`: what would make a path free of singularities, or keep its limits, each proven by a new check.

One remedy is made here: a corner cut short, where a straight path reaches a singularity around a row at which it turns.
A parabola from a point before the corner to one after it, with the corner as its control point, leaves the path in the
direction it has there and comes back in the direction it goes on in. It stays half as far in as the corner does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.codec import Result
from rankdrop.errors import OptionError, TaskError
from rankdrop.kinematics import pose
from rankdrop.local.block import joint_scale
from rankdrop.local.rates import rate_limits
from rankdrop.motion import text
from rankdrop.motion.candidates import Parameter, Ranking, branches, null_spaces, shifts, tilts
from rankdrop.motion.check import check_path
from rankdrop.motion.curve import Curve
from rankdrop.motion.follow import follow
from rankdrop.motion.options import RemedyOptions
from rankdrop.motion.record import FREE, UNDECIDED, PathCheck
from rankdrop.motion.retime import Usage, retimed, usage
from rankdrop.motion.tool_path import ToolPath, joints_at, tool_path
from rankdrop.motion.trajectory import Trajectory
from rankdrop.options import takes
from rankdrop.results.analysis import Analysis
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section

_CORNER = np.cos(np.radians(3.0))  # directions that differ by less are one
_POINTS = 33  # of a parabola
_SIZES = 8
_LOOKS = 201
RETIME, NULL, FLIP, BLEND, TILT, SHIFT = "retime", "null-space", "flip", "blend", "tool tilt", "base shift"
KINDS = (NULL, FLIP, BLEND, TILT, SHIFT, RETIME)
"""Those that leave the tool's path come first; retime changes the time only."""


@dataclass(frozen=True, eq=False)
class Remedy:
    """A path that was mended and checked again.

    Attributes:
        kind: one of `KINDS`.
        words: what is done, as a sentence.
        parameters: what with.
        gains: distance, speed, duration -> the number before and after; inf or nan where not known. The distance is 0
            where the path reaches a singularity.
        trajectory: the new path; in time where the old one is.
        interpolate: between its rows.
        check: the new judgement: free, proven, with the distance asked for kept. Of retime, which keeps the path, it
            may be any; that kind is accepted by its limits.
        usage: shares of the rate and acceleration limits that it nowhere exceeds, at most 1; None without times or
            limits.
        off: how far the tool is from the path meant, at most, in the middle between two of its rows [m], [rad];
            at the rows it is on it. Of a blend: from the old path, at sampled points.
        retimed: it has a new time law as well, because the old one would break limits.
    """

    kind: str
    words: str
    parameters: tuple[Parameter, ...]
    gains: dict[str, tuple[float, float]]
    trajectory: Trajectory
    interpolate: str
    check: PathCheck
    usage: Usage | None
    off: tuple[float, float]
    retimed: bool


@dataclass(frozen=True, eq=False)
class Mending(Result):
    """What was tried of a path.

    Attributes:
        before: the judgement of the path as it was.
        remedies: found and proven, in the order of `KINDS`.
        notes: for each kind without one, what was tried and what came of it.
        needed: the path needs one: it is not proven free and far enough, or breaks limits.
        complete: False where it was interrupted; what was found until then holds.
    """

    before: PathCheck
    remedies: tuple[Remedy, ...]
    notes: tuple[str, ...]
    needed: bool
    complete: bool
    FILE: ClassVar[str] = "remedies"

    @property
    def best(self) -> Remedy | None:
        """The first that is proven free, in the order of `KINDS`; None where there is none."""
        return next((one for one in self.remedies if one.check.clear), None)

    def sections(self, *, deg: bool = True) -> tuple[Section, ...]:
        """As sections of text."""
        return text.remedy_sections(self, deg=deg)

    @property
    def sentence(self) -> str:
        """One line for people."""
        return text.remedies_sentence(self)


Proposal = tuple[str, tuple[Parameter, ...], Trajectory, tuple[float, float]]
"""A changed path to be checked: what is done, with which numbers, its rows, how far off the tool is [m, rad]."""


def blends(check: PathCheck, most: float) -> Iterator[Proposal]:
    """Paths with the corners nearest to where it reaches singularities cut, less first, the tool within `most` [m]."""
    robot, path, scale = check.robot, check.curve, joint_scale(check.robot, check.task)
    bad = [one for one in check.stretches if one.verdict != FREE]
    near = bad or [one for one in check.stretches if one.closest.distance < check.options.min_distance]
    places = np.array([one.closest.place.position - 1.0 for one in near])
    if path.degree != 1 or not len(places):
        return
    until, corners = _until(path, scale), _corners(path, scale)
    if not len(corners):
        return
    at = np.interp(places, np.arange(len(until)), until)
    nearest = np.abs(until[corners][None] - at[:, None]).argmin(axis=1)
    cut = np.unique(nearest)
    least = max(float(np.abs(at[nearest == k] - until[corners[k]]).max()) for k in cut)
    ends = np.concatenate([[0.0], until[corners], until[-1:]])
    room = min(min(ends[k + 1] - ends[k], ends[k + 2] - ends[k + 1]) for k in cut)
    room *= 0.5 if (np.diff(cut) == 1).any() else 1.0
    rows = ", ".join(str(int(corner) + 1) for corner in corners[cut])
    words = f"the corner{'s' if len(cut) > 1 else ''} at row {rows} cut by a parabola"
    for radius in np.geomspace(max(1.05 * least, 1e-3 * room), room, _SIZES) if least < room else ():
        place, q, off = _cut(robot, path, until, corners[cut], float(radius))
        if off <= most:
            tool = ToolPath(robot, check.task, path, place, q, np.zeros((0, 4, 4)), False)
            parameters = ("radius", float(radius), "rad"), ("tool off", off, "m")
            yield words, parameters, tool.trajectory(q, "linear"), (off, np.nan)


def _until(path: Curve, scale: Array) -> Array:
    length = np.linalg.norm(np.diff(path.control, axis=1)[:, 0] / scale, axis=1)
    return np.concatenate([[0.0], np.cumsum(length)])


def _corners(path: Curve, scale: Array) -> Array:
    """Rows, counted from 0, at which the direction changes."""
    step = np.diff(path.control, axis=1)[:, 0] / scale
    size = np.linalg.norm(step, axis=1)
    cosine = (step[1:] * step[:-1]).sum(axis=1) / np.maximum(size[1:] * size[:-1], 1e-300)
    return np.asarray(np.flatnonzero(cosine < _CORNER) + 1)


def _cut(robot: Robot, path: Curve, until: Array, corners: Array, radius: float) -> tuple[Array, Array, float]:
    """Places and rows of a path with corners cut, and how far the tool point is from the old path at most [m]."""
    rows = np.arange(len(until), dtype=np.float64)
    keep = np.ones(len(rows), dtype=np.bool_)
    places, values, off = [], [], 0.0
    share = np.linspace(0.0, 1.0, _POINTS)
    for corner in corners.tolist():
        low, high = np.interp([until[corner] - radius, until[corner] + radius], until, rows)
        keep &= (rows < low) | (rows > high)
        place = low + share * (high - low)
        start, end = joints_at(path, np.array([low, high]))
        middle = joints_at(path, np.array([float(corner)]))[0]
        s = share[:, None]
        curve = (1 - s) ** 2 * start + 2 * s * (1 - s) * middle + s**2 * end
        places.append(place)
        values.append(curve)
        old = pose(robot, joints_at(path, np.linspace(low, high, _LOOKS)))[:, :3, 3]
        new = pose(robot, curve)[:, :3, 3]
        off = max(off, float(np.linalg.norm(new[:, None] - old[None], axis=2).min(axis=1).max()))
    place = np.concatenate([rows[keep], *places])
    q = np.concatenate([joints_at(path, rows[keep]), *values])
    order = np.argsort(place, kind="stable")
    return place[order], q[order], off


Progressed = Callable[[int, int], None]
Progress = Callable[[str, int, int], None]
"""progress(kind, done, all)."""

_CHECKED = 4  # candidates of a kind that are checked, widest first
_KEPT = 1e-9  # of a limit: above it by less is within it


@takes(RemedyOptions)
def mend_path(
    found: PathCheck,
    *,
    analysis: Analysis | None = None,
    acceleration: ArrayLike | None = None,
    options: RemedyOptions | None = None,
    progress: Progress | None = None,
    **given: Any,
) -> Mending:
    """Remedies of a checked path: computed, and checked again as `check_path` checked the path itself.

    null-space    the same tool path by other joint motion of a redundant arm, from the same start where there is one
    flip          the same tool path on another branch of the inverse kinematics
    blend         a corner cut, where the path meets the singularity around it, within `blend`
    tool tilt     the tool held tilted, within `tool_tilt`
    base shift    the base moved, within `base_shift`
    retime        the same path in a new time: inside the limits of joint rates and accelerations

    A change of the path is a remedy only where its judgement is free, proven for every point, with the distance asked
    for proven to be kept. A new time law is one only where the limits hold at every instant, by bounds on the curve
    between its rows (`Usage.how`). Paths in time that would break limits once changed get a new time law as well. That
    no remedy is found is no proof that there is none.

    Args:
        found: the judgement; its settings are those of the new ones.
        analysis: families, where `found` was checked with an analysis.
        acceleration: () or (n,) limits [rad/s², m/s²]; None: none. Arms state none of their own.
        options: how far the path may be changed; its fields are taken as keywords as well.
        progress: called with the kind, and how much of it is done.

    Returns:
        The remedies found, one of each kind at most, and for the other kinds what was tried.

    Raises:
        OptionError: a bound outside what is allowed.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> path = [[0.3, 0.4, 0.1], [0.5, -0.2, 0.3], [0.9, 0.5, 0.3]]
        >>> mended = mend_path(check_path(open_robot("planar3r"), path), blend=0.5)
        >>> [(one.kind, one.check.verdict.value) for one in mended.remedies]
        [('blend', 'free')]
    """
    how = RemedyOptions.of(options, given)
    work = _Mender(found, analysis, _limits(found, acceleration), progress)
    needed = not found.clear or work.breaks(found)
    try:
        if not found.clear:
            work.path_kinds(how)
        if work.breaks(found):
            work.in_new_time()
    except KeyboardInterrupt:
        work.complete = False
    order = sorted(work.remedies, key=lambda one: KINDS.index(one.kind))
    return Mending(found, tuple(order), tuple(work.notes), needed, work.complete)


def _limits(check: PathCheck, acceleration: ArrayLike | None) -> tuple[Array, Array]:
    """(n,) each: of rates and accelerations."""
    given = np.asarray(np.inf if acceleration is None else acceleration, dtype=np.float64)
    if given.shape not in ((), (check.robot.n,)) or np.isnan(given).any() or not (given > 0.0).all():
        raise OptionError("an acceleration limit is above zero", where="acceleration", got=given.tolist(),
                          allowed=f"one number, or {check.robot.n}, one for each joint")  # fmt: skip
    return rate_limits(check.robot), np.array(np.broadcast_to(given, (check.robot.n,)))


@dataclass(eq=False)
class _Mender:
    found: PathCheck
    analysis: Analysis | None
    limits: tuple[Array, Array]
    progress: Progress | None
    remedies: list[Remedy] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    complete: bool = True

    def __post_init__(self) -> None:
        self.scale = joint_scale(self.found.robot, self.found.task)
        self.interpolate = self.found.options.interpolate

    def breaks(self, check: PathCheck) -> bool:
        """Whether a path in time breaks a limit."""
        took = self._usage(check)
        return took is not None and took.slower > 1.0 + _KEPT

    def _usage(self, check: PathCheck) -> Usage | None:
        limited = bool(np.isfinite(self.limits[0]).any() or np.isfinite(self.limits[1]).any())
        return usage(check.curve, *self.limits) if check.curve.times is not None and limited else None

    def path_kinds(self, most: RemedyOptions) -> None:
        """Every kind that changes the path."""
        tool = tool_path(self.found.robot, self.found.task, self.found.curve)
        kinds: list[tuple[str, str, Callable[[Progressed], Ranking]]] = [
            (NULL, "joint motion that leaves the tool where it is", lambda report: null_spaces(tool, report)),
            (FLIP, "other posture at the first pose", lambda report: branches(tool, report)),
            (TILT, "rotation in the task", lambda report: tilts(tool, most.tool_tilt, report)),
            (SHIFT, "translation in the task", lambda report: shifts(tool, most.base_shift, report)),
        ]
        unwanted = {kind for kind, bound in ((TILT, most.tool_tilt), (SHIFT, most.base_shift)) if not bound}
        try:
            follow(tool.robot, tool.poses[:1], tool.q[0], tool.task, limits=False)
        except TaskError as error:
            self.notes.append(f"the tool's path cannot be followed: {error.what}")
            unwanted = {kind for kind, _, _ in kinds}
        if most.blend > 0.0:
            self._blend(most.blend)
        for kind, what, rank in kinds:
            if kind not in unwanted:
                ranking = rank(partial(self._report, kind))
                if not self._first(kind, self._proposals(ranking)):
                    self.notes.append(f"{kind}: {text.not_found(ranking, what)}")

    def _report(self, kind: str, done: int, count: int) -> None:
        if self.progress is not None:
            self.progress(kind, done, count)

    def _proposals(self, ranking: Ranking) -> Iterator[Proposal]:
        for other in ranking.found[:_CHECKED]:
            tool, followed = other.tool.refined(other.run)
            if followed.complete:
                made = tool.trajectory(followed.q, self.interpolate)
                yield other.words, other.parameters, made, tool.deviation(made, self.interpolate)

    def _first(self, kind: str, proposals: Iterable[Proposal]) -> bool:
        """The first proposal that is proven free becomes the remedy of its kind."""
        for words, parameters, plainly, off in proposals:
            made, again = self._in_time(plainly)
            check = self._checked_again(made)
            if check.clear:
                self._add(kind, words, parameters, made, check, off, again=again)
                return True
        return False

    def _blend(self, most: float) -> None:
        if self.interpolate != "linear":
            self.notes.append(f"{BLEND}: only paths that are straight between their rows have corners")
            return
        proposals = list(blends(self.found, most))
        if not self._first(BLEND, proposals):
            none = "no corner is near enough for the tool to stay within the bound"
            self.notes.append(f"{BLEND}: {f'{len(proposals)} tried, none was proven free' if proposals else none}")

    def in_new_time(self) -> None:
        """The path itself inside its limits."""
        self._report(RETIME, 0, 1)
        made = retimed(self.found.curve, *self.limits, self.scale)
        if usage(made.curve(self.interpolate), *self.limits).slower > 1.0 + _KEPT:
            self.notes.append(f"{RETIME}: the limits could not be kept everywhere")
            return
        words = "the same path in a new time, never faster than before and slower where a limit asks for it"
        check = self._checked_again(made)
        self._add(RETIME, words, (), made, check, (0.0, 0.0), again=True)
        self._report(RETIME, 1, 1)

    def _in_time(self, made: Trajectory) -> tuple[Trajectory, bool]:
        """A path in time that breaks a limit gets another time law."""
        limited = made.timed and bool(np.isfinite(np.concatenate(self.limits)).any())
        if not limited or usage(made.curve(self.interpolate), *self.limits).slower <= 1.0 + _KEPT:
            return made, False
        return retimed(made.curve(self.interpolate), *self.limits, self.scale), True

    def _checked_again(self, made: Trajectory) -> PathCheck:
        check = check_path(
            self.found.robot, made.q, made.times if made.timed else None, velocities=made.velocities,
            accelerations=made.accelerations, task=self.found.task, analysis=self.analysis,
            options=self.found.options, tolerances=self.found.tolerances,
        )  # fmt: skip
        if not check.complete:
            raise KeyboardInterrupt
        return check

    def _add(
        self, kind: str, words: str, parameters: tuple[Parameter, ...], made: Trajectory, check: PathCheck,
        off: tuple[float, float], *, again: bool,
    ) -> None:  # fmt: skip
        took = self._usage(check)
        gains = {"distance": (_distance(self.found), _distance(check))}
        before = self._usage(self.found)
        if before is not None and took is not None:
            gains["speed"] = 1 / before.slower, 1 / took.slower
            gains["duration"] = _duration(self.found), _duration(check)
        self.remedies.append(
            Remedy(kind, words, parameters, gains, replace(made, name="mended"), self.interpolate, check, took, off,
                   again)
        )  # fmt: skip


def _distance(check: PathCheck) -> float:
    """Least distance known along a path; 0 where it meets a singularity, or may."""
    if any(one.verdict not in (FREE, UNDECIDED) for one in check.stretches):
        return 0.0
    return min((one.closest.distance for one in check.stretches), default=np.inf)


def _duration(check: PathCheck) -> float:
    times = check.curve.times
    return np.nan if times is None else float(times[-1] - times[0])
