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

from rankdrop.path.check.tool_line import poses_between
from rankdrop.poses.inverse import Aim
from rankdrop.robot.model import Array

_STEPS = (0.04, 0.01, 2.5e-3)  # |Δq| of a departure that is tried [rad; slides scaled]
_SPREAD = (0.0, 1.0, -1.0, 4.0, -4.0)  # kernel parts of a guess, in shares of the step
_DIRECTIONS = 6  # random ones of a kernel of more than one dimension
_FAR = 12.0  # |Δq| of a smooth departure at most, in steps
_PROPORTIONAL = 0.25  # how far Δq may be from twice that of half the way; √2 or less where it is not smooth
_BENT = 0.5  # share of a kernel motion that the corrector may add
_CLOSE, _ARRIVED = 1e-12, 1e-10  # of an error: of Newton's method while it has rounds left, and at its end
_ROUNDS = 12
_STILL = 1e-9  # of w: the tool stands still
_SECOND = 1e-4  # σ_(r−1) below which the corank is 2 or more, and nothing is decided
_ALONG = 0.05  # steps along a self-motion [rad]
_SHORTEST = 1e-6  # of these steps: next to corank 2 the lost direction is not known
_POINTS = 400  # … each way; two turns of two joints are 260 of the longest
_KEPT = 0.9  # cosine between the directions lost at two of them at least: next to corank 2 it turns fast
_NOT_NEEDED = 1e-7  # |u·ξ| of a move that does not need the lost direction
_SMALL = 1e-3  # of a second difference along (x, w)
_DEFINITE = 1e-6  # of a quadratic form: it is definite, or rounding decides
_FLAT = 1e-6  # w of a unit direction of a self-motion
_CROSSED = 0.1  # share of a step that the corrector may add, and of w that is left at least
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


class StraightMove:
    """One straight move of a tool path, the one that begins or goes on at a place, seen from a configuration there."""

    def __init__(self, aim: Aim, poses: Array, place: float) -> None:
        k = min(int(place + 1e-12), len(poses) - 2)
        self.aim, self.start, self.end, self.k, self.place = aim, poses[k], poses[k + 1], k, place
        at = place - k
        self._ends = poses_between(self.start, self.end, np.array([at - _DELTA, at + _DELTA]))
        self.size = 0.0

    def seen_from(self, q: Array) -> Array:
        """(m,) ξ, of length 1, in the axes that the task has at q; `size` is |dx/d place|."""
        rows = np.broadcast_to(q, (2, len(q)))
        behind, ahead = self.aim.error(self._ends, np.ascontiguousarray(rows))
        rate = (ahead - behind) / (2 * _DELTA)
        self.size = float(np.linalg.norm(rate))
        return np.asarray(rate / self.size if self.size > 0.0 else rate)

    @property
    def room(self) -> float:
        """The way to the end of the move."""
        return (self.k + 1 - self.place) * self.size

    def place_at(self, w: float) -> float:
        """Place of the tool path a way w on."""
        if w >= self.room:
            return float(self.k + 1)
        return self.place + w / self.size

    def target(self, w: float) -> Array:
        """(1, 4, 4) pose a way w on; the move is continued beyond its ends."""
        return poses_between(self.start, self.end, np.array([self.place - self.k + w / self.size]))

    def solution_near(self, w: float, guess: Array) -> Array | None:
        """(n,) the solution next to a guess, a way w on."""
        solved, arrived = self.aim.solve(self.target(w), guess[None])
        if arrived[0]:
            return np.asarray(solved[0])
        return None

    def missing(self, y: Array) -> Array:
        """(m,) e at y = (x, w): the error from the pose of q = S x to the pose at w."""
        return np.asarray(self.aim.error(self.target(float(y[-1])), (y[:-1] * self.aim.joints)[None])[0])

    def slopes(self, y: Array) -> Array:
        """(m, n + 1) of −e at y = (x, w), q = S x: (J, −ξ), ξ = dx/dw at w in the axes that the task has at q."""
        now = (y[:-1] * self.aim.joints)[None]
        delta = _DELTA * self.size
        behind, ahead = (self.aim.error(self.target(y[-1] + part), now)[0] for part in (-delta, delta))
        xi = (ahead - behind) / (2 * delta)
        return np.hstack([self.aim.jacobian(now)[0], -xi[:, None]])

    def on_plane(self, guess: Array, across: Array) -> Array | None:
        """(n + 1,) the solution y = (x, w) on the plane through a guess across directions (k, n + 1) or (n + 1,).

        None where Newton's method does not arrive.
        """
        y, across = guess, np.atleast_2d(across)
        for _ in range(_ROUNDS):
            off = np.concatenate([self.missing(y), across @ (guess - y)])
            if np.linalg.norm(off) <= _CLOSE:
                return y
            y = y + np.linalg.lstsq(np.vstack([self.slopes(y), across]), off, rcond=1e-13)[0]
        if np.linalg.norm(self.missing(y)) <= _ARRIVED:
            return y
        return None


def _local_geometry(aim: Aim, q: Array) -> tuple[Array, Array, Array]:
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
    move = StraightMove(aim, poses, place)
    xi = move.seen_from(q)
    if move.size <= _STILL:
        return [], False
    _, sigma, kernel = _local_geometry(aim, q)
    if len(sigma) > 1 and sigma[-2] < _SECOND:
        return [], False
    room = move.room
    crossings = _crossing_departures(move, q, xi, room) or list(_smooth_departures(move, q, xi, kernel, room))
    if crossings:
        return crossings, False
    return _departures_from_rest(move, q, kernel, room)


def _crossing_departures(move: StraightMove, q: Array, xi: Array, room: float) -> list[Departure]:
    """Curves that cross where the move has no share along the direction that is lost, flattest first.

    The kernel of (J, −ξ) is a plane of (x, w) there. On solution curves uᵀe vanishes to second order, which is a
    quadratic form on that plane: its zeros are the directions of the curves, that of a self-motion (w = 0) among them.
    """
    aim = move.aim
    u, _, kernel = _local_geometry(aim, q)
    if kernel.shape[1] != 1 or abs(float(u @ xi)) > _NOT_NEEDED:
        return []
    y = np.append(q / aim.joints, 0.0)
    plane = np.linalg.svd(move.slopes(y))[2][-2:]
    ways = [way for way in _zeros(_second_order(move, y, u, plane), plane) if way[-1] > _FLAT]
    ways.sort(key=lambda way: -float(way[-1]))
    departing = [_departure_along(move, y, way, room) for way in ways]
    return [departure for departure in departing if departure is not None]


def _departure_along(move: StraightMove, y: Array, way: Array, room: float) -> Departure | None:
    """A smooth departure from y = (x, w) along a unit vector."""
    for step in _STEPS:
        guess = y + step * way
        end = move.on_plane(guess, way)
        if end is None or np.linalg.norm(end - guess) > _CROSSED * step:
            continue
        if _CROSSED * step * way[-1] < end[-1] <= room:
            return Departure(move.place_at(float(end[-1])), end[:-1] * move.aim.joints, False)
    return None


def _second_order(move: StraightMove, y: Array, u: Array, plane: Array) -> Array:
    """(2, 2) the quadratic form d²(uᵀe) on a plane (2, n + 1) on which uᵀe vanishes to first order."""

    def second(way: Array) -> float:
        ends = [u @ move.missing(y + sign * _SMALL * way) for sign in (1.0, -1.0)]
        return float(sum(ends)) / _SMALL**2

    first, last, both = second(plane[0]), second(plane[1]), second(plane[0] + plane[1])
    mixed = (both - first - last) / 2
    return np.array([[first, mixed], [mixed, last]])


def _zeros(form: Array, plane: Array) -> list[Array]:
    """Unit vectors of a plane on which a quadratic form is zero, with w ≥ 0; none where it is definite, or nearly so.
    """
    values, axes = np.linalg.eigh(form)
    low, high = values
    if low >= -_DEFINITE or high <= _DEFINITE:
        return []
    parts = np.sqrt(np.array([high, -low]))  # low · high + high · (−low) = 0
    zeros = []
    for sign in (1.0, -1.0):
        way = (axes @ (parts * np.array([1.0, sign]))) @ plane
        zeros.append(np.asarray(_same_way(way / np.linalg.norm(way), np.eye(len(way))[-1])))
    return zeros


def _smooth_departures(move: StraightMove, q: Array, xi: Array, kernel: Array, room: float) -> Iterator[Departure]:
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
                end = move.solution_near(w, guess)
                if end is None:
                    continue
                gone = (end - q) / aim.joints
                if np.linalg.norm(gone) > _FAR * step:
                    continue
                half = move.solution_near(w / 2, q + gone / 2 * aim.joints)
                if half is None:
                    continue
                bend = np.linalg.norm(gone - 2 * (half - q) / aim.joints)
                if bend > _PROPORTIONAL * np.linalg.norm(gone) + 1e-9:
                    continue
                if any(np.linalg.norm(gone - other) < 0.05 * step for other in known):
                    continue
                known.append(gone)
                yield Departure(move.place_at(w), end, False)
        if known:
            return


def _departures_from_rest(move: StraightMove, q: Array, kernel: Array, room: float) -> tuple[list[Departure], bool]:
    """Δq along the kernel first."""
    count = kernel.shape[1]
    ways = [np.eye(count)[i] for i in range(count)]
    if count > 1:
        ways += [way / np.linalg.norm(way) for way in np.random.default_rng(0).normal(size=(_DIRECTIONS, count))]
    departing: list[tuple[float, Departure]] = []
    leads = []
    for direction in ways:
        for way in (direction, -direction):
            lead, w, end = _lead(move, q, kernel, way, room)
            leads.append(lead)
            if end is not None:
                departing.append((w, Departure(move.place_at(w), end, True)))
    departing.sort(key=lambda pair: round(-pair[0], 9))
    folds = not departing and _Lead.UNKNOWN not in leads and _Lead.BACK in leads
    return [departure for _, departure in departing], folds


class _Lead(Enum):
    """Where a motion along the kernel leads on the path."""

    NOWHERE = auto()
    BACK = auto()
    AHEAD = auto()
    UNKNOWN = auto()


def _lead(move: StraightMove, q: Array, kernel: Array, way: Array, room: float) -> tuple[_Lead, float, Array | None]:
    """Where a way along the kernel leads; ahead: w at the end of a step, and the configuration there."""
    for step in _STEPS:
        half = _point_along_kernel(move, q, kernel, 0.5 * step * way)
        whole = _point_along_kernel(move, q, kernel, 1.0 * step * way)
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


def _point_along_kernel(move: StraightMove, q: Array, kernel: Array, offset: Array) -> tuple[Array, float] | None:
    """Configuration on the path whose kernel part is `offset` (k,), and w there; None where Newton fails."""
    aim = move.aim
    x0 = q / aim.joints
    across = np.hstack([kernel.T, np.zeros((kernel.shape[1], 1))])
    y = move.on_plane(np.append(x0 + kernel @ offset, 0.0), across)
    if y is None:
        return None
    x, w = y[:-1], float(y[-1])
    if np.linalg.norm(x - x0 - kernel @ offset) > _BENT * np.linalg.norm(offset):
        return None
    end = move.solution_near(w, x * aim.joints)
    if end is None or np.linalg.norm(end / aim.joints - x) > 1e-6:
        return None
    return end, w


def internal_turn(aim: Aim, poses: Array, place: float, q: Array, *, limits: bool) -> Array | None:
    """The nearest configuration of the self-motion through q from which the tool path goes on.

    Args:
        aim, poses, place, q: as for `departures`.
        limits: keep to the joint limits on the way.

    Returns:
        (n,), or None where the tool does not stand still along any curve through q, or no such point of it was found.
    """
    move = StraightMove(aim, poses, place)
    if _local_geometry(aim, q)[2].shape[1] != 1:
        return None
    turns = [_first_turn(move, q, sign, limits=limits) for sign in (1.0, -1.0)]
    for _, end in sorted((turn for turn in turns if turn is not None), key=itemgetter(0)):
        ways, _ = departures(aim, poses, place, end)
        if any(not departure.rest for departure in ways):
            return end
    return None


def _first_turn(move: StraightMove, q: Array, sign: float, *, limits: bool) -> tuple[float, Array] | None:
    """Along the self-motion from q one way, the first configuration where the lost direction leaves the path free.

    There the tool's next move ξ has no part along the lost direction u: uᵀξ changes its sign.

    Returns:
        How far it is along the curve, and the configuration (n,); None where there is none.
    """
    aim = move.aim
    u, _, kernel = _local_geometry(aim, q)
    heading = sign * kernel[:, 0]
    lost = float(u @ move.seen_from(q))
    now, length, step = q, 0.0, _ALONG
    for _ in range(_POINTS):
        new = _next_of_self_motion(move, now, heading, step)
        if new is None or not _keeps_lost_direction(aim, new, u):
            step /= 2
            if step < _SHORTEST:
                return None
            continue
        other = _same_way(_local_geometry(aim, new)[0], u)
        if limits and not _inside_limits(aim, new):
            return None
        gone = (new - now) / aim.joints
        length += float(np.linalg.norm(gone))
        heading = gone / np.linalg.norm(gone)
        after = float(other @ move.seen_from(new))
        if lost * after <= 0.0 and abs(lost - after) > 1e-9:
            return length, _zero_between(move, now, new, u, lost, after)
        now, u, lost = new, other, after
        step = min(2.0 * step, _ALONG)
        if length > 4 * _ALONG and _joint_distance(aim, now, q) < 0.6 * _ALONG:
            return None
    return None


def _keeps_lost_direction(aim: Aim, q: Array, u: Array) -> bool:
    """Whether the direction lost at a configuration is near enough to ±u to know its sign."""
    return float(abs(_local_geometry(aim, q)[0] @ u)) >= _KEPT


def _same_way(direction: Array, other: Array) -> Array:
    """A direction, or its negative, at an angle of at most 90° to another one."""
    if direction @ other >= 0.0:
        return direction
    return -direction


def _joint_distance(aim: Aim, q: Array, other: Array) -> float:
    """How far two configurations are apart, whole turns aside."""
    apart = np.abs(np.remainder(q - other + np.pi, 2 * np.pi) - np.pi)
    return float(np.linalg.norm(apart / aim.joints))


def _next_of_self_motion(move: StraightMove, now: Array, heading: Array, step: float) -> Array | None:
    """The next configuration with the same pose."""
    _, _, kernel = _local_geometry(move.aim, now)
    along = kernel @ (kernel.T @ heading)
    size = float(np.linalg.norm(along))
    if size < 0.5:
        return None
    guess = now + step * along / size * move.aim.joints
    new = move.solution_near(0.0, guess)
    if new is None or np.linalg.norm((new - guess) / move.aim.joints) > step / 3:
        return None
    return new


def _zero_between(move: StraightMove, a: Array, b: Array, u: Array, at_a: float, at_b: float) -> Array:
    """The configuration between two of a self-motion at which u·ξ = 0, by regula falsi on the curve."""
    low, high = 0.0, 1.0
    best = a
    for _ in range(40):
        share = low + (high - low) * (0.5 if abs(at_a - at_b) < 1e-15 else at_a / (at_a - at_b))
        guess = a + share * (b - a)
        new = move.solution_near(0.0, guess)
        best = guess if new is None else new
        value = float(_same_way(_local_geometry(move.aim, best)[0], u) @ move.seen_from(best))
        if abs(value) <= 1e-13 or high - low < 1e-14:
            break
        if value * at_a > 0.0:
            low, at_a, at_b = share, value, at_b / 2  # Illinois
        else:
            high, at_b, at_a = share, value, at_a / 2
    return best


def _inside_limits(aim: Aim, q: Array) -> bool:
    return bool(((q >= aim.robot.lower - 1e-9) & (q <= aim.robot.upper + 1e-9)).all())
