"""`mend_path`: what would make a path free of singularities, or keep its limits, each proven by a new judgement.

One remedy stands here: a corner cut short, where a straight path meets a singularity around a row at which it turns. A
parabola from a point before the corner to one after it, with the corner as its control point, leaves the path in the
direction it has there and comes back in the direction it goes on in. It stays half as far in as the corner does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import OptionError, TaskError
from rankdrop.kinematics import pose
from rankdrop.local.block import joint_scale
from rankdrop.local.rates import rate_limits
from rankdrop.motion.check import check_path
from rankdrop.motion.curve import Curve, curve
from rankdrop.motion.follow import follow
from rankdrop.motion.mending import BLEND, FLIP, KINDS, NULL, RETIME, SHIFT, TILT, Gain, Mending, Parameter, Remedy
from rankdrop.motion.options import RemedyOptions
from rankdrop.motion.others import Ranking, branches, null_spaces, shifts, tilts
from rankdrop.motion.record import FREE, UNDECIDED, PathCheck, Stretch
from rankdrop.motion.retime import Usage, retimed, usage
from rankdrop.motion.tool_path import ToolPath, joints_at, tool_path
from rankdrop.motion.trajectory import Trajectory
from rankdrop.options import takes
from rankdrop.results.analysis import Analysis
from rankdrop.robot.model import Array, Robot

_CORNER = np.cos(np.radians(3.0))  # directions that differ by less are one
_POINTS = 33  # of a parabola
_SIZES = 8
_LOOKS = 201


@dataclass(frozen=True, eq=False)
class Blend:
    """A path with some corners cut.

    Attributes:
        place: (K,) where each row was on the path; inside a blend, in proportion of its parameter.
        q: (K, n).
        rows: the corners cut, numbered from 1.
        radius: joint motion before and after each corner that is replaced [rad; slides divided by the scale].
        off: farthest that the tool point is from the old path [m].
    """

    place: Array
    q: Array
    rows: tuple[int, ...]
    radius: float
    off: float


def blends(robot: Robot, path: Curve, scale: Array, met: Array, most: float) -> Iterator[Blend]:
    """Paths with the corners nearest to where it meets singularities cut, less first.

    Args:
        robot: the arm.
        path: a straight curve.
        scale: (n,) of joint motions.
        met: (M,) places that have to go, stretch and share, counted from 0.
        most: how far the tool point may leave the path [m].
    """
    until = _until(path, scale)
    corners = _corners(path, scale)
    if path.degree != 1 or not len(corners) or not len(met):
        return
    at = np.interp(met, np.arange(len(until)), until)
    nearest = np.abs(until[corners][None] - at[:, None]).argmin(axis=1)
    cut = np.unique(nearest)
    least = max(float(np.abs(at[nearest == k] - until[corners[k]]).max()) for k in cut)
    ends = np.concatenate([[0.0], until[corners], until[-1:]])
    room = min(min(ends[k + 1] - ends[k], ends[k + 2] - ends[k + 1]) for k in cut)
    together = bool((np.diff(cut) == 1).any())
    room *= 0.5 if together else 1.0
    for radius in np.geomspace(max(1.05 * least, 1e-3 * room), room, _SIZES) if least < room else ():
        made = _cut(robot, path, until, corners[cut], float(radius))
        if made.off <= most:
            yield made


def _until(path: Curve, scale: Array) -> Array:
    length = np.linalg.norm(np.diff(path.control, axis=1)[:, 0] / scale, axis=1)
    return np.concatenate([[0.0], np.cumsum(length)])


def _corners(path: Curve, scale: Array) -> Array:
    """Rows, counted from 0, at which the direction changes."""
    step = np.diff(path.control, axis=1)[:, 0] / scale
    size = np.linalg.norm(step, axis=1)
    cosine = (step[1:] * step[:-1]).sum(axis=1) / np.maximum(size[1:] * size[:-1], 1e-300)
    return np.asarray(np.flatnonzero(cosine < _CORNER) + 1)


def _cut(robot: Robot, path: Curve, until: Array, corners: Array, radius: float) -> Blend:
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
    return Blend(place[order], q[order], tuple(int(k) + 1 for k in corners), radius, off)


Progress = Callable[[str, int, int], None]
"""progress(kind, done, all)."""

_JUDGED = 4  # candidates of a kind that are judged, widest first
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
    """Remedies of a judged path: computed, and judged again as `check_path` judged the path itself.

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
        analysis: families, where `found` was judged with an analysis.
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
        >>> [(one.kind, one.check.verdict) for one in mended.remedies]
        [('blend', 'free')]
    """
    how = RemedyOptions.of(options, given)
    work = _Mender(found, analysis, _limits(found, acceleration), progress)
    wants = {TILT: how.tool_tilt, SHIFT: how.base_shift, BLEND: how.blend}
    needed = not found.clear or work.breaks(found)
    try:
        if not found.clear:
            work.path_kinds(wants)
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
    """Remedies of one path, as they are found."""

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

    def path_kinds(self, wants: dict[str, float]) -> None:
        """Every kind that changes the path."""
        tool = tool_path(self.found.robot, self.found.task, self.found.curve)
        try:
            follow(tool.robot, tool.poses[:1], tool.q[0], tool.task, limits=False)
        except TaskError as error:
            self.notes.append(f"the tool's path cannot be followed: {error.what}")
            wants = wants | {TILT: 0.0, SHIFT: 0.0}
        else:
            self._first(NULL, null_spaces(tool, self._told(NULL)), "joint motion that leaves the tool where it is")
            self._first(FLIP, branches(tool, self._told(FLIP)), "other posture at the first pose")
        if wants[BLEND] > 0.0:
            self._blend(wants[BLEND])
        if wants[TILT] > 0.0:
            self._first(TILT, tilts(tool, wants[TILT], self._told(TILT)), "rotation in the task")
        if wants[SHIFT] > 0.0:
            self._first(SHIFT, shifts(tool, wants[SHIFT], self._told(SHIFT)), "translation in the task")

    def _told(self, kind: str) -> Callable[[int, int], None]:
        def told(done: int, count: int) -> None:
            if self.progress is not None:
                self.progress(kind, done, count)

        return told

    def _first(self, kind: str, ranking: Ranking, what: str) -> None:
        """The widest candidate that is proven free."""
        for other in ranking.found[:_JUDGED]:
            tool, followed = other.tool.refined(other.run)
            if not followed.complete:
                continue
            plain = tool.trajectory(followed.q, self.interpolate)
            made, again = self._in_time(plain)
            check = self._judged(made)
            if check.clear:
                self._add(kind, other.words, other.parameters, made, check, tool.deviation(plain, self.interpolate),
                          again=again)  # fmt: skip
                return
        self.notes.append(f"{kind}: {ranking.sentence(what)}")

    def _blend(self, most: float) -> None:
        if self.interpolate != "linear":
            self.notes.append(f"{BLEND}: only paths that are straight between their rows have corners")
            return
        path, robot = self.found.curve, self.found.robot
        met = np.array([one.closest.place.row - 1 + one.closest.place.share for one in self._bad()])
        count = 0
        for count, one in enumerate(blends(robot, path, self.scale, met, most), start=1):  # noqa: B007  # told after the loop
            tool = ToolPath(robot, self.found.task, path, one.place, one.q, np.zeros((0, 4, 4)), False)
            made, again = self._in_time(tool.trajectory(one.q, self.interpolate))
            check = self._judged(made)
            if check.clear:
                corners = ", ".join(str(row) for row in one.rows)
                words = f"the corner{'s' if len(one.rows) > 1 else ''} at row {corners} cut by a parabola"
                parameters = (Parameter("radius", one.radius, "rad"), Parameter("tool off", one.off, "m"))
                self._add(BLEND, words, parameters, made, check, (one.off, np.nan), again=again)
                return
        none = "no corner is near enough for the tool to stay within the bound"
        self.notes.append(f"{BLEND}: {f'{count} tried, none was proven free' if count else none}")

    def _bad(self) -> list[Stretch]:
        bad = [one for one in self.found.stretches if one.verdict != FREE]
        least = self.found.options.min_distance
        return bad or [one for one in self.found.stretches if one.closest.distance < least]

    def in_new_time(self) -> None:
        """The path itself inside its limits."""
        self._told(RETIME)(0, 1)
        made = self._named(retimed(self.found.curve, *self.limits, self.scale))
        took = self._taken(made)
        if took.slower > 1.0 + _KEPT:
            self.notes.append(f"{RETIME}: the limits could not be kept everywhere")
            return
        words = "the same path in a new time, never faster than before and slower where a limit asks for it"
        check = self._judged(made)
        self._add(RETIME, words, (), made, check, (0.0, 0.0), again=True)
        self._told(RETIME)(1, 1)

    def _in_time(self, made: Trajectory) -> tuple[Trajectory, bool]:
        """A path in time that breaks a limit gets another time law."""
        if not made.timed or not np.isfinite(np.concatenate(self.limits)).any():
            return self._named(made), False
        if self._taken(made).slower <= 1.0 + _KEPT:
            return self._named(made), False
        path = curve(made.q, made.times, made.velocities, made.accelerations, self.interpolate)
        return self._named(retimed(path, *self.limits, self.scale)), True

    def _named(self, made: Trajectory) -> Trajectory:
        return replace(made, name="mended")

    def _taken(self, made: Trajectory) -> Usage:
        path = curve(made.q, made.times, made.velocities, made.accelerations, self.interpolate)
        return usage(path, *self.limits)

    def _judged(self, made: Trajectory) -> PathCheck:
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
        gains = [Gain("distance", _distance(self.found), _distance(check), "rad")]
        before = self._usage(self.found)
        if before is not None and took is not None:
            gains.append(Gain("speed", 1 / before.slower, 1 / took.slower, ""))
            gains.append(Gain("duration", _duration(self.found), _duration(check), "s"))
        self.remedies.append(
            Remedy(kind, words, parameters, tuple(gains), made, self.interpolate, check, took, off, again)
        )


def _distance(check: PathCheck) -> float:
    """Least distance known along a path; 0 where it meets a singularity, or may."""
    if any(one.verdict not in (FREE, UNDECIDED) for one in check.stretches):
        return 0.0
    return min((one.closest.distance for one in check.stretches), default=np.inf)


def _duration(check: PathCheck) -> float:
    times = check.curve.times
    return np.nan if times is None else float(times[-1] - times[0])
