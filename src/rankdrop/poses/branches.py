"""`inverse`: the configurations of an arm at one pose of the tip, each confirmed by forward kinematics.

Damped Newton's method from random starts finds solutions (`poses.inverse`); the starts are drawn in batches until
several batches in a row find nothing new. Solutions are isolated, or they form continua: curves and surfaces of
configurations along which the tool stands still. A redundant arm has these at every pose, any arm may at a singular
one. At a configuration with null motions N of J the dimension is the number of independent displacements that remain

    q′ − q,   q′ = the solution next to q + δ N w,

and a curve is followed by such steps until it closes, ends, or its budget is spent. Not finding a solution proves
nothing; how the search was made is part of the result.

Where there is no solution, ‖W e(q)‖ is minimised with Levenberg's method, which says how far the pose is out of reach:
its position alone; its position with the orientation kept; its orientation with the position kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.codec import Result
from rankdrop.configuration import configuration_at
from rankdrop.errors import ConfigurationError
from rankdrop.kinematics import check_robot
from rankdrop.kinematics import pose as pose_of
from rankdrop.local.block import joint_scale, sampling_box, singular_values
from rankdrop.local.pointing import TILTED, level_task, tilt_is_fixed, tilts_off
from rankdrop.options import takes
from rankdrop.poses.inverse import Aim, distinct, joint_difference, within_limits, wrap_joints
from rankdrop.poses.postures import posture_names
from rankdrop.problem import into_limits
from rankdrop.questions import ExplainOptions, InverseOptions
from rankdrop.results.explanation import Explanation
from rankdrop.results.known import known_families
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.transform import as_numbers, from_xyz_rpy, nearest_rotation
from rankdrop.sections import Section
from rankdrop.task import Task, resolve_task
from rankdrop.text.inverse import inverse_sections, inverse_sentence
from rankdrop.tolerances import DEFAULT

POSITION, ORIENTATION, JOINTS, TILT = "position", "orientation", "joints", "tilt"
"""Why a pose has no solution: its position is out of reach; it is in reach, but not with this orientation; the arm has
too few joints to give every orientation; no joint tilts the tool, and the pose is tilted."""
_BATCH, _QUIET, _LIMIT = 256, 3, 8  # starts at a time; batches without news at the end; most starts, in `starts`
_SINGULAR = 1e-5  # σ_r below which a solution counts as singular: pairs of solutions cannot be separated there
_SAME = 1e-6  # regular solutions nearer to each other are one [rad; slides scaled]; singular ones, `_STEP`
_NEWS = 0.5  # a singular solution nearer to a known one is no news: it is on the same curve, or ends there [rad]
_PROBE = 0.02  # δ of a displacement that may leave the tool still [rad]
_STEP, _STEPS = 0.08, 500  # along a curve [rad]; steps each way
_ENOUGH = 8  # singular solutions looked at where one of them is on a surface
_INWARDS = 20  # projections of the points of a surface into the joint limits
_CURVES = 64  # curves that are followed at most
_JUDGED = 64  # branches whose verdict is computed by a search; beyond, by σ alone
_LEAST_STARTS, _ROUNDS, _HEAVY = 128, 150, 1e3  # of Levenberg's method; weight of what is kept
_NONE = 1e-5  # of what is kept: what may be missing [rad; lengths divided by the length scale]
_QUATERNION = 1e-3  # a quaternion's length may be off by this: digits of a file
_UNREACHED = 1e-6  # a distance below it is none [length scales]


@dataclass(frozen=True, eq=False)
class Branch:
    """One isolated configuration at the pose.

    Attributes:
        q: (n,) [rad, m]; turning joints between their limits where a whole turn brings them there.
        verdict: "regular", "near" or "singular", as `explain` gives it.
        sigma: σ_r [1].
        posture: signs of the parts of the arm, such as "elbow +"; empty where none are known.
        beyond: joints (from 1) outside their limits, each with how far [rad, m].
        residual: the largest entry of the difference between the pose of q and the pose asked for [m, 1].
    """

    q: Array
    verdict: str
    sigma: float
    posture: tuple[str, ...]
    beyond: tuple[tuple[int, float], ...]
    residual: float


@dataclass(frozen=True, eq=False)
class Continuum:
    """A self-motion: connected configurations along which the tool stands still.

    Attributes:
        q: (n,) a configuration on it, inside the joint limits and away from singularities where one was found.
        dimension: 1 for a curve, 2 for a surface.
        closed: a curve that comes back to its start.
        complete: a curve that was followed to its closing or to both of its ends.
        singular: every configuration of it is singular.
        lowest, highest: (n,) of the joints along the curve that was followed [rad, m], counted on through whole turns.
        inside: share of the curve inside the joint limits; of a surface, share of its points that were found.
        beyond, residual: as of a `Branch`.
    """

    q: Array
    dimension: int
    closed: bool
    complete: bool
    singular: bool
    lowest: Array
    highest: Array
    inside: float
    beyond: tuple[tuple[int, float], ...]
    residual: float


@dataclass(frozen=True, eq=False)
class Unreached:
    """How far a pose without solution is from poses that the arm reaches, joint limits ignored.

    Attributes:
        kind: `POSITION`, `ORIENTATION`, `JOINTS` or `TILT`.
        position: least distance of the tip from the position, whatever the orientation [m].
        shift: … with the orientation kept [m]; None where the arm does not make it.
        turn: least angle of the tool from the orientation, the position kept [rad]; None where it is not reached. Of
            `TILT` the angle between the tilt of the pose and that of the tool.
        tip: (4, 4) the reachable pose of the least distance: with the orientation kept where the arm makes it.
        turned: (4, 4) the reachable pose of the least angle; None where there is none.
    """

    kind: str
    position: float
    shift: float | None
    turn: float | None
    tip: Array
    turned: Array | None


@dataclass(frozen=True, eq=False)
class InverseSolutions(Result):
    """The solutions that were found, how they were searched, and why there is none.

    Attributes:
        robot, task, options: what was asked.
        pose: (4, 4) of the tip in the base frame [m].
        branches: isolated solutions, those inside the joint limits first, then the nearest to q = 0.
        continua: self-motions.
        most: the number that no such arm exceeds: 16 for six turning joints and a full pose; None where none is stated.
        starts: starts of Newton's method.
        arrived: how many of them ended on a solution.
        more: there may be self-motions that are not listed: beyond a number of curves, or next to a surface.
        unreached: why there is no solution; None where there is one.
    """

    robot: Robot
    task: Task
    options: InverseOptions
    pose: Array
    branches: tuple[Branch, ...]
    continua: tuple[Continuum, ...]
    most: int | None
    starts: int
    arrived: int
    more: bool
    unreached: Unreached | None
    FILE: ClassVar[str] = "inverse"

    @property
    def inside(self) -> int:
        """How many solutions and self-motions have a place inside the joint limits."""
        return sum(not branch.beyond for branch in self.branches) + sum(not branch.beyond for branch in self.continua)

    @property
    def residual(self) -> float:
        """The largest of all."""
        every = [branch.residual for branch in self.branches] + [branch.residual for branch in self.continua]
        return max(every, default=0.0)

    @property
    def sentence(self) -> str:
        """How many solutions there are, or why there is none."""
        return inverse_sentence(self)

    def sections(self, *, deg: bool = False) -> tuple[Section, ...]:
        """For people: the count first, then a table of the solutions, then how they were searched."""
        return inverse_sections(self, deg=deg)


def _unit_quaternion(given: Array) -> Array:
    """A quaternion (4,) of unit length to rounding, divided by its length.

    Raises:
        ConfigurationError: it has another length.
    """
    length = float(np.linalg.norm(given))
    if abs(length - 1.0) <= _QUATERNION:
        return np.asarray(given / length)
    mend = None
    if length > _QUATERNION:
        mend = f"write {','.join(f'{value:.9g}' for value in given / length)}"
    raise ConfigurationError("the quaternion has no unit length", where="pose", got=f"length {length:.6g}",
                             allowed="qx² + qy² + qz² + qw² = 1", mend=mend)  # fmt: skip


def matrix_of(pose: ArrayLike) -> Array:
    """(4, 4) the pose that numbers write.

    Args:
        pose: a (4, 4) matrix; x, y, z; x, y, z, roll, pitch, yaw with R = Rz(yaw) Ry(pitch) Rx(roll); or
            x, y, z, qx, qy, qz, qw [m, rad], in the base frame.

    Raises:
        ConfigurationError: neither of these, not finite, no rotation, or no unit quaternion.
    """
    given = as_numbers(pose, "pose", ConfigurationError)
    forms = "a (4, 4) matrix; x,y,z; x,y,z,roll,pitch,yaw; or x,y,z,qx,qy,qz,qw [m, rad]"
    if given.shape not in ((4, 4), (3,), (6,), (7,)):
        raise ConfigurationError("this is no pose", where="pose", got=f"shape {given.shape}", allowed=forms)
    if not np.isfinite(given).all():
        raise ConfigurationError("the pose is not finite", where="pose", got=given.tolist(), allowed=forms)
    if given.shape == (7,):
        x, y, z, w = _unit_quaternion(given[3:])
        made = np.eye(4)
        made[:3, 3] = given[:3]
        k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        made[:3, :3] += 2 * w * k + 2 * k @ k
        return made
    if given.ndim == 1:
        return from_xyz_rpy(given[:3].tolist(), given[3:].tolist() or [0.0, 0.0, 0.0])
    turn = given[:3, :3]
    off = float(np.abs(turn @ turn.T - np.eye(3)).max())
    if off > 1e-6 or np.linalg.det(turn) < 0.0 or np.abs(given[3] - (0, 0, 0, 1)).max() > 1e-12:
        raise ConfigurationError("the pose is no rotation with a translation", where="pose", got=given.tolist(),
                                 allowed="[R p; 0 0 0 1]")  # fmt: skip
    made = given.copy()
    made[:3, :3] = nearest_rotation(turn)
    return made


@takes(InverseOptions)
def inverse(
    robot: Robot,
    pose: ArrayLike,
    task: Task | str | None = None,
    *,
    options: InverseOptions | None = None,
    **given: Any,
) -> InverseSolutions:
    """Find the configurations of an arm at a pose of the tip: all branches, or why there is none.

    Newton's method runs from random starts until several batches of them find nothing new. Each solution is confirmed
    by forward kinematics to 1e-9. That every solution is found is not proven. Joint limits do not restrict the search:
    each solution says which joints exceed theirs.

    Args:
        robot: the arm.
        pose: of the tip in the base frame: (4, 4); x, y, z, roll, pitch, yaw; or x, y, z, qx, qy, qz, qw [m, rad]. Of
            x, y, z alone the orientation is that of the base. What the task leaves free is ignored, but for the tilt of
            a tool that no joint tilts.
        task: name, rows or Task; None is the task the arm is made for.
        options: starts and seed; its fields are taken as keywords as well.

    Returns:
        Isolated solutions with verdict, posture and joint limits; self-motions with their dimension; how far the pose
        is out of reach where there is none.

    Raises:
        ConfigurationError: this is no pose.
        OptionError: an option outside what is allowed.
        TaskError: no such task, or the pose does not determine what it wants.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = inverse(open_robot("puma560"), [0.3, 0.2, 0.4, 0.0, 1.2, 0.4])
        >>> len(found.branches), found.most, found.residual < 1e-9
        (8, 16, True)
        >>> inverse(open_robot("puma560"), [3, 0, 0, 0, 0, 0]).unreached.kind
        'position'
    """
    check_robot(robot)
    how = InverseOptions.of(options, given)
    resolved = resolve_task(task, robot)
    goal = matrix_of(pose)
    aim = Aim(robot, resolved)
    search = _Search(aim, resolved, goal)
    tilted = _tilt_missing(search, how)
    if tilted is not None:
        return InverseSolutions(
            robot, resolved, how, goal, (), (), _most(robot, resolved), search.tried, search.arrived, False, tilted
        )
    search.run(how)
    isolated, curves, more = search.isolated_and_curves()
    branches = _judge_solutions(search, isolated)
    return InverseSolutions(
        robot, resolved, how, goal, branches, curves, _most(robot, resolved), search.tried, search.arrived, more,
        None if branches or curves else _why_unreached(search, how),
    )  # fmt: skip


def _most(robot: Robot, task: Task) -> int | None:
    """16 for six turning joints and a full pose: Lee and Liang 1988, attained by Manseur and Doty 1989."""
    turning = all(joint.kind is not JointKind.PRISMATIC for joint in robot.joints)
    if robot.n == len(robot.joints) == task.m == 6 and turning:
        return 16
    return None


@dataclass(frozen=True, eq=False)
class Curve:
    """A self-motion as it was followed.

    Attributes:
        points: (K, n) configurations in order, some 0.08 rad apart, angles counted on through whole turns [rad, m].
        closed: the last point is next to the first one.
        complete: it was followed to its closing or to both of its ends.
    """

    points: Array
    closed: bool
    complete: bool


def self_motion_curves(
    robot: Robot, pose: ArrayLike, task: Task | str | None = None, *, options: InverseOptions | None = None
) -> tuple[tuple[Curve, ...], bool]:
    """Curves of configurations along which the tool stands still at a pose, joint limits ignored.

    Args:
        robot, pose, task, options: as of `inverse`.

    Returns:
        The curves, and whether there may be more. No curve where the self-motions are surfaces: an arm with two joints
        to spare, or more.

    Raises:
        ConfigurationError, OptionError, TaskError: as `inverse`.
    """
    check_robot(robot)
    resolved = resolve_task(task, robot)
    search = _Search(Aim(robot, resolved), resolved, matrix_of(pose))
    search.run(options or InverseOptions())
    _, _, more = search.isolated_and_curves()
    return tuple(search.curves), more


class _Piece(NamedTuple):
    """A solution on a self-motion.

    Attributes:
        q: (n,) [rad, m].
        dimension: of the self-motion.
        singular: σ_r is zero at q.
    """

    q: Array
    dimension: int
    singular: bool


@dataclass(eq=False)
class _Search:
    """Solutions of one pose as they are found."""

    aim: Aim
    task: Task
    goal: Array
    tried: int = 0
    arrived: int = 0

    def __post_init__(self) -> None:
        self.robot = self.aim.robot
        self.scale = joint_scale(self.robot, self.task)
        self.curves: list[Curve] = []
        self.regular = np.empty((0, self.robot.n))
        self.singular = np.empty((0, self.robot.n))

    @property
    def redundant(self) -> bool:
        """Regular solutions form continua."""
        return self.robot.n > self.aim.rank

    def run(self, how: InverseOptions) -> None:
        """Batches of random starts, inside the joint limits and outside in turn, until there is no news."""
        boxes = [sampling_box(self.robot, self.task, limits=limits) for limits in (False, True)]
        rng = np.random.default_rng(how.seed)
        quiet = 0
        while self.tried < how.starts or (quiet < _QUIET and self.tried < _LIMIT * how.starts and not self.redundant):
            low, high = boxes[(self.tried // _BATCH) % 2]
            if self.tried == 0:
                size = min(_BATCH, how.starts)
            else:
                size = _BATCH
            if self.redundant and self.tried >= how.starts // 4:  # every start finds a new point of the same curves
                break
            news = self._take(rng.uniform(low, high, (size, self.robot.n)))
            self.tried += size
            quiet = 0 if news else quiet + 1

    def _take(self, starts: Array) -> bool:
        """Whether some of the starts led to new solutions."""
        found = self.aim.solve_from(self.goal, starts)
        self.arrived += len(found)
        if not len(found):
            return False
        targets = np.broadcast_to(self.goal, (len(found), 4, 4))
        polished, arrived = self.aim.solve(targets, found)
        found = wrap_joints(self.robot, np.where(arrived[:, None], polished, found))
        found = found[self.aim.confirms(targets, found)]
        weak = self.sigma(found) <= _SINGULAR
        near = _STEP if self.redundant else _SAME
        regular = distinct(self.robot, self.task, found[~weak], near, self.regular)
        apart_from_all = distinct(self.robot, self.task, found[weak], _NEWS, self.singular)
        singular = distinct(self.robot, self.task, found[weak], _STEP, self.singular)
        self.regular = np.concatenate([self.regular, regular])
        self.singular = np.concatenate([self.singular, singular])
        return len(regular) + len(apart_from_all) > 0

    def sigma(self, q: Array) -> Array:
        """(N,) σ_r, r the generic rank."""
        if not len(q):
            return np.empty(0)
        return np.asarray(singular_values(self.robot, q, self.task)[:, self.aim.rank - 1])

    def isolated_and_curves(self) -> tuple[Array, tuple[Continuum, ...], bool]:
        """Isolated solutions (k, n), self-motions, and whether some were not followed."""
        isolated, pieces = self._by_freedom()
        surface = max(pieces, key=lambda piece: piece.dimension, default=None)
        if surface is not None and surface.dimension > 1:  # surfaces are not separated, nor what is connected with them
            q, dimension, singular = surface
            same = [piece.q for piece in pieces if piece.dimension == dimension and piece.singular == singular]
            points = self._inwards(np.array(same))
            return isolated, (self._continuum(q, dimension, points, False, False, singular),), True
        found, more = self._follow_curves(pieces)
        found.sort(key=lambda continuum: (bool(continuum.beyond), not continuum.closed))
        alone = [not self._on_a_curve(q) for q in isolated]
        return isolated[alone], tuple(found), more

    def _inwards(self, points: Array) -> Array:
        """Points (N, n) of a surface, and where none of them is inside the joint limits, those towards the limits.

        Alternating projections: to the limits joint by joint, and by Newton's method back to the pose.
        """
        now = into_limits(self.robot, points)
        kept = now
        for _ in range(_INWARDS):
            if within_limits(self.robot, kept).any() or not len(now):
                break
            found, arrived = self.aim.solve(self.goal[None], np.clip(now, self.robot.lower, self.robot.upper))
            now = into_limits(self.robot, found[arrived])
            kept = np.concatenate([kept, now])
        return kept

    def _by_freedom(self) -> tuple[Array, list[_Piece]]:
        """Isolated solutions (k, n), and those on a self-motion; of a surface not all that were found."""
        isolated: list[Array] = [np.empty((0, self.robot.n))]
        pieces: list[_Piece] = []
        if self.redundant:
            pieces = [_Piece(q, self.robot.n - self.aim.rank, False) for q in self.regular]
        else:
            isolated.append(self.regular)
        for row, q in enumerate(self.singular):
            if row >= _ENOUGH and any(piece.dimension > 1 for piece in pieces):
                break
            dimension = self._freedom(q)
            if dimension:
                pieces.append(_Piece(q, dimension, True))
            else:
                isolated.append(q[None])
        return np.concatenate(isolated), pieces

    def _follow_curves(self, pieces: Sequence[_Piece]) -> tuple[list[Continuum], bool]:
        """The curves through solutions, and whether some were not followed: there are more than `_CURVES`."""
        found: list[Continuum] = []
        for q, _, singular in pieces:
            if self._on_a_curve(q):
                continue
            if len(self.curves) == _CURVES:
                return found, True
            points, closed, complete = self._curve(q)
            self.curves.append(Curve(points, closed, complete))
            found.append(self._continuum(q, 1, points, closed, complete, singular))
        return found, False

    def _on_a_curve(self, q: Array) -> bool:
        return any(self._lies_on(q, curve.points) for curve in self.curves)

    def _lies_on(self, q: Array, points: Array) -> bool:
        gap = np.linalg.norm(joint_difference(self.robot, q, points) / self.scale, axis=1)
        return bool(gap.min() <= 1.5 * _STEP)

    def _null(self, q: Array) -> Array:
        """(k, n) orthonormal null motions of scaled joints."""
        _, sigma, vt = np.linalg.svd(self.aim.jacobian(q[None])[0])
        return np.asarray(vt[int((sigma > _SINGULAR).sum()) :])

    def _next_solution(self, q: Array, guess: Array, step: float, off_at_most: float) -> Array | None:
        """The solution next to a guess a step away from q; None where the tool does not stand still along it."""
        found, arrived = self.aim.solve(self.goal[None], guess[None])
        off = float(np.linalg.norm((found[0] - guess) / self.scale))
        gone = float(np.linalg.norm((found[0] - q) / self.scale))
        good = arrived[0] and off <= off_at_most * step and gone >= step / 4
        if good:
            return np.asarray(found[0])
        return None

    def _freedom(self, q: Array) -> int:
        """Dimension of the self-motion through q."""
        null = self._null(q)
        if not len(null):
            return 0
        rng = np.random.default_rng(0)
        if len(null) > 1:
            mixed = rng.normal(size=(4 * len(null), len(null)))
        else:
            mixed = np.ones((1, 1))
        ways = np.concatenate([np.eye(len(null)), mixed]) @ null
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        moved = []
        for way in (*ways, *(-ways)):
            end = self._next_solution(q, q + _PROBE * way * self.scale, _PROBE, 1.0)
            if end is not None:
                moved.append((end - q) / self.scale / _PROBE)
        if not moved:
            return 0
        size = np.linalg.svd(np.array(moved), compute_uv=False)
        return int((size > 0.1 * size[0]).sum())

    def _curve(self, q: Array) -> tuple[Array, bool, bool]:
        """(K, n) points along a curve, whether it is closed, and whether it was followed to its ends."""
        first = self._null(q)[0]
        parts: list[list[Array]] = []
        complete = True
        for way in (first, -first):
            now, heading, points = q, way, list[Array]()
            for count in range(_STEPS):
                null = self._null(now)
                along = null.T @ (null @ heading)
                size = float(np.linalg.norm(along))
                if size < 0.5:
                    end = None
                else:
                    end = self._next_solution(now, now + _STEP * along / size * self.scale, _STEP, 1 / 3)
                if end is None:
                    break
                heading = (end - now) / self.scale
                heading = heading / np.linalg.norm(heading)
                now = end
                points.append(now)
                back = float(np.linalg.norm(joint_difference(self.robot, q, now[None])[0] / self.scale))
                if count > 2 and back <= 0.6 * _STEP and heading @ way > 0.0:
                    return np.array([q, *points]), True, True
            else:
                complete = False
            parts.append(points)
        return np.array([*parts[1][::-1], q, *parts[0]]), False, complete

    def _continuum(
        self, q: Array, dimension: int, points: Array, closed: bool, complete: bool, singular: bool
    ) -> Continuum:
        """The facts of a self-motion, shown at its best configuration."""
        placed = into_limits(self.robot, wrap_joints(self.robot, points))
        outside = _beyond_limits(self.robot, placed).max(axis=1, initial=0.0)
        inside = outside <= 0.0
        best = np.lexsort((-self.sigma(points), outside))[0]
        return Continuum(
            placed[best], dimension, closed, complete, singular, points.min(axis=0), points.max(axis=0),
            float(inside.mean()), _joints_beyond(self.robot, placed[best]), self.residual(points),
        )  # fmt: skip

    def residual(self, q: Array) -> float:
        """Largest difference in what the task asks for [m, 1]."""
        away, chord = self.aim.missing(np.broadcast_to(self.goal, (len(q), 4, 4)), q)
        if self.aim.heading is not None:
            chord = np.abs(self.aim.error(self.goal, q)[:, -1])
        return float(max(away.max(initial=0.0), chord.max(initial=0.0)))


def _beyond_limits(robot: Robot, q: Array) -> Array:
    """(N, n) how far each joint is beyond its limits, with a sign; 0 inside [rad, m]."""
    high = np.maximum(q - robot.upper - 1e-9, 0.0)
    low = np.maximum(robot.lower - q - 1e-9, 0.0)
    return np.asarray(np.maximum(high, low))


def _joints_beyond(robot: Robot, q: Array) -> tuple[tuple[int, float], ...]:
    amounts = _beyond_limits(robot, q[None])[0]
    return tuple((int(i) + 1, float(amounts[i])) for i in np.flatnonzero(amounts > 0.0))


def _judge_solutions(search: _Search, q: Array) -> tuple[Branch, ...]:
    """Isolated solutions with verdict, posture and limits, in order."""
    robot, task = search.robot, search.task
    q = into_limits(robot, q)
    sigma = search.sigma(q)
    postures = posture_names(robot, task, q)
    if len(q):
        families, source = known_families(robot, task, None, DEFAULT)
    else:
        families, source = ((), "")
    made: list[Branch] = []
    for row in range(len(q)):
        verdict = "singular"
        if sigma[row] > _SINGULAR:
            how = ExplainOptions(evaluations=0)
            if sigma[row] > how.small:
                verdict = "regular"
            else:
                verdict = "near"
            if row < _JUDGED:
                verdict = str(Explanation(configuration_at(robot, q[row], task), families, source, how).verdict)
        made.append(Branch(q[row], verdict, float(sigma[row]), postures[row], _joints_beyond(robot, q[row]),
                           search.residual(q[row : row + 1])))  # fmt: skip
    home = np.clip(np.zeros(robot.n), robot.lower, robot.upper)

    def order(branch: Branch) -> tuple[bool, float]:
        return bool(branch.beyond), round(float(np.linalg.norm((branch.q - home) / search.scale)), 6)

    return tuple(sorted(made, key=order))


def _tilt_missing(search: _Search, how: InverseOptions) -> Unreached | None:
    """How far the pose is tilted, where an arm that never tilts its tool is asked for yaw; else None."""
    aim, robot, goal = search.aim, search.robot, search.goal
    never = tilt_is_fixed(robot, search.task) or level_task(robot, search.task) is not None
    if not never:
        return None
    off = float(tilts_off(robot, goal[None])[0])
    if off <= TILTED:
        return None
    weights = np.where(np.array(aim.rows) < 3, 1.0, 0.0)
    near = _nearest(aim, goal, weights, _descent_starts(search, how))
    tip = pose_of(robot, near)
    position = float(np.linalg.norm(tip[:3, 3] - goal[:3, 3]))
    return Unreached(TILT, position, None, off, tip, None)


def _descent_starts(search: _Search, how: InverseOptions) -> Array:
    """(S, n) random configurations, joint limits ignored."""
    low, high = sampling_box(search.robot, search.task, limits=False)
    return np.random.default_rng(how.seed).uniform(low, high, (_LEAST_STARTS, search.robot.n))


def _why_unreached(search: _Search, how: InverseOptions) -> Unreached:
    """How far the pose is from those that the arm reaches."""
    aim, robot, goal = search.aim, search.robot, search.goal
    rows = np.array(aim.rows)
    moves = rows < 3
    starts = _descent_starts(search, how)

    def least(position: float, turning: float) -> tuple[float, float, Array]:
        """Least distance [length scales] and angle [rad] with these weights, and where."""
        q = _nearest(aim, goal, np.where(moves, position, turning), starts)
        error = aim.error(goal, q[None])[0]
        return float(np.linalg.norm(error[moves])), float(np.linalg.norm(error[~moves])), q

    if moves.any():
        position, _, near = least(1.0, 0.0)
    else:
        position, _, near = (0.0, 0.0, starts[0])
    shift = turn = None
    tip, turned = pose_of(robot, near), None
    if moves.any() and not moves.all():
        away, angle, q = least(1.0, _HEAVY)
        if angle <= _NONE:
            shift, tip = away * aim.length, pose_of(robot, q)
        away, angle, q = least(_HEAVY, 1.0)
        if away <= _NONE:
            turn, turned = angle, pose_of(robot, q)
    elif moves.all():
        shift = position * aim.length
    else:
        _, turn, q = least(0.0, 1.0)
        turned = pose_of(robot, q)
    if position > _UNREACHED:
        kind = POSITION
    elif aim.rank < search.task.m:
        kind = JOINTS
    else:
        kind = ORIENTATION
    return Unreached(kind, position * aim.length, shift, turn, tip, turned)


def _nearest(aim: Aim, goal: Array, weights: Array, starts: Array) -> Array:
    """(n,) the configuration with the least ‖W e‖ of those that Levenberg's method ends at."""
    q = starts.copy()
    error = aim.error(goal, q) * weights
    cost = (error * error).sum(axis=1)
    size = float(weights.max()) ** 2
    damping = np.full(len(q), 1e-2 * size)
    for _ in range(_ROUNDS):
        j = aim.jacobian(q) * weights[:, None]
        square = j.swapaxes(1, 2) @ j + damping[:, None, None] * np.eye(q.shape[1])
        step = np.linalg.solve(square, j.swapaxes(1, 2) @ error[:, :, None])[:, :, 0]
        length = np.linalg.norm(step, axis=1)
        step *= np.minimum(1.0, 0.5 / np.maximum(length, 1e-300))[:, None]
        tried = q + step * aim.joints
        new = aim.error(goal, tried) * weights
        now = (new * new).sum(axis=1)
        better = now < cost
        q[better], error[better], cost[better] = tried[better], new[better], now[better]
        damping = np.clip(np.where(better, damping / 4, damping * 4), 1e-12 * size, 1e12 * size)
    return np.asarray(q[int(cost.argmin())])
