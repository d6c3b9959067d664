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

from rankdrop.path.curve import Curve, Index, Spot, number_parts
from rankdrop.path.mend.retime import usage
from rankdrop.path.read.trajectory import Trajectory
from rankdrop.problem import Mask
from rankdrop.robot.model import Array

_BRAKING = 0.4  # L: old time within which a path is slowed down at least [s]
_LONGER, _ROUNDS = 1.6, 8  # where accelerations are limited: L grows, and so many times
_ROWS = 24  # of that time at least
_SPARE = 1.0 + 1e-6  # of rates: times are rounded
_MOST, _AT_ONCE = 200_000_000, 2_000_000  # pairs of spans and fast stretches that are compared, in all and at once


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
        (2.0, 0.24)
    """
    if path.degree != 1 or path.times is None or path.rates is None:
        return None
    most = np.asarray((path.rates / rates).max(axis=1))
    for k in range(_ROUNDS):
        slowed = _slow_down(path, most, _BRAKING * _LONGER**k)
        if slowed is None:
            return None
        share = usage(slowed[0].curve("linear"), rates, accelerations)
        if share.slower <= 1.0:
            return slowed
        if share.rate > 1.0:
            return None
        most = np.where(most > 1.0, most * min(2.0, share.slower), most)
    return None


@dataclass(frozen=True, eq=False)
class _Fast:
    """The stretches that are too fast, in order.

    Attributes:
        first, last: (F,) when they begin and end [s].
        least: (F,) c = 1/m², which y = g² is to be there.
        braking: L [s].
    """

    first: Array
    last: Array
    least: Array
    braking: float

    def squared_speed(self, start: Array, until: Array) -> Array:
        """(N,) y, the least that any of the stretches asks for, of spans of time in order, at most 1."""
        low = int(np.searchsorted(self.last, start[0] - self.braking))
        high = int(np.searchsorted(self.first, until[-1] + self.braking))
        first, last, least = self.first[low:high], self.last[low:high], self.least[low:high]
        ahead, behind = first - until[:, None], start[:, None] - last  # d of the stretches after, and before, a span
        distance = np.maximum(0.0, np.maximum(ahead, behind))
        x = np.minimum(distance / self.braking, 1.0)
        s = 1.0 - (1.0 - x) ** 3
        return np.asarray((least + (1.0 - least) * s).min(axis=1, initial=1.0))


@dataclass(frozen=True, eq=False)
class _Spans:
    """Spans of time into which the stretches of a path are divided.

    Attributes:
        stretch: (N,) that a span is part of.
        part: (N,) its number in the stretch, from 0.
        share: (N,) of the stretch that lies before it.
        start: (N,) when it begins [s].
    """

    stretch: Index
    part: Index
    share: Array
    start: Array

    def until(self, end: float) -> Array:
        """(N,) when the spans end, the last of them at `end` [s]."""
        return np.append(self.start[1:], end)

    def only(self, kept: Mask) -> _Spans:
        """Some of the spans; one that is left out belongs to the one before it."""
        return _Spans(self.stretch[kept], self.part[kept], self.share[kept], self.start[kept])


def _slow_down(path: Curve, most: Array, braking: float) -> tuple[Trajectory, tuple[Slower, ...]] | None:
    """With a time L of braking, stretches of which are `most` times too fast."""
    assert path.times is not None
    times, end = path.times, path.times[-1]
    too_fast = np.asarray(most > 1.0)
    if not too_fast.any():
        return None
    fast = _Fast(times[:-1][too_fast], times[1:][too_fast], 1.0 / (most[too_fast] * _SPARE) ** 2, braking)
    near = _spans_near(times[:-1], times[1:], fast.first, fast.last, braking)
    spans = _divide_stretches(times, near & ~too_fast, braking / _ROWS)
    y = _squared_speeds(spans, near, fast, end)
    if y is None:
        return None
    slow = y < 1.0
    behind_slow = np.append(False, slow[:-1])
    kept = (spans.part == 0) | slow | behind_slow
    spans, y, slow = spans.only(kept), y[kept], slow[kept]
    longer = np.where(slow, (spans.until(end) - spans.start) * (1.0 / np.sqrt(y) - 1.0), 0.0)
    at = np.append(spans.start, end) + np.concatenate([[0.0], np.cumsum(longer)])
    return Trajectory("", at, _rows(path, spans), True, ()), _slower_parts(spans, slow, longer, len(times) - 1)


def _divide_stretches(times: Array, finely: Mask, longest: float) -> _Spans:
    """Stretches divided into equal spans no longer than `longest` [s] where they are to be, else as they are."""
    lasts = np.diff(times)
    parts = np.where(finely, np.ceil(lasts / longest), 1.0).astype(np.int64).clip(1)
    stretch, part = number_parts(parts)
    share = part / parts[stretch]
    return _Spans(stretch, part, share, times[stretch] + share * lasts[stretch])


def _squared_speeds(spans: _Spans, near: Mask, fast: _Fast, end: float) -> Array | None:
    """(N,) y of each span; None where too many pairs would have to be compared."""
    y = np.ones(len(spans.stretch))
    until = spans.until(end)
    inside = np.flatnonzero(near[spans.stretch])
    pairs = len(inside) * len(fast.first)
    if pairs > _MOST:
        return None
    for some in np.array_split(inside, max(1, pairs // _AT_ONCE)):
        y[some] = fast.squared_speed(spans.start[some], until[some])
    return y


def _rows(path: Curve, spans: _Spans) -> Array:
    """(N + 1, n) configurations where spans begin, and the last of the path; rows of the path to the last bit."""
    rows = path.samples
    begins_stretch = spans.part[:, None] == 0
    begins = np.where(begins_stretch, rows[spans.stretch], path.at(spans.stretch, spans.share))
    return np.concatenate([begins, rows[-1:]])


def _slower_parts(spans: _Spans, slow: Mask, longer: Array, stretches: int) -> tuple[Slower, ...]:
    """The parts of a path in which neighbouring spans are all slow, with how much longer each of them takes."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], slow, [False]])))
    parts = []
    for low, high in edges.reshape(-1, 2).tolist():
        begin = int(spans.stretch[low]), float(spans.share[low])
        if high < len(spans.stretch):
            end = int(spans.stretch[high]), float(spans.share[high])
        else:
            end = stretches - 1, 1.0
        parts.append(Slower(begin, end, float(longer[low:high].sum())))
    return tuple(parts)


def _spans_near(begin: Array, end: Array, first: Array, last: Array, within: float) -> Mask:
    """(N,) which of the spans are so near to one of some others, both in order."""
    ahead = np.searchsorted(first, end + within, side="right")
    behind = np.searchsorted(last, begin - within, side="left")
    return np.asarray(ahead > behind)
