"""The inverse of an arm: poses solved by Newton's method, from near and from far.

    e(q) = (p* − p ; log(R* Rᵀ)), the rows of the task, translations divided by the length scale

    from near  q ← q + J⁺ e
    from far   q ← q + Jᵀ(J Jᵀ + λ)⁻¹ e,  λ = |e|²

A solution that no start leads to is missed: a list is what was found. What is found is a solution, to rounding.

An arm of lower rank than the task has rows (five joints, six rows) reaches a thin set of poses. A pose of six digits is
next to it: the nearest reachable pose within `tolerances.MISSED` is taken. There the steps J⁺ e end, and e is missing.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from rankdrop import _core
from rankdrop.errors import TaskError
from rankdrop.kinematics import chain_of, task_jacobian, task_view
from rankdrop.local.block import generic_rank, joint_scale, sample, singular_values
from rankdrop.local.departure import release_mimics
from rankdrop.local.orientation import rotation_vector
from rankdrop.path.curve import Index
from rankdrop.problem import Mask, into_limits, whole_turns
from rankdrop.robot.arm_reach import anchors
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.transform import hat
from rankdrop.task import BASE, TIP, WORLD_ALIGNED, Frame, Task, link_index
from rankdrop.tolerances import MISSED
from rankdrop.units import counted_length

_ACCEPTED = 1e-11  # of an error that is taken for none
_ROUNDS, _ITERATIONS = 10, 60  # from near, and from far
_SAME = 1e-6  # solutions nearer than this are one [rad]
_REGULAR = 1e-5  # σ_r of a solution that counts: nearer to the singular set pairs of solutions cannot be separated
_CONFIRMED = 1e-9  # by which forward kinematics may miss the pose of a solution [m and chord]
_FULL = (0, 1, 2, 3, 4, 5)
_NOTED = 1e-10  # a miss below it is rounding of doubles [m and chord]
_AT_REST = 1e-9  # a step J⁺ e so short ends next to such a pose [rad; slides scaled]
_ROUNDED = 1e-12  # share of the links' length that rounding may add


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
        if whole or min(task.rows) >= 3:
            point = (0.0, 0.0, 0.0)
        else:
            point = task.frame.point
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
        self._aim = _core.make_aim(
            rows=self.rows, length=self.length, point=list(point), with_tip=self.with_tip,
            free=_axis(self.free), heading=_axis(self.heading), joints=self.joints.tolist(),
        )  # fmt: skip
        self.square = robot.n == task.m == rank
        self.task, self.rank = plain, rank
        self.may_miss = rank < task.m
        self._missed = (MISSED[0] * counted_length(robot), MISSED[1])

    def error(self, poses: Array, q: Array) -> Array:
        """(N, m) what is missing from the poses at q (N, n) to `poses` (N, 4, 4) or (4, 4): e, lengths divided by ℓ."""
        return _core.aim_errors(self._chain, self._aim, _each(poses, len(q)), np.ascontiguousarray(q))

    def missing(self, poses: Array, q: Array) -> tuple[Array, Array]:
        """What is missing at q (N, n) to `poses` (N, 4, 4), straight from forward kinematics.

        Only what the task asks for counts. The angle θ is that of the chord 2 sin(θ/2) = ‖R − R*‖/√2, which is largest
        at half a turn.

        Returns:
            (N,) distance of the reference point [m]; (N,) the chord [1].
        """
        return self.missing_between(poses, _core.pose(self._chain, np.ascontiguousarray(q)))

    def missing_between(self, poses: Array, now: Array) -> tuple[Array, Array]:
        """As `missing`, from poses `now` (N, 4, 4) to `poses` (N, 4, 4)."""
        away, chord = np.zeros(len(now)), np.zeros(len(now))
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

    def confirms(self, poses: Array, q: Array) -> Mask:
        """(N,) whether forward kinematics at q (N, n) gives the poses (N, 4, 4), to 1e-9 of the length scale and 1e-9;
        of an arm of lower rank than rows to `MISSED`.
        """
        away, chord = self.missing(poses, q)
        if self.heading is not None:  # the tilt does not count
            chord = np.abs(self.error(poses, q)[:, -1])
        most_away, most_turned = _CONFIRMED * max(self.length, 1.0), _CONFIRMED
        if self.may_miss:
            most_away, most_turned = self._missed
        return np.asarray((away <= most_away) & (chord <= most_turned))

    def missed(self, poses: Array, q: Array) -> tuple[float, float] | None:
        """By how much the tool misses the poses (N, 4, 4) at q (N, n) at most [m, rad], where an arm of lower rank than
        rows takes the nearest poses; None where it takes them to rounding.
        """
        if not self.may_miss or not len(q):
            return None
        away, chord = (float(values.max()) for values in self.missing(poses, q))
        if away <= _NOTED * max(self.length, 1.0) and chord <= _NOTED:
            return None
        return away, 2.0 * float(np.arcsin(min(1.0, chord / 2.0)))

    def _is_nearest(self, poses: Array, q: Array) -> Mask:
        """(N,) whether an arm of lower rank than rows is at the reachable pose nearest to `poses` (N, 4, 4)."""
        steps = self.step(q, self.error(poses, q))
        still = np.linalg.norm(steps / self.joints, axis=1) <= _AT_REST
        return np.asarray(still & self.confirms(_each(poses, len(q)), q))

    def jacobian(self, q: Array) -> Array:
        """(N, m, n) of scaled joints."""
        return np.asarray(_core.jacobian(self._chain, self._view, q) * self.joints)

    def step(self, q: Array, error: Array) -> Array:
        """(N, n) J⁺ e of errors e (N, m) at q (N, n) [rad, m]; directions with σ below 1e-9 are left alone."""
        wanted = np.ascontiguousarray(error)
        return _core.aim_steps(self._chain, self._view, self._aim, np.ascontiguousarray(q), wanted)

    def rates(self, q: Array, move: Array, omega: Array) -> Array:
        """(N, n) joint rates J⁺ẋ that move the tip by `move` (N, 3) [m/s] and turn it by `omega` (N, 3) [rad/s]."""
        tip_axes = _core.pose(self._chain, q)[:, :3, :3]
        shift = move + np.cross(omega, tip_axes @ self.point)
        velocities = np.stack([shift, omega], axis=1)
        velocities = velocities @ tip_axes if self.with_tip else velocities
        twist = np.concatenate([velocities[:, 0] / self.length, velocities[:, 1]], axis=1)[:, self.rows]
        return self.step(q, twist)

    def solve(self, poses: Array, q: Array) -> tuple[Array, Mask]:
        """From near: configurations (N, n), and which are within 1e-11 of their poses (N, 4, 4), or next to them."""
        now, when = self._newton(poses, q, _ACCEPTED, _ROUNDS, far=False)
        arrived = when >= 0
        if self.may_miss and not arrived.all():
            arrived |= self._is_nearest(poses, now)
        return now, arrived

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
        return self._newton(goals, starts, close, rounds, far=True)

    def solve_from(self, goal: Array, starts: Array) -> Array:
        """(k, n) from far: solutions for the pose (4, 4) from the starts (N, n), in the order of their steps."""
        if self.may_miss:
            close = float(np.hypot(self._missed[0] / self.length, self._missed[1]))
            q, arrived = self.descend(goal, starts, close=close)
            q, solved = self.solve(np.broadcast_to(goal, (len(q), 4, 4)), q)
            arrived = np.where(solved, arrived, -1)
        else:
            q, arrived = self.descend(goal, starts)
        order = np.argsort(arrived, kind="stable")
        candidates = q[order[arrived[order] >= 0]]
        return np.asarray(candidates[self.confirms(np.broadcast_to(goal, (len(candidates), 4, 4)), candidates)])

    def _newton(self, poses: Array, q: Array, close: float, rounds: int, *, far: bool) -> tuple[Array, Index]:
        """Ends (N, n), and the number of steps after which each arrived, −1 where it did not."""
        return _core.aim_newton(self._chain, self._view, self._aim, _each(poses, len(q)), np.ascontiguousarray(q),
                                close=close, rounds=rounds, far=far)  # fmt: skip

    def side(self, q: Array) -> float:
        """Sign of the determinant; 0 for arms that have none."""
        if self.square:
            return float(np.linalg.slogdet(self.jacobian(q[None])[0])[0])
        return 0.0

    @cached_property
    def _tip(self) -> tuple[Array, Array, Array, Array, Array]:
        """Every joint as a variable: shares and offsets; lengths of the links, which joints turn, metres along an axis.
        """
        robot = self.robot
        chain, offset, share = release_mimics(robot, np.zeros(robot.n))
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


def _axis(number: int | None) -> int:
    """An axis as the core has it: −1 for none."""
    if number is None:
        return -1
    return number


def _each(poses: Array, count: int) -> Array:
    """(count, 4, 4) poses, one for each configuration, of (4, 4) or of as many."""
    return np.ascontiguousarray(np.broadcast_to(poses, (count, 4, 4)))


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
    candidates = Aim(robot, task).solve_from(target, begin)
    candidates = wrap_joints(robot, candidates[singular_values(robot, candidates, task)[:, -1] > _REGULAR])
    different = distinct(robot, task, candidates, _SAME)
    return different[sorted(range(len(different)), key=lambda row: [round(float(x), 6) for x in different[row]])]


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
    chosen = [] if known is None else list(known)
    for solution in q:
        if most is not None and len(chosen) - first >= most:
            break
        if chosen:
            gaps = joint_difference(robot, solution, np.array(chosen)) / scale
            apart = bool(np.linalg.norm(gaps, axis=1).min() > near)
        else:
            apart = True
        if apart:
            chosen.append(solution)
    return np.array(chosen[first:]).reshape(-1, robot.n)


def regular(robot: Robot, task: Task, q: Array) -> bool:
    """Whether a configuration (n,) is far enough from the singular set for its solution to be separated from others."""
    return bool(singular_values(robot, q, task)[-1] > _REGULAR)


def determinants(robot: Robot, task: Task, q: Array) -> Array:
    """(N,) det J of the task, without unit."""
    return np.asarray(np.linalg.det(task_jacobian(robot, q, task) * joint_scale(robot, task)))


def wrap_joints(robot: Robot, q: Array) -> Array:
    """Turning joints in (−π, π]."""
    turned = q - 2 * np.pi * np.ceil((q - np.pi - _SAME) / (2 * np.pi))
    return np.where(robot.periodic, turned, q)


def near_and_within(robot: Robot, q: Array, near: Array, *, limits: bool) -> Array:
    """(k, n) configurations turned by whole turns to come near others, with limits those that have a place in them."""
    q = q - whole_turns(robot, q - near)
    if not limits:
        return q
    q = into_limits(robot, q)
    return q[within_limits(robot, q)]


def within_limits(robot: Robot, q: Array) -> Mask:
    """(N,) inside the joint limits, to 1e-9."""
    return np.asarray(((q >= robot.lower - 1e-9) & (q <= robot.upper + 1e-9)).all(axis=1))


def joint_difference(robot: Robot, start: Array, end: Array) -> Array:
    """end − start, turning joints the short way."""
    gap = end - start
    return np.asarray(gap - whole_turns(robot, gap))
