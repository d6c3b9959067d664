"""Inverse kinematics along a tool path: joint values pose by pose, the branch kept, or where it cannot be followed.

Between two poses the tip goes straight and turns about one axis at a constant rate, as a linear move of a controller
does. Predictor and corrector are Newton's method towards a pose a little further on,

    q ← q + J⁺ e,   e = (p* − p ; log(R* Rᵀ)), its task rows, translations divided by the length scale,

with the pseudo-inverse: a redundant arm makes the shortest step. A step counts only where the corrector has little left
to correct, where no joint motion is long, and where no determinant changes its sign; otherwise it is halved, so that
the branch is kept up to the singularity or the limit at which it ends. Poses passed over by a step are filled in from a
straight guess between its ends, all at once, and polished to rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import atan2

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop import _core
from rankdrop._handles import chain_of, task_view
from rankdrop.errors import ConfigurationError, TaskError
from rankdrop.frames import BASE, TIP, Frame, link_index
from rankdrop.local.block import generic_rank, joint_scale, singular_values
from rankdrop.local.bracket import hat
from rankdrop.local.orientation import orientation_coordinates
from rankdrop.local.verdict import one_configuration
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task

Pull = Callable[[Array], Array]
"""pull(q) -> (n,) wanted joint motion per unit length of joint motion; its part in the null space is followed."""

_GOAL, _ACCEPTED = 1e-14, 1e-11  # of an error: rounding, and what is still taken for none
_ROUNDS = 10
_LONGEST = 0.15  # of a step in joint space [rad; slides divided by the length scale]
_BENT = 0.2  # share of a step that the corrector may add to the predictor
_SHORTEST = 1e-6  # step at which the branch has ended [of the way between two poses]
_TRIES = (400, 1)  # steps at most, and for each pose: a branch that creeps along a singularity ends
_MOST = 4096  # poses passed over by one step
_WEAK = 1e-9  # σ below which Newton leaves a direction alone
_SMALL = 1e-2  # σ_r at the end of a branch below which a singularity is named as its reason
_FULL = (0, 1, 2, 3, 4, 5)


@dataclass(frozen=True, eq=False)
class Followed:
    """Joint values along a tool path.

    Attributes:
        q: (K, n) configurations of the first K poses [rad, m]; angles run on, they are not wrapped.
        complete: every pose was reached.
        row: how far it got: number of the last pose reached, from 1, with the share of the way to the next.
        last: (n,) configuration there.
        reason: "" where complete, else "start", "singular", "limit" or "stuck".
        words: the reason as a sentence.
    """

    q: Array
    complete: bool
    row: float
    last: Array
    reason: str
    words: str


def follow(
    robot: Robot,
    poses: ArrayLike,
    start: ArrayLike,
    task: Task | str | None = None,
    *,
    limits: bool = True,
    pull: Pull | None = None,
) -> Followed:
    """Follow poses of the tip from a configuration at the first of them, on the branch of that configuration.

    Args:
        robot: the arm.
        poses: (T, 4, 4) of the tip in the base frame [m]; rows that the task leaves free are not looked at.
        start: (n,) configuration near the first pose [rad, m]; Newton brings it there.
        task: name, `Task`, or None for the task the arm is made for.
        limits: end at joint limits.
        pull: null-space motion of a redundant arm; None for the shortest motion.

    Returns:
        What was reached. At every configuration the pose is right to 1e-11, translations divided by the length scale.

    Raises:
        ConfigurationError: poses or start have the wrong shape or are not finite.
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
    if wanted.ndim != 3 or wanted.shape[1:] != (4, 4) or not len(wanted) or not np.isfinite(wanted).all():
        raise ConfigurationError("poses are finite matrices, one for each moment", where="poses",
                                 got=f"shape {wanted.shape}", allowed="shape (T, 4, 4), T ≥ 1")  # fmt: skip
    first = one_configuration(robot, start)
    return _Walk(robot, wanted, resolve_task(task, robot), limits, pull).run(first)


def between(start: Array, end: Array, share: Array) -> Array:
    """(N, 4, 4) poses at shares (N,) 0 … 1 from poses `start` to `end`, each (4, 4) or (N, 4, 4).

    The origin goes straight, the orientation turns about one axis at a constant rate, the shorter way round.
    """
    share = np.asarray(share, dtype=np.float64)
    turn = orientation_coordinates(end[..., :3, :3] @ np.swapaxes(start[..., :3, :3], -1, -2), "rotvec")
    made = np.zeros((len(share), 4, 4))
    made[:, :3, :3] = _rotation(share[:, None] * turn) @ start[..., :3, :3]
    made[:, :3, 3] = start[..., :3, 3] + share[:, None] * (end[..., :3, 3] - start[..., :3, 3])
    made[:, 3, 3] = 1.0
    return made


def solve(robot: Robot, poses: Array, q: Array, task: Task) -> tuple[Array, NDArray[np.bool_]]:
    """Newton's method at N poses (N, 4, 4) from N configurations (N, n): configurations, and which have arrived.

    Args:
        robot: the arm.
        poses: of the tip.
        q: where to begin.
        task: from `resolve_task`, told by the pose of the tip.
    """
    return _Aim(robot, task).solve(poses, q)


def _rotation(turn: Array) -> Array:
    """(N, 3, 3) rotations by vectors (N, 3), Rodrigues' formula."""
    angle = np.linalg.norm(turn, axis=1)
    safe = np.where(angle > 0.0, angle, 1.0)
    k = hat(turn / safe[:, None])
    return np.asarray(
        np.eye(3) + np.sin(angle)[:, None, None] * k + (1.0 - np.cos(angle))[:, None, None] * (k @ k)
    )


class _Aim:
    """Newton's method towards poses of the tip.

    Raises:
        TaskError: the pose of the tip does not tell what the task wants.
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
                "the pose of the tip does not tell what this task wants", got=task.frame,
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
        """(N, m) what is missing."""
        now = _core.pose(self._chain, q)
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
        factor = np.array([atan2(s, c) / s if s > 1e-9 else 1.0 for s, c in zip(sine, cosine, strict=True)])
        both = np.concatenate([shift / self.length, twist * factor[:, None]], axis=1)
        return np.asarray(both[:, self.rows])

    def _without(self, turn: Array, axis: int) -> Array:
        """(N, 3, 3) rotations less what they turn about one axis, which the task leaves free."""
        i, j = (axis + 1) % 3, (axis + 2) % 3
        angle = 2 * np.arctan2(turn[:, j, i] - turn[:, i, j], 1.0 + turn[:, 0, 0] + turn[:, 1, 1] + turn[:, 2, 2])
        back = _rotation(-angle[:, None] * np.eye(3)[axis])
        return np.asarray(turn @ back if self.with_tip else back @ turn)

    def jacobian(self, q: Array) -> Array:
        """(N, m, n) of scaled joints."""
        return np.asarray(_core.jacobian(self._chain, self._view, q) * self.joints)

    def step(self, q: Array, error: Array) -> Array:
        """(N, n) J⁺ e [rad, m]."""
        u, sigma, v = _core.svd(np.ascontiguousarray(self.jacobian(q)))
        count = sigma.shape[1]
        gains = np.divide(1.0, sigma, out=np.zeros_like(sigma), where=sigma > _WEAK)
        shares = gains * (error[:, None, :] @ u[:, :, :count])[:, 0]
        return np.asarray((v[:, :, :count] @ shares[:, :, None])[:, :, 0] * self.joints)

    def solve(self, poses: Array, q: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Configurations (N, n), and which are within 1e-11 of their poses."""
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

    def side(self, q: Array) -> float:
        """Sign of the determinant; 0 for arms that have none."""
        return float(np.linalg.slogdet(self.jacobian(q[None])[0])[0]) if self.square else 0.0


@dataclass(eq=False)
class _Walk:
    """One tool path, followed once."""

    robot: Robot
    poses: Array
    task: Task
    limits: bool
    pull: Pull | None

    def __post_init__(self) -> None:
        self.aim = _Aim(self.robot, self.task)
        self.low, self.high = self.robot.lower - 1e-9, self.robot.upper + 1e-9

    def run(self, start: Array) -> Followed:
        """From the first pose on."""
        found, arrived = self.aim.solve(self.poses[:1], start[None])
        now = found[0]
        if not arrived[0]:
            return Followed(start[None][:0], False, 1.0, start, "start", "the start does not reach the first pose")
        if (beyond := self._beyond(found)) >= 0:
            words = f"{self._name(beyond)} starts beyond its limit"
            return Followed(start[None][:0], False, 1.0, start, "limit", words)
        count = len(self.poses)
        rows, place, h, side = [found], 0.0, 1.0, self.aim.side(now)
        tries = _TRIES[0] + _TRIES[1] * count
        while place < count - 1:
            ahead = self._next(place, h, count)
            there = self._try(now, place, ahead, side)
            stopped = -1 if there is None else self._beyond(there)
            tries -= 1
            if there is None or stopped >= 0:
                if h < _SHORTEST or tries < 0:
                    return self._ended(rows, place, now, stopped)
                h = (ahead - place) / 2
                continue
            whole = int(ahead) - int(place)  # poses reached by this step
            if whole:
                rows.append(there[:whole])
            h, place, now = min(2.0 * (ahead - place), float(_MOST)), ahead, there[-1]
        return Followed(np.concatenate(rows), True, float(count), now, "", "")

    @staticmethod
    def _next(place: float, h: float, count: int) -> float:
        """The end of a step: a pose where it can be one, so that no share of a way is left over."""
        ahead = place + h
        if ahead >= int(place) + 1:
            ahead = float(int(ahead + 1e-9))
        return min(ahead, count - 1.0)

    def _at(self, place: float) -> Array:
        """(4, 4) the pose at a place counted from 0."""
        k = min(int(place), len(self.poses) - 1)
        if place == k:
            return np.asarray(self.poses[k])
        return np.asarray(between(self.poses[k], self.poses[k + 1], np.array([place - k]))[0])

    def _try(self, now: Array, place: float, ahead: float, side: float) -> Array | None:
        """(K, n) configurations at the poses after `place` up to `ahead`, its own last; None: too long a step."""
        target = self._at(ahead)[None]
        error = self.aim.error(target, now[None])
        if np.linalg.norm(error) > 1.0:  # Newton is not to be trusted so far
            return None
        guess = now + self.aim.step(now[None], error)[0]
        first = float(np.linalg.norm((guess - now) / self.aim.joints))
        if first > _LONGEST:
            return None
        guess = guess + self._pulled(now, first)
        found, arrived = self.aim.solve(target, guess[None])
        if not arrived[0]:
            return None
        end = found[0]
        added = float(np.linalg.norm((end - guess) / self.aim.joints))
        if added > _BENT * first + 1e-9 or (self.aim.square and self.aim.side(end) != side):
            return None
        inside = np.arange(int(place) + 1, int(np.ceil(ahead - 1e-12)))
        if not len(inside):
            return found
        share = ((inside - place) / (ahead - place))[:, None]
        line = now + share * (end - now)
        filled, reached = self.aim.solve(self.poses[inside], line)
        off = np.linalg.norm((filled - line) / self.aim.joints, axis=1)
        if not reached.all() or (off > _BENT * first + 1e-9).any():
            return None
        return np.asarray(np.concatenate([filled, end[None]]))

    def _pulled(self, now: Array, length: float) -> Array:
        """(n,) the part of the pull in the null space, for a step of some length."""
        if self.pull is None:
            return np.zeros_like(now)
        joints = self.aim.joints
        _, _, v = _core.svd(np.ascontiguousarray(self.aim.jacobian(now[None])))
        null = v[0][:, self.aim.rank :]
        return np.asarray(length * joints * (null @ (null.T @ (self.pull(now) / joints))))

    def _beyond(self, q: Array) -> int:
        """First joint beyond its limit in any row; −1 for none, or where limits do not count."""
        if not self.limits:
            return -1
        out = np.argwhere((q < self.low) | (q > self.high))
        return int(out[0, 1]) if len(out) else -1

    def _ended(self, rows: list[Array], place: float, now: Array, joint: int) -> Followed:
        sigma = float(singular_values(self.robot, now, self.aim.task)[self.aim.rank - 1])
        at = f"at pose {place + 1:.6g}"
        low = f"(σ{self.aim.rank} = {sigma:.1e} there)"
        if joint >= 0:
            reason, words = "limit", f"{self._name(joint)} reaches its limit {at}"
        elif sigma <= _SMALL:
            reason, words = "singular", f"the branch ends at a singularity {at} {low}"
        else:
            reason, words = "stuck", f"the corrector does not converge {at} {low}"
        return Followed(np.concatenate(rows), False, place + 1.0, now, reason, words)

    def _name(self, joint: int) -> str:
        return f"joint {joint + 1} ({self.robot.variables[joint].name})"
