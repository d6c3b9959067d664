"""How do the joints cross a singularity that poses miss by as little as they are rounded?

Where a tool path misses a singularity of its branch, the exact solutions turn by up to half a turn within next to no
way of the tool. The joints go straight across it instead, from a solution behind it to one as far ahead, and the tip
keeps its tolerance of the curve (`Aim.deviation`). At the pose that misses it the joints are at the singularity.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rankdrop.local.block import singular_values
from rankdrop.path.check.passing import StraightMove
from rankdrop.path.check.tool_line import poses_at
from rankdrop.poses.inverse import Aim
from rankdrop.poses.unreached import ROUNDED
from rankdrop.robot.model import Array, first_joint_beyond_limit

_ACROSS = (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4)  # σ_r of the row behind a singularity from which a step leads over it
_SAME = 1e-11  # error of poses that a configuration has; translations divided by the length scale
_FROM_START = 0.1  # of a pose: a start farther off is brought to it by Newton's method alone
_MISSED = 1e-5  # σ_r of a start that counts as at a singularity that its pose misses by rounding
_LEAVING = 0.5 ** np.arange(16)  # shares of the first move that are tried to leave it
_LONGEST = 0.15  # of these in joint space [rad; slides divided by the length scale]
_BENT = 0.2  # share of a step by which a solution may be off the straight line
_TRUNCATED = 4  # steps of Newton's method without the weakest direction
_ONTO, _STEP = 6, 1e-6  # of Newton's method along the weakest direction; of its differences [rad]


def without_weakest(aim: Aim, target: Array, q: Array) -> Array:
    """(n,) Newton's method from q (n,) towards a pose (1, 4, 4), the weakest direction left alone.

    Steps are Δq = V₁ Σ₁⁻¹ U₁ᵀ e, of J = U Σ Vᵀ in scaled joints without its smallest singular value.
    """
    for _ in range(_TRUNCATED):
        u, sigma, vt = np.linalg.svd(aim.jacobian(q[None])[0])
        strong = aim.rank - 1
        part = u[:, :strong].T @ aim.error(target, q[None])[0] / sigma[:strong]
        q = q + vt[:strong].T @ part * aim.joints
    return q


def missed_start(aim: Aim, goal: Array, start: Array) -> Array | None:
    """(n,) the singular configuration next to a start (n,) that a pose (4, 4) misses by as little as poses are rounded.

    None where there is none, or the pose has one of the singularity itself.
    """
    if not aim.square or float(np.linalg.norm(aim.error(goal[None], start[None]))) > _FROM_START:
        return None
    singular = without_weakest(aim, goal[None], _onto_singularity(aim, start))
    off = float(np.linalg.norm(aim.error(goal[None], singular[None])))
    sigma = singular_values(aim.robot, singular, aim.task)[aim.rank - 1]
    if _SAME < off <= ROUNDED and sigma <= _MISSED:
        return singular
    return None


def _onto_singularity(aim: Aim, q: Array) -> Array:
    """(n,) q moved along its weakest direction v to where ±σ_r, signed as det J, is zero; q where that leads away.

    Newton's steps on the sign times σ_r, its derivative along v by differences.
    """
    first, moved = _signed_weakest(aim, q), 0.0
    way = first.way
    here = first
    for _ in range(_ONTO):
        slope = (_signed_weakest(aim, q + (moved + _STEP) * way).sigma - here.sigma) / _STEP
        if abs(here.sigma) >= _LONGEST * abs(slope):
            return q
        moved -= here.sigma / slope
        here = _signed_weakest(aim, q + moved * way)
    if abs(here.sigma) > min(abs(first.sigma), _MISSED):
        return q
    return np.asarray(q + moved * way)


class _Weakest(NamedTuple):
    """σ_r signed as det J, and the joint motion (n,) of its direction [rad, m]."""

    sigma: float
    way: Array


def _signed_weakest(aim: Aim, q: Array) -> _Weakest:
    """The smallest singular value at q (n,)."""
    u, sigma, vt = np.linalg.svd(aim.jacobian(q[None])[0])
    sign = np.sign(np.linalg.det(u) * np.linalg.det(vt))
    return _Weakest(float(sign * sigma[-1]), vt[-1] * aim.joints)


@dataclass(frozen=True, eq=False)
class StraightRows:
    """Rows of joints that go straight, after the row that they begin at.

    Attributes:
        behind: index of the row that they begin at.
        place: (K,) places, counted in poses from 0.
        q: (K, n) configurations there [rad, m].
        missed: places of poses at the singularity, which the rows miss by rounding.
    """

    behind: int
    place: Array
    q: Array
    missed: frozenset[float]


@dataclass(frozen=True, eq=False)
class StraightCrossing:
    """Straight joint motion across singularities that poses of a tool path miss by rounding.

    Attributes:
        aim: the arm and its task.
        poses: (P, 4, 4) of the tip.
        tolerance: how far the tip may leave its curve: its place [m] and its turn [rad].
        limits: joints keep their limits.
    """

    aim: Aim
    poses: Array
    tolerance: tuple[float, float]
    limits: bool

    def leave(self, singular: Array) -> StraightRows | None:
        """Straight away from a singularity (n,) that the first pose misses; None where no row ahead is straight on.

        The row ahead and that half the way to it are solutions, in line with the singularity; the joints go straight
        between them, within the tolerance of the tip.
        """
        for share in _LEAVING:
            ahead = self._solution_ahead(singular, float(share))
            if ahead is None:
                continue
            ends = np.stack([singular, ahead])
            rows = self._straight_rows(0, np.array([0.0, share]), ends, frozenset({0.0}))
            if rows is not None:
                return rows
        return None

    def _solution_ahead(self, singular: Array, share: float) -> Array | None:
        """(n,) the configuration after a share of the first move, straight on from a singularity (n,); else None."""
        targets = poses_at(self.poses, np.array([share, share / 2.0]))
        guesses = np.stack([without_weakest(self.aim, targets[k : k + 1], singular) for k in range(2)])
        solutions, arrived = self.aim.solve(targets, guesses)
        step = (solutions - singular) / self.aim.joints
        size = float(np.linalg.norm(step[0]))
        if not arrived.all() or size > _LONGEST or np.linalg.norm(step[1] - step[0] / 2.0) > _BENT * size / 2.0:
            return None
        sigma = singular_values(self.aim.robot, solutions[:1], self.aim.task)[0, self.aim.rank - 1]
        if sigma < _ACROSS[-1] or self._beyond_limits(solutions):
            return None
        return np.asarray(solutions[0])

    def cross(self, rows: Array, places: Array, place: float) -> StraightRows | None:
        """Straight on over a singularity that lies on the branch, or next to it by as little as poses are rounded.

        Args:
            rows: (K, n) of the branch so far, the last one next to the singularity.
            places: (K,) of the rows.
            place: of the singularity.

        Returns:
            Rows ahead, and which row they begin at; None where no row ahead is straight on.
        """
        sigma = singular_values(self.aim.robot, rows, self.aim.task)[:, self.aim.rank - 1]
        for clear in _ACROSS:
            far, farther = np.flatnonzero(sigma >= clear), np.flatnonzero(sigma >= 2.0 * clear)
            if not len(farther) or farther[-1] == far[-1]:
                continue
            behind = int(far[-1])
            share = float(sigma[behind] / (sigma[farther[-1]] - sigma[behind]))
            singular = rows[behind] + share * (rows[behind] - rows[farther[-1]])
            end = self._end_across(place, rows[behind], singular)
            if end is None:
                continue
            end_place, end_row, missed = end
            if int(places[behind]) + 1.0 < place:  # the row at a pose is kept
                behind = len(rows) - 1
            at = np.append(places[behind], end_place)
            across = self._straight_rows(behind, at, np.stack([rows[behind], end_row]), missed)
            if across is not None:
                return across
        return None

    def _end_across(
        self, place: float, behind: Array, singular: Array
    ) -> tuple[float, Array, frozenset[float]] | None:
        """Place and configuration (n,) as far ahead of a singularity as a row is behind it, and the place of a last
        pose that misses the singularity.

        None where no solution is straight on, or the singularity that the joints going straight meet, about `singular`
        (n,), is farther from the path than poses are rounded.
        """
        aim, target = self.aim, poses_at(self.poses, np.array([place]))
        if np.linalg.norm(aim.error(target, without_weakest(aim, target, singular)[None])) > ROUNDED:
            return None
        ahead = self._as_far_ahead(place, behind, singular)
        if ahead is None:
            return self._end_at_singularity(singular)
        guess = 2.0 * singular - behind
        solutions, arrived = aim.solve(poses_at(self.poses, np.array([ahead])), guess[None])
        off = float(np.linalg.norm((solutions[0] - guess) / aim.joints))
        straight = arrived[0] and off <= _BENT * float(np.linalg.norm((singular - behind) / aim.joints))
        if not straight or aim.side(solutions[0]) == aim.side(behind):
            return None
        return ahead, solutions[0], frozenset()

    def _end_at_singularity(self, singular: Array) -> tuple[float, Array, frozenset[float]] | None:
        """As `_end_across`, where the path ends at the singularity."""
        last, target = len(self.poses) - 1.0, self.poses[-1:]
        end = without_weakest(self.aim, target, singular)
        if np.linalg.norm(self.aim.error(target, end[None])) > ROUNDED:
            return None
        return last, end, frozenset({last})

    def _as_far_ahead(self, place: float, behind: Array, singular: Array) -> float | None:
        """The place as far ahead of a place as that of a configuration is behind it; None beyond the last pose."""
        way = float(np.linalg.norm(self.aim.error(poses_at(self.poses, np.array([place])), behind[None])))
        while place < len(self.poses) - 1.0:
            move = StraightMove(self.aim, self.poses, place)
            move.seen_from(singular)
            if move.size > 0.0 and way <= move.room:
                return move.place_at(way)
            way -= move.room
            place = move.k + 1.0
        return None

    def _straight_rows(self, behind: int, at: Array, ends: Array, missed: frozenset[float]) -> StraightRows | None:
        """Rows after the first of two ends, with those at the poses between them, of joints that go straight.

        None where the tip leaves its tolerance, or a joint its range.

        Args:
            behind: index of the row at the first end.
            at: (2,) places of the ends.
            ends: (2, n) configurations there.
            missed: places of the ends that miss the singularity; those of poses between them do, too.
        """
        between = np.arange(np.floor(at[0]) + 1.0, np.ceil(at[1]))
        at = np.concatenate([at[:1], between, at[1:]])
        targets = poses_at(self.poses, at)
        q = ends[0] + ((at - at[0]) / (at[-1] - at[0]))[:, None] * (ends[1] - ends[0])
        for k in range(1, len(at) - 1):
            q[k] = without_weakest(self.aim, targets[k : k + 1], q[k])
        away, turned = self.aim.deviation(q, targets)
        wide = np.maximum(away / self.tolerance[0], turned / self.tolerance[1])
        if (wide > 1.0).any() or self._beyond_limits(q):
            return None
        return StraightRows(behind, at[1:], q[1:], missed | frozenset(between.tolist()))

    def _beyond_limits(self, q: Array) -> bool:
        """Whether a row (K, n) leaves the joint limits, where they count."""
        return self.limits and first_joint_beyond_limit(self.aim.robot, q) >= 0
