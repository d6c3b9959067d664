"""A new time law for a path that keeps where it goes: inside rate and acceleration limits, never faster than it was.

Reachability on a grid, as in time-optimal path parameterisation: with y the square of the speed along the path, rate
limits are caps on y, and acceleration limits are |α y' − β y| ≤ a between neighbours on the grid. Backwards, the
largest y from which the end can still be reached; forwards, as fast as that allows (Pham and Pham, IEEE T-RO 2018).
The grid decides how good the law is, not whether it holds: what the curve that comes out needs is then bounded
everywhere (`usage`), and if that is above a limit the whole law is slowed down by as much, which is exact.

Straight stretches jump in their rates at every row, and no finite acceleration follows that. Held against the limit is
that of the parabolic blends from the middle of each stretch to the middle of the next, which rounds the corner between.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rankdrop.path.curve import Curve, halves, number_parts
from rankdrop.path.read.trajectory import Trajectory
from rankdrop.robot.model import Array
from rankdrop.text.remedies import BOUNDED

_STILL, _LEAST = 1e-3, 1e-9  # durations of stretches that no time and no rate holds back, at rest and moving [s]
_PARTS = 200  # a straight path is cut into so many pieces at least, where accelerations are limited
_PIECE = {3: 0.008, 5: 0.003}  # … and a smooth one into pieces no longer than this, by degree, for 1e-9 of it [rad]
_FEWEST, _MOST = 4, 1024  # pieces of one smooth stretch
_EASY = 0.25  # y falls to this share of itself from one place of the grid to the next at most
_FLAT = 1e-12  # share of the largest α below which one is zero


@dataclass(frozen=True, slots=True)
class Usage:
    """What a timed curve takes of its limits, as shares that it nowhere exceeds; 0 where there are no limits.

    Attributes:
        rate: of the rate limits.
        acceleration: of the acceleration limits.
        straight: between its rows; else it is smooth.
    """

    rate: float
    acceleration: float
    straight: bool

    @property
    def how(self) -> str:
        """What was bounded, in words."""
        return BOUNDED[self.straight]

    @property
    def slower(self) -> float:
        """The factor, at least 1, that all durations have to be longer by."""
        return max(1.0, self.rate, float(np.sqrt(self.acceleration)))


def usage(path: Curve, rates: Array, accelerations: Array) -> Usage:
    """Bounds that hold at every instant, between rows too.

    Args:
        path: a curve with times.
        rates, accelerations: (n,) limits [rad/s, rad/s²; m]; inf where there are none.
    """
    assert path.times is not None
    lasts = np.diff(path.times)[:, None]
    if path.degree == 1:
        speed = np.diff(path.control, axis=1)[:, 0] / lasts
        rest = np.zeros((1, speed.shape[1]))
        jump = np.abs(np.diff(np.concatenate([rest, speed, rest]), axis=0))
        long = np.concatenate([lasts[:1], lasts[:-1] + lasts[1:], lasts[-1:]]) / 2
        return Usage(_share(np.abs(speed), rates), _share(jump / long, accelerations), True)
    control, lasts = halves(halves(path.control)), np.repeat(lasts, 4, axis=0)[:, None] / 4
    first = path.degree * np.diff(control, axis=1) / lasts
    second = (path.degree - 1) * np.diff(first, axis=1) / lasts
    return Usage(_share(np.abs(first), rates), _share(np.abs(second), accelerations), False)


def _share(values: Array, limits: Array) -> float:
    most = values.reshape(-1, values.shape[-1]).max(axis=0, initial=0.0)
    return float((most / limits).max(initial=0.0))


def retime_path(path: Curve, rates: Array, accelerations: Array, scale: Array) -> Trajectory:
    """The same path in time: inside the limits everywhere, nowhere faster than it was, fast where it may be.

    Straight paths keep their rows, and get more on long stretches where accelerations are limited; others get rows on
    the curve, with the velocities (and accelerations, for quintics) that interpolate it.

    Args:
        path: the curve; without times only a straight one.
        rates, accelerations: (n,) limits; inf where there are none.
        scale: (n,) of joint motions.
    """
    if path.degree == 1:
        return _straight(path, rates, accelerations, scale)
    return _smooth(path, rates, accelerations, scale)


def _straight(path: Curve, rates: Array, accelerations: Array, scale: Array) -> Trajectory:
    bounded = bool(np.isfinite(accelerations).any())
    steps = path.control[:, -1] - path.control[:, 0]
    parts = np.ones(len(steps), dtype=np.int64)
    if bounded:
        length = np.linalg.norm(steps / scale, axis=1)
        parts = np.maximum(1, np.ceil(_PARTS * length / max(float(length.sum()), 1e-300))).astype(np.int64)
    stretch, part = number_parts(parts)
    q = np.concatenate([path.at(stretch, part / parts[stretch]), path.control[-1:, -1]])
    move = steps[stretch] / parts[stretch, None]
    if path.times is None:
        was = np.zeros(len(stretch))
    else:
        was = np.diff(path.times)[stretch] / parts[stretch]
    least = np.maximum(was, (np.abs(move) / rates).max(axis=1))
    least = np.where(least > 0.0, least, np.where(move.any(axis=1), _LEAST, _STILL))
    h = np.linalg.norm(move / scale, axis=1)
    h = np.where(h > 0.0, h, np.median(h[h > 0.0]) if h.any() else 1.0)  # of a stretch at rest, any length will do
    y = (h / least) ** 2
    if bounded:
        turn = move / h[:, None]
        ends = np.abs(turn[[0, -1]]) * 2 / accelerations
        y[[0, -1]] = np.minimum(y[[0, -1]], h[[0, -1]] / np.maximum(ends.max(axis=1), 1e-300))
        both = 2 * (h[1:] + h[:-1])[:, None]
        y = fastest((3 * turn[1:] - turn[:-1]) / both, (3 * turn[:-1] - turn[1:]) / both, accelerations, y)
    return _slow_whole(_in_time(q, h / np.sqrt(y), path.times), "linear", rates, accelerations)


def _smooth(path: Curve, rates: Array, accelerations: Array, scale: Array) -> Trajectory:
    assert path.times is not None
    lasts = np.diff(path.times)
    length = np.linalg.norm(np.diff(path.control, axis=1) / scale, axis=2).sum(axis=1)
    parts = np.clip(np.ceil(length / _PIECE[path.degree]), _FEWEST, _MOST).astype(np.int64)
    stretch, part = number_parts(parts)
    step = lasts[stretch] / parts[stretch]
    low, middle, high = (derivatives(path, stretch, (part + at) / parts[stretch]) for at in (0.0, 0.5, 1.0))
    slope = np.concatenate([low[1], high[1][-1:]])
    cap = np.minimum(1.0, ((rates / np.maximum(np.abs(slope), 1e-300)).min(axis=1)) ** 2)
    ahead, bend = middle[1] / (2 * step[:, None]), middle[2] / 2
    x = fastest(ahead + bend, ahead - bend, accelerations, cap)
    speed = np.sqrt(x)
    gain = np.diff(x) / (2 * step)
    gain = np.concatenate([gain[:1], (gain[:-1] + gain[1:]) / 2, gain[-1:]])
    bends = np.concatenate([low[2][:1], (high[2][:-1] + low[2][1:]) / 2, high[2][-1:]])
    q = np.concatenate([low[0], path.control[-1:, -1]])
    if path.degree == 5:
        added = slope * gain[:, None] + bends * x[:, None]
    else:
        added = None
    trajectory = _in_time(q, 2 * step / (speed[:-1] + speed[1:]), path.times, slope * speed[:, None], added)
    return _slow_whole(trajectory, "cubic" if path.degree == 3 else "quintic", rates, accelerations)


def derivatives(path: Curve, stretch: NDArray[np.int64], share: Array) -> tuple[Array, Array, Array]:
    """q, dq/dt and d²q/dt² at shares of stretches, (N, n) each."""
    assert path.times is not None
    lasts = np.diff(path.times)[stretch][:, None]
    d = path.degree
    second = d * (d - 1) * Curve(np.diff(path.control, n=2, axis=1), None).at(stretch, share)
    return path.at(stretch, share), path.slope(stretch, share) / lasts, second / lasts**2


def _slow_whole(trajectory: Trajectory, how: str, rates: Array, accelerations: Array) -> Trajectory:
    """Slowed down until every bound is kept; times that are rounded are longer, not shorter."""
    for _ in range(4):
        slower = usage(trajectory.curve(how), rates, accelerations).slower
        if slower <= 1.0:
            break
        slower *= 1.0 + 1e-12 * len(trajectory.q) ** 0.5
        trajectory = replace(
            trajectory, times=trajectory.times[0] + (trajectory.times - trajectory.times[0]) * slower,
            velocities=None if trajectory.velocities is None else trajectory.velocities / slower,
            accelerations=None if trajectory.accelerations is None else trajectory.accelerations / slower**2,
        )  # fmt: skip
    return trajectory


def _in_time(
    q: Array, lasts: Array, was: Array | None, velocities: Array | None = None, accelerations: Array | None = None
) -> Trajectory:
    """Rows with the durations (T − 1,) between them, from when the path began."""
    times = (0.0 if was is None else float(was[0])) + np.concatenate([[0.0], np.cumsum(lasts)])
    return Trajectory("", times, q, True, (), velocities, accelerations)


def fastest(alpha: Array, beta: Array, limits: Array, cap: Array) -> Array:
    """(N + 1,) the largest y_k ≤ cap_k with |α_kj y_{k+1} − β_kj y_k| ≤ a_j for every k and j, and y_{k+1} ≥ y_k/4.

    Args:
        alpha, beta: (N, n).
        limits: (n,) a; inf where there is none.
        cap: (N + 1,).

    Example:
        >>> ones = np.ones((3, 1))
        >>> fastest(ones, ones, np.array([1.0]), np.array([0.0, 9.0, 9.0, 1.0])).tolist()
        [0.0, 1.0, 2.0, 1.0]
    """
    held = np.isfinite(limits)
    if not held.any() or not len(alpha):
        return cap.copy()
    a, alpha, beta = limits[held], alpha[:, held], beta[:, held]
    sign = np.where(alpha < 0.0, -1.0, 1.0)
    alpha, beta = alpha * sign, beta * sign
    flat = alpha <= _FLAT * max(float(alpha.max()), 1e-300)
    cap = cap.copy()
    rest = np.where(flat & (np.abs(beta) > 0.0), a / np.maximum(np.abs(beta), 1e-300), np.inf).min(axis=1)
    cap[:-1] = np.minimum(cap[:-1], rest)
    safe = np.where(flat, 1.0, alpha)
    slope, room = np.where(flat, 0.0, beta / safe), np.where(flat, np.inf, a / safe)  # y' within slope·y ± room
    gap = slope[:, :, None] - slope[:, None, :]
    with np.errstate(invalid="ignore", divide="ignore"):
        meet = np.where(gap > 0.0, (room[:, :, None] + room[:, None, :]) / np.where(gap > 0.0, gap, 1.0), np.inf)
        falls = np.where(slope < _EASY, room / np.where(slope < _EASY, _EASY - slope, 1.0), np.inf)
    cap[:-1] = np.minimum(cap[:-1], np.minimum(meet.min(axis=(1, 2)), falls.min(axis=1)))
    with np.errstate(divide="ignore"):
        steep, lift = 1.0 / np.where(slope > 0.0, slope, 0.0), np.where(slope > 0.0, room, 1.0)
    for k in range(len(alpha) - 1, -1, -1):
        cap[k] = min(cap[k], cap[k + 1] / _EASY, float(((cap[k + 1] + lift[k]) * steep[k]).min()))
    y = cap.copy()
    for k in range(len(alpha)):
        y[k + 1] = min(cap[k + 1], float((slope[k] * y[k] + room[k]).min()))
    return y
