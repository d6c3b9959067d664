"""The number of connected parts of the set {h_1 > 0, …, h_m > 0} on a torus of at most three angles, by cells.

Every cell of a grid is inside (all h_i > 0 proven), outside (some h_i < 0 proven) or open. Cells that share a face are
neighbours.

*At least* as many parts as there are clusters of cells that are not outside and hold one that is inside: cells that are
proven outside lie between them. (A part that goes through a corner of two cells has points in the cells around it.)

*At most* as many parts as there are clusters of inside cells, if every part holds an inside cell. A part that holds
none lies in open cells; the smallest of the h_i has a maximum on it, and there the gradients of those h_i that are
equal have zero in their convex hull. In a cell this is excluded where one direction d has d·∇h_i > 0 for every h_i
that can be the smallest. `proven` says that all open cells pass; where one does not, parts smaller than a cell are
not excluded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rankdrop.algebra.work import Work, tick
from rankdrop.aspects.waves import Interval, Wave
from rankdrop.robot.model import Array

Mask = NDArray[np.bool_]
Labels = NDArray[np.int64]

SIZES = {1: (32, 256, 2048, 16_384), 2: (32, 128, 512), 3: (16, 32, 64, 96)}
"""Cells along each angle, coarse ones first, by the number of angles."""
_PART = 100_000  # cells in one array
_TICKS = 0.3  # work of one cell [µs]


class Condition(Protocol):
    """A function h of some joint angles that is to be positive."""

    @property
    def joints(self) -> tuple[int, ...]:
        """Joints (from 1) it depends on."""

    def over(self, middles: Mapping[int, Array], radius: float) -> Interval:
        """Enclosures of h over cells."""

    def slopes_over(self, middles: Mapping[int, Array], radius: float) -> dict[int, Interval]:
        """Enclosures of the derivatives of h over cells."""


@dataclass(frozen=True, eq=False)
class Positive:
    """h = s f, with a sign s."""

    f: Wave
    sign: int

    @property
    def joints(self) -> tuple[int, ...]:
        """Joints it depends on."""
        return self.f.joints

    def over(self, middles: Mapping[int, Array], radius: float) -> Interval:
        """Enclosures of h."""
        return self.f.over(middles, radius).scaled(self.sign)

    def slopes_over(self, middles: Mapping[int, Array], radius: float) -> dict[int, Interval]:
        """Enclosures of its derivatives."""
        return {joint: slope.scaled(self.sign) for joint, slope in self.f.slopes_over(middles, radius).items()}


@dataclass(frozen=True, eq=False)
class Shadow:
    """h = s A + √(B² + C²): positive where s (A + B cos θ + C sin θ) > 0 for some θ of the peeled joint."""

    a: Wave
    b: Wave
    c: Wave
    sign: int

    @property
    def joints(self) -> tuple[int, ...]:
        """Joints it depends on."""
        return tuple(sorted({*self.a.joints, *self.b.joints, *self.c.joints}))

    def over(self, middles: Mapping[int, Array], radius: float) -> Interval:
        """Enclosures of h."""
        b, c = (wave.over(middles, radius).size() for wave in (self.b, self.c))
        root = Interval(np.hypot(b.low, c.low), np.hypot(b.high, c.high))
        return self.a.over(middles, radius).scaled(self.sign) + root

    def slopes_over(self, middles: Mapping[int, Array], radius: float) -> dict[int, Interval]:
        """Enclosures of its derivatives: s A_j + (B B_j + C C_j)/√(B² + C²); without bounds where B = C = 0 may be."""
        b, c = (wave.over(middles, radius) for wave in (self.b, self.c))
        sizes = b.size(), c.size()
        least, most = (np.hypot(getattr(sizes[0], end), getattr(sizes[1], end)) for end in ("low", "high"))
        with np.errstate(divide="ignore"):
            inverse = Interval(1 / most, np.where(least > 0, 1 / least, np.inf))
        slopes = [wave.slopes_over(middles, radius) for wave in (self.a, self.b, self.c)]
        count = len(least)
        zero = Interval(np.zeros(count), np.zeros(count))
        found = {}
        for joint in self.joints:
            a_j, b_j, c_j = (some.get(joint, zero) for some in slopes)
            with np.errstate(invalid="ignore"):
                root = (b * b_j + c * c_j) * inverse
            unknown = ~np.isfinite(root.low) | ~np.isfinite(root.high)
            root = Interval(np.where(unknown, -np.inf, root.low), np.where(unknown, np.inf, root.high))
            found[joint] = a_j.scaled(self.sign) + root
        return found


@dataclass(frozen=True)
class Parts:
    """How many connected parts.

    Attributes:
        at_least: proven.
        at_most: clusters of cells that are inside.
        proven: whether no part is smaller than a cell, so that `at_most` is proven too.
    """

    at_least: int
    at_most: int
    proven: bool

    @property
    def exact(self) -> bool:
        """Whether the number is proven."""
        return self.proven and self.at_least == self.at_most

    def __mul__(self, other: Parts) -> Parts:
        """Of the product of two sets; none where one of them is proven to be empty."""
        none = 0 in (self.at_least, other.at_least) and (self.exact or other.exact)
        return Parts(self.at_least * other.at_least, self.at_most * other.at_most,
                     (self.proven and other.proven) or none)  # fmt: skip


ONE = Parts(1, 1, proven=True)


def count_parts(conditions: Sequence[Condition], work: Work | None = None) -> Parts:
    """The connected parts of the set where all conditions hold, on the torus of the joints they depend on.

    Grids are made finer until the number is proven, or the finest of `SIZES` is reached.

    Args:
        conditions: of at most three joints together.
        work: its limit is checked before each grid.

    Raises:
        OutOfTime: that limit was met.
    """
    joints = sorted({joint for condition in conditions for joint in condition.joints})
    best: Parts | None = None
    for size in SIZES[max(len(joints), 1)] if joints else (1,):
        if work is not None:
            work.check()
        found = _at(conditions, joints, size)
        if best is None:
            best = found
        else:
            best = _better(best, found)
        if best.exact:
            break
    assert best is not None
    return best


def _better(one: Parts, other: Parts) -> Parts:
    """Of two grids: the larger proven lower number, the upper one that is proven, or of the finer grid."""
    at_least = max(one.at_least, other.at_least)
    if one.proven and other.proven:
        return Parts(at_least, min(one.at_most, other.at_most), proven=True)
    upper = one if one.proven else other
    return Parts(at_least, max(upper.at_most, at_least), upper.proven)


def _at(conditions: Sequence[Condition], joints: Sequence[int], size: int) -> Parts:
    """By one grid."""
    shape = (size,) * len(joints)
    radius = np.pi / size
    inside, outside = np.ones(shape, dtype=bool).ravel(), np.zeros(shape, dtype=bool).ravel()
    tick(_TICKS * inside.size * len(conditions))
    for places in _chunks(np.arange(inside.size)):
        middles = _middles(places, joints, size)
        for condition in conditions:
            value = condition.over(middles, radius)
            inside[places] &= value.low > 0
            outside[places] |= value.high < 0
    inside &= ~outside
    labels = clusters(~outside.reshape(shape)).ravel()
    at_least = len(np.unique(labels[inside]))
    own = clusters(inside.reshape(shape))
    at_most = len(np.unique(own[own >= 0]))
    undecided = np.flatnonzero(~inside & ~outside)
    proven = all(_no_maximum(conditions, joints, places, size).all() for places in _chunks(undecided))
    return Parts(at_least, at_most, proven)


def _chunks(places: Labels) -> list[Labels]:
    ends = [*range(0, len(places), _PART), len(places)]
    return [places[first:last] for first, last in pairwise(ends) if last > first]


def _middles(places: Labels, joints: Sequence[int], size: int) -> dict[int, Array]:
    """Angles of the middles of cells by joint."""
    if joints:
        index = np.unravel_index(places, (size,) * len(joints))
    else:
        index = ()
    step = 2 * np.pi / size
    return {joint: np.asarray((k + 0.5) * step - np.pi) for joint, k in zip(joints, index, strict=True)}


def _no_maximum(conditions: Sequence[Condition], joints: Sequence[int], places: Labels, size: int) -> Mask:
    """For each open cell: whether in one direction all conditions that can be the smallest there grow.

    The direction that is tried is the sum of the gradients of the conditions that can be the smallest.
    """
    radius = np.pi / size
    middles = _middles(places, joints, size)
    values = [condition.over(middles, radius) for condition in conditions]
    lowest = reduce(np.minimum, [value.high for value in values])
    active = [value.low <= lowest for value in values]
    slopes = [condition.slopes_over(middles, radius) for condition in conditions]
    count = len(places)
    direction = {joint: np.zeros(count) for joint in joints}
    for some, here in zip(slopes, active, strict=True):
        for joint, slope in some.items():
            with np.errstate(invalid="ignore"):
                middle = 0.5 * (slope.low + slope.high)
            direction[joint] += np.where(here & np.isfinite(middle), middle, 0.0)
    grows = np.ones(count, dtype=bool)
    for some, here in zip(slopes, active, strict=True):
        along = np.zeros(count)
        for joint, slope in some.items():
            d = direction[joint]
            with np.errstate(invalid="ignore"):
                least = np.where(d > 0, d * slope.low, np.where(d < 0, d * slope.high, 0.0))
            along = along + least
        grows &= ~here | (along > 0)
    return grows


def clusters(mask: Mask) -> Labels:
    """A number for each cell of the mask, the same for cells that faces join around the torus; −1 outside it."""
    flat = mask.ravel()
    number = np.where(flat, np.arange(flat.size), -1).reshape(mask.shape)
    pairs = []
    for axis in range(mask.ndim):
        other = np.roll(number, -1, axis=axis)
        both = (number >= 0) & (other >= 0)
        pairs.append(np.stack([number[both], other[both]]))
    if pairs:
        edges = np.concatenate(pairs, axis=1)
    else:
        edges = np.zeros((2, 0), dtype=np.int64)
    return np.where(flat, joined(flat.size, edges), -1).reshape(mask.shape)


def joined(count: int, edges: Labels) -> Labels:
    """(count,) a number for each node of a graph, the same for those that edges (2, E) join: the least node there."""
    label = np.arange(count)
    while True:
        one, two = label[edges[0]], label[edges[1]]
        apart = one != two
        if not apart.any():
            return label
        edges = edges[:, apart]
        low, high = np.minimum(one, two)[apart], np.maximum(one, two)[apart]
        np.minimum.at(label, high, low)
        while True:  # every node to the root of its tree
            above = label[label]
            if np.array_equal(above, label):
                break
            label = above
