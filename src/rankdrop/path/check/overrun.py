"""Joints that exceed their rate limits on a path: how fast, how far they turn meanwhile, and for how long."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop.local.rates import rate_limits
from rankdrop.path.curve import Curve, Place
from rankdrop.robot.model import Array, Robot

_KEPT = 1.0 + 1e-9  # a share of a limit below it keeps the limit: rounding
_PARTS = 16  # of a stretch that is a cubic or a quintic, each with the rate in its middle


@dataclass(frozen=True, eq=False)
class Fastest:
    """Where a joint is fastest, as a share of its limit where limits are known.

    Attributes:
        joint: number from 1.
        rate: |q̇| there [rad/s, m/s].
        limit: of the rate [rad/s, m/s]; inf where none is known.
        place: on the path.
    """

    joint: int
    rate: float
    limit: float
    place: Place


@dataclass(frozen=True, eq=False)
class Overrun(Fastest):
    """A joint that exceeds its rate limit.

    Attributes:
        seconds: how long it does, all parts together [s].
        travel: sum of |Δq| in that time [rad, m].
        start, end: of the first and the last part.
    """

    seconds: float
    travel: float
    start: Place
    end: Place


@dataclass(frozen=True, eq=False)
class _RatePieces:
    """Joint rates on pieces of a path, P to each stretch.

    Attributes:
        rates: (K, n) |q̇| [rad/s, m/s].
        travel: (K, n) |Δq| [rad, m].
        lasts: (K,) [s].
        parts: P.
    """

    rates: Array
    travel: Array
    lasts: Array
    parts: int


def overruns(robot: Robot, path: Curve, first: int = 0, last: int | None = None) -> tuple[Overrun, ...]:
    """Joints that exceed their rate limits between two rows, the one that exceeds its limit most first.

    A path that is straight between its rows has one rate for each stretch, or that of the tool's curve at its ends.
    The rates of a cubic or a quintic are those in the middle of sixteen parts of a stretch.

    Args:
        robot: the arm.
        path: with times; without any there are no rates.
        first, last: rows, from 0; None: the last one.
    """
    pieces = _pieces(path, first, last)
    if pieces is None:
        return ()
    shares = _shares(pieces, rate_limits(robot))
    found = [_overrun(robot, path, pieces, shares[:, joint], joint, first)
             for joint in np.flatnonzero((shares > _KEPT).any(axis=0)).tolist()]  # fmt: skip
    return tuple(sorted(found, key=lambda overrun: -overrun.rate / overrun.limit))


def fastest(robot: Robot, path: Curve) -> Fastest | None:
    """The joint that comes nearest to its rate limit, or turns fastest where no limit is known; None without times."""
    pieces = _pieces(path, 0, None)
    if pieces is None:
        return None
    limits = rate_limits(robot)
    turning = np.array([variable.unit == "rad" for variable in robot.variables])
    shares = _shares(pieces, limits)
    if not np.isfinite(limits).any():
        shares = np.where(turning, pieces.rates, 0.0)
    k, joint = (int(index) for index in np.unravel_index(int(shares.argmax()), shares.shape))
    place = path.place((k // pieces.parts, (k % pieces.parts + 0.5) / pieces.parts))
    return Fastest(joint + 1, float(pieces.rates[k, joint]), float(limits[joint]), place)


def _pieces(path: Curve, first: int, last: int | None) -> _RatePieces | None:
    """The rates between two rows; None without times or without a stretch."""
    rates = path.rates
    if rates is None or path.times is None or not len(rates[first:last]):
        return None
    lasts = np.diff(path.times)[first:last]
    if path.degree == 1:
        travel = np.abs(path.control[first:last, -1] - path.control[first:last, 0])
        return _RatePieces(rates[first:last], travel, lasts, 1)
    stretch = np.repeat(np.arange(first, first + len(lasts)), _PARTS)
    share = np.tile((np.arange(_PARTS) + 0.5) / _PARTS, len(lasts))
    slope = np.abs(path.slope(stretch, share))
    each = np.repeat(lasts, _PARTS)
    return _RatePieces(slope / each[:, None], slope / _PARTS, each / _PARTS, _PARTS)


def _shares(pieces: _RatePieces, limits: Array) -> Array:
    """(K, n) rates as shares of their limits; 0 for a joint that stands still, whatever its limit."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(pieces.rates > 0.0, pieces.rates / limits, 0.0)


def _overrun(robot: Robot, path: Curve, pieces: _RatePieces, shares: Array, joint: int, first: int) -> Overrun:
    """The overrun of a joint, counted from 0, by its shares (K,) of the limit."""
    over = np.flatnonzero(shares > _KEPT)

    def place(piece: int, share: float) -> Place:
        return path.place((first + piece // pieces.parts, (piece % pieces.parts + share) / pieces.parts))

    worst = int(shares.argmax())
    return Overrun(
        joint + 1, float(pieces.rates[worst, joint]), float(rate_limits(robot)[joint]), place(worst, 0.5),
        float(pieces.lasts[over].sum()), float(pieces.travel[over, joint].sum()), place(int(over[0]), 0.0),
        place(int(over[-1]), 1.0),
    )  # fmt: skip
