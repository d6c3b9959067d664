"""Local changes of a tool path that was given as poses: the tool led around each singularity that ends its branch.

The branch is followed from the first pose until it ends at a singularity, or comes to one. There the poses of a
window are moved, T′ = exp(ε B ŵ) T (`path.mend.detours`), w the way or the turn of the tool with the larger share
along the direction lost, or else the other one, and the branch goes on along them: past a wrist, where two joints
turn half around, or inside the edge of reach, which the poses leave. Of both ways along w, windows of some lengths and
sizes, all followed side by side, the least is taken that the joints can follow with room to the singularity. After the
window the poses are as they were, and the joints are on the branch to which the window led. All other poses stay as
they are, to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from rankdrop.path.check.follow import follow
from rankdrop.path.check.record import PathCheck
from rankdrop.path.check.tool_branch import Followed
from rankdrop.path.check.tool_line import poses_at
from rankdrop.path.check.tool_path import tip_tolerance
from rankdrop.path.curve import Place
from rankdrop.path.mend.detours import Hindrance
from rankdrop.path.mend.given_poses import given_tool_path, way_lengths
from rankdrop.path.mend.local_change import poses_off, step
from rankdrop.path.mend.lost_direction import lost_motions, moved_along
from rankdrop.path.read.trajectory import Trajectory, regular_times
from rankdrop.poses.inverse import Aim
from rankdrop.problem import Mask
from rankdrop.robot.model import Array

_RAMP = 0.3  # of a window where there is room [s]; without times that many metres or rad, lengths by the length scale
_LONGER = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)  # times the shortest window that are tried
_FINEST, _GROWING, _WIDENED = 1e-2, 1.6, 8.0  # sizes: from that share of the clearance on, up to times the bound
_FINER = 10  # … and so many between the least that does and the one before
_LOOKED, _JUMP = 120, 0.6  # places of a first look on each side; joint motion between two of them at most [rad]
_CONFIRMED = 8  # looks that are followed in full
_NEARER = 0.9  # share of the clearance that is kept
_BESIDE = 15.0  # times the clearance: a joint that reaches its limit after coming so near turned because of that
_ROOM = 0.9  # share of the time before and after it that a ramp may take
_SHORTEST = 0.02  # half of a core at least, by the clock
_INSTANT = 1e-9  # rows nearer in time are one [s]
_MET = 0.05  # share of the clearance below which a path counts as at the singularity
_ROWS = 40  # of a window at least
_MOST = 12  # windows of one branch


@dataclass(frozen=True, eq=False)
class PoseWindow:
    """A part of the poses that is moved.

    Attributes:
        low, high: its ends, places counted in poses from 0.
        off: how far the tool is from its path at most [m], [rad].
    """

    low: float
    high: float
    off: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Blocked:
    """Where the poses cannot be led around a singularity.

    Attributes:
        place: counted in poses from 0.
        hindrance: why.
        needed: the size that would do where it is above the bound, else nan [rad; lengths by the length scale].
        joint: number from 1 of the one that reached its limit; 0: none.
        beyond: how far it goes beyond its range, where without its limits the poses are followed to the end and no
            other joint leaves its range; else nan [rad, m].
    """

    place: float
    hindrance: Hindrance
    needed: float = np.nan
    joint: int = 0
    beyond: float = np.nan


@dataclass(frozen=True, eq=False)
class Span:
    """Where a window may be.

    Attributes:
        kept: row of the branch at which it begins.
        low, high: its ends, places counted in poses from 0.
        ends: (4,) of the clock: where its ramps begin, where they end, and the same on the way back.
        middle: by the clock, where the branch comes nearest to the singularity.
    """

    kept: int
    low: float
    high: float
    ends: tuple[float, float, float, float]
    middle: float


@dataclass(frozen=True, eq=False)
class Look:
    """A size ε, a window and a tool motion ŵ of size 1, and (n,) how far joints go beyond their limits."""

    size: float
    span: Span
    way: Array
    excess: Array


@dataclass(eq=False)
class PoseDetourer:
    """Looks for windows in which poses are moved.

    Attributes:
        check: of the poses.
        bound: largest size [rad; lengths divided by the length scale].
        clearance: first-order distance that is left to a singularity [rad].
        searched: windows that were looked for until now, on all branches.
    """

    check: PathCheck
    bound: float
    clearance: float
    searched: int = 0

    def __post_init__(self) -> None:
        given = self.check.poses
        assert given is not None
        self.poses, times = given.matrices, given.times
        self.robot, self.task = self.check.robot, given.task
        self.aim = Aim(self.robot, self.task)
        self.tolerance = tip_tolerance(self.check.options, self.robot)
        self.clock = way_lengths(self.poses, self.aim.length) if times is None else times
        self.tool = given_tool_path(self.check, np.zeros(self.robot.n))
        self.rows: list[tuple[Array, Array]] = []  # places and configurations that are kept, in order

    def find_windows(
        self, report: Callable[[int, int], None], other: Array | None = None, most: int = _MOST
    ) -> list[PoseWindow] | Blocked:
        """Windows after which the whole path is followed; else where there is none.

        Args:
            report: how many windows are done, of how many at least.
            other: (n,) a configuration at the first pose; None: that of the check.
            most: windows that are looked for at most.
        """
        most = min(most, _MOST)
        tool = self.check.tool
        assert tool is not None
        if other is None and not len(tool.q):
            return Blocked(0.0, Hindrance.END)
        start = tool.q[0] if other is None else other
        place, windows = 0.0, list[PoseWindow]()
        self.rows.clear()
        for _ in range(most + 1):
            at = self._places_from(place)
            known = tool if other is None and not windows else None
            run = self._run_from(at, start, known)
            end = self._ends(run)
            if end is None:
                self.rows.append((self._places(at, run), run.q))
                return windows
            if len(windows) == most:
                break
            self.searched += 1
            outcome = self._window_of_run(at, run, end, first=not windows)
            if isinstance(outcome, Blocked):
                return self._with_excess(outcome, at, start) if run.reason == "limit" and not outcome.joint else outcome
            window, place, start = outcome
            windows.append(window)
            report(len(windows), len(windows) + 1)
        return Blocked(float(self._places(at, run)[-1]), Hindrance.REST)

    def _window_of_run(
        self, at: Array, run: Followed, end: int, *, first: bool
    ) -> tuple[PoseWindow, float, Array] | Blocked:
        """A window around the row at which a run ends. Where it ends as a joint turned too far while the tool passed
        by a singularity, the other way round may do: a window around the row nearest to it.
        """
        if run.reason != "limit" or end < len(run.q) - 1:
            return self._window_around(at, run, end)
        at_limit = Blocked(float(self._places(at, run)[-1]), Hindrance.RANGE)
        room = self.tool.room(run.q)
        nearest = int(room.argmin())
        if room[nearest] > _BESIDE * self.clearance:
            return at_limit
        outcome = self._window_around(at, run, nearest)
        if isinstance(outcome, Blocked) and outcome.hindrance is Hindrance.END and not first:
            return at_limit
        return outcome

    def _with_excess(self, blocked: Blocked, at: Array, start: Array) -> Blocked:
        """With the joint that needs a wider range for the branch to go on, and by how much."""
        poses = poses_at(self.poses, at)
        free = follow(self.robot, poses, start, self.task, limits=False, tolerance=self.tolerance)
        if not free.complete:
            return blocked
        excess = self._excess(free.q)
        joint = int((excess / self.aim.joints).argmax())
        if excess[joint] <= 0.0:
            return blocked
        return replace(blocked, joint=joint + 1, beyond=_of_one_joint(excess, joint))

    def _excess(self, q: Array) -> Array:
        """(n,) how far each joint leaves its range at most in rows (K, n), negative inside it."""
        return np.asarray(np.maximum(q - self.robot.upper, self.robot.lower - q).max(axis=0))

    def _excess_to_end(self, look: Look, q: Array) -> Array | None:
        """(n,) as `_excess`, along a window and the poses after it; None where they are not followed to the end."""
        _, _, moved = self._window_poses(look)
        led = follow(self.robot, moved, q[look.span.kept], self.task, limits=False, tolerance=self.tolerance)
        if not led.complete:
            return None
        rest = poses_at(self.poses, self._places_from(look.span.high))
        free = follow(self.robot, rest, led.q[-1], self.task, limits=False, tolerance=self.tolerance)
        if not free.complete:
            return None
        return self._excess(np.concatenate([led.q, free.q]))

    def _run_from(self, at: Array, start: Array, known: Followed | None) -> Followed:
        """The branch of a configuration along places; one that is known up to the first singularity that it goes
        through.
        """
        if known is None:
            return self._follow_branch(at, start)
        if not known.passed:
            return known
        kept = known.place < known.passed[0].place
        return replace(known, q=known.q[kept], place=known.place[kept], complete=False, reason="singular")

    def _places_from(self, place: float) -> Array:
        """Places from one on: it, and all poses after it."""
        return np.concatenate([[place], np.arange(np.floor(place) + 1.0, len(self.poses))])

    def _follow_branch(self, at: Array, start: Array, moved: Array | None = None) -> Followed:
        """The branch of a configuration along poses at places, moved or not."""
        poses = poses_at(self.poses, at) if moved is None else moved
        whole = at == np.floor(at)
        if moved is None:
            poses[whole] = self.poses[at[whole].astype(np.int64)]
        return follow(self.robot, poses, start, self.task, tolerance=self.tolerance)

    def _places(self, at: Array, run: Followed) -> Array:
        """(K,) places of the rows of a run along places."""
        return np.asarray(np.interp(run.place - 1.0, np.arange(len(at)), at))

    def _ends(self, run: Followed) -> int | None:
        """The first row of a run that is at a singularity, or its last one; None where it is free to the end."""
        if not len(run.q):
            return 0
        sigma, slope = self.tool.rising(run.q)
        room = sigma / np.maximum(np.linalg.norm(slope, axis=1), 1e-2)
        near = (room < _MET * self.clearance) | self._crossed(run.q, sigma, slope)
        met = np.flatnonzero(near)
        if len(met):
            first = int(met[0])
            beyond = np.flatnonzero(~near[first:])
            stop = first + (int(beyond[0]) if len(beyond) else len(room) - first)
            return first + int(room[first:stop].argmin())
        if run.complete:
            return None
        return len(run.q) - 1

    def _crossed(self, q: Array, sigma: Array, slope: Array) -> Mask:
        """(K,) whether a run (K, n) crosses a singularity next to each row: from both sides σ_r would fall below zero
        before the other one, to first order.
        """
        move = np.diff(q, axis=0) / self.aim.joints
        ahead = sigma[:-1] + (slope[:-1] * move).sum(axis=1)
        behind = sigma[1:] - (slope[1:] * move).sum(axis=1)
        between = (ahead < 0.0) & (behind < 0.0)
        return np.asarray(np.append(between, False) | np.insert(between, 0, False))

    def _window_around(self, at: Array, run: Followed, end: int) -> tuple[PoseWindow, float, Array] | Blocked:
        """A window around a row of a run, where the path goes on after it, and the configuration there."""
        if not len(run.q):
            return Blocked(float(at[0]), Hindrance.REST)
        places = self._places(at, run)
        place = float(places[end])  # of the singularity
        clear = np.flatnonzero(self.tool.room(run.q[: end + 1]) >= self.clearance)
        if not len(clear):
            return Blocked(place, Hindrance.END)
        last_clear = float(places[clear[-1]])
        spans = self._spans(places[: end + 1], last_clear, place)
        if not spans:
            return Blocked(place, Hindrance.END)
        before = run.q[clear[-1]]  # nearer, two joints may have begun to turn half around
        larger, *smaller = lost_motions(self.aim, self.tool.rank, before)
        window = self._led_along(larger, spans, places, run.q, place)
        for motion in smaller:
            if not isinstance(window, Blocked):
                break
            other = self._led_along(motion, spans, places, run.q, place)
            if not isinstance(other, Blocked):
                window = other
        return window

    def _led_along(
        self, motion: Array, spans: list[Span], places: Array, q: Array, place: float
    ) -> tuple[PoseWindow, float, Array] | Blocked:
        """A window in which the poses are moved along a tool motion (m,) of size 1."""
        sizes = self._sizes()
        looks = self._looks(spans, q, motion, sizes)
        if not looks:
            return self._joint_that_blocks(place, spans, q, motion, sizes)
        least = looks[0].size
        if least > self._largest:
            return Blocked(place, Hindrance.TOOL, least)
        before = max((size for size in sizes if size < least), default=least / _GROWING)
        finer = self._looks([looks[0].span], q, motion, np.geomspace(before, least, _FINER + 1)[1:-1])
        for look in [*finer, *looks][:_CONFIRMED]:
            confirmed = self._follow_window(look, q)
            if look.size <= self._largest and confirmed is not None:
                window, window_places, moved = confirmed
                kept = look.span.kept
                self.rows.append((places[: kept + 1], q[: kept + 1]))
                self.rows.append((window_places[1:-1], moved[1:-1]))
                return window, look.span.high, moved[-1]
        return Blocked(place, Hindrance.TOOL)

    @property
    def _largest(self) -> float:
        """Size up to which rounding leaves a window within the bound."""
        return self.bound * (1 + 1e-9)

    def _spans(self, places: Array, core: float, met: float) -> list[Span]:
        """Windows of some lengths around a singularity, those for which there is room."""
        spans = []
        for longer in _LONGER:
            span = self._span(places, core, met, longer)
            if span is not None:
                spans.append(span)
        return spans

    def _joint_that_blocks(self, place: float, spans: list[Span], q: Array, lost: Array, sizes: Array) -> Blocked:
        """Why no window does: the joint that would have to go least beyond its limit, where one would do without."""
        unlimited = self._looks(spans, q, lost, sizes, limits=False)
        within = [look for look in unlimited if look.size <= self.bound]
        if not within:
            return Blocked(place, Hindrance.TOOL)
        least = min(within, key=lambda look: float((look.excess / self.aim.joints).max()))
        joint = int((least.excess / self.aim.joints).argmax())
        excess = self._excess_to_end(least, q)
        beyond = np.nan if excess is None else _of_one_joint(excess, joint)
        return Blocked(place, Hindrance.LIMIT, np.nan, joint + 1, beyond)

    def _sizes(self) -> Array:
        """Sizes that are tried, the least first, the bound among them."""
        least, most = _FINEST * self.clearance, _WIDENED * self.bound
        count = int(np.ceil(np.log(max(most / least, 1.0)) / np.log(_GROWING))) + 1
        return np.unique(np.append(np.geomspace(least, most, count), self.bound))

    def _span(self, places: Array, core: float, met: float, longer: float) -> Span | None:
        """Where a window begins and ends around a core; None where there is no room for it."""
        full, middle = (float(x) for x in self._time(np.array([core, met])))
        half = longer * max(middle - full, _SHORTEST)
        back, ramp = middle + half, max(_RAMP, half)
        first, last = float(self._time(places[:1])[0]), float(self.clock[-1])
        ahead, behind = min(ramp, _ROOM * (full - first)), min(ramp, _ROOM * (last - back))
        if min(ahead, behind) <= 0.0:
            return None
        kept = int(np.searchsorted(self._time(places), full - ahead, side="right")) - 1
        low = float(places[kept])
        high = min(float(np.ceil(self._place(np.array([back + behind]))[0])), len(self.poses) - 1.0)
        begin, end = (float(x) for x in self._time(np.array([low, high])))
        return Span(kept, low, high, (begin, full, back, end), middle)

    def _moved_poses(self, span: Span, place: Array, twist: Array) -> tuple[Array, Array]:
        """(N, 4, 4) poses at places of a window, as they were and moved."""
        time, (begin, full, back, end) = self._time(place), span.ends
        share = np.where(time <= (full + back) / 2, step((time - begin) / (full - begin))[0],
                         step((end - time) / (end - back))[0])  # fmt: skip
        old = poses_at(self.poses, place)
        return old, moved_along(self.aim, old, share[:, None] * twist)

    def _looks(
        self, windows: list[Span], q: Array, lost: Array, sizes: Array, *, limits: bool = True
    ) -> list[Look]:
        """Sizes, windows and ways that the joints can follow with room, the least first: all of them followed side by
        side, at places that are close together near the singularity.
        """
        looks: list[Look] = []
        poses, times = [], []
        for span in windows:
            time = self._look_times(span)
            place = self._place(time).clip(span.low, span.high)
            for size in sizes.tolist():
                for way in (lost, -lost):
                    looks.append(Look(size, span, way, np.zeros(self.robot.n)))
                    poses.append(self._moved_poses(span, place, size * way)[1])
                    times.append(time)
        starts = np.array([q[look.span.kept] for look in looks])
        followed, alive = self._side_by_side(np.stack(poses, axis=1), np.stack(times, axis=1), starts, limits=limits)
        kept = np.flatnonzero(alive)
        if not len(kept):
            return []
        room = self.tool.room(followed[:, kept].reshape(-1, self.robot.n)).reshape(len(followed), len(kept))
        excess = np.maximum(followed - self.robot.upper, self.robot.lower - followed).max(axis=0)
        clear = kept[room.min(axis=0) >= _NEARER * self.clearance]
        clear_looks = [replace(looks[index], excess=excess[index]) for index in clear]
        return sorted(clear_looks, key=lambda look: (look.size, look.span.high - look.span.low))

    def _look_times(self, span: Span) -> Array:
        """(N,) times of a first look along a window, close together near the singularity, in the middle."""
        begin, *_, end = span.ends
        u = np.linspace(-1.0, 1.0, 2 * _LOOKED + 1)
        x = np.sign(u) * u * u
        half = np.where(x < 0.0, span.middle - begin, end - span.middle)
        return np.asarray(span.middle + half * x)

    def _side_by_side(self, poses: Array, times: Array, starts: Array, *, limits: bool) -> tuple[Array, Mask]:
        """(N, L, n) configurations along L rows of poses (N, L, 4, 4), and (L,) which rows were followed to the end.

        Each guess goes on from the last two configurations at their rate. A configuration that was not reached is nan.
        """
        lasts = np.diff(times, axis=0)
        followed = np.full((*poses.shape[:2], self.robot.n), np.nan)
        followed[0] = starts
        alive = np.ones(poses.shape[1], dtype=np.bool_)
        for k in range(1, len(poses)):
            before = followed[k - 1, alive]
            guess = before
            if k > 1:
                ratio = lasts[k - 1, alive] / lasts[k - 2, alive]
                guess = before + (before - followed[k - 2, alive]) * ratio[:, None]
            solved, arrived = self.aim.solve(poses[k, alive], guess)
            jump = np.abs((solved - before) / self.aim.joints).max(axis=1)
            good = arrived & (jump < _JUMP)
            if limits:
                good &= self._inside_limits(solved)
            rows = np.flatnonzero(alive)
            followed[k, rows[good]] = solved[good]
            alive[rows[~good]] = False
            if not alive.any():
                break
        return followed, alive

    def _inside_limits(self, q: Array) -> Mask:
        return np.asarray(((q >= self.robot.lower) & (q <= self.robot.upper)).all(axis=1))

    def _follow_window(self, look: Look, q: Array) -> tuple[PoseWindow, Array, Array] | None:
        """A window followed as any tool path is: its places and rows; None where it is not free."""
        span = look.span
        at, old, moved = self._window_poses(look)
        run = self._follow_branch(at, q[span.kept], moved)
        if not run.complete or float(self.tool.room(run.q).min()) < _NEARER * self.clearance:
            return None
        off = poses_off(old, moved, self.aim)
        return PoseWindow(span.low, span.high, off), self._places(at, run), run.q

    def _window_poses(self, look: Look) -> tuple[Array, Array, Array]:
        """(N,) places of a window, and (N, 4, 4) the poses there, as they were and moved."""
        span = look.span
        inner = np.arange(np.floor(span.low) + 1.0, np.ceil(span.high))
        begin, *_, end = span.ends
        fine = self._place(np.linspace(begin, end, _ROWS)).clip(span.low, span.high)
        at = np.unique(np.concatenate([[span.low], inner, fine, [span.high]]))
        old, moved = self._moved_poses(span, at, look.size * look.way)
        return at, old, moved

    def _time(self, place: Array) -> Array:
        return np.asarray(np.interp(place, np.arange(len(self.clock)), self.clock))

    def _place(self, time: Array) -> Array:
        return np.asarray(np.interp(time, self.clock, np.arange(len(self.clock))))

    def place_at(self, place: float) -> Place:
        """A place by the number of its pose."""
        given = self.check.poses
        timed = given is not None and given.times is not None
        row = int(np.floor(place))
        if timed:
            time = float(self._time(np.array([place]))[0])
        else:
            time = None
        return Place(row + 1, place - row, time, pose=place + 1.0)

    def trajectory(self) -> Trajectory:
        """The joint path along the moved poses."""
        place, q = (np.concatenate(parts) for parts in zip(*self.rows, strict=True))
        distinct = np.concatenate([[True], np.diff(self._time(place)) > _INSTANT])
        place, q = place[distinct], q[distinct]
        given = self.check.poses
        timed = given is not None and given.times is not None
        times = self._time(place) if timed else regular_times(len(place))
        return Trajectory("", times, q, timed, ())


def _of_one_joint(excess: Array, joint: int) -> float:
    """How far a joint, by its index, leaves its range; nan where another one leaves its own, or it does not."""
    if excess[joint] <= 0.0 or (np.delete(excess, joint) > 0.0).any():
        return np.nan
    return float(excess[joint])
