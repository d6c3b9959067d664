"""The inverse of an arm: poses solved by Newton's method, from near and from far; tool paths followed on one branch.

    e(q) = (p* − p ; log(R* Rᵀ)), the rows of the task, translations divided by the length scale

    from near  q ← q + J⁺ e
    from far   q ← q + Jᵀ(J Jᵀ + λ)⁻¹ e,  λ = |e|²

A solution that no start leads to is missed: a list is what was found. What is found is a solution, to rounding.

Between two poses of a tool path the tip goes straight and turns about one axis at a constant rate, as a linear move of
a controller does. It is followed by steps from near. A step counts only where the corrector has little left to correct,
where no joint motion is long, and where no determinant changes its sign; otherwise it is halved, so that the branch is
kept up to the singularity or the limit at which it ends. Poses passed over by a step are filled in from a straight
guess between its ends, all at once, and polished to rounding. With a tolerance rows are put in until the tip is proven
to stay within it of its curve while the joints go straight from row to row (`Aim.deviation`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from rankdrop import _core
from rankdrop.errors import TaskError
from rankdrop.kinematics import chain_of, one_configuration, task_jacobian, task_view
from rankdrop.local.block import generic_rank, joint_scale, sample, singular_values
from rankdrop.local.departure import unlocked
from rankdrop.local.orientation import rotation_vector
from rankdrop.motion.curve import Index, numbered
from rankdrop.problem import Mask, into_limits, whole_turns
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.numbers import anchors
from rankdrop.robot.transform import hat
from rankdrop.task import BASE, TIP, WORLD_ALIGNED, Frame, Task, link_index, resolve_task
from rankdrop.text.paths import branch_chosen

Pull = Callable[[Array], Array]
"""pull(q) -> (n,) wanted joint motion per unit length of joint motion; its part in the null space is followed."""

_GOAL, _ACCEPTED = 1e-14, 1e-11  # of an error: rounding, and what is still taken for none
_ROUNDS, _ITERATIONS = 10, 60  # from near, and from far
_CAP = 0.5  # of a step from far [rad; slides scaled]: a quarter of the way between neighbouring solutions
_WEAK = 1e-9  # σ below which Newton leaves a direction alone
_SAME = 1e-6  # solutions nearer than this are one [rad]
_REGULAR = 1e-5  # σ_r of a solution that counts: nearer to the singular set pairs of solutions cannot be separated
_CONFIRMED = 1e-9  # by which forward kinematics may miss the pose of a solution [m and chord]
_TURNED_OVER = 1e-9  # of 1 + cos of the tilt: the heading of a tool that is turned over is undefined
_FULL = (0, 1, 2, 3, 4, 5)
_ROUNDED = 1e-12  # share of the links' length that rounding may add
_LONGEST = 0.15  # of a step in joint space [rad; slides divided by the length scale]
_BENT = 0.2  # share of a step that the corrector may add to the predictor
_SHORTEST = 1e-9  # step at which the branch has ended [of the way between two poses]
_TRIES = (400, 1)  # steps at most, and for each pose: a branch that creeps along a singularity ends
_MOST = 4096  # poses passed over by one step
_ROWS = 400_000  # at most
_FILLS, _PARTS = 8, 64  # of putting rows in within one step, and of one piece in one round
_PUT_IN = 20_000  # rows of one step; a bound that does not fall with them would ask for more and more
_SPARE = 1.1  # rows are put in for a bound so many times tighter
_SMALL = 1e-2  # σ_r at the end of a branch below which a singularity is named as its reason


def rotation(turn: Array) -> Array:
    """(N, 3, 3) rotations by vectors (N, 3), Rodrigues' formula."""
    angle = np.linalg.norm(turn, axis=1)
    safe = np.where(angle > 0.0, angle, 1.0)
    k = hat(turn / safe[:, None])
    return np.asarray(np.eye(3) + np.sin(angle)[:, None, None] * k + (1.0 - np.cos(angle))[:, None, None] * (k @ k))


class Aim:
    """Newton's method towards poses of the tip: what is missing, and the steps.

    Args:
        robot: the arm.
        task: from `resolve_task`, determined by the pose of the tip.

    Raises:
        TaskError: the pose of the tip does not determine what the task wants.
    """

    def __init__(self, robot: Robot, task: Task) -> None:
        last = len(robot.joints) + 1
        whole = task.rows == _FULL  # all six stand still, whatever their axes and their point
        axes = link_index(task.frame.axes, len(robot.joints), "axes")
        if not whole and (
            (min(task.rows) < 3 and link_index(task.frame.origin, len(robot.joints), "point") != last)
            or (axes not in (0, last) and task.rows not in ((0, 1, 2), (3, 4, 5)))
        ):
            raise TaskError(
                "the pose of the tip does not determine what this task wants", got=task.frame,
                allowed="axes of the base or the tip, origin at the tip",
            )  # fmt: skip
        point = (0.0, 0.0, 0.0) if whole or min(task.rows) >= 3 else task.frame.point
        self.with_tip = axes == last and not whole
        turns = [row for row in task.rows if row >= 3]
        self.free = next(row - 3 for row in (3, 4, 5) if row not in turns) if len(turns) == 2 else None
        self.heading = turns[0] - 3 if len(turns) == 1 else None
        self.robot, self.rows = robot, list(task.rows)
        self.length = task.scale(robot)
        self.point = np.array(point)
        self.joints = joint_scale(robot, task)
        plain = Task(task.name, task.rows, Frame(TIP if self.with_tip else BASE, TIP, point), self.length)
        self._chain, self._view = chain_of(robot), task_view(robot, plain)
        rank = generic_rank(robot, plain)
        self.square = robot.n == task.m == rank
        self.task, self.rank = plain, rank

    def error(self, poses: Array, q: Array) -> Array:
        """(N, m) what is missing from the poses at q (N, n) to `poses` (N, 4, 4) or (4, 4): e, lengths divided by ℓ."""
        now = _core.pose(self._chain, q)
        poses = np.broadcast_to(poses, now.shape)
        here, goal = now[:, :3, :3], poses[:, :3, :3]
        back = here.swapaxes(1, 2)
        shift = poses[:, :3, 3] - now[:, :3, 3] + (goal - here) @ self.point
        turn = back @ goal if self.with_tip else goal @ back
        if self.with_tip:
            shift = (back @ shift[:, :, None])[:, :, 0]
        if self.free is not None:
            turn = self._without(turn, self.free)
        vector = rotation_vector(turn)
        if self.heading is not None:  # undefined where the tool is turned over
            over = 1.0 + turn[:, self.heading, self.heading] < _TURNED_OVER
            vector[over, self.heading] = np.pi
        both = np.concatenate([shift / self.length, vector], axis=1)
        return np.asarray(both[:, self.rows])

    def missing(self, poses: Array, q: Array) -> tuple[Array, Array]:
        """What is missing at q (N, n) to `poses` (N, 4, 4), straight from forward kinematics.

        Only what the task asks for counts. The angle θ is that of the chord 2 sin(θ/2) = ‖R − R*‖/√2, which is largest
        at half a turn.

        Returns:
            (N,) distance of the reference point [m]; (N,) the chord [1].
        """
        now = _core.pose(self._chain, np.ascontiguousarray(q))
        away, chord = np.zeros(len(q)), np.zeros(len(q))
        rows = [row for row in self.rows if row < 3]
        apart = now[:, :3, :3] - poses[:, :3, :3]
        if rows:
            off = now[:, :3, 3] - poses[:, :3, 3] + apart @ self.point
            away = np.linalg.norm(off[:, [0, 1, 2] if self.with_tip else rows], axis=1)
        if len(rows) == len(self.rows):
            return away, chord
        if self.free is None:
            return away, np.asarray(np.linalg.norm(apart, axis=(1, 2)) / np.sqrt(2.0))
        # of the axis alone about which the task leaves the tool free
        return away, np.linalg.norm(apart[:, :, self.free] if self.with_tip else apart[:, self.free], axis=1)

    def confirmed(self, poses: Array, q: Array) -> Mask:
        """(N,) whether forward kinematics at q (N, n) gives the poses (N, 4, 4), to 1e-9 of the length scale and 1e-9.
        """
        away, chord = self.missing(poses, q)
        if self.heading is not None:  # the tilt does not count
            chord = np.abs(self.error(poses, q)[:, -1])
        return np.asarray((away <= _CONFIRMED * max(self.length, 1.0)) & (chord <= _CONFIRMED))

    def _without(self, turn: Array, axis: int) -> Array:
        """(N, 3, 3) rotations less what they turn about one axis, which the task leaves free."""
        i, j = (axis + 1) % 3, (axis + 2) % 3
        angle = 2 * np.arctan2(turn[:, j, i] - turn[:, i, j], 1.0 + turn[:, 0, 0] + turn[:, 1, 1] + turn[:, 2, 2])
        back = rotation(-angle[:, None] * np.eye(3)[axis])
        return np.asarray(turn @ back if self.with_tip else back @ turn)

    def jacobian(self, q: Array) -> Array:
        """(N, m, n) of scaled joints."""
        return np.asarray(_core.jacobian(self._chain, self._view, q) * self.joints)

    def step(self, q: Array, error: Array, damping: Array | float = 0.0) -> Array:
        """(N, n) Jᵀ(J Jᵀ + λ)⁻¹ e, J⁺ e without damping λ (N,) [rad, m]."""
        u, sigma, v = _core.svd(np.ascontiguousarray(self.jacobian(q)))
        count, damped = sigma.shape[1], sigma**2 + np.broadcast_to(damping, len(q))[:, None]
        gains = np.divide(sigma, damped, out=np.zeros_like(sigma), where=damped > _WEAK**2)
        shares = gains * (error[:, None, :] @ u[:, :, :count])[:, 0]
        return np.asarray((v[:, :, :count] @ shares[:, :, None])[:, :, 0] * self.joints)

    def rates(self, q: Array, move: Array, omega: Array) -> Array:
        """(N, n) joint rates J⁺ẋ that move the tip by `move` (N, 3) [m/s] and turn it by `omega` (N, 3) [rad/s]."""
        here = _core.pose(self._chain, q)[:, :3, :3]
        shift = move + np.cross(omega, here @ self.point)
        both = np.stack([shift, omega], axis=1)
        both = both @ here if self.with_tip else both
        twist = np.concatenate([both[:, 0] / self.length, both[:, 1]], axis=1)[:, self.rows]
        return self.step(q, twist)

    def solve(self, poses: Array, q: Array) -> tuple[Array, Mask]:
        """From near: configurations (N, n), and which are within 1e-11 of their poses (N, 4, 4)."""
        now, when = self._newton(poses, q, _ACCEPTED, _ROUNDS, far=False)
        return now, when >= 0

    def descend(
        self, goals: Array, starts: Array, *, close: float = _ACCEPTED, rounds: int = _ITERATIONS
    ) -> tuple[Array, Index]:
        """From far: damped Newton's method from each start, λ = |e|², so that the last steps are Newton's.

        Args:
            goals: (4, 4) the pose of all, or (N, 4, 4) one for each.
            starts: (N, n) [rad, m].
            close: |e| of a solution.
            rounds: steps at most.

        Returns:
            (N, n) where each ends; (N,) the step at which it arrived, −1 where it did not.
        """
        return self._newton(np.broadcast_to(goals, (len(starts), 4, 4)), starts, close, rounds, far=True)

    def reached(self, goal: Array, starts: Array) -> Array:
        """(k, n) from far: solutions for the pose (4, 4) from the starts (N, n), in the order of their steps."""
        q, arrived = self.descend(goal, starts)
        order = np.argsort(arrived, kind="stable")
        found = q[order[arrived[order] >= 0]]
        return np.asarray(found[self.confirmed(np.broadcast_to(goal, (len(found), 4, 4)), found)])

    def _newton(self, poses: Array, q: Array, close: float, rounds: int, *, far: bool) -> tuple[Array, Index]:
        """Ends (N, n), and the number of steps after which each arrived, −1 where it did not."""
        now, left = np.array(q, dtype=np.float64), np.arange(len(q))
        when, size = np.full(len(q), -1), np.full(len(q), np.inf)
        for number in range(rounds + (not far)):
            error = self.error(poses[left], now[left])
            new, before = np.sqrt((error * error).sum(axis=1)), size[left]
            size[left] = new
            stands = far or number == rounds  # else steps are made while they help
            done = (new <= _GOAL) | ((new <= close) & (stands | (new > 0.3 * before)))
            when[left[done]] = number
            going = ~done & (far | (new <= 3.0 * before))
            left, error, new = left[going], error[going], new[going]
            if not len(left) or number == rounds:
                break
            step = self.step(now[left], error, np.minimum(new**2, 1.0) if far else 0.0)
            if far:
                length = np.linalg.norm(step / self.joints, axis=1)
                step *= np.minimum(1.0, _CAP / np.maximum(length, 1e-300))[:, None]
            now[left] += step
        return now, when

    def side(self, q: Array) -> float:
        """Sign of the determinant; 0 for arms that have none."""
        return float(np.linalg.slogdet(self.jacobian(q[None])[0])[0]) if self.square else 0.0

    @cached_property
    def _tip(self) -> tuple[Array, Array, Array, Array, Array]:
        """Every joint as a variable: shares and offsets; lengths of the links, which joints turn, metres along an axis.
        """
        robot = self.robot
        chain, offset, share = unlocked(robot, np.zeros(robot.n))
        tip = robot.home[:3, 3] + robot.home[:3, :3] @ self.point
        links = np.linalg.norm(np.diff(np.vstack([anchors(robot), tip]), axis=0), axis=1)
        slides = np.array([joint.kind is JointKind.PRISMATIC for joint in chain.joints])
        along = np.array([abs(float(joint.screw[:3] @ joint.screw[3:])) for joint in chain.joints])
        return share, offset, links, ~slides * 1.0, np.where(slides, 1.0, along)

    def deviation(self, q: Array, poses: Array) -> tuple[Array, Array]:
        """Bounds on how far the tip leaves its curve while the joints go straight: proven, not sampled.

        Between two rows the joints go as q(τ) = a + τ Δ, 0 ≤ τ ≤ 1, and the tip is on its curve c(τ) at both rows but
        for e₀ and e₁. A function with |f''| ≤ M differs from the straight line between its ends by M/8 at most, so that

            |p(q(τ)) − c(τ)| ≤ max(|e₀|, |e₁|) + M/8,    M = Σ_i l_i t_i² + Σ_s (|q_s| t_s² + 2 |Δ_s| t_s) + |x| θ²

        l_i is the length of link i, t_i the sum of |Δ_k| of the turning joints up to it (t_s: before slide s), θ the
        turn of the tool between the rows, x the reference point in the axes of the tip. Rotations as matrices:
        |R'' − S''| ≤ t_N² + θ². Only what the task asks for is compared.

        Args:
            q: (K, n) rows.
            poses: (K, 4, 4) of the curve at the rows.

        Returns:
            (K − 1,) each: how far the tip leaves the curve at most between rows, its place [m] and its turn [rad].
        """
        share, offset, links, turns, pitch = self._tip
        values = q @ share.T + offset
        step = np.abs(np.diff(values, axis=0))
        turn = np.cumsum(step * turns, axis=1)
        before = turn - step * turns
        most = np.maximum(np.abs(values[1:]), np.abs(values[:-1]))
        bend = (turn**2 @ links) + ((most * before + 2 * step) * before) @ pitch
        tool = poses[1:, :3, :3] @ poses[:-1, :3, :3].swapaxes(1, 2)
        theta = np.linalg.norm(rotation_vector(tool), axis=1)
        bend = bend + float(np.linalg.norm(self.point)) * theta**2
        off, chord = self.missing(poses, q)
        away = turned = np.zeros(len(step))
        if min(self.rows) < 3:
            away = np.maximum(off[1:], off[:-1]) + bend / 8 + _ROUNDED * float(links.sum())
        if max(self.rows) >= 3:
            bound = np.maximum(chord[1:], chord[:-1]) + (turn[:, -1] ** 2 + theta**2) / 8
            turned = 2 * np.arcsin(np.minimum(1.0, (bound + _ROUNDED) / 2))
        return away, turned


def check_square(robot: Robot, task: Task) -> None:
    """Refuse tasks whose inverse is no list of solutions.

    Raises:
        TaskError: the arm has more or fewer joints than the task rows, or the rows are not in the base's axes.
    """
    if robot.n != task.m:
        raise TaskError(
            "postures are solutions of the inverse, which are a list only without redundancy",
            got=f"{task.m} rows, {robot.n} joints", allowed="as many joints as rows",
            mend="choose a task with as many rows as joints" if robot.n <= 6 else "",
        )  # fmt: skip
    check_axes(task)


def check_axes(task: Task) -> None:
    """Refuse rows that are not of the tip in the axes of the base.

    Raises:
        TaskError: they are not.
    """
    if task.frame != WORLD_ALIGNED:
        raise TaskError("poses are those of the tip, in the axes of the base", got=task.frame,
                        allowed="WORLD_ALIGNED")  # fmt: skip


def solutions(robot: Robot, task: Task, target: Array, *, starts: int, seed: int, also: Array | None = None) -> Array:
    """Regular solutions of an arm with as many joints as rows.

    Args:
        robot, task: as many joints as rows, in the unit of length that is wanted.
        target: (4, 4) pose of the tip; what the task leaves free is ignored.
        starts, seed: random starts; the same seed gives the same solutions.
        also: (k, n) further starts.

    Returns:
        (k, n), angles in (−π, π], in lexicographic order of rounded values. Limits are ignored.
    """
    begin = sample(robot, task, starts, seed, limits=False)
    if also is not None:
        begin = np.concatenate([np.atleast_2d(also), begin])
    found = Aim(robot, task).reached(target, begin)
    found = wrapped(robot, found[singular_values(robot, found, task)[:, -1] > _REGULAR])
    kept = distinct(robot, task, found, _SAME)
    return kept[sorted(range(len(kept)), key=lambda row: [round(float(x), 6) for x in kept[row]])]


def distinct(
    robot: Robot, task: Task, q: Array, near: float, known: Array | None = None, most: int | None = None
) -> Array:
    """(k, n) those of configurations (N, n) that are farther than `near` [rad; slides scaled] from all before them.

    Args:
        robot, task: the arm.
        q: (N, n); turning joints count the short way.
        near: distance.
        known: (k, n) others to be apart from, which are not returned.
        most: to return.
    """
    scale = joint_scale(robot, task)
    first = 0 if known is None else len(known)
    kept = [] if known is None else list(known)
    for one in q:
        if most is not None and len(kept) - first >= most:
            break
        if not kept or np.linalg.norm(apart(robot, one, np.array(kept)) / scale, axis=1).min() > near:
            kept.append(one)
    return np.array(kept[first:]).reshape(-1, robot.n)


def regular(robot: Robot, task: Task, q: Array) -> bool:
    """Whether a configuration (n,) is far enough from the singular set for its solution to be separated from others."""
    return bool(singular_values(robot, q, task)[-1] > _REGULAR)


def determinants(robot: Robot, task: Task, q: Array) -> Array:
    """(N,) det J of the task, without unit."""
    return np.asarray(np.linalg.det(task_jacobian(robot, q, task) * joint_scale(robot, task)))


def wrapped(robot: Robot, q: Array) -> Array:
    """Turning joints in (−π, π]."""
    turned = q - 2 * np.pi * np.ceil((q - np.pi - _SAME) / (2 * np.pi))
    return np.where(robot.periodic, turned, q)


def near_and_within(robot: Robot, q: Array, near: Array, *, limits: bool) -> Array:
    """(k, n) configurations turned by whole turns to come near others, with limits those that have a place in them."""
    q = q - whole_turns(robot, q - near)
    if not limits:
        return q
    q = into_limits(robot, q)
    return q[within(robot, q)]


def within(robot: Robot, q: Array) -> Mask:
    """(N,) inside the joint limits, to 1e-9."""
    return np.asarray(((q >= robot.lower - 1e-9) & (q <= robot.upper + 1e-9)).all(axis=1))


def apart(robot: Robot, one: Array, other: Array) -> Array:
    """other − one, turning joints the short way."""
    gap = other - one
    return np.asarray(gap - whole_turns(robot, gap))


@dataclass(frozen=True, eq=False)
class Followed:
    """Joint values along a tool path, and how they were found.

    Attributes:
        q: (K, n) configurations at the places [rad, m]; angles run on, they are not wrapped.
        place: (K,) poses reached, from 1; with a tolerance places between poses as well, as shares of the way.
        complete: every pose was reached.
        reached: number of the last pose reached, from 1, with the share of the way to the next.
        last: (n,) configuration there.
        reason: why it ended: "" where complete, else "start", "singular", "limit", "stuck", or "budget": the steps or
            the rows that one path may have were used up.
        joint: number of the joint at its limit, from 1; 0 for other reasons.
        sigma: σ_r where it ended [1].
        poses: how many were given.
        solutions: how many configurations at the first pose were found to choose it from; 0: it was given.
        more: the arm is redundant, so that there are more.
        next_reachable: a configuration within the joint limits was found for the pose after the end.
        off: the tip stays within this distance of its curve, proven [m].
        turned: … and within this angle, as far as the task asks for orientations [rad].
    """

    q: Array
    place: Array
    complete: bool
    reached: float
    last: Array
    reason: str = ""
    joint: int = 0
    sigma: float = np.inf
    poses: int = 0
    solutions: int = 0
    more: bool = False
    next_reachable: bool = False
    off: float = 0.0
    turned: float = 0.0

    @property
    def start(self) -> list[float]:
        """(n,) configuration at the first pose."""
        return [float(x) for x in self.q[0]]

    @property
    def chosen(self) -> str:
        """Which branch of the inverse kinematics the path takes, in words."""
        return branch_chosen(self)


def follow(
    robot: Robot,
    poses: ArrayLike,
    start: ArrayLike,
    task: Task | str | None = None,
    *,
    limits: bool = True,
    pull: Pull | None = None,
    tolerance: tuple[float, float] | None = None,
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

    Returns:
        What was reached. At every configuration the pose is right to 1e-11, translations divided by the length scale.

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
    return _Walk(aim, wanted, limits, pull, tolerance).run(one_configuration(robot, start))


def between(start: Array, end: Array, share: Array) -> Array:
    """(N, 4, 4) poses at shares (N,) 0 … 1 from poses `start` to `end`, each (4, 4) or (N, 4, 4).

    The origin goes straight, the orientation turns about one axis at a constant rate, the shorter way round.
    """
    share = np.asarray(share, dtype=np.float64)
    turn = rotation_vector(end[..., :3, :3] @ np.swapaxes(start[..., :3, :3], -1, -2))
    made = np.zeros((len(share), 4, 4))
    made[:, :3, :3] = rotation(share[:, None] * turn) @ start[..., :3, :3]
    made[:, :3, 3] = start[..., :3, 3] + share[:, None] * (end[..., :3, 3] - start[..., :3, 3])
    made[:, 3, 3] = 1.0
    return made


def poses_at(poses: Array, place: Array) -> Array:
    """(N, 4, 4) poses of the tip at places (N,) of a tool path (P, 4, 4), counted from 0."""
    k = np.clip(np.floor(place), 0, max(len(poses) - 2, 0)).astype(np.int64)
    return between(poses[k], poses[np.minimum(k + 1, len(poses) - 1)], place - k)


@dataclass(eq=False)
class _Walk:
    aim: Aim
    poses: Array
    limits: bool
    pull: Pull | None
    tolerance: tuple[float, float] | None

    def run(self, start: Array) -> Followed:
        """From the first pose on."""
        found, arrived = self.aim.solve(self.poses[:1], start[None])
        joint = self._beyond(found) if arrived[0] else -1
        if not arrived[0] or joint >= 0:
            reason = "limit" if arrived[0] else "start"
            return Followed(start[None][:0], np.zeros(0), False, 1.0, start, reason, joint + 1)
        now, rows, places, last = found[0], [found], [np.zeros(1)], len(self.poses) - 1.0
        place, h, side, size = 0.0, 1.0, self.aim.side(now), 1
        tries = _TRIES[0] + _TRIES[1] * len(self.poses)
        spent = False
        while place < last:
            spent = tries < 0 or size > _ROWS
            if spent:
                break
            ahead = min(place + h, last)
            if ahead >= int(place) + 1:  # a pose where it can be one, so that no share of a way is left over
                ahead = float(int(ahead + 1e-9))
            step = self._try(now, place, ahead, side)
            joint = -1 if step is None else self._beyond(step[1])
            tries -= 1
            if step is None or joint >= 0:
                if h < _SHORTEST:
                    break
                h = (ahead - place) / 2
                continue
            at, q = step
            kept = slice(None) if self.tolerance is not None else at == np.floor(at)
            rows.append(q[kept])
            places.append(at[kept])
            size += len(rows[-1])
            h, place, now = min(2.0 * (ahead - place), float(_MOST)), ahead, q[-1]
        ended, sigma = "", np.inf
        if place < last:
            sigma = float(singular_values(self.aim.robot, now, self.aim.task)[self.aim.rank - 1])
            ended = "limit" if joint >= 0 else "singular" if sigma <= _SMALL else "budget" if spent else "stuck"
        q, at = np.concatenate(rows), np.concatenate(places) + 1.0
        return self._confirmed(Followed(q, at, not ended, place + 1.0, now, ended, joint + 1, sigma))

    def _confirmed(self, found: Followed) -> Followed:
        """The rows up to the first one whose forward kinematics misses its pose; else all of them."""
        good = self.aim.confirmed(poses_at(self.poses, found.place - 1.0), found.q)
        if good.all():
            return found
        count = int(good.argmin())
        reached = float(found.place[max(0, count - 1)])
        q = found.q[:count]
        return Followed(q, found.place[:count], False, reached, q[-1] if count else found.last, "stuck")

    def _try(self, now: Array, place: float, ahead: float, side: float) -> tuple[Array, Array] | None:
        """Places (K,) after `place`, `ahead` the last, and configurations (K, n) there; None: too long a step."""
        target = poses_at(self.poses, np.array([ahead]))
        error = self.aim.error(target, now[None])
        if np.linalg.norm(error) > 1.0:  # Newton is not to be trusted so far
            return None
        guess = now + self.aim.step(now[None], error)[0]
        first = float(np.linalg.norm((guess - now) / self.aim.joints))
        if first > _LONGEST:
            return None
        guess = guess + self._null_space_pull(now, first)
        found, arrived = self.aim.solve(target, guess[None])
        if not arrived[0]:
            return None
        end = found[0]
        added = float(np.linalg.norm((end - guess) / self.aim.joints))
        if added > _BENT * first + 1e-9 or (self.aim.square and self.aim.side(end) != side):
            return None
        at = np.append(np.arange(int(place) + 1.0, np.ceil(ahead - 1e-12)), ahead)
        return self._filled(np.append(place, at), np.stack([now, end]), _BENT * first + 1e-9)

    def _filled(self, at: Array, ends: Array, off: float) -> tuple[Array, Array] | None:
        """Places and configurations of one step, solved from straight guesses, none farther than `off` from its guess.

        With a tolerance more places are put in until the tip keeps it between all of them.
        """
        known, q = at[[0, -1]], ends
        for _ in range(_FILLS):
            line = np.stack([np.interp(at, known, column) for column in q.T], axis=1)
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
            k, part = numbered(parts)
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

    def _beyond(self, q: Array) -> int:
        """First joint beyond its limit in any row; −1 for none, or where limits do not count."""
        low, high = self.aim.robot.lower - 1e-9, self.aim.robot.upper + 1e-9
        out = np.argwhere(self.limits & ((q < low) | (q > high)))
        return int(out[0, 1]) if len(out) else -1
