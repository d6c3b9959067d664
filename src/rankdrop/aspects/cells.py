"""The number of connected parts of the set {h_1 > 0, …, h_m > 0} of at most three angles, by cells.

Angles turn round (a torus), or lie between limits (a box, or a product of both).

Every cell of a grid is inside (all h_i > 0 proven), outside (some h_i < 0 proven) or open. Cells that share a face are
neighbours.

*At least* as many parts as there are clusters of cells that are not outside and hold one that is inside: cells that are
proven outside lie between them. (A part that goes through a corner of two cells has points in the cells around it.)

*At most* as many parts as there are clusters of inside cells, if every part holds an inside cell. A part that holds
none lies in open cells; the smallest of the h_i has a maximum on it, and there the gradients of those h_i that are
equal have zero in their convex hull. In a cell this is excluded where one direction d has d·∇h_i > 0 for every h_i
that can be the smallest; where the cell touches a limit, d must not leave the box. `proven` says that all open cells
pass; where one does not, parts smaller than a cell are not excluded.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import pairwise, product
from math import ceil, prod
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rankdrop.algebra.work import Work, tick
from rankdrop.aspects.waves import FourierSum, Interval
from rankdrop.robot.model import Array

Mask = NDArray[np.bool_]
Labels = NDArray[np.int64]

SIZES = {1: (32, 256, 2048, 16_384), 2: (32, 128, 512), 3: (16, 32, 64, 96)}
"""Cells along each angle, coarse ones first, by the number of angles."""
MOST_CELLS = 1_000_000
"""Cells of a grid after the first one."""
_PART = 100_000  # cells in one array
_TICKS = 0.3  # work of one cell [µs]

Box = Mapping[int, tuple[float, float]]
"""Joint -> lower and upper limit of its angle [rad]; a joint without an entry turns round."""


class PositiveFunction(Protocol):
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

    f: FourierSum
    sign: int

    @property
    def joints(self) -> tuple[int, ...]:
        """Joints it depends on."""
        return self.f.joints

    def over(self, middles: Mapping[int, Array], radius: float) -> Interval:
        """Enclosures of h."""
        return self.f.over(middles, radius).times(self.sign)

    def slopes_over(self, middles: Mapping[int, Array], radius: float) -> dict[int, Interval]:
        """Enclosures of its derivatives."""
        return {joint: slope.times(self.sign) for joint, slope in self.f.slopes_over(middles, radius).items()}


@dataclass(frozen=True, eq=False)
class Shadow:
    """h = s A + √(B² + C²): positive where s (A + B cos θ + C sin θ) > 0 for some θ of the peeled joint."""

    a: FourierSum
    b: FourierSum
    c: FourierSum
    sign: int

    @property
    def joints(self) -> tuple[int, ...]:
        """Joints it depends on."""
        return tuple(sorted({*self.a.joints, *self.b.joints, *self.c.joints}))

    def over(self, middles: Mapping[int, Array], radius: float) -> Interval:
        """Enclosures of h."""
        b, c = (wave.over(middles, radius).size() for wave in (self.b, self.c))
        root = Interval(np.hypot(b.low, c.low), np.hypot(b.high, c.high))
        return self.a.over(middles, radius).times(self.sign) + root

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
        bounds = {}
        for joint in self.joints:
            a_j, b_j, c_j = (by_joint.get(joint, zero) for by_joint in slopes)
            with np.errstate(invalid="ignore"):
                root = (b * b_j + c * c_j) * inverse
            unknown = ~np.isfinite(root.low) | ~np.isfinite(root.high)
            root = Interval(np.where(unknown, -np.inf, root.low), np.where(unknown, np.inf, root.high))
            bounds[joint] = a_j.times(self.sign) + root
        return bounds


@dataclass(frozen=True, eq=False)
class Either:
    """h = max(first, second): positive where one of the two is."""

    first: Positive
    second: Positive

    @property
    def joints(self) -> tuple[int, ...]:
        """Joints it depends on."""
        return tuple(sorted({*self.first.joints, *self.second.joints}))

    def over(self, middles: Mapping[int, Array], radius: float) -> Interval:
        """Enclosures of h."""
        first, second = self.first.over(middles, radius), self.second.over(middles, radius)
        return Interval(np.maximum(first.low, second.low), np.maximum(first.high, second.high))

    def slopes_over(self, middles: Mapping[int, Array], radius: float) -> dict[int, Interval]:
        """Enclosures of its derivatives: those of the larger one, or of both where that is not decided."""
        first, second = self.first.over(middles, radius), self.second.over(middles, radius)
        slopes = [part.slopes_over(middles, radius) for part in (self.first, self.second)]
        zero = Interval(np.zeros(len(first.low)), np.zeros(len(first.low)))
        first_larger, second_larger = first.low > second.high, second.low > first.high
        bounds = {}
        for joint in self.joints:
            a, b = (slopes_of_part.get(joint, zero) for slopes_of_part in slopes)
            low = np.where(first_larger, a.low, np.where(second_larger, b.low, np.minimum(a.low, b.low)))
            high = np.where(first_larger, a.high, np.where(second_larger, b.high, np.maximum(a.high, b.high)))
            bounds[joint] = Interval(low, high)
        return bounds


@dataclass(frozen=True)
class PartCount:
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

    def __mul__(self, other: PartCount) -> PartCount:
        """Of the product of two sets; none where one of them is proven to be empty."""
        none = 0 in (self.at_least, other.at_least) and (self.exact or other.exact)
        return PartCount(self.at_least * other.at_least, self.at_most * other.at_most,
                     (self.proven and other.proven) or none)  # fmt: skip


ONE = PartCount(1, 1, proven=True)


@dataclass(frozen=True)
class Grid:
    """Cells of a torus, a box, or a product of both.

    Attributes:
        joints: the joints (from 1) of its axes.
        shape: cells along each.
        low: where each axis begins [rad].
        step: width of a cell along each [rad].
        wraps: whether the last cell of an axis has the first one for a neighbour.
    """

    joints: tuple[int, ...]
    shape: tuple[int, ...]
    low: tuple[float, ...]
    step: tuple[float, ...]
    wraps: tuple[bool, ...]

    @classmethod
    def of(cls, joints: Sequence[int], size: int, box: Box) -> Grid:
        """A grid with so many cells along a whole turn.

        Args:
            joints: of its axes.
            size: cells along 2π; of a joint with limits, as many as its range takes at this width.
            box: limits.
        """
        ends = [box.get(joint, (-np.pi, np.pi)) for joint in joints]
        shape = tuple(max(1, ceil(size * (high - low) / (2 * np.pi) - 1e-9)) for low, high in ends)
        steps = tuple((high - low) / count for (low, high), count in zip(ends, shape, strict=True))
        return cls(tuple(joints), shape, tuple(low for low, _ in ends), steps, tuple(j not in box for j in joints))

    @property
    def cells(self) -> int:
        """Their number."""
        return prod(self.shape)

    @property
    def radius(self) -> float:
        """Half the width of the widest cell [rad]."""
        return 0.5 * max(self.step, default=0.0)

    def indices(self, places: Labels) -> tuple[Labels, ...]:
        """Index of cells along each axis."""
        if not self.joints:
            return ()
        return np.unravel_index(places, self.shape)

    def middles(self, places: Labels) -> dict[int, Array]:
        """Angles of the middles of cells by joint."""
        axes = zip(self.joints, self.indices(places), self.low, self.step, strict=True)
        return {joint: np.asarray(low + (k + 0.5) * step) for joint, k, low, step in axes}

    def inward(self, places: Labels, direction: Mapping[int, Array]) -> dict[int, Array]:
        """The part of a direction, by joint, along which no cell that touches a limit leaves the box."""
        kept = dict(direction)
        for joint, k, count, wraps in zip(self.joints, self.indices(places), self.shape, self.wraps, strict=True):
            if not wraps:
                d = np.where(k == 0, np.maximum(kept[joint], 0.0), kept[joint])
                kept[joint] = np.where(k == count - 1, np.minimum(d, 0.0), d)
        return kept


def count_parts(conditions: Sequence[PositiveFunction], work: Work | None = None, box: Box | None = None) -> PartCount:
    """The connected parts of the set where all conditions hold, over the joints they depend on.

    Grids are made finer until the number is proven, or the finest of `SIZES` is reached.

    Args:
        conditions: of at most three joints together.
        work: its limit is checked before each grid.
        box: limits of joints; None: all turn round.

    Raises:
        OutOfTime: that limit was reached.
    """
    best: PartCount | None = None
    for grid in _grids(conditions, box or {}):
        if work is not None:
            work.check()
        classified = _classify_cells(conditions, grid)
        if best is None:
            best = classified
        else:
            best = _better(best, classified)
        if best.exact:
            break
    assert best is not None
    return best


def _grids(conditions: Sequence[PositiveFunction], box: Box) -> Iterator[Grid]:
    """Finer and finer grids of the joints that conditions depend on."""
    joints = sorted(set[int]().union(*(condition.joints for condition in conditions)))
    if not joints:
        yield Grid.of((), 1, box)
        return
    first, *finer = (Grid.of(joints, size, box) for size in SIZES[len(joints)])
    yield first
    yield from (grid for grid in finer if grid.cells <= MOST_CELLS)


def _better(first: PartCount, second: PartCount) -> PartCount:
    """Of two grids: the larger proven lower number, the upper one that is proven, or of the finer grid."""
    at_least = max(first.at_least, second.at_least)
    if first.proven and second.proven:
        return PartCount(at_least, min(first.at_most, second.at_most), proven=True)
    upper = first if first.proven else second
    return PartCount(at_least, max(upper.at_most, at_least), upper.proven)


def _classify_cells(conditions: Sequence[PositiveFunction], grid: Grid) -> PartCount:
    """By one grid."""
    inside, outside = np.ones(grid.cells, dtype=bool), np.zeros(grid.cells, dtype=bool)
    tick(_TICKS * inside.size * len(conditions))
    for places in _chunks(np.arange(inside.size)):
        middles = grid.middles(places)
        for condition in conditions:
            value = condition.over(middles, grid.radius)
            inside[places] &= value.low > 0
            outside[places] |= value.high < 0
    for condition in conditions:
        _mark_behind_limits(condition, grid, outside)
    inside &= ~outside
    labels = clusters(~outside.reshape(grid.shape), grid.wraps).ravel()
    at_least = len(np.unique(labels[inside]))
    cluster_labels = clusters(inside.reshape(grid.shape), grid.wraps)
    at_most = len(np.unique(cluster_labels[cluster_labels >= 0]))
    undecided = np.flatnonzero(~inside & ~outside)
    proven = all(_no_maximum(conditions, grid, places).all() for places in _chunks(undecided))
    return PartCount(at_least, at_most, proven)


def _mark_behind_limits(condition: PositiveFunction, grid: Grid, outside: Mask) -> None:
    """Mark the last cells before the limits of a joint as outside, where a function of it alone rises to a value < 0.

    A limit that stands on a zero of h would else leave open cells on every grid.
    """
    if len(condition.joints) != 1:
        return
    axis = grid.joints.index(condition.joints[0])
    if grid.wraps[axis]:
        return
    joint, count, low, step = condition.joints[0], grid.shape[axis], grid.low[axis], grid.step[axis]
    cells = np.moveaxis(outside.reshape(grid.shape), axis, 0)
    for k, limit, outward in ((0, low, -1), (count - 1, low + count * step, 1)):
        there = condition.over({joint: np.array([limit])}, 0.0)
        slope = condition.slopes_over({joint: np.array([low + (k + 0.5) * step])}, 0.5 * step)[joint].times(outward)
        if there.high[0] < 0 and slope.low[0] > 0:
            cells[k] = True


def _chunks(places: Labels) -> list[Labels]:
    ends = [*range(0, len(places), _PART), len(places)]
    return [places[first:last] for first, last in pairwise(ends) if last > first]


def _no_maximum(conditions: Sequence[PositiveFunction], grid: Grid, places: Labels) -> Mask:
    """For each open cell: whether in one direction all conditions that can be the smallest there grow.

    Directions that are tried: the sum of the gradients of the conditions that can be the smallest, then those towards
    the neighbours of a cell; each without what leaves the box.
    """
    radius, middles = grid.radius, grid.middles(places)
    values = [condition.over(middles, radius) for condition in conditions]
    lowest = reduce(np.minimum, [value.high for value in values])
    active = [value.low <= lowest for value in values]
    slopes = [condition.slopes_over(middles, radius) for condition in conditions]
    direction = _sum_gradients(slopes, active, grid.joints)
    grows = _all_grow(slopes, active, grid.inward(places, direction))
    for steps in product((-1.0, 0.0, 1.0), repeat=len(grid.joints)):
        if grows.all():
            break
        constant = {joint: np.full(len(places), step) for joint, step in zip(grid.joints, steps, strict=True)}
        grows |= _all_grow(slopes, active, grid.inward(places, constant))
    return grows


def _sum_gradients(
    slopes: Sequence[Mapping[int, Interval]], active: Sequence[Mask], joints: Sequence[int]
) -> dict[int, Array]:
    """The sum of the middles of the gradients of active conditions."""
    direction = {joint: np.zeros(len(active[0])) for joint in joints}
    for by_joint, mask in zip(slopes, active, strict=True):
        for joint, slope in by_joint.items():
            with np.errstate(invalid="ignore"):
                middle = 0.5 * (slope.low + slope.high)
            direction[joint] += np.where(mask & np.isfinite(middle), middle, 0.0)
    return direction


def _all_grow(slopes: Sequence[Mapping[int, Interval]], active: Sequence[Mask], direction: Mapping[int, Array]) -> Mask:
    """For each cell: whether every active condition grows along a direction."""
    grows = np.ones(len(active[0]), dtype=bool)
    for by_joint, mask in zip(slopes, active, strict=True):
        along = np.zeros(len(mask))
        for joint, slope in by_joint.items():
            d = direction[joint]
            with np.errstate(invalid="ignore"):
                least = np.where(d > 0, d * slope.low, np.where(d < 0, d * slope.high, 0.0))
            along = along + least
        grows &= ~mask | (along > 0)
    return grows


def clusters(mask: Mask, wraps: Sequence[bool]) -> Labels:
    """A number for each cell of the mask, the same for cells that faces join; −1 outside it.

    Args:
        mask: of the cells of a grid.
        wraps: for each axis, whether its last cell has the first one for a neighbour.
    """
    flat = mask.ravel()
    number = np.where(flat, np.arange(flat.size), -1).reshape(mask.shape)
    pairs = []
    for axis in range(mask.ndim):
        other = np.roll(number, -1, axis=axis)
        if not wraps[axis]:
            np.moveaxis(other, axis, 0)[-1] = -1
        both = (number >= 0) & (other >= 0)
        pairs.append(np.stack([number[both], other[both]]))
    if pairs:
        edges = np.concatenate(pairs, axis=1)
    else:
        edges = np.zeros((2, 0), dtype=np.int64)
    return np.where(flat, connected_components(flat.size, edges), -1).reshape(mask.shape)


def connected_components(count: int, edges: Labels) -> Labels:
    """(count,) a number for each node of a graph, the same for those that edges (2, E) join: the least node there."""
    label = np.arange(count)
    while True:
        left, right = label[edges[0]], label[edges[1]]
        apart = left != right
        if not apart.any():
            return label
        edges = edges[:, apart]
        low, high = np.minimum(left, right)[apart], np.maximum(left, right)[apart]
        np.minimum.at(label, high, low)
        while True:  # every node to the root of its tree
            above = label[label]
            if np.array_equal(above, label):
                break
            label = above
