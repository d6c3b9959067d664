"""The curve between samples: polynomials in Bernstein form, whose control points enclose them.

A stretch is what lies between two samples. Its curve Σ_j B_j(s) b_j, 0 ≤ s ≤ 1, lies in the convex hull of the control
points b_j, and halving it gives control points of each half (de Casteljau). That is all a proof needs to know of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from math import comb

import numpy as np
from numpy.typing import NDArray

from rankdrop.errors import OptionError
from rankdrop.robot.model import Array

Index = NDArray[np.int64]
Spot = tuple[int, float]
"""A point of a path: stretch from 0, and the share of it."""

_BATCH, _HALVINGS = 1024, 7  # curves whose bound is made tighter together, and how often each is halved


@dataclass(frozen=True, slots=True, order=True)
class Place:
    """A point of a path, for people: the end of a stretch is the beginning of the next.

    Attributes:
        row: number of the sample before it, from 1.
        share: of the way to the next sample, 0 … 1.
        time: [s]; None without times.
        pose: of a tool path the pose, from 1, with the share of the way to the next; None of a joint path.
    """

    row: int
    share: float
    time: float | None = field(compare=False)
    pose: float | None = field(default=None, compare=False)

    @property
    def position(self) -> float:
        """Row with the share of the way to the next as a fraction."""
        return self.row + self.share


@dataclass(frozen=True, eq=False)
class Curve:
    """A path through T samples.

    Attributes:
        control: (T − 1, d + 1, n) Bernstein control points of each stretch, degree d = 1, 3 or 5 [rad, m].
        times: (T,) [s]; None where the path has none.
        speeds: (T − 1, n) joint rates that a straight stretch stands for, where they are larger than its own: those of
            the tool's curve at both ends [rad/s, m/s].
        poses: (T,) of a tool path the pose that each sample takes, as in `Place`.
    """

    control: Array
    times: Array | None
    speeds: Array | None = None
    poses: Array | None = None

    @property
    def degree(self) -> int:
        """Of the polynomials."""
        return int(self.control.shape[1]) - 1

    def at(self, stretch: Index, share: Array) -> Array:
        """(N, n) configurations at shares (N,) 0 … 1 of stretches (N,)."""
        s, d = np.asarray(share, dtype=np.float64)[:, None], self.degree
        basis = [comb(d, j) * s**j * (1 - s) ** (d - j) for j in range(d + 1)]
        return np.asarray(sum(b * self.control[stretch, j] for j, b in enumerate(basis)))

    def split(self, position: Array) -> tuple[Index, Array]:
        """Stretches and shares of them, of positions (N,) counted in stretches from 0."""
        stretch = np.clip(np.floor(position), 0, len(self.control) - 1).astype(np.int64)
        return stretch, position - stretch

    def slope(self, stretch: Index, share: Array) -> Array:
        """(N, n) derivative by the share: times 1/(duration of the stretch) the joint rates."""
        d = self.degree
        return d * Curve(np.diff(self.control[stretch], axis=1), None).at(np.arange(len(stretch)), share)

    @cached_property
    def rates(self) -> Array | None:
        """(T − 1, n) bounds on the joint rates of every stretch, exact for straight ones; None without times."""
        if self.times is None:
            return None
        lasts = np.diff(self.times)[:, None]
        steps = np.abs(np.diff(self.control, axis=1)).max(axis=1) * self.degree
        rates = np.where(steps > 0.0, steps / np.where(lasts > 0.0, lasts, np.inf), 0.0)
        if self.speeds is None:
            return rates
        return np.maximum(rates, self.speeds)

    def time(self, stretch: Index, share: Array) -> Array | None:
        """(N,) times [s]."""
        if self.times is None:
            return None
        start, end = self.times[stretch], self.times[stretch + 1]
        return np.asarray(start + share * (end - start))

    @property
    def samples(self) -> Array:
        """(T, n) the configurations that the path goes through [rad, m]."""
        return np.concatenate([self.control[:, 0], self.control[-1:, -1]])

    def place(self, spot: Spot) -> Place:
        """A point with its row, its time and its pose."""
        stretch, share = spot
        time = self.time(np.array([stretch]), np.array([share]))
        pose = None
        if self.poses is not None:
            before, after = self.poses[stretch : stretch + 2].tolist()
            pose = before + share * (after - before)
        if share == 1.0:
            stretch, share = (stretch + 1, 0.0)
        else:
            stretch, share = spot
        return Place(stretch + 1, share, None if time is None else float(time[0]), pose)

    def configuration_and_slope(self, place: Place) -> tuple[Array, Array]:
        """(n,) configuration at a place, and the derivative by the share."""
        stretch, share = (np.array([part]) for part in self.spot(place))
        return self.at(stretch, share)[0], self.slope(stretch, share)[0]

    def spot(self, place: Place) -> Spot:
        """Stretch and share of a place."""
        last = len(self.control)
        if place.row > last:
            return (last - 1, 1.0)
        return (place.row - 1, place.share)


def curve(
    q: Array,
    times: Array | None,
    velocities: Array | None = None,
    accelerations: Array | None = None,
    interpolate: str = "linear",
) -> Curve:
    """The curve that a controller makes of samples, as ROS's joint trajectory controller does.

    linear: straight. cubic: Hermite, through positions and velocities. quintic: positions, velocities, accelerations.

    Args:
        q: (T, n) samples, T ≥ 1; one sample is a stretch of no length.
        times: (T,) [s], increasing; needed for cubic and quintic.
        velocities, accelerations: (T, n) [rad/s, rad/s²] or None.
        interpolate: as in `PathOptions`.

    Raises:
        OptionError: what the interpolation needs is not given.

    Example:
        >>> rest = np.zeros((2, 1))
        >>> curve(np.array([[0.0], [1.0]]), np.array([0.0, 2.0]), rest, None, "cubic").control[0, :, 0].tolist()
        [0.0, 0.0, 1.0, 1.0]
    """
    if len(q) == 1:
        q = np.repeat(q, 2, axis=0)
        if times is not None:
            times = np.repeat(times, 2)
        velocities, accelerations, interpolate = None, None, "linear"
    start, end = q[:-1], q[1:]
    if interpolate == "linear":
        return Curve(np.stack([start, end], axis=1), times)
    if times is None or velocities is None or (interpolate == "quintic" and accelerations is None):
        raise _not_given(interpolate, {"times": times, "velocities": velocities, "accelerations": accelerations})
    dt = np.diff(times)[:, None]
    v0, v1 = velocities[:-1] * dt, velocities[1:] * dt
    if interpolate == "cubic" or accelerations is None:
        return Curve(np.stack([start, start + v0 / 3, end - v1 / 3, end], axis=1), times)
    a0, a1 = accelerations[:-1] * dt * dt, accelerations[1:] * dt * dt
    return Curve(
        np.stack(
            [start, start + v0 / 5, start + 2 * v0 / 5 + a0 / 20, end - 2 * v1 / 5 + a1 / 20, end - v1 / 5, end], axis=1
        ),
        times,
    )


def _not_given(interpolate: str, given: dict[str, Array | None]) -> OptionError:
    """The error that says which of the quantities an interpolation needs are not given."""
    needed = ["times", "velocities"]
    if interpolate == "quintic":
        needed.append("accelerations")
    missing = " and ".join(name for name in needed if given[name] is None)
    return OptionError(
        f"{interpolate} interpolation needs {missing}", where="interpolate", got=interpolate,
        mend=f"give {missing}, or interpolate='linear'",
        typed=f"a file with {missing}, or --interpolate linear",
    )  # fmt: skip


def halves(control: Array) -> Array:
    """(2 P, d + 1, n) control points of the two halves of each of P curves, one after the other (de Casteljau)."""
    count, degree = len(control), control.shape[1] - 1
    out = np.empty((count, 2, *control.shape[1:]))
    row = control
    for j in range(degree + 1):
        out[:, 0, j], out[:, 1, degree - j] = row[:, 0], row[:, -1]
        row = (row[:, :-1] + row[:, 1:]) / 2
    return out.reshape(2 * count, *control.shape[1:])


def largest(control: Array, measure: Callable[[Array], Array], enough: float) -> tuple[Array, Array]:
    """(P, n) each: the largest value that a convex measure of curves takes at points evaluated, and a bound for it.

    Args:
        control: (P, d + 1, n) control points.
        measure: of points (…, n), convex in each entry.
        enough: the bound of a curve that is below it is not made tighter.
    """
    values = measure(control)
    reached, bound = values[:, [0, -1]].max(axis=1), values.max(axis=1)
    wide = np.flatnonzero(((bound > enough) & (bound > reached)).any(axis=1))
    for part in (wide[i : i + _BATCH] for i in range(0, len(wide), _BATCH)):
        pieces = control[part]
        for _ in range(_HALVINGS):
            pieces = halves(pieces)
        values = measure(pieces).reshape(len(part), -1, *control.shape[1:])
        bound[part], reached[part] = values.max(axis=(1, 2)), values[:, :, [0, -1]].max(axis=(1, 2))
    return reached, bound


def number_parts(parts: Index) -> tuple[Index, Index]:
    """Of stretches cut into so many parts each: the stretch of every part, and its number there, from 0."""
    stretch = np.repeat(np.arange(len(parts)), parts)
    return stretch, np.arange(len(stretch)) - np.repeat(np.cumsum(parts) - parts, parts)


def boxes(control: Array) -> tuple[Array, Array]:
    """(P, n) lower and upper corners of boxes that hold the curves."""
    return control.min(axis=1), control.max(axis=1)


def chord_form(control: Array) -> tuple[Array, Array, Array]:
    """Each curve as c + Δ τ + e, |τ| ≤ 1, |e_k| ≤ ε_k: middle c, half the chord Δ, and ε, each (P, n).

    e is the same polynomial with control points e_j = b_j − (c + Δ (2j/d − 1)), the first and the last of them zero.
    The weights of the others are at most 1 − 2^(1 − d) together, half way, so that |e| ≤ (1 − 2^(1 − d)) max |e_j|.
    """
    degree = control.shape[1] - 1
    middle, chord = (control[:, 0] + control[:, -1]) / 2, (control[:, -1] - control[:, 0]) / 2
    if degree == 1:
        return middle, chord, np.zeros_like(middle)
    at = 2 * np.arange(degree + 1)[None, :, None] / degree - 1
    off = np.abs(control - middle[:, None] - at * chord[:, None]).max(axis=1)
    return middle, chord, (1 - 2.0 ** (1 - degree)) * off
