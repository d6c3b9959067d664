"""Tool paths followed on one branch of the inverse kinematics, up to where it ends, and through singularities.

Between two poses of a tool path the tip goes straight and turns about one axis at a constant rate, as a linear move of
a controller does. It is followed by steps from near (`Aim.solve`). A step counts only where the corrector has little
left to correct, where no joint motion is long, and where no determinant changes its sign; otherwise it is halved, so
that the branch is kept up to the singularity or the limit at which it stops. What the branch does at a singularity is
decided by the local geometry (`path.check.passing`). One that poses miss by as little as they are rounded is crossed
straight (`path.check.missed_singularity`). Poses passed over by a step are filled in from a straight guess between its
ends, all at once, and polished to rounding. With a tolerance rows are put in until the tip is proven to stay within it
of its curve while the joints go straight from row to row (`Aim.deviation`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from rankdrop import _core
from rankdrop.kinematics import one_configuration
from rankdrop.local.block import singular_values
from rankdrop.local.posture import by_habit
from rankdrop.path.check.missed_singularity import StraightCrossing, missed_start
from rankdrop.path.check.passing import Departure, StraightMove, Turn, departures, internal_turn
from rankdrop.path.check.solution_curve import CurvePart, follow_curve
from rankdrop.path.check.tool_branch import Followed, Passed
from rankdrop.path.check.tool_line import poses_at
from rankdrop.path.curve import number_parts
from rankdrop.poses.inverse import Aim
from rankdrop.problem import Mask
from rankdrop.robot.model import Array, Robot, first_joint_beyond_limit
from rankdrop.task import Task, resolve_task

Pull = Callable[[Array], Array]
"""pull(q) -> (n,) wanted joint motion per unit length of joint motion; its part in the null space is followed."""

_LONGEST = 0.15  # of a step in joint space [rad; slides divided by the length scale]
_BENT = 0.2  # share of a step that the corrector may add to the predictor
_ROUNDING = 1e-9  # … and this much: where the tool stands still, both are rounding [rad; slides scaled]
_GROWING, _KEPT = 2.0, 0.9  # a step is so many times as long as the last one at most, and of what it may be as long
_SHORTEST = 1e-9  # step at which the branch has ended [of the way between two poses]
_TRIES = (400, 1)  # steps at most, and for each pose: a branch that creeps along a singularity ends
_MOST = 4096  # poses passed over by one step
_ROWS = 400_000  # at most
_FILLS, _PARTS = 8, 64  # of putting rows in within one step, and of one piece in one round
_PUT_IN = 20_000  # rows of one step; a bound that does not fall with them would ask for more and more
_SPARE = 1.1  # rows are put in for a bound so many times tighter
_SMALL = 1e-2  # σ_r at the end of a branch above which no singularity is its reason
_SINGULAR = 1e-6  # σ_r of a row below which the branch is at a singularity, and leaves it by its local geometry
_NEXT_TO = 1e-12  # poses, from where a branch stops to the singularity that it steps over
_TOUCH = 1e-3  # a step that ends at a singular pose is at most so long: Newton leaves the lost joint motion alone [rad]
_AT_END = 1e-5  # poses: a singularity so near to the end of the branch is the one at which it ends
_CLEAR = 0.01  # rows nearer to a singularity that is passed are left out [rad; slides scaled]
_STRAIGHT = 0.97  # cosine of the turn of the joint motion at a singularity below which it is a corner
_STALLED, _STAYED = 75, 0.5  # so many tries within one move and so much joint motion: the branch may creep [rad]
_ADVANCED = 0.1  # of the way between two poses: who gets so far within `_STALLED` tries does not creep
_NO_NEARER = 3.0  # … and does where σ_r changed by no more than this factor: on the way to a near miss it falls more
_CREPT_TO = 1e-4  # σ_r at which a branch that creeps ends at the singularity
_SAME = 1e-11  # error of poses that a configuration has; translations divided by the length scale
_SNAPPED = 0.02  # an internal turn so short at the start is made: the start is near enough [rad]


def follow(
    robot: Robot,
    poses: ArrayLike,
    start: ArrayLike,
    task: Task | str | None = None,
    *,
    limits: bool = True,
    pull: Pull | None = None,
    tolerance: tuple[float, float] | None = None,
    through: bool = False,
) -> Followed:
    """Follow poses of the tip from a configuration at the first of them, on the branch of that configuration.

    Args:
        robot: the arm.
        poses: (T, 4, 4) of the tip in the base frame [m]; rows that the task leaves free are ignored.
        start: (n,) configuration near the first pose [rad, m]; Newton brings it there.
        task: name, `Task`, or None for the task the arm is made for.
        limits: end at joint limits.
        pull: null-space motion of a redundant arm; None for the shortest motion.
        tolerance: how far the tip may leave its curve between rows, proven: its place [m] and its turn [rad]; None:
            rows at the poses alone.
        through: go on where the branch leads through a singularity, or begins at one; False: end there.

    Returns:
        What was reached. At every configuration the pose is right to 1e-11, translations divided by the length scale;
        at a pose that misses a singularity of the branch by rounding, to 2e-6; of an arm of lower rank than rows to
        `tolerances.MISSED`.

    Raises:
        ConfigurationError: the start is not one configuration.
        TaskError: there is no such task, or its reference point does not move with the tip.

    Example:
        >>> from rankdrop.kinematics import pose
        >>> from rankdrop.robot.open import open_robot
        >>> arm = open_robot("ur5")
        >>> ends = pose(arm, [[0, -1, 1, 0.3, 0.8, 0], [0.2, -1.1, 1.2, 0.3, 0.8, 0]])
        >>> found = follow(arm, ends, [0, -1, 1, 0.3, 0.8, 0])
        >>> found.complete, (found.q[1].round(6) + 0.0).tolist()
        (True, [0.2, -1.1, 1.2, 0.3, 0.8, 0.0])
    """
    wanted = np.asarray(poses, dtype=np.float64)
    aim = Aim(robot, resolve_task(task, robot))
    return _BranchWalk(aim, wanted, limits, pull, tolerance, through).run(one_configuration(robot, start))


@dataclass(eq=False)
class _BranchProgress:
    """How far a branch was followed, and how its next step is taken.

    Attributes:
        now: (n,) the last configuration.
        side: sign of the determinant that the next step keeps; 0: there is none, or `now` is singular and may be left.
        place: of `now`, counted in poses from 0.
        length: of the next step, in poses.
        rows, places: configurations kept so far, and where, one array for each step.
        size: how many were kept.
        joint: index of the joint beyond its limit after the last try; −1: none.
        spent: the steps or the rows that one path may have were used up, or the branch creeps.
        creeps: many steps have led nowhere.
        tries: steps tried so far.
        seen: place and configuration (n,) some tries before.
        folds: the branch folds back at the singularity at which it ends.
        turn: the internal turn that it needs to go on.
        heading: (n + 1,) direction of the solution curve at `now`; None where no such curve was followed to it.
    """

    now: Array
    side: float
    place: float = 0.0
    length: float = 1.0
    rows: list[Array] = field(default_factory=list)
    places: list[Array] = field(default_factory=list)
    size: int = 1
    joint: int = -1
    spent: bool = False
    creeps: bool = False
    tries: int = 0
    seen: tuple[float, Array] = field(init=False)
    folds: bool = False
    turn: Turn | None = None
    heading: Array | None = None

    def __post_init__(self) -> None:
        self.rows.append(self.now[None])
        self.places.append(np.zeros(1))
        self.seen = self.place, self.now

    def next_place(self, last: float) -> float:
        """Where the next step ends: at a pose where it can, so that no share of a way is left over."""
        ahead = min(self.place + self.length, last)
        if ahead >= int(self.place) + 1:
            return float(int(ahead + 1e-9))
        return ahead

    def direction(self, joints: Array) -> Array | None:
        """(n,) unit vector of the joint motion (scaled by `joints`) that leads to `now`; None where nothing does."""
        away = (self.now - np.concatenate(self.rows)[:-1]) / joints
        far = np.flatnonzero(np.linalg.norm(away, axis=1) >= _CLEAR)
        if not len(far):
            return None
        last = away[far[-1]]
        return np.asarray(last / np.linalg.norm(last))

    def keep(self, at: Array, q: Array, *, between: bool, growth: float) -> None:
        """Go on to the end of a step; its rows between poses are kept where they are wanted. The next is so many times
        as long.
        """
        if between:
            kept = np.ones(len(at), dtype=np.bool_)
        else:
            kept = at == np.floor(at)
        self.rows.append(q[kept])
        self.places.append(at[kept])
        self.size += len(self.rows[-1])
        self.length = min(max(growth * (at[-1] - self.place), _SHORTEST), float(_MOST))
        self.place, self.now = float(at[-1]), q[-1]


@dataclass(eq=False)
class _BranchWalk:
    aim: Aim
    poses: Array
    limits: bool
    pull: Pull | None
    tolerance: tuple[float, float] | None
    through: bool = False
    passed: list[Passed] = field(default_factory=list)
    growth: float = _GROWING  # of the next step, as the last one allows
    missed: set[float] = field(default_factory=set)  # places of poses at singularities that are missed by rounding

    def run(self, start: Array) -> Followed:
        """From the first pose on."""
        singular = missed_start(self.aim, self.poses[0], start)
        if singular is not None:
            left = self._leave_miss(singular)
            if left is not None:
                return self._walk(left)
        solved, arrived = self.aim.solve(self.poses[:1], start[None])
        if not arrived[0]:
            return Followed(start[None][:0], np.zeros(0), False, 1.0, start, "start", 0)
        joint = self._joint_beyond_limit(solved)
        if joint >= 0:
            return Followed(start[None][:0], np.zeros(0), False, 1.0, start, "limit", joint + 1)
        now, last = solved[0], len(self.poses) - 1.0
        if self.through and last > 0.0 and self._singular(now):
            now = self._turn_start(now)
        return self._walk(_BranchProgress(now, self._side(now)))

    def _leave_miss(self, singular: Array) -> _BranchProgress | None:
        """Straight away from a singularity (n,) that the first pose misses; None where that is not asked for, or no row
        ahead is straight on.
        """
        if self.tolerance is None or not self.decides or len(self.poses) < 2:
            return None
        rows = StraightCrossing(self.aim, self.poses, self.tolerance, self.limits).leave(singular)
        if rows is None:
            return None
        self.missed.update(rows.missed)
        progress = _BranchProgress(singular, 0.0)
        progress.keep(rows.place, rows.q, between=True, growth=_GROWING)
        progress.side = self._side(progress.now)
        return progress

    def _walk(self, progress: _BranchProgress) -> Followed:
        """From where a branch has begun to where it ends."""
        last = len(self.poses) - 1.0
        while progress.place < last:
            self._look_at_work(progress)
            if progress.spent or not self._take_step(progress, last):
                break
            progress.tries += 1
        return self._cut_at_miss(self._as_followed(progress, last))

    def _look_at_work(self, progress: _BranchProgress) -> None:
        """Note whether the work of one path is used up, or the branch creeps."""
        if progress.tries > 0 and progress.tries % _STALLED == 0:
            progress.creeps = self._creeps(progress)
            progress.seen = progress.place, progress.now
        most = _TRIES[0] + _TRIES[1] * len(self.poses)
        progress.spent = progress.creeps or progress.tries > most or progress.size > _ROWS

    def _creeps(self, progress: _BranchProgress) -> bool:
        """Whether the branch is where it was `_STALLED` tries before, and no nearer to a singularity, nor farther.

        Where it passes by a singularity, σ_r falls and rises by orders of magnitude while the joints hardly move, and
        between that they turn far, within fewer tries.
        """
        place, q = progress.seen
        moved = float(np.linalg.norm((progress.now - q) / self.aim.joints))
        if progress.place - place >= _ADVANCED or moved >= _STAYED:
            return False
        sigma = singular_values(self.aim.robot, np.stack([q, progress.now]), self.aim.task)[:, self.aim.rank - 1]
        return bool(sigma.max() <= _NO_NEARER * sigma.min())

    def _take_step(self, progress: _BranchProgress, last: float) -> bool:
        """Take one step or halve it, and return True; at the end of the branch, note why and return False."""
        step = None
        self.growth = _GROWING
        if progress.side != 0.0 or not self._singular(progress.now):
            ahead = progress.next_place(last)
            step = self._try_step(progress.now, progress.place, ahead, progress.side)
            progress.joint = self._stopping_joint(step)
            if (step is None or progress.joint >= 0) and progress.length >= _SHORTEST:
                progress.length = (ahead - progress.place) / 2
                return True
        heading = None
        if step is None:
            step, heading = self._step_from_singularity(progress)
            progress.joint = self._stopping_joint(step)
        if step is None or progress.joint >= 0:
            return False
        if self.passed and self.passed[-1].place == progress.place + 1.0 and not self.passed[-1].rest:
            progress.rows, progress.places, step = self._step_over_singularity(progress.rows, progress.places, step)
        progress.keep(*step, between=self.tolerance is not None, growth=self.growth)
        progress.heading = heading
        if progress.folds:
            return False
        if self.through:
            progress.side = self._side(progress.now)
        return True

    def _stopping_joint(self, step: tuple[Array, Array] | None) -> int:
        """First joint beyond its limit in a step; −1 for none, or without a step."""
        if step is None:
            return -1
        return self._joint_beyond_limit(step[1])

    def _as_followed(self, progress: _BranchProgress, last: float) -> Followed:
        """What was followed, and why it ended."""
        q, place = np.concatenate(progress.rows), np.concatenate(progress.places) + 1.0
        reason, sigma = "", np.inf
        if progress.place < last:
            sigma = float(singular_values(self.aim.robot, progress.now, self.aim.task)[self.aim.rank - 1])
            reason = self._reason(progress, sigma)
        passed = self.passed
        if reason == "singular":  # nobody has gone on from the singularity at which it ends
            passed = [point for point in passed if point.place < progress.place + 1.0 - _AT_END]
        return Followed(q, place, not reason, progress.place + 1.0, progress.now, reason, progress.joint + 1, sigma,
                        passed=tuple(passed), folds=progress.folds, turn=progress.turn)  # fmt: skip

    def _reason(self, progress: _BranchProgress, sigma: float) -> str:
        """Why a branch ended before the last pose."""
        if progress.turn is not None:
            return "turn"
        if progress.joint >= 0:
            return "limit"
        if progress.folds or sigma <= (_SINGULAR if self.decides else _SMALL):
            return "singular"
        if progress.creeps and sigma <= _CREPT_TO:
            return "singular"
        if progress.spent:
            return "budget"
        if self.aim.rank < self.aim.task.m:
            return "few joints"
        return "stuck"

    @property
    def decides(self) -> bool:
        """The local geometry at a singularity is asked for."""
        return self.through and self.aim.rank == self.aim.task.m

    def _singular(self, q: Array) -> bool:
        sigma = singular_values(self.aim.robot, q, self.aim.task)[self.aim.rank - 1]
        return self.decides and bool(sigma <= _SINGULAR)

    def _side(self, q: Array) -> float:
        """Sign of the determinant; 0 for arms that have none, and at a singularity that may be left."""
        if self._singular(q):
            return 0.0
        return self.aim.side(q)

    def _holds_poses(self, q: Array, poses: Array) -> Mask:
        """(N,) whether a configuration has the poses (N, 4, 4), to rounding."""
        rows = np.tile(q, (len(poses), 1))
        return np.asarray(np.linalg.norm(self.aim.error(poses, rows), axis=1) <= _SAME)

    def _turn_start(self, q: Array) -> Array:
        """A start at a singularity, brought to the nearest configuration of its self-motion from which the path goes on
        if that is very near.
        """
        moved = np.flatnonzero(~self._holds_poses(q, self.poses[1:]))
        if not len(moved):
            return q
        begins = float(moved[0])
        if departures(self.aim, self.poses, begins, q)[0]:
            return q
        end = internal_turn(self.aim, self.poses, begins, q, limits=self.limits)
        near = end is not None and np.linalg.norm((end - q) / self.aim.joints) <= _SNAPPED
        if end is not None and near:
            return end
        return q

    def _step_from_singularity(self, progress: _BranchProgress) -> tuple[tuple[Array, Array] | None, Array | None]:
        """From a configuration at or next to a singularity: a step ahead, and the direction of the solution curve at
        its end, where it was followed. Without a step, note whether the branch folds back, and the turn that it needs.
        """
        now, place = progress.now, progress.place
        following = int(place) + 1
        if self._holds_poses(now, self.poses[following : following + 1])[0]:
            return (np.array([float(following)]), now[None]), None
        sigma = singular_values(self.aim.robot, now, self.aim.task)[self.aim.rank - 1]
        if not self.decides or sigma > _SMALL:
            return None, None
        if sigma > _SINGULAR:
            across = self._step_across_miss(progress)
            if across is not None:
                return across, None
        if self.aim.square and (sigma > _SINGULAR or progress.heading is not None):
            move = StraightMove(self.aim, self.poses, place)
            move.seen_from(now)
            part = follow_curve(move, now, progress.heading)
            if part is not None:
                return self._step_along_curve(progress, move, part)
            if sigma > _SINGULAR:
                return None, None
        return self._step_by_geometry(progress, sigma), None

    def _step_across_miss(self, progress: _BranchProgress) -> tuple[Array, Array] | None:
        """Straight on over a singularity that lies on the branch, or next to it by as little as poses are rounded.

        Returns:
            Places and configurations of the rows ahead; None where no row ahead is straight on.
        """
        if self.tolerance is None or not self.aim.square:
            return None
        rows, places = np.concatenate(progress.rows), np.concatenate(progress.places)
        crossing = StraightCrossing(self.aim, self.poses, self.tolerance, self.limits)
        across = crossing.cross(rows, places, progress.place)
        if across is None:
            return None
        kept = across.behind + 1
        progress.rows, progress.places = [rows[:kept]], [places[:kept]]
        self.missed.update(across.missed)
        if across.place[-1] not in self.missed:
            self.passed.append(Passed(progress.place + _NEXT_TO + 1.0, rest=False))
        return across.place, across.q

    def _step_by_geometry(self, progress: _BranchProgress, sigma: float) -> tuple[Array, Array] | None:
        """As `_step_from_singularity`, by the local geometry of a singular configuration."""
        now, place = progress.now, progress.place
        ways, folds = departures(self.aim, self.poses, place, now)
        ways = self._sort_by_turn(progress, ways)
        for departure in ways:
            step = self._step_to_departure(now, place, departure)
            if step is not None and (self._joint_beyond_limit(step[1]) < 0 or departure is ways[-1]):
                self.passed.append(Passed(place + 1.0, departure.rest))
                return step
        progress.folds = folds and not ways
        if ways or folds or sigma > _SINGULAR:
            return None
        end = internal_turn(self.aim, self.poses, place, now, limits=self.limits)
        if end is not None:
            progress.turn = Turn(place + 1.0, now, end)
        return None

    def _step_along_curve(
        self, progress: _BranchProgress, move: StraightMove, part: CurvePart
    ) -> tuple[tuple[Array, Array] | None, Array | None]:
        """As `_step_from_singularity`, for a part of the solution curve that was followed from `progress.now`."""
        at, q = np.array([move.place_at(w) for w in part.w]), part.q
        progress.folds = part.folds
        if not len(at):
            return None, None
        count = self._count_within_limits(q)
        if count < len(q):
            at, q, progress.folds = at[:count], q[:count], False
        crossings = [crossing for crossing in part.crossings if move.place_at(crossing.w) <= at[-1]]
        at, q = np.append(progress.place, at), np.vstack([progress.now, q])
        step = self._join_rows(at, q)
        if step is None:  # a fold stands even where its last rows are too near to each other
            return None, None
        for crossing in crossings:
            if not crossing.rest:
                step = self._step_over_crossing(progress, at, q, crossing.q) or step
            self.passed.append(Passed(move.place_at(crossing.w) + 1.0, crossing.rest))
        if at[-1] == move.k + 1.0:
            return step, None
        return step, part.heading

    def _count_within_limits(self, q: Array) -> int:
        """How many of the first rows (K, n) keep the joint limits; 1 at least, so that the joint is known."""
        for k in range(len(q)):
            if self._joint_beyond_limit(q[k : k + 1]) >= 0:
                return max(1, k)
        return len(q)

    def _join_rows(self, at: Array, q: Array) -> tuple[Array, Array] | None:
        """Places after the first one, and configurations, from those (K,) and (K, n) of a solution curve."""
        pieces = []
        for k in range(len(at) - 1):
            off = float(np.linalg.norm((q[k + 1] - q[k]) / self.aim.joints))
            piece = self._fill_step(at[k : k + 2], q[k : k + 2], off)
            if piece is None:
                return None
            pieces.append(piece)
        return np.concatenate([piece[0] for piece in pieces]), np.concatenate([piece[1] for piece in pieces])

    def _step_over_crossing(
        self, progress: _BranchProgress, at: Array, q: Array, crossing: Array
    ) -> tuple[Array, Array] | None:
        """As `_join_rows`, without rows so near to a crossing that their rates are ill-conditioned, those before the
        first one too; None where no row leads over it.
        """
        near = np.linalg.norm((q - crossing) / self.aim.joints, axis=1) < _CLEAR
        near[-1] = False
        if not near[0]:
            return self._join_rows(at[~near], q[~near])
        rows, places = np.concatenate(progress.rows), np.concatenate(progress.places)
        far = np.flatnonzero(np.linalg.norm((rows - crossing) / self.aim.joints, axis=1) >= _CLEAR)
        base = int(far.max(initial=0))
        if int(places[base]) != int(progress.place):
            return None
        over = self._join_rows(np.append(places[base], at[~near]), np.vstack([rows[base], q[~near]]))
        if over is not None:
            progress.rows, progress.places = [rows[: base + 1]], [places[: base + 1]]
        return over

    def _sort_by_turn(self, progress: _BranchProgress, ways: list[Departure]) -> list[Departure]:
        """Departures, those first that go on in the direction in which the joints arrive; at the start those into the
        posture that people use.

        Where two solution curves cross at a singularity, a change from one to the other is a corner of the joint path
        within a straight move: the arm has to rest there.
        """
        arriving = progress.direction(self.aim.joints)
        if arriving is None:
            return self._sort_by_habit(ways)
        if not ways or ways[0].rest:
            return ways
        turned: list[tuple[float, Departure]] = []
        for departure in ways:
            leaving = (departure.q - progress.now) / self.aim.joints
            cosine = float(arriving @ leaving) / float(np.linalg.norm(leaving))
            corner = cosine < _STRAIGHT and progress.place > int(progress.place)
            turned.append((cosine, replace(departure, rest=corner)))
        turned.sort(key=lambda pair: -pair[0])
        return [departure for _, departure in turned]

    def _sort_by_habit(self, ways: list[Departure]) -> list[Departure]:
        """Departures, those first that lead into a usual posture."""
        if len(ways) < 2:
            return ways
        order = by_habit(self.aim.robot, self.aim.task, np.stack([departure.q for departure in ways]))
        return [ways[k] for k in order]

    def _step_over_singularity(
        self, rows: list[Array], places: list[Array], step: tuple[Array, Array]
    ) -> tuple[list[Array], list[Array], tuple[Array, Array]]:
        """Rows and places, and a step over a singularity.

        Rows so near to it that their rates are ill-conditioned are left out, where one step leads over them.
        """
        q, at, (ahead, ends) = np.concatenate(rows), np.concatenate(places), step
        away = np.linalg.norm((q - q[-1]) / self.aim.joints, axis=1)
        if (away >= _CLEAR).any():
            base = int(np.flatnonzero(away >= _CLEAR)[-1])
        else:
            base = 0
        if base == len(q) - 1 or int(at[base]) != int(at[-1]):
            return rows, places, step
        over = self._fill_step(np.array([at[base], ahead[-1]]), np.stack([q[base], ends[-1]]), _LONGEST)
        if over is None or self._joint_beyond_limit(over[1]) >= 0:
            return rows, places, step
        return [q[: base + 1]], [at[: base + 1]], over

    def _step_to_departure(self, now: Array, place: float, to: Departure) -> tuple[Array, Array] | None:
        """Places and configurations from a singular configuration to a departure."""
        at = np.append(np.arange(int(place) + 1.0, np.ceil(to.place - 1e-12)), to.place)
        off = float(np.linalg.norm((to.q - now) / self.aim.joints))
        return self._fill_step(np.append(place, at), np.stack([now, to.q]), off)

    def _cut_at_miss(self, followed: Followed) -> Followed:
        """The rows up to the first one whose forward kinematics misses its pose; else all of them."""
        good = self.aim.confirms(poses_at(self.poses, followed.place - 1.0), followed.q)
        good |= np.isin(followed.place - 1.0, list(self.missed))
        if good.all():
            return followed
        count = int(good.argmin())
        reached = float(followed.place[max(0, count - 1)])
        q = followed.q[:count]
        return Followed(q, followed.place[:count], False, reached, q[-1] if count else followed.last, "stuck")

    def _try_step(self, now: Array, place: float, ahead: float, side: float) -> tuple[Array, Array] | None:
        """Places (K,) after `place`, `ahead` the last, and configurations (K, n) there; None: too long a step."""
        target = poses_at(self.poses, np.array([ahead]))
        error = self.aim.error(target, now[None])
        if np.linalg.norm(error) > 1.0:  # Newton is not to be trusted so far
            return None
        ahead_of_now = guess = now + self.aim.step(now[None], error)[0]
        first = float(np.linalg.norm((guess - now) / self.aim.joints))
        if first > _LONGEST:
            return None
        guess = guess + self._null_space_pull(now, first)
        solved, arrived = self.aim.solve(target, guess[None])
        if not arrived[0]:
            return None
        end = solved[0]
        added = float(np.linalg.norm((end - guess) / self.aim.joints))
        bent = _BENT * first + _ROUNDING
        if added > bent or self._changes_side(end, side, touch=ahead == int(ahead) and first <= _TOUCH):
            return None
        at = np.append(np.arange(int(place) + 1.0, np.ceil(ahead - 1e-12)), ahead)
        self.growth = min(_GROWING, _KEPT * _LONGEST / max(first, 1e-12), _KEPT * bent / max(added, 1e-12))
        return self._fill_step(np.append(place, at), np.stack([now, end]), bent, ahead_of_now - end)

    def _changes_side(self, end: Array, side: float, *, touch: bool) -> bool:
        """The determinant changed its sign; with `touch` zero is no change for a branch that may go on from there."""
        if not self.aim.square:
            return False
        if self._singular(end):
            return not touch
        return self.aim.side(end) != side

    def _fill_step(
        self, at: Array, ends: Array, off: float, bend: Array | None = None
    ) -> tuple[Array, Array] | None:
        """Places and configurations of one step, solved from guesses between its ends, none farther than `off` from
        its guess.

        With a tolerance more places are put in until the tip keeps it between all of them.

        Args:
            at: places, those of the ends first and last.
            ends: (2, n) configurations there.
            off: how far a guess may be off [rad; slides scaled].
            bend: (n,) from the second end to where the tangent at the first one leads: guesses are on the parabola
                with that tangent; None: they are on a straight line.
        """
        known, q = at[[0, -1]], ends
        for _ in range(_FILLS):
            line = np.stack([np.interp(at, known, column) for column in q.T], axis=1)
            if bend is not None:
                share = (at - at[0]) / (at[-1] - at[0])
                line += (share * (1.0 - share))[:, None] * bend
                bend = None
            solved, reached = self.aim.solve(poses_at(self.poses, at), line)
            apart = np.linalg.norm((solved - line) / self.aim.joints, axis=1)
            if not reached.all() or (apart > off).any():
                return None
            solved[0], known, q = ends[0], at, solved
            if self.tolerance is None:
                return at[1:], q[1:]
            away, turned = self.aim.deviation(q, poses_at(self.poses, at))
            wide = np.maximum(away / self.tolerance[0], turned / self.tolerance[1])
            if (wide <= 1.0).all():
                return at[1:], q[1:]
            parts = np.where(wide > 1.0, np.clip(np.ceil(np.sqrt(_SPARE * wide)), 2, _PARTS), 1).astype(np.int64)
            if int(parts.sum()) > _PUT_IN:  # the step is halved instead
                return None
            k, part = number_parts(parts)
            at = np.append(known[k] + part / parts[k] * (known[k + 1] - known[k]), known[-1])
        return None

    def _null_space_pull(self, now: Array, length: float) -> Array:
        """(n,) the part of the pull in the null space, for a step of some length."""
        if self.pull is None:
            return np.zeros_like(now)
        joints = self.aim.joints
        _, _, v = _core.svd(np.ascontiguousarray(self.aim.jacobian(now[None])))
        null = v[0][:, self.aim.rank :]
        return np.asarray(length * joints * (null @ (null.T @ (self.pull(now) / joints))))

    def _joint_beyond_limit(self, q: Array) -> int:
        """First joint beyond its limit in any row; −1 for none, or where limits do not count."""
        if self.limits:
            return first_joint_beyond_limit(self.aim.robot, q)
        return -1
