"""`mend_path`: what would make a path free of singularities, or keep its limits, each proven by a new check.

Local changes are made in `path.mend.bumps` and `path.mend.detours`, other joint paths for the tool in
`path.mend.candidates`, new time laws in `path.mend.retime`. One remedy is made here: a corner cut short, where a
straight path reaches a singularity around a row at which it turns. A parabola from a point before the corner to one
after it, with the corner as its control point, leaves the path in the direction it has there and comes back in the
direction it goes on in. It stays half as far in as the corner does.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from operator import attrgetter
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.codec import Result
from rankdrop.errors import OptionError, TaskError
from rankdrop.kinematics import pose
from rankdrop.local.block import joint_scale
from rankdrop.local.rates import rate_limits
from rankdrop.options import takes
from rankdrop.path.check.check import check_path
from rankdrop.path.check.record import FREE, UNDECIDED, PathCheck, Stretch
from rankdrop.path.check.turns import FarTurn, far_turns
from rankdrop.path.curve import Curve
from rankdrop.path.mend.bumps import CLEARANCE, ON_PATH, SPARE, Bump, Bumper, Core, NoBump, Obstacle
from rankdrop.path.mend.candidates import (
    Candidate,
    Parameter,
    Ranking,
    branches,
    joint_values,
    null_spaces,
    other_branches,
    shifts,
    tilts,
)
from rankdrop.path.mend.detours import Detour, Detourer, NoDetour
from rankdrop.path.mend.given_poses import given_tool_path
from rankdrop.path.mend.joint_tool_path import JointToolPath, tool_path
from rankdrop.path.mend.local_change import LocalChange, RowsBefore
from rankdrop.path.mend.pose_detours import Blocked, PoseDetourer, PoseWindow
from rankdrop.path.mend.retime import Usage, retime_path, usage
from rankdrop.path.mend.slow_down import slowed_down
from rankdrop.path.read.trajectory import Trajectory
from rankdrop.questions import RemedyOptions
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import known_families
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section
from rankdrop.text import remedies as text

_CORNER = np.cos(np.radians(3.0))  # directions that differ by less are one
_POINTS = 33  # of a parabola
_SIZES = 8
_LOOKS = 201
_CHECKED = 4  # candidates of a kind that are checked, widest first
_SLOWER = 1.0 + 1e-9  # of a limit: above it by less is within it
_CLEARER = 1.5  # times the clearance of a bump whose window was not proven free
_ROUNDS = 3  # of that
MANY = 200
"""Places on one path above which no local remedy is tried: such a file is not what it was meant to be."""
_DETOURS = 12  # crossings of one path that the tool is led around, some 2 s each
BUMP, DETOUR, SLOW, RETIME, NULL, FLIP, BLEND, TILT, SHIFT = (
    "bump", "detour", "slow-down", "retime", "null-space", "flip", "blend", "tool tilt", "base shift",
)  # fmt: skip
KINDS = (NULL, FLIP, BUMP, DETOUR, BLEND, TILT, SHIFT, SLOW, RETIME)
LOCAL = (BUMP, DETOUR, SLOW)
"""Those that change the path around its singularities: a bump keeps the joints of the rest, a detour the tool, a
slow-down all of the path and the time that the rest takes."""
Progress = Callable[[str, int, int], None]
"""progress(kind, done, all)."""
Failure = tuple[str, Any]
"""A kind without a remedy, and what was tried: as `rankdrop.text.remedies.remedy_note` reads it."""


@dataclass(frozen=True, eq=False)
class Proposal:
    """A changed path to be checked.

    Attributes:
        how: what is done, and a fact about it.
        parameters: with which numbers.
        made: its rows.
        off: how far off the tool is [m, rad].
        changes: the parts that are changed; empty where all of it is.
    """

    how: tuple[str, Any]
    parameters: tuple[Parameter, ...]
    made: Trajectory
    off: tuple[float, float]
    changes: tuple[LocalChange, ...] = ()


@dataclass(frozen=True, eq=False)
class Remedy:
    """A path that was mended and checked again.

    Attributes:
        kind: one of `KINDS`.
        how: what is done, and a fact about it.
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
            at the rows it is on it. Of a blend and a bump: from the old path, at sampled points.
        retimed: it has a new time law as well, because the old one would break limits.
        changes: of a local remedy the parts that it changes, in order.
    """

    kind: str
    how: tuple[str, Any]
    parameters: tuple[Parameter, ...]
    gains: dict[str, tuple[float, float]]
    trajectory: Trajectory
    interpolate: str
    check: PathCheck
    usage: Usage | None
    off: tuple[float, float]
    retimed: bool
    changes: tuple[LocalChange, ...] = ()

    @property
    def deviation(self) -> tuple[float, float]:
        """How far the tool leaves the path that it was given at most [m], [rad]: `off`, and what the tool is tilted."""
        tilt = next((value for name, value, _ in self.parameters if name == "tool tilt"), 0.0)
        assert isinstance(tilt, float)
        return self.off[0], float(np.nan_to_num(self.off[1])) + tilt

    @property
    def turns(self) -> tuple[FarTurn, ...]:
        """Joints that turn far on the new path."""
        return far_turns(self.check.robot, self.check.curve)

    @property
    def rank(self) -> tuple[bool, bool, float, float]:
        """What remedies are sorted by: proven free, the base where it is, deviation of the tool, duration."""
        away, turned = self.deviation
        size = away / self.check.length_scale + turned
        _, after = self.gains.get("duration", (0.0, 0.0))
        return not self.check.clear, self.kind == SHIFT, 0.0 if size < ON_PATH else size, after

    @property
    def words(self) -> str:
        """What is done, as a sentence."""
        return text.remedy_words(*self.how)


@dataclass(frozen=True, eq=False)
class Mending(Result):
    """What was tried of a path.

    Attributes:
        before: the judgement of the path as it was.
        remedies: found and proven; those first whose tool leaves its path least, then the shorter ones.
        failures: for each kind without one, what was tried.
        needed: the path needs one: it is not proven free and far enough, or breaks limits.
        complete: False where it was interrupted; what was found until then holds.
    """

    before: PathCheck
    remedies: tuple[Remedy, ...]
    failures: tuple[Failure, ...]
    needed: bool
    complete: bool
    FILE: ClassVar[str] = "remedies"

    @property
    def notes(self) -> tuple[str, ...]:
        """For each kind without a remedy, what was tried and what came of it."""
        return tuple(text.remedy_note(kind, fact) for kind, fact in self.failures)

    @property
    def best(self) -> Remedy | None:
        """The first that is proven free; None where there is none."""
        return next((remedy for remedy in self.remedies if remedy.check.clear), None)

    @property
    def written(self) -> Remedy | None:
        """The remedy that is written to a file: the best, else the first that keeps the limits; None where none is."""
        return self.best or next(iter(self.remedies), None)

    def sections(self, *, deg: bool = True) -> tuple[Section, ...]:
        """As sections of text."""
        return text.remedy_sections(self, deg=deg)

    @property
    def sentence(self) -> str:
        """One line for people."""
        return text.remedies_sentence(self)


def blends(check: PathCheck, most: float) -> Iterator[Proposal]:
    """Paths with the corners nearest to where it reaches singularities cut, less first, the tool within `most` [m]."""
    robot, path = check.robot, check.curve
    near = _stretches_to_mend(check)
    steps = np.diff(path.control, axis=1)[:, 0] / joint_scale(robot, check.task)
    size = np.linalg.norm(steps, axis=1)
    cosine = (steps[1:] * steps[:-1]).sum(axis=1) / np.maximum(size[1:] * size[:-1], 1e-300)
    corners = np.flatnonzero(cosine < _CORNER) + 1  # rows at which the direction changes, from 0
    if path.degree != 1 or not near or not len(corners):
        return
    until = np.concatenate([[0.0], np.cumsum(size)])
    at = np.interp([stretch.closest.place.position - 1.0 for stretch in near], np.arange(len(until)), until)
    away = np.abs(until[corners][None] - at[:, None])
    cut, least = np.unique(away.argmin(axis=1)), float(away.min(axis=1).max())
    room = _room(until, corners, cut)
    if not least < room:
        return
    rows = ", ".join(str(int(corner) + 1) for corner in corners[cut])
    tool = tool_path(robot, check.task, path)
    for radius in np.geomspace(max(1.05 * least, 1e-3 * room), room, _SIZES):
        place, q, off = _cut(robot, path, until, corners[cut], float(radius))
        if off <= most:
            parameters = ("radius", float(radius), "rad"), ("tool off", off, "m")
            trajectory = replace(tool, place=place).trajectory(q, "linear")
            yield Proposal(("blend" if len(cut) == 1 else "blends", rows), parameters, trajectory, (off, np.nan))


def _poses_determine(tool: JointToolPath) -> bool:
    """Whether poses of the tool determine its task, so that the joints can follow them."""
    try:
        tool.aim  # noqa: B018  # refuses a task that poses do not determine
    except TaskError:
        return False
    return True


def _ends_early(check: PathCheck) -> float | None:
    """The pose up to which a tool path can be followed; None where it is followed to its end, or is of joints."""
    if check.tool is None or check.tool.complete:
        return None
    return check.tool.reached


def _stretches_to_mend(check: PathCheck) -> list[Stretch]:
    """The stretches that are not free; where all are, those that come nearer to a singularity than is asked."""
    bad = [stretch for stretch in check.stretches if stretch.verdict != FREE]
    return bad or [stretch for stretch in check.stretches if stretch.closest.distance < check.options.min_distance]


def _room(until: Array, corners: NDArray[np.intp], cut: NDArray[np.intp]) -> float:
    """The largest radius by which corners can be cut: to the next corner, half way where that one is cut as well.

    Args:
        until: (rows,) length of the path up to each row.
        corners: rows at which the direction changes.
        cut: which of the corners.
    """
    ends = np.concatenate([[0.0], until[corners], until[-1:]])
    room: float = min(min(ends[k + 1] - ends[k], ends[k + 2] - ends[k + 1]) for k in cut)
    if (np.diff(cut) == 1).any():
        return 0.5 * room
    return room


def _cut(robot: Robot, path: Curve, until: Array, corners: Array, radius: float) -> tuple[Array, Array, float]:
    """Places and rows of a path with corners cut, and how far the tool point is from the old path at most [m]."""
    def joints_at(place: Array) -> Array:
        return path.at(*path.split(place))

    rows = np.arange(len(until), dtype=np.float64)
    keep = np.ones(len(rows), dtype=np.bool_)
    places, values, off = [], [], 0.0
    share = np.linspace(0.0, 1.0, _POINTS)
    for corner in corners.tolist():
        low, high = np.interp([until[corner] - radius, until[corner] + radius], until, rows)
        keep &= (rows < low) | (rows > high)
        start, middle, end = joints_at(np.array([low, float(corner), high]))
        s = share[:, None]
        curve = (1 - s) ** 2 * start + 2 * s * (1 - s) * middle + s**2 * end
        places.append(low + share * (high - low))
        values.append(curve)
        old = pose(robot, joints_at(np.linspace(low, high, _LOOKS)))[:, :3, 3]
        new = pose(robot, curve)[:, :3, 3]
        off = max(off, float(np.linalg.norm(new[:, None] - old[None], axis=2).min(axis=1).max()))
    place = np.concatenate([rows[keep], *places])
    order = np.argsort(place, kind="stable")
    return place[order], np.concatenate([joints_at(rows[keep]), *values])[order], off


@takes(RemedyOptions)
def mend_path(
    check: PathCheck,
    *,
    analysis: Analysis | None = None,
    acceleration: ArrayLike | None = None,
    kinds: Collection[str] = KINDS,
    options: RemedyOptions | None = None,
    progress: Progress | None = None,
    **given: Any,
) -> Mending:
    """Remedies of a checked path: computed, and checked again as `check_path` checked the path itself.

    null-space    the same tool path by other joint motion of a redundant arm, from the same start where there is one
    flip          the same tool path on another branch of the inverse kinematics
    bump          the joints moved aside around each singularity, within `bump`, and the rest of the path as it is
    detour        where the joints go to the other side of a singularity, or a bump takes the tool farther off its path
                  than `detour`: the tool led around it, within `detour`
    blend         a corner cut, where the path meets the singularity around it, within `blend`
    tool tilt     the tool held tilted, within `tool_tilt`
    base shift    the base moved, within `base_shift`
    slow-down     the same path, slower where it is too fast, and the rest of its times only shifted
    retime        the same path in a new time: inside the limits of joint rates and accelerations; where no slow-down
                  is found

    A change of the path is a remedy only where its judgement is free, proven for every point, with the distance asked
    for proven to be kept. A new time law is one only where the limits hold at every instant, by bounds on the curve
    between its rows (`Usage.how`). Paths in time that would break limits once changed get a new time law as well. That
    no remedy is found is no proof that there is none.

    Args:
        found: the judgement; its settings are those of the new ones.
        analysis: families, where `found` was checked with an analysis.
        acceleration: () or (n,) limits [rad/s², m/s²]; None: none. Arms state none of their own.
        kinds: those of `KINDS` that are tried.
        options: how far the path may be changed; its fields are taken as keywords as well.
        progress: called with the kind, and how much of it is done.

    Returns:
        The remedies found, one of each kind at most, and for the other kinds what was tried.

    Raises:
        OptionError: a bound outside what is allowed.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> path = [[0.3, 0.4, 0.1], [0.5, -0.2, 0.3], [0.9, 0.5, 0.3]]
        >>> mended = mend_path(check_path(open_robot("planar3r"), path), kinds=["blend"], blend=0.5)
        >>> [(one.kind, one.check.verdict.value) for one in mended.remedies]
        [('blend', 'free')]
    """
    how = RemedyOptions.of(options, given)
    unknown = [kind for kind in kinds if kind not in KINDS]
    if unknown:
        raise OptionError("there is no such remedy", where="kinds", got=unknown[0], allowed=", ".join(KINDS))
    work = _Mender(check, analysis, _limits(check, acceleration), frozenset(kinds), progress)
    results: list[Remedy | Failure] = []
    complete = True
    try:
        for result in work.results(how):
            results.append(result)  # what is made before Ctrl-C is kept
    except KeyboardInterrupt:
        complete = False
    remedies = sorted((result for result in results if isinstance(result, Remedy)), key=attrgetter("rank"))
    failures = tuple(result for result in results if not isinstance(result, Remedy))
    return Mending(check, tuple(remedies), failures, not check.clear or work.breaks(check), complete)


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
    kinds: frozenset[str]
    progress: Progress | None

    def __post_init__(self) -> None:
        self.scale = joint_scale(self.found.robot, self.found.task)
        self.interpolate = self.found.options.interpolate
        self.limited = bool(np.isfinite(self.limits[0]).any() or np.isfinite(self.limits[1]).any())

    def breaks(self, check: PathCheck) -> bool:
        """Whether a path in time breaks a limit."""
        took = self._usage(check.curve)
        return took is not None and took.slower > _SLOWER

    def results(self, most: RemedyOptions) -> Iterator[Remedy | Failure]:
        """A remedy of each kind, or what was tried."""
        if not self.found.clear:
            yield from self._changed_paths(most)
        if not self.breaks(self.found) or (self.found.tool is not None and not self.found.tool.complete):
            return
        if SLOW in self.kinds and self.found.clear:
            slower = self._slower()
            yield slower
            if isinstance(slower, Remedy):
                return
        if RETIME in self.kinds:
            yield self._in_new_time()

    def _usage(self, path: Curve) -> Usage | None:
        if path.times is not None and self.limited:
            return usage(path, *self.limits)
        return None

    def _changed_paths(self, most: RemedyOptions) -> Iterator[Remedy | Failure]:
        """Every kind that changes the path; of poses in turn until one is found."""
        if self.found.poses is None:
            yield from self._changed_joints(most)
            return
        for kinds in (self._poses_detour, self._changed_joints, self._other_branch_detour):
            is_found = False
            for result in kinds(most):
                is_found |= isinstance(result, Remedy)
                yield result
            if is_found:
                return

    def _start(self) -> Array | None:
        """(n,) the configuration at the first pose; None where it is not reached."""
        tool = self.found.tool
        if tool is None or not len(tool.q):
            return None
        return np.asarray(tool.q[0])

    def _changed_joints(self, most: RemedyOptions) -> Iterator[Remedy | Failure]:
        """Every kind that changes joint paths; of poses that cannot be followed to their end those that begin anew."""
        reached = _ends_early(self.found)
        if reached is not None:
            start = self._start()
            if start is not None:
                yield from self._rank_paths(given_tool_path(self.found, start), most)
            elif self.kinds - set(LOCAL):
                yield "unfinished", reached
            return
        tool = tool_path(self.found.robot, self.found.task, self.found.curve)
        yield from self._local(tool, most)
        if most.blend > 0.0 and BLEND in self.kinds:
            yield self._blend(most.blend)
        yield from self._rank_paths(tool, most)

    def _rank_paths(self, tool: JointToolPath, most: RemedyOptions) -> Iterator[Remedy | Failure]:
        """Every kind that ranks whole paths of the joints."""
        kinds: dict[str, Callable[[Callable[[int, int], None]], Ranking]] = {
            NULL: partial(null_spaces, tool), FLIP: partial(branches, tool),
        }  # fmt: skip
        if most.tool_tilt:
            kinds[TILT] = partial(tilts, tool, most.tool_tilt)
        if most.base_shift:
            kinds[SHIFT] = partial(shifts, tool, most.base_shift)
        kinds = {kind: rank for kind, rank in kinds.items() if kind in self.kinds}
        try:
            tool.aim  # noqa: B018  # refuses a task that poses do not determine
        except TaskError as error:
            if kinds:
                yield "path", error.what
            return
        for kind, rank in kinds.items():
            remedies, ended = rank(partial(self._report, kind))
            yield self._first(kind, self._proposals(remedies)) or (kind, (len(remedies), ended))

    def _clearance(self) -> float:
        asked = SPARE * self.found.options.min_distance
        return asked if asked > 0.0 else CLEARANCE

    def _poses_detour(self, bounds: RemedyOptions) -> Iterator[Remedy | Failure]:
        """The poses moved around each singularity that they lead through, and the joints along them."""
        most = bounds.detour
        if DETOUR not in self.kinds or most <= 0.0:
            return
        work = PoseDetourer(self.found, most, self._clearance())
        windows = work.find_windows(partial(self._report, DETOUR))
        if isinstance(windows, Blocked):
            place = work.place_at(windows.place)
            joints = (windows.joint,) if windows.joint else ()
            yield DETOUR, (most, [(place, windows.hindrance, windows.needed, joints)], 0)
            if windows.joint:
                yield "range", (windows.joint, windows.beyond, self.found.robot)
            return
        if not windows:
            yield DETOUR, (most, [], 0)
            return
        yield self._first(DETOUR, [self._pose_proposal(work, windows, "detour")]) or (DETOUR, (most, [], 0))

    def _other_branch_detour(self, bounds: RemedyOptions) -> Iterator[Remedy]:
        """The poses followed on another branch from the first one on, and moved around the singularities there."""
        start = self._start()
        if not {DETOUR, FLIP} <= self.kinds or bounds.detour <= 0.0 or start is None:
            return
        work = PoseDetourer(self.found, bounds.detour, self._clearance())
        starts = other_branches(given_tool_path(self.found, start))
        proposals = []
        for k, other in enumerate(starts):
            self._report(DETOUR, k, len(starts))
            windows = work.find_windows(_unreported, other)
            if isinstance(windows, Blocked) or not windows:
                continue
            proposal = self._pose_proposal(work, windows, "detour elsewhere")
            proposals.append(replace(proposal, parameters=(joint_values("start", other),)))
        self._report(DETOUR, len(starts), len(starts))
        length = self.found.length_scale
        proposals.sort(key=lambda proposal: proposal.off[0] / length + proposal.off[1])
        remedy = self._first(DETOUR, proposals)
        if remedy is not None:
            yield remedy

    def _pose_proposal(self, work: PoseDetourer, windows: list[PoseWindow], how: str) -> Proposal:
        """The joints along poses that are moved in windows."""
        still = np.zeros(self.found.robot.n)
        changes = tuple(
            LocalChange(work.place_at(window.low), work.place_at(window.high), still, window.off, still)
            for window in windows
        )
        off = max(window.off[0] for window in windows), max(window.off[1] for window in windows)
        return Proposal((how, len(windows)), (), work.trajectory(), off, changes)

    def _local(self, tool: JointToolPath, most: RemedyOptions) -> Iterator[Remedy | Failure]:
        """The joints moved aside; where they have to go to the other side, the tool led around it."""
        local = self.found
        if sum(stretch.verdict != FREE for stretch in local.stretches) > MANY:
            yield "local", MANY
            return
        families, _ = known_families(local.robot, local.task, self.analysis, local.tolerances)
        bumper = Bumper(local, tool, families, most.bump, *self.limits)
        clearance = self._clearance()
        if BUMP in self.kinds and most.bump > 0.0:
            result = self._bump(bumper, clearance)
            yield result
            if isinstance(result, Remedy) and bumper.size(result.deviation) <= most.detour:
                return
        if DETOUR in self.kinds and most.detour > 0.0 and local.poses is None:
            yield self._detour(bumper, self._bumps_beside(bumper, clearance, most.detour), most.detour, clearance)

    def _bumps_beside(
        self, bumper: Bumper, clearance: float, farthest: float
    ) -> tuple[Proposal, PathCheck] | None:
        """A path that needs detours besides its bumps, with them: some part of it has none, or one that takes the tool
        farther off its path than a detour may. None without bumps.

        Bumps that bring the tool back are taken where only the singularities without a bump are left after them.
        """
        if bumper.bound <= 0.0:
            return None
        found, failed = self._bumps(bumper, clearance)
        bumps = [bump for bump in found if bumper.size(bump.off) <= farthest]
        led_around = _without(bumps, found, failed)
        if not bumps or not led_around:
            return None
        most = sum(len(core.stretches) for core in led_around)
        for proposal in _bump_proposals(bumper, bumps, clearance):
            check = self._check_changed(proposal.made)
            if sum(stretch.verdict != FREE for stretch in check.stretches) <= most:
                break
        return proposal, check

    def _bump(self, bumper: Bumper, clearance: float) -> Remedy | Failure:
        """The joints moved aside at every singularity, farther where the path is not proven free."""
        for tried in range(1, _ROUNDS + 1):
            bumps, failed = self._bumps(bumper, clearance)
            if failed or not bumps:
                missing = [
                    (bumper.path.place(bumper.spot(failure.core)), failure.obstacle, failure.needed)
                    for failure in failed
                ]
                return BUMP, (tried - 1, bumper.bound, missing)
            remedy = self._first(BUMP, _bump_proposals(bumper, bumps, clearance))
            if remedy is not None:
                return remedy
            clearance *= _CLEARER
        return BUMP, (_ROUNDS, bumper.bound, [])

    def _bumps(self, bumper: Bumper, clearance: float) -> tuple[list[Bump], list[NoBump]]:
        """A bump for each part of a path that has one, and why the others have none."""
        cores, crossed = bumper.cores(clearance)
        results: list[Bump | NoBump] = [NoBump(core, Obstacle.SIDE) for core in crossed]
        for k, core in enumerate(cores):
            self._report(BUMP, k, len(cores))
            results.append(bumper.bump(core, clearance))
        self._report(BUMP, len(cores), len(cores))
        bumps = [result for result in results if isinstance(result, Bump)]
        return bumps, [result for result in results if isinstance(result, NoBump)]

    def _detour(
        self, bumper: Bumper, bumped: tuple[Proposal, PathCheck] | None, most: float, clearance: float
    ) -> Remedy | Failure:
        """The tool led around what no bump avoids, on the path with its bumps."""
        if not _poses_determine(bumper.tool) or bumper.path.degree != 1:
            return DETOUR, None
        changes: list[LocalChange] = []
        rows = RowsBefore.of(bumper.path, bumper.path, ())
        if bumped is not None:
            before, checked = bumped
            rows = RowsBefore.of(bumper.path, checked.curve, before.changes)
            bumper = replace(bumper, check=checked, tool=tool_path(checked.robot, checked.task, checked.curve))
            changes += before.changes
        stretches = sorted(
            (stretch for stretch in bumper.check.stretches if stretch.verdict != FREE), key=attrgetter("start")
        )
        if len(stretches) > _DETOURS:
            return DETOUR, (most, [], len(stretches))
        cores = [bumper.core(stretch, clearance) for stretch in stretches]
        work = Detourer(bumper, most)
        results = work.find_detours(cores, clearance)
        self._report(DETOUR, len(results), len(cores))
        detours = [result for result in results if isinstance(result, Detour)]
        failed = [(rows.place(bumper.path.place(bumper.spot(result.core))), result.hindrance, result.needed,
                   result.joints) for result in results if isinstance(result, NoDetour)]  # fmt: skip
        if failed or not detours:
            return DETOUR, (most, failed, 0)
        for change in work.changes(detours):
            changes.append(replace(change, start=rows.place(change.start), end=rows.place(change.end)))
        changes.sort(key=attrgetter("start"))
        trajectory, rest = work.trajectory(detours)
        off = max(rest[0], *(change.off[0] for change in changes)), max(rest[1], *(change.off[1] for change in changes))
        proposal = Proposal(("detour", len(detours)), (), trajectory, off, tuple(changes))
        return self._first(DETOUR, [proposal]) or (DETOUR, (most, [], 0))

    def _report(self, kind: str, done: int, count: int) -> None:
        if self.progress is not None:
            self.progress(kind, done, count)

    def _proposals(self, candidates: list[Candidate]) -> Iterator[Proposal]:
        for other in candidates[:_CHECKED]:
            tool, followed = other.tool.refine_run(other.run)
            if followed.complete:
                trajectory = tool.trajectory(followed.q, self.interpolate)
                off = tool.deviation(trajectory, self.interpolate)
                yield Proposal((other.how, None), other.parameters, trajectory, off)

    def _first(self, kind: str, proposals: Iterable[Proposal]) -> Remedy | None:
        """The first proposal that is proven free; one in time that breaks a limit gets another time law."""
        for proposal in proposals:
            trajectory = proposal.made
            if trajectory.timed:
                took = self._usage(trajectory.curve(self.interpolate))
            else:
                took = None
            retimed = took is not None and took.slower > _SLOWER
            if retimed:
                trajectory = self._within_limits(trajectory.curve(self.interpolate))
            remedy = self._as_remedy(kind, replace(proposal, made=trajectory), retimed=retimed)
            if remedy.check.clear:
                return remedy
        return None

    def _blend(self, most: float) -> Remedy | Failure:
        if self.interpolate != "linear":
            return BLEND, None
        proposals = list(blends(self.found, most))
        return self._first(BLEND, proposals) or (BLEND, len(proposals))

    def _within_limits(self, path: Curve) -> Trajectory:
        """A changed path slower around the rows that are too fast, or else all of it in a new time."""
        slowed = slowed_down(path, *self.limits)
        if slowed is not None:
            return slowed[0]
        return retime_path(path, *self.limits, self.scale)

    def _slower(self) -> Remedy | Failure:
        """The path itself, slower around the places where it is too fast."""
        self._report(SLOW, 0, 1)
        path = self.found.curve
        slowed = slowed_down(path, *self.limits)
        if slowed is None:
            return SLOW, path.degree == 1
        still = np.zeros(self.found.robot.n)
        changes = tuple(LocalChange(path.place(part.start), path.place(part.end), still, (0.0, 0.0), still, part.longer)
                        for part in slowed[1])  # fmt: skip
        proposal = Proposal(("slow-down", len(changes)), (), slowed[0], (0.0, 0.0), changes)
        remedy = self._as_remedy(SLOW, proposal, retimed=True)
        self._report(SLOW, 1, 1)
        return remedy if remedy.check.clear else (SLOW, True)

    def _in_new_time(self) -> Remedy | Failure:
        """The path itself inside its limits."""
        self._report(RETIME, 0, 1)
        trajectory = retime_path(self.found.curve, *self.limits, self.scale)
        if usage(trajectory.curve(self.interpolate), *self.limits).slower > _SLOWER:
            return RETIME, None
        remedy = self._as_remedy(RETIME, Proposal(("retime", None), (), trajectory, (0.0, 0.0)), retimed=True)
        self._report(RETIME, 1, 1)
        return remedy

    def _as_remedy(self, kind: str, proposal: Proposal, *, retimed: bool) -> Remedy:
        trajectory = proposal.made
        check = self._check_changed(trajectory)
        before, took = self._usage(self.found.curve), self._usage(check.curve)
        gains = {"distance": (_distance(self.found), _distance(check))}
        if before is not None and took is not None:
            gains |= {"speed": (1 / before.slower, 1 / took.slower),
                      "duration": (_duration(self.found), _duration(check))}  # fmt: skip
        trajectory = replace(trajectory, name="mended")
        return Remedy(kind, proposal.how, proposal.parameters, gains, trajectory, self.interpolate, check, took,
                      proposal.off, retimed, proposal.changes)  # fmt: skip

    def _check_changed(self, trajectory: Trajectory) -> PathCheck:
        """A changed path, checked as the path was."""
        check = check_path(
            self.found.robot, trajectory.q, trajectory.times if trajectory.timed else None,
            velocities=trajectory.velocities, accelerations=trajectory.accelerations, task=self.found.task,
            analysis=self.analysis,
            options=self.found.options, tolerances=self.found.tolerances,
        )  # fmt: skip
        if not check.complete:
            raise KeyboardInterrupt
        return check


def _unreported(done: int, count: int) -> None:
    """Progress of a part of the work that is too short to be reported."""


def _without(bumps: list[Bump], found: list[Bump], failed: list[NoBump]) -> list[Core]:
    """Parts of a path that have none of the bumps that are taken."""
    left_out = [bump.core for bump in found if bump not in bumps]
    return [failure.core for failure in failed] + left_out


def _bump_proposals(bumper: Bumper, bumps: list[Bump], clearance: float) -> Iterator[Proposal]:
    """A path with bumps: the tool brought back to its path where that is better; then as the bumps are."""
    led = [bumper.lead_aside(bump, clearance) for bump in bumps]
    if any(bump.twist is not None for bump in led):
        yield _bump_proposal(bumper, led)
    yield _bump_proposal(bumper, bumps)


def _bump_proposal(bumper: Bumper, bumps: list[Bump]) -> Proposal:
    """A path with bumps."""
    path = bumper.path
    changes = []
    for bump in sorted(bumps, key=lambda bump: bump.core.low):
        start, end = (path.place(spot) for spot in bumper.ends(bump))
        changes.append(LocalChange(start, end, bumper.most_moved(bump), bump.off, np.zeros_like(bump.way)))
    off = max(bump.off[0] for bump in bumps), max(bump.off[1] for bump in bumps)
    return Proposal(("bump", len(bumps)), (), bumper.trajectory(bumps), off, tuple(changes))


def _distance(check: PathCheck) -> float:
    """Least distance known along a path; 0 where it meets a singularity, or may."""
    if any(stretch.verdict not in (FREE, UNDECIDED) for stretch in check.stretches):
        return 0.0
    return min((stretch.closest.distance for stretch in check.stretches), default=np.inf)


def _duration(check: PathCheck) -> float:
    times = check.curve.times
    if times is None:
        return np.nan
    return float(times[-1] - times[0])
