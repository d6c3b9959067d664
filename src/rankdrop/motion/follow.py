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

import numpy as np
from numpy.typing import ArrayLike

from rankdrop import _core
from rankdrop.errors import ConfigurationError
from rankdrop.kinematics import one_configuration
from rankdrop.local.block import singular_values
from rankdrop.local.orientation import orientation_coordinates
from rankdrop.motion.inverse import Aim, rotation
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task

Pull = Callable[[Array], Array]
"""pull(q) -> (n,) wanted joint motion per unit length of joint motion; its part in the null space is followed."""

_LONGEST = 0.15  # of a step in joint space [rad; slides divided by the length scale]
_BENT = 0.2  # share of a step that the corrector may add to the predictor
_SHORTEST = 1e-6  # step at which the branch has ended [of the way between two poses]
_TRIES = (400, 1)  # steps at most, and for each pose: a branch that creeps along a singularity ends
_MOST = 4096  # poses passed over by one step
_SMALL = 1e-2  # σ_r at the end of a branch below which a singularity is named as its reason


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
    made[:, :3, :3] = rotation(share[:, None] * turn) @ start[..., :3, :3]
    made[:, :3, 3] = start[..., :3, 3] + share[:, None] * (end[..., :3, 3] - start[..., :3, 3])
    made[:, 3, 3] = 1.0
    return made


@dataclass(eq=False)
class _Walk:
    """One tool path, followed once."""

    robot: Robot
    poses: Array
    task: Task
    limits: bool
    pull: Pull | None

    def __post_init__(self) -> None:
        self.aim = Aim(self.robot, self.task)
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
