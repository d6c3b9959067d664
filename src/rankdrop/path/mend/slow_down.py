"""Slower where a path is too fast, and nowhere else: the rows around get more time, the rest is only shifted.

With τ the old time and g = dτ/dt the speed at which the path is gone through, y = g² is

    y(τ) = min over the stretches j that are too fast of   c_j + (1 − c_j) s(d_j(τ)/L),    c_j = 1/m_j²,

m_j the largest joint rate of stretch j as a multiple of its limit, d_j the time from τ to that stretch, and
s(x) = 1 − (1 − x)³ up to x = 1. On the stretch itself the rate is its limit; before it the path brakes by no more than
3/(2 L) of its speed in a second. At d = L it is as fast as before, with slope and bend of y zero: the new time law is
C² where it begins and ends.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop.path.curve import Curve, Spot, numbered
from rankdrop.path.mend.retime import usage
from rankdrop.path.read.trajectory import Trajectory
from rankdrop.problem import Mask
from rankdrop.robot.model import Array

_BRAKING = 0.4  # L: old time within which a path is slowed down at least [s]
_LONGER, _ROUNDS = 1.6, 8  # where accelerations are limited: L grows, and so many times
_ROWS = 24  # of that time at least
_SPARE = 1.0 + 1e-6  # of rates: times are rounded
_MOST = 200_000_000  # pairs of stretches that are compared


@dataclass(frozen=True, slots=True)
class Slower:
    """A part of a path that takes longer.

    Attributes:
        start, end: of the old path.
        longer: by how much [s].
    """

    start: Spot
    end: Spot
    longer: float


def slowed_down(path: Curve, rates: Array, accelerations: Array) -> tuple[Trajectory, tuple[Slower, ...]] | None:
    """A straight path in time, slower around the stretches that are too fast.

    Args:
        path: straight between its rows, with times.
        rates, accelerations: (n,) limits [rad/s, rad/s²; m]; inf where there are none.

    Returns:
        The path with rows put in where it is slowed down, all others and the durations between them as they were, and
        its parts that take longer; None where that does not keep the limits, or nearly all of the path is too fast.

    Example:
        >>> rows = np.array([[0.0], [0.1], [0.5], [0.6]])
        >>> path = Trajectory("", np.array([0.0, 1.0, 1.1, 2.1]), rows, True, ()).curve("linear")
        >>> made, parts = slowed_down(path, np.array([2.0]), np.array([np.inf]))
        >>> round(float(np.abs(np.diff(made.q[:, 0]) / np.diff(made.times)).max()), 5), round(parts[0].longer, 3)
        (2.0, 0.3)
    """
    if path.degree != 1 or path.times is None or path.rates is None:
        return None
    most = np.asarray((path.rates / rates).max(axis=1))
    for k in range(_ROUNDS):
        made = _slowed(path, most, _BRAKING * _LONGER**k)
        if made is None:
            return None
        share = usage(made[0].curve("linear"), rates, accelerations)
        if share.slower <= 1.0:
            return made
        if share.rate > 1.0:
            return None
        most = np.where(most > 1.0, most * min(2.0, share.slower), most)
    return None


def _slowed(path: Curve, most: Array, braking: float) -> tuple[Trajectory, tuple[Slower, ...]] | None:
    """With a time L of braking, stretches of which are `most` times too fast."""
    assert path.times is not None
    times, lasts = path.times, np.diff(path.times)
    fast = np.asarray(most > 1.0)
    if not fast.any():
        return None
    first, last = times[:-1][fast], times[1:][fast]
    near = _near(times[:-1], times[1:], first, last, braking)
    parts = np.where(near & ~fast, np.ceil(lasts / (braking / _ROWS)), 1.0).astype(np.int64).clip(1)
    stretch, part = numbered(parts)
    share = part / parts[stretch]
    start = times[stretch] + share * lasts[stretch]
    until = np.append(start[1:], times[-1])
    y = np.ones(len(stretch))
    inside = np.flatnonzero(near[stretch])
    if len(inside) * int(fast.sum()) > _MOST:
        return None
    least = 1.0 / (most[fast] * _SPARE) ** 2
    for i in np.array_split(inside, max(1, len(inside) * int(fast.sum()) // 2_000_000)):
        low, high = (np.searchsorted(last, start[i[0]] - braking), np.searchsorted(first, until[i[-1]] + braking))
        here = slice(int(low), int(high))
        away = np.maximum(0.0, np.maximum(first[here] - until[i, None], start[i, None] - last[here]))
        x = np.minimum(away / braking, 1.0)
        y[i] = (least[here] + (1.0 - least[here]) * (1.0 - (1.0 - x) ** 3)).min(axis=1, initial=1.0)
    kept = (part == 0) | (y < 1.0) | (np.append(1.0, y[:-1]) < 1.0)
    stretch, part, share, start, y = (values[kept] for values in (stretch, part, share, start, y))
    until = np.append(start[1:], times[-1])
    long = np.where(y < 1.0, (until - start) * (1.0 / np.sqrt(y) - 1.0), 0.0)
    at = np.append(start, times[-1]) + np.concatenate([[0.0], np.cumsum(long)])
    rows = np.concatenate([path.control[:, 0], path.control[-1:, -1]])
    q = np.concatenate([np.where(part[:, None] == 0, rows[stretch], path.at(stretch, share)), rows[-1:]])
    edges = np.flatnonzero(np.diff(np.concatenate([[False], y < 1.0, [False]])))
    slower = []
    for low, high in edges.reshape(-1, 2).tolist():
        begin = (int(stretch[low]), float(share[low]))
        end = (int(stretch[high]), float(share[high])) if high < len(stretch) else (len(lasts) - 1, 1.0)
        slower.append(Slower(begin, end, float(long[low:high].sum())))
    return Trajectory("", at, q, True, ()), tuple(slower)


def _near(begin: Array, end: Array, first: Array, last: Array, within: float) -> Mask:
    """(N,) which of the spans are so near to one of some others, both in order."""
    ahead = np.searchsorted(first, end + within, side="right")
    behind = np.searchsorted(last, begin - within, side="left")
    return np.asarray(ahead > behind)
