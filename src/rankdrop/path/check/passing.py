"""What a branch of a tool path does at a singular configuration: it goes on, it folds back, or it needs a turn first.

On a straight move the pose is x(w), w measured in units of the task's rows, ξ = dx/dw, |ξ| = 1. At a singularity of
corank 1, u is the direction lost, N the kernel of J in scaled joints. A departure is a solution curve q(w) that begins
at the configuration. Three kinds are looked for, by finite motion on the move itself:

    smooth   u·ξ = 0: Δq is proportional to Δw. Any time law will do.
    rest     u·ξ ≠ 0: the curve starts in the kernel, Δq = σ N e + …, s(σ) = c σ^k + …. The arm rests there.
    turn     none of these from here, but the tool stands still along a curve through the configuration
             (a self-motion), and at another of its points u·ξ = 0 and a smooth departure exists.

A branch that neither departs nor turns is met on one side of the pose only: it folds back. This is the geometry of
`path.mend.time_law`, which has the orders and the sources.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum, auto
from operator import itemgetter

import numpy as np

from rankdrop.path.check.tool_line import between
from rankdrop.poses.inverse import Aim
from rankdrop.robot.model import Array

_STEPS = (0.04, 0.01, 2.5e-3)  # |Δq| of a departure that is tried [rad; slides scaled]
_SPREAD = (0.0, 1.0, -1.0, 4.0, -4.0)  # kernel parts of a guess, in shares of the step
_DIRECTIONS = 6  # random ones of a kernel of more than one dimension
_FAR = 12.0  # |Δq| of a smooth departure at most, in steps
_PROPORTIONAL = 0.25  # how far Δq may be from twice that of half the way; √2 or less where it is not smooth
_BENT = 0.5  # share of a kernel motion that the corrector may add
_CLOSE = 1e-12
_ROUNDS = 12
_STILL = 1e-9  # of w: the tool stands still
_SECOND = 1e-4  # σ_(r−1) below which the corank is 2 or more, and nothing is decided
_ALONG, _POINTS = 0.05, 260  # along a self-motion [rad]; points each way, two turns of two joints
_DELTA = 1e-6  # of a difference quotient of the pose


@dataclass(frozen=True, eq=False)
class Departure:
    """A point of a curve q(w) that leaves a singular configuration on the tool path.

    Attributes:
        place: of the tool path, counted from 0.
        q: (n,) there [rad, m].
        rest: the arm has to rest at the singular configuration: joint rates per path speed have no bound there.
    """

    place: float
    q: Array
    rest: bool


@dataclass(frozen=True, eq=False)
class Turn:
    """An internal turn: joint motion that leaves the tool where it is.

    Attributes:
        place: number of the pose at which it is made, from 1.
        q: (n,) configuration at its start, and
        to: (n,) at its end [rad, m].
        rest_complete: after it the tool path can be followed to its end; None where that was not tried.
        rest_reached: number of the last pose reached after it, with the share of the way to the next.
    """

    place: float
    q: Array
    to: Array
    rest_complete: bool | None = None
    rest_reached: float = 0.0


class _Move:
    """One straight move of a tool path, seen from a configuration on it."""

    def __init__(self, aim: Aim, poses: Array, k: int, place: float) -> None:
        self.aim, self.start, self.end, self.k, self.place = aim, poses[k], poses[k + 1], k, place
        at = place - k
        self._ends = between(self.start, self.end, np.array([at - _DELTA, at + _DELTA]))
        self.size = 0.0

    def seen_from(self, q: Array) -> Array:
        """(m,) ξ, of length 1, in the axes that the task has at q; `size` is |dx/d place|."""
        rows = np.broadcast_to(q, (2, len(q)))
        behind, ahead = self.aim.error(self._ends, np.ascontiguousarray(rows))
        rate = (ahead - behind) / (2 * _DELTA)
        self.size = float(np.linalg.norm(rate))
        return np.asarray(rate / self.size if self.size > 0.0 else rate)

    def target(self, w: float) -> Array:
        """(1, 4, 4) pose a way w on; the move is continued beyond its ends."""
        return between(self.start, self.end, np.array([self.place - self.k + w / self.size]))

    def solved(self, w: float, guess: Array) -> Array | None:
        """(n,) the solution next to a guess, a way w on."""
        found, arrived = self.aim.solve(self.target(w), guess[None])
        if arrived[0]:
            return np.asarray(found[0])
        return None


def _local(aim: Aim, q: Array) -> tuple[Array, Array, Array]:
    """u (m,), σ (r,) and N (n, n − r + 1) at q, for corank 1; r the generic rank."""
    u, sigma, vt = np.linalg.svd(aim.jacobian(q[None])[0])
    r = aim.rank
    return u[:, r - 1], sigma[:r], vt[r - 1 :].T


def departures(aim: Aim, poses: Array, place: float, q: Array) -> tuple[list[Departure], bool]:
    """Curves ahead from a configuration near a singular one on a tool path.

    Args:
        aim: of an arm whose generic rank is the number of rows.
        poses: (P, 4, 4) of the tool path.
        place: of it, counted from 0; the move that begins or goes on there is followed.
        q: (n,) configuration there [rad, m].

    Returns:
        Departures, smooth ones first, then those that begin with a larger step; and whether there is none because the
        branch folds back: the path was followed by finite motion, and all of it is behind.
    """
    k = min(int(place + 1e-12), len(poses) - 2)
    move = _Move(aim, poses, k, place)
    xi = move.seen_from(q)
    if move.size <= _STILL:
        return [], False
    _, sigma, kernel = _local(aim, q)
    if len(sigma) > 1 and sigma[-2] < _SECOND:
        return [], False
    room = (k + 1 - place) * move.size  # of this move
    found = list(_smooth(move, q, xi, kernel, room))
    if found:
        return found, False
    return _from_rest(move, q, kernel, room)


def _smooth(move: _Move, q: Array, xi: Array, kernel: Array, room: float) -> Iterator[Departure]:
    """Δq proportional to Δw."""
    aim = move.aim
    ahead = aim.step(q[None], xi[None])[0] / aim.joints
    weak = kernel @ (kernel.T @ ahead)
    ahead = ahead - weak  # J⁺ξ without what the lost direction adds
    slope = max(1.0, float(np.linalg.norm(ahead)))
    known: list[Array] = []
    for step in _STEPS:
        w = min(step / slope, room)
        for share in _SPREAD:
            for direction in kernel.T if share else kernel.T[:1]:
                guess = q + (w * ahead + share * step * direction) * aim.joints
                end = move.solved(w, guess)
                if end is None:
                    continue
                gone = (end - q) / aim.joints
                if np.linalg.norm(gone) > _FAR * step:
                    continue
                half = move.solved(w / 2, q + gone / 2 * aim.joints)
                if half is None:
                    continue
                bend = np.linalg.norm(gone - 2 * (half - q) / aim.joints)
                if bend > _PROPORTIONAL * np.linalg.norm(gone) + 1e-9:
                    continue
                if any(np.linalg.norm(gone - other) < 0.05 * step for other in known):
                    continue
                known.append(gone)
                yield Departure(_place(move, w, room), end, False)
        if known:
            return


def _from_rest(move: _Move, q: Array, kernel: Array, room: float) -> tuple[list[Departure], bool]:
    """Δq along the kernel first."""
    count = kernel.shape[1]
    ways = [np.eye(count)[i] for i in range(count)]
    if count > 1:
        ways += [way / np.linalg.norm(way) for way in np.random.default_rng(0).normal(size=(_DIRECTIONS, count))]
    found: list[tuple[float, Departure]] = []
    leads = []
    for direction in ways:
        for way in (direction, -direction):
            lead, w, end = _lead(move, q, kernel, way, room)
            leads.append(lead)
            if end is not None:
                found.append((w, Departure(_place(move, w, room), end, True)))
    found.sort(key=lambda pair: round(-pair[0], 9))
    folds = not found and _Lead.UNKNOWN not in leads and _Lead.BACK in leads
    return [departure for _, departure in found], folds


class _Lead(Enum):
    """Where a motion along the kernel leads on the path."""

    NOWHERE = auto()
    BACK = auto()
    AHEAD = auto()
    UNKNOWN = auto()


def _lead(move: _Move, q: Array, kernel: Array, way: Array, room: float) -> tuple[_Lead, float, Array | None]:
    """Where a way along the kernel leads; ahead: w at the end of a step, and the configuration there."""
    for step in _STEPS:
        half = _along(move, q, kernel, 0.5 * step * way)
        whole = _along(move, q, kernel, 1.0 * step * way)
        if half is None or whole is None:
            continue
        at_half, (end, at_end) = half[1], whole
        if max(abs(at_half), abs(at_end)) <= _STILL:
            return _Lead.NOWHERE, at_end, None
        if at_end < 0.0 and at_half < 0.0:
            return _Lead.BACK, at_end, None
        if 0.0 < at_half < at_end <= room:
            return _Lead.AHEAD, at_end, end
    return _Lead.UNKNOWN, 0.0, None


def _along(move: _Move, q: Array, kernel: Array, offset: Array) -> tuple[Array, float] | None:
    """Configuration on the path whose kernel part is `offset` (k,), and w there; None where Newton fails."""
    aim = move.aim
    x0 = q / aim.joints
    x, w = x0 + kernel @ offset, 0.0
    n = len(q)
    for _ in range(_ROUNDS):
        now = x * aim.joints
        target = move.target(w)
        error = np.concatenate([aim.error(target, now[None])[0], offset - kernel.T @ (x - x0)])
        if np.linalg.norm(error) <= _CLOSE:
            break
        delta = _DELTA * move.size
        ends = [aim.error(move.target(w + part), now[None])[0] for part in (-delta, delta)]
        xi = (ends[1] - ends[0]) / (2 * delta)
        top = np.hstack([aim.jacobian(now[None])[0], -xi[:, None]])
        low = np.hstack([kernel.T, np.zeros((kernel.shape[1], 1))])
        change = np.linalg.lstsq(np.vstack([top, low]), error, rcond=1e-13)[0]
        x, w = x + change[:n], w + float(change[n])
    if np.linalg.norm(x - x0 - kernel @ offset) > _BENT * np.linalg.norm(offset):
        return None
    end = move.solved(w, x * aim.joints)
    if end is None or np.linalg.norm(end / aim.joints - x) > 1e-6:
        return None
    return end, w


def _place(move: _Move, w: float, room: float) -> float:
    if w >= room:
        return float(move.k + 1)
    return move.place + w / move.size


def internal_turn(aim: Aim, poses: Array, place: float, q: Array, *, limits: bool) -> Array | None:
    """The nearest configuration of the self-motion through q from which the tool path goes on.

    Args:
        aim, poses, place, q: as for `departures`.
        limits: keep to the joint limits on the way.

    Returns:
        (n,), or None where the tool does not stand still along any curve through q, or no such point of it was found.
    """
    k = min(int(place + 1e-12), len(poses) - 2)
    move = _Move(aim, poses, k, place)
    if _local(aim, q)[2].shape[1] != 1:
        return None
    turns = [_first_turn(move, q, sign, limits=limits) for sign in (1.0, -1.0)]
    for _, end in sorted((turn for turn in turns if turn is not None), key=itemgetter(0)):
        found, _ = departures(aim, poses, place, end)
        if any(not departure.rest for departure in found):
            return end
    return None


def _first_turn(move: _Move, q: Array, sign: float, *, limits: bool) -> tuple[float, Array] | None:
    """Along the self-motion from q one way, the first configuration where the lost direction leaves the path free.

    There the tool's next move ξ has no part along the lost direction u: uᵀξ changes its sign.

    Returns:
        How far it is along the curve, and the configuration (n,); None where there is none.
    """
    aim = move.aim
    u, _, kernel = _local(aim, q)
    heading = sign * kernel[:, 0]
    lost = float(u @ move.seen_from(q))
    now, length = q, 0.0
    for _ in range(_POINTS):
        new = _next(move, now, heading, _ALONG)
        if new is None or (limits and not _inside(aim, new)):
            return None
        step = (new - now) / aim.joints
        length += float(np.linalg.norm(step))
        heading = step / np.linalg.norm(step)
        other = _same_way(_local(aim, new)[0], u)
        after = float(other @ move.seen_from(new))
        if lost * after <= 0.0 and abs(lost - after) > 1e-9:
            return length, _zero(move, now, new, u, lost, after)
        now, u, lost = new, other, after
        if length > 4 * _ALONG and _apart(aim, now, q) < 0.6 * _ALONG:
            return None
    return None


def _same_way(direction: Array, other: Array) -> Array:
    """A direction, or its negative, at an angle of at most 90° to another one."""
    if direction @ other >= 0.0:
        return direction
    return -direction


def _apart(aim: Aim, q: Array, other: Array) -> float:
    """How far two configurations are apart, whole turns aside."""
    apart = np.abs(np.remainder(q - other + np.pi, 2 * np.pi) - np.pi)
    return float(np.linalg.norm(apart / aim.joints))


def _next(move: _Move, now: Array, heading: Array, step: float) -> Array | None:
    """The next configuration with the same pose."""
    _, _, kernel = _local(move.aim, now)
    along = kernel @ (kernel.T @ heading)
    size = float(np.linalg.norm(along))
    if size < 0.5:
        return None
    guess = now + step * along / size * move.aim.joints
    new = move.solved(0.0, guess)
    if new is None or np.linalg.norm((new - guess) / move.aim.joints) > step / 3:
        return None
    return new


def _zero(move: _Move, a: Array, b: Array, u: Array, at_a: float, at_b: float) -> Array:
    """The configuration between two of a self-motion at which u·ξ = 0, by regula falsi on the curve."""
    low, high = 0.0, 1.0
    best = a
    for _ in range(40):
        share = low + (high - low) * (0.5 if abs(at_a - at_b) < 1e-15 else at_a / (at_a - at_b))
        guess = a + share * (b - a)
        new = move.solved(0.0, guess)
        best = guess if new is None else new
        value = float(_same_way(_local(move.aim, best)[0], u) @ move.seen_from(best))
        if abs(value) <= 1e-13 or high - low < 1e-14:
            break
        if value * at_a > 0.0:
            low, at_a, at_b = share, value, at_b / 2  # Illinois
        else:
            high, at_b, at_a = share, value, at_a / 2
    return best


def _inside(aim: Aim, q: Array) -> bool:
    return bool(((q >= aim.robot.lower - 1e-9) & (q <= aim.robot.upper + 1e-9)).all())
