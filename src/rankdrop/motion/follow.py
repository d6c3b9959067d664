"""Inverse kinematics along a tool path: joint values pose by pose, the branch kept, or where it cannot be followed.

Between two poses the tip goes straight and turns about one axis at a constant rate, as a linear move of a controller
does. Predictor and corrector are Newton's method towards a pose a little further on,

    q ← q + J⁺ e,   e = (p* − p ; log(R* Rᵀ)), its task rows, translations divided by the length scale,

with the pseudo-inverse: a redundant arm makes the shortest step. A step counts only where the corrector has little left
to correct, where no joint motion is long, and where no determinant changes its sign; otherwise it is halved, so that
the branch is kept up to the singularity or the limit at which it ends. Poses passed over by a step are filled in from a
straight guess between its ends, all at once, and polished to rounding. With a tolerance rows are put in until the tip
is proven to stay within it of its curve while the joints go straight from row to row (`TipDeviation`).
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
from rankdrop.motion.curve import numbered
from rankdrop.motion.inverse import Aim, TipDeviation, rotation
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task

Pull = Callable[[Array], Array]
"""pull(q) -> (n,) wanted joint motion per unit length of joint motion; its part in the null space is followed."""

_LONGEST = 0.15  # of a step in joint space [rad; slides divided by the length scale]
_BENT = 0.2  # share of a step that the corrector may add to the predictor
_SHORTEST = 1e-9  # step at which the branch has ended [of the way between two poses]
_TRIES = (400, 1)  # steps at most, and for each pose: a branch that creeps along a singularity ends
_MOST = 4096  # poses passed over by one step
_ROWS = 400_000  # at most
_ROUNDS, _PARTS = 8, 64  # of putting rows in within one step, and of one piece in one round
_SPARE = 1.1  # rows are put in for a bound so many times tighter
_SMALL = 1e-2  # σ_r at the end of a branch below which a singularity is named as its reason


@dataclass(frozen=True, eq=False)
class Followed:
    """Joint values along a tool path.

    Attributes:
        q: (K, n) configurations at the places [rad, m]; angles run on, they are not wrapped.
        place: (K,) poses reached, counted from 0; with a tolerance places between poses as well, as shares of the way.
        complete: every pose was reached.
        row: how far it got: number of the last pose reached, from 1, with the share of the way to the next.
        last: (n,) configuration there.
        reason: "" where complete, else "start", "singular", "limit" or "stuck".
        joint: number of the joint at its limit, from 1; 0 for other reasons.
        sigma: σ_r where it ended.
    """

    q: Array
    place: Array
    complete: bool
    row: float
    last: Array
    reason: str = ""
    joint: int = 0
    sigma: float = np.inf


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
    return _Walk(robot, wanted, resolve_task(task, robot), limits, pull, tolerance).run(first)


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


def poses_at(poses: Array, place: Array) -> Array:
    """(N, 4, 4) poses of the tip at places (N,) of a tool path (P, 4, 4), counted from 0."""
    k = np.clip(np.floor(place), 0, max(len(poses) - 2, 0)).astype(np.int64)
    return between(poses[k], poses[np.minimum(k + 1, len(poses) - 1)], place - k)


@dataclass(eq=False)
class _Walk:
    robot: Robot
    poses: Array
    task: Task
    limits: bool
    pull: Pull | None
    tolerance: tuple[float, float] | None

    def __post_init__(self) -> None:
        self.aim = Aim(self.robot, self.task)
        self.low, self.high = self.robot.lower - 1e-9, self.robot.upper + 1e-9
        self.tip = None if self.tolerance is None else TipDeviation(self.aim)

    def run(self, start: Array) -> Followed:
        """From the first pose on."""
        found, arrived = self.aim.solve(self.poses[:1], start[None])
        now, none = found[0], np.zeros(0)
        if not arrived[0]:
            return Followed(start[None][:0], none, False, 1.0, start, "start")
        if (beyond := self._beyond(found)) >= 0:
            return Followed(start[None][:0], none, False, 1.0, start, "limit", beyond + 1)
        count = len(self.poses)
        rows, places = [found], [np.zeros(1)]
        place, h, side, size = 0.0, 1.0, self.aim.side(now), 1
        tries = _TRIES[0] + _TRIES[1] * count
        while place < count - 1:
            ahead = self._next(place, h, count)
            step = self._try(now, place, ahead, side)
            stopped = -1 if step is None else self._beyond(step[1])
            tries -= 1
            if step is None or stopped >= 0:
                if h < _SHORTEST or tries < 0 or size > _ROWS:
                    return self._ended(rows, places, place, now, stopped)
                h = (ahead - place) / 2
                continue
            at, q = step
            kept = slice(None) if self.tip is not None else at == np.floor(at)
            rows.append(q[kept])
            places.append(at[kept])
            size += len(rows[-1])
            h, place, now = min(2.0 * (ahead - place), float(_MOST)), ahead, q[-1]
        return Followed(np.concatenate(rows), np.concatenate(places), True, float(count), now)

    @staticmethod
    def _next(place: float, h: float, count: int) -> float:
        """The end of a step: a pose where it can be one, so that no share of a way is left over."""
        ahead = place + h
        if ahead >= int(place) + 1:
            ahead = float(int(ahead + 1e-9))
        return min(ahead, count - 1.0)

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
        for _ in range(_ROUNDS):
            line = np.stack([np.interp(at, known, column) for column in q.T], axis=1)
            solved, reached = self.aim.solve(poses_at(self.poses, at), line)
            apart = np.linalg.norm((solved - line) / self.aim.joints, axis=1)
            if not reached.all() or (apart > off).any():
                return None
            solved[0], known, q = ends[0], at, solved
            if self.tip is None or self.tolerance is None:
                return at[1:], q[1:]
            away, turned = self.tip.bound(q, poses_at(self.poses, at))
            wide = np.maximum(away / self.tolerance[0], turned / self.tolerance[1])
            if (wide <= 1.0).all():
                return at[1:], q[1:]
            parts = np.where(wide > 1.0, np.clip(np.ceil(np.sqrt(_SPARE * wide)), 2, _PARTS), 1).astype(np.int64)
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
        if not self.limits:
            return -1
        out = np.argwhere((q < self.low) | (q > self.high))
        return int(out[0, 1]) if len(out) else -1

    def _ended(self, rows: list[Array], places: list[Array], place: float, now: Array, joint: int) -> Followed:
        sigma = float(singular_values(self.robot, now, self.aim.task)[self.aim.rank - 1])
        reason = "limit" if joint >= 0 else "singular" if sigma <= _SMALL else "stuck"
        return Followed(np.concatenate(rows), np.concatenate(places), False, place + 1.0, now, reason, joint + 1, sigma)
