"""The inverse of an arm: Newton's method towards poses of the tip, from near and from far, and what solutions it finds.

    e(q) = (p* − p ; log(R* Rᵀ)), the rows of the task, translations divided by the length scale

    from near  q ← q + J⁺ e
    from far   q ← q + Jᵀ(J Jᵀ + λ)⁻¹ e,  λ = |e|²

A solution that no start leads to is missed: a list is what was found. What is found is a solution, to rounding.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.errors import TaskError
from rankdrop.kinematics import chain_of, pose, task_jacobian, task_view
from rankdrop.local.block import generic_rank, joint_scale, sample, singular_values
from rankdrop.local.bracket import hat
from rankdrop.local.departure import unlocked
from rankdrop.local.orientation import orientation_coordinates
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.numbers import anchors
from rankdrop.task import BASE, TIP, WORLD_ALIGNED, Frame, Task, link_index

_GOAL, _ACCEPTED = 1e-14, 1e-11  # of an error: rounding, and what is still taken for none
_ROUNDS, _ITERATIONS = 10, 60  # from near, and from far
_LONGEST = 0.5  # of a step from far [rad; slides scaled]: a quarter of the way between neighbouring solutions
_WEAK = 1e-9  # σ below which Newton leaves a direction alone
_SAME = 1e-6  # solutions nearer than this are one [rad]
_REGULAR = 1e-5  # σ_r of a solution that counts: nearer to the singular set pairs of solutions cannot be separated
_FULL = (0, 1, 2, 3, 4, 5)
_ROUNDED = 1e-12  # share of the links' length that rounding may add


def rotation(turn: Array) -> Array:
    """(N, 3, 3) rotations by vectors (N, 3), Rodrigues' formula."""
    angle = np.linalg.norm(turn, axis=1)
    safe = np.where(angle > 0.0, angle, 1.0)
    k = hat(turn / safe[:, None])
    return np.asarray(
        np.eye(3) + np.sin(angle)[:, None, None] * k + (1.0 - np.cos(angle))[:, None, None] * (k @ k)
    )


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
        twist = np.stack([turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]],
                         axis=1) / 2  # fmt: skip
        sine = np.sqrt((twist * twist).sum(axis=1))
        cosine = (turn[:, 0, 0] + turn[:, 1, 1] + turn[:, 2, 2] - 1.0) / 2
        factor = np.where(sine > 1e-9, np.arctan2(sine, cosine) / np.where(sine > 1e-9, sine, 1.0), 1.0)
        both = np.concatenate([shift / self.length, twist * factor[:, None]], axis=1)
        return np.asarray(both[:, self.rows])

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

    def solve(self, poses: Array, q: Array) -> tuple[Array, NDArray[np.bool_]]:
        """From near: configurations (N, n), and which are within 1e-11 of their poses (N, 4, 4)."""
        now, left = np.array(q, dtype=np.float64), np.arange(len(q))
        arrived, size = np.zeros(len(q), dtype=np.bool_), np.full(len(q), np.inf)
        for _ in range(_ROUNDS):
            error = self.error(poses[left], now[left])
            new, before = np.sqrt((error * error).sum(axis=1)), size[left]
            size[left] = new
            done = (new <= _GOAL) | ((new <= _ACCEPTED) & (new > 0.3 * before))
            arrived[left[done]] = True
            going = ~done & (new <= 3.0 * before)
            left, error = left[going], error[going]
            if not len(left):
                return now, arrived
            now[left] += self.step(now[left], error)
        arrived[left] = np.linalg.norm(self.error(poses[left], now[left]), axis=1) <= _ACCEPTED
        return now, arrived

    def reached(self, goal: Array, starts: Array) -> Array:
        """(k, n) from far: where damped Newton's method from each of the starts (N, n) reaches the pose (4, 4).

        λ = |e|² dies out with the error, so that the last steps are Newton's. Ends are in the order of their steps.
        """
        q, found = np.array(starts, dtype=np.float64), [np.empty((0, self.robot.n))]
        going = np.arange(len(q))
        for _ in range(_ITERATIONS):
            e = self.error(goal, q[going])
            size = np.linalg.norm(e, axis=1)
            done = size <= _ACCEPTED
            found.append(q[going[done]])
            going, e, size = going[~done], e[~done], size[~done]
            if not len(going):
                break
            step = self.step(q[going], e, np.minimum(size**2, 1.0))
            length = np.linalg.norm(step / self.joints, axis=1)
            q[going] += step * np.minimum(1.0, _LONGEST / np.maximum(length, 1e-300))[:, None]
        return np.concatenate(found)

    def side(self, q: Array) -> float:
        """Sign of the determinant; 0 for arms that have none."""
        return float(np.linalg.slogdet(self.jacobian(q[None])[0])[0]) if self.square else 0.0


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


def apart(robot: Robot, one: Array, other: Array) -> Array:
    """other − one, turning joints the short way."""
    gap = other - one
    return np.where(robot.periodic, gap - 2 * np.pi * np.round(gap / (2 * np.pi)), gap)


class TipDeviation:
    """Bounds on how far the tip leaves its Cartesian curve while the joints go straight: proven, not sampled.

    Between two rows the joints go as q(τ) = a + τ Δ, 0 ≤ τ ≤ 1, and the tip is on its curve c(τ) at both rows but for
    e₀ and e₁. A function with |f''| ≤ M differs from the straight line between its ends by M/8 at most, so that

        |p(q(τ)) − c(τ)| ≤ max(|e₀|, |e₁|) + M/8,    M = Σ_i l_i t_i² + Σ_s (|q_s| t_s² + 2 |Δ_s| t_s) + |x| θ²

    l_i is the length of link i, t_i the sum of |Δ_k| of the turning joints up to it (t_s: before slide s), θ the turn
    of the tool between the rows, x the reference point in the axes of the tip. Rotations as matrices:
    |R'' − S''| ≤ t_N² + θ².

    Args:
        aim: the arm and its task; only what the task asks for is compared.
    """

    def __init__(self, aim: Aim) -> None:
        robot = aim.robot
        chain, _, self._share = unlocked(robot, np.zeros(robot.n))
        self._offset = unlocked(robot, np.zeros(robot.n))[1]
        tip = robot.home[:3, 3] + robot.home[:3, :3] @ aim.point
        self._links = np.linalg.norm(np.diff(np.vstack([anchors(robot), tip]), axis=0), axis=1)
        self._turns = np.array([joint.kind is not JointKind.PRISMATIC for joint in chain.joints], dtype=np.float64)
        self._pitch = np.array([_pitch(joint.kind, joint.screw) for joint in chain.joints])
        self._aim = aim
        partial = [row for row in aim.rows if row < 3]
        self._rows = [0, 1, 2] if aim.with_tip and partial else partial
        self._turned = any(row >= 3 for row in aim.rows)

    def bound(self, q: Array, poses: Array) -> tuple[Array, Array]:
        """(K − 1,) each: how far the tip leaves the curve at most between rows, its place [m] and its turn [rad].

        Args:
            q: (K, n) rows.
            poses: (K, 4, 4) of the curve at the rows.
        """
        aim, now = self._aim, pose(self._aim.robot, q)
        values = q @ self._share.T + self._offset
        step = np.abs(np.diff(values, axis=0))
        turn = np.cumsum(step * self._turns, axis=1)
        before = turn - step * self._turns
        most = np.maximum(np.abs(values[1:]), np.abs(values[:-1]))
        bend = (turn**2 @ self._links) + ((most * before + 2 * step) * before) @ self._pitch
        tool = poses[1:, :3, :3] @ poses[:-1, :3, :3].swapaxes(1, 2)
        theta = np.linalg.norm(orientation_coordinates(tool, "rotvec"), axis=1)
        bend = bend + float(np.linalg.norm(aim.point)) * theta**2
        off = now[:, :3, 3] - poses[:, :3, 3] + (now[:, :3, :3] - poses[:, :3, :3]) @ aim.point
        rounding = _ROUNDED * float(self._links.sum())
        away = _largest_end(np.linalg.norm(off[:, self._rows], axis=1)) + bend / 8 + rounding
        if not self._rows:
            away = np.zeros_like(away)
        if not self._turned:
            return away, np.zeros_like(away)
        chord = _largest_end(self._turned_off(now[:, :3, :3], poses[:, :3, :3])) + (turn[:, -1] ** 2 + theta**2) / 8
        return away, 2 * np.arcsin(np.minimum(1.0, (chord + _ROUNDED) / 2))

    def _turned_off(self, now: Array, wanted: Array) -> Array:
        """(K,) |R − S|, of the axis alone about which the task leaves the tool free."""
        free, apart = self._aim.free, now - wanted
        if free is None:
            return np.asarray(np.linalg.norm(apart, axis=(1, 2)) / np.sqrt(2.0))
        return np.asarray(np.linalg.norm(apart[:, :, free] if self._aim.with_tip else apart[:, free], axis=1))


def _pitch(kind: JointKind, screw: Array) -> float:
    """Metres along its axis per unit of a joint's value."""
    return 1.0 if kind is JointKind.PRISMATIC else abs(float(screw[:3] @ screw[3:]))


def _largest_end(values: Array) -> Array:
    return np.maximum(values[1:], values[:-1])
