"""Aspects in the joints that separate them: the sign of each factor on a grid, as a picture shows it.

Factors that share joints are one group, and the aspects of the arm are the products of the regions of its groups. The
regions of a group are drawn in at most three of its joints: two across a picture, the third one by slices; any further
joint is held. A region is named by the signs of its factors. In one or two joints, cells of one sign vector that fall
apart into as many clusters as are counted for it are regions of their own.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import pi, radians

import numpy as np
from numpy.typing import NDArray

from rankdrop.aspects.cells import clusters
from rankdrop.aspects.count import AspectCount, joints_of, polynomial_of, sharing, wave_of_factor
from rankdrop.aspects.waves import FourierSum
from rankdrop.errors import OptionError
from rankdrop.exact.signs import Signs
from rankdrop.robot.model import Array

CELLS = {1: 720, 2: 150}
"""Cells along a whole turn, by the number of joints across a picture."""
SLICES = tuple(radians(value) for value in (-135.0, -45.0, 45.0, 135.0))
"""Values of a third joint [rad]."""
_HELD = radians(60.0)  # where any further joint is: at multiples of a right angle factors may vanish


@dataclass(frozen=True)
class PictureRegion:
    """A region of a group.

    Attributes:
        signs: of the factors of the group, +1 or −1.
        number: from 1, among the regions with these signs that are drawn apart; 0 where there is one colour for all.
        parts: how many regions this colour stands for, a proven lower bound; 0 where that is not known of one group.
    """

    signs: tuple[int, ...]
    number: int
    parts: int


@dataclass(frozen=True, eq=False)
class AspectMap:
    """The regions of one group of factors.

    Attributes:
        factors: indices of the factors of the group.
        joints: up to three joints (from 1) that are drawn: across, up, by slices.
        held: further joints and their values [rad].
        slices: values of the third joint [rad]; empty where there is none.
        cells: (n1,), (n1, n2) or (slices, n1, n2) index of the region of each cell, over −π … π along each joint.
        regions: in the order of `cells`.
    """

    factors: tuple[int, ...]
    joints: tuple[int, ...]
    held: tuple[tuple[int, float], ...]
    slices: tuple[float, ...]
    cells: NDArray[np.int64]
    regions: tuple[PictureRegion, ...]


def aspect_maps(count: AspectCount, signs: Signs | None) -> tuple[AspectMap, ...]:
    """The regions of every group of factors that share joints.

    Args:
        count, signs: from `rankdrop.aspects.arm.count_of_arm`.

    Raises:
        OptionError: nothing was counted, no condition separates regions, or a condition depends on a slide.

    Example:
        >>> from rankdrop.aspects.arm import count_of_arm
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("ur5e")
        >>> [(chart.joints, len(chart.regions)) for chart in aspect_maps(*count_of_arm(arm, resolve_task(None, arm)))]
        [((5,), 2), ((2, 3, 4), 4)]
    """
    signs = _drawable(count, signs)
    ring, polynomials = signs.chain.ring, [polynomial_of(factor) for factor in signs.factors]
    joints = {i: joints_of(ring, polynomial) for i, polynomial in enumerate(polynomials)}
    if any(used & set(ring.prismatic) for used in joints.values()):
        raise OptionError("a condition depends on a slide: aspects are drawn in angles", where="aspects")
    waves = [wave_of_factor(ring, signs.chain.numbers, [polynomial])[0] for polynomial in polynomials]
    groups, shifts = sharing(joints), np.asarray(signs.chain.shifts, dtype=np.float64)
    maps = []
    for group in groups:
        shared = set[int]().union(*(joints[i] for i in group))
        maps.append(_map_of(count, group, sorted(shared), waves, shifts, whole=len(groups) == 1))
    return tuple(maps)


def _drawable(count: AspectCount, signs: Signs | None) -> Signs:
    """The signs of the factors, where there are any and the aspects were counted."""
    if count.left is not None or signs is None:
        raise OptionError("the aspects of this arm were not counted, so that they cannot be drawn", where="aspects")
    if not signs.factors:
        raise OptionError("no condition separates regular configurations: there is nothing to draw", where="aspects")
    return signs


def _map_of(
    count: AspectCount, group: tuple[int, ...], joints: list[int], waves: list[FourierSum], shifts: Array, *,
    whole: bool,
) -> AspectMap:
    """The regions of one group; `whole`: it holds every factor, so that the counts of the arm are its own."""
    drawn, held = tuple(joints[:3]), tuple((joint, _HELD) for joint in joints[3:])
    slices = SLICES if len(drawn) == 3 else ()
    positive = np.array([_positive(waves[i], drawn, held, slices, shifts) for i in group])
    shape = positive.shape[1:]
    cells = np.zeros(shape, dtype=np.int64)
    regions: list[PictureRegion] = []
    for signs in product((1, -1), repeat=len(group)):
        inside = np.all([positive[k] == (sign > 0) for k, sign in enumerate(signs)], axis=0)
        if not inside.any():
            continue
        parts = _parts(count, group, signs, whole=whole)
        apart: list[NDArray[np.bool_]] = []
        if not slices:
            apart = _clusters(inside, parts)
        for number, mask in enumerate(apart, start=1):
            cells[mask] = len(regions)
            regions.append(PictureRegion(signs, number, 1))
        if not apart:
            cells[inside] = len(regions)
            regions.append(PictureRegion(signs, 0, parts))
    return AspectMap(group, drawn, held, slices, cells, tuple(regions))


def _clusters(inside: NDArray[np.bool_], parts: int) -> list[NDArray[np.bool_]]:
    """The clusters of the cells of one sign vector where these are several, as many as regions are counted."""
    if parts < 2:
        return []
    labels = clusters(inside, [True] * inside.ndim)
    regions = [labels == label for label in np.unique(labels[inside])]
    if len(regions) == parts:
        return regions
    return []


def _positive(
    wave: FourierSum, drawn: tuple[int, ...], held: tuple[tuple[int, float], ...], slices: tuple[float, ...],
    shifts: Array,
) -> NDArray[np.bool_]:
    """Whether a factor is positive on the cells of a picture: (n1,), (n1, n2) or (slices, n1, n2).

    Joint values q are drawn; factors are written in θ = q + shift.
    """
    across = drawn[:2]
    size = CELLS[len(across)]
    middles = -pi + (np.arange(size) + 0.5) * 2 * pi / size
    axes = [*((np.array(slices),) if slices else ()), *[middles] * len(across)]
    order = [*drawn[2:], *across]
    grid = np.meshgrid(*axes, indexing="ij")
    values = dict(zip(order, (axis.ravel() for axis in grid), strict=True))
    values |= {joint: np.full(grid[0].size, value) for joint, value in held}
    angles = {joint: value + shifts[joint - 1] for joint, value in values.items()}
    return np.asarray(wave.jets(angles)[0].reshape(grid[0].shape) > 0)


def _parts(count: AspectCount, group: tuple[int, ...], signs: tuple[int, ...], *, whole: bool) -> int:
    """How many regions are proven that have these signs of the factors of a group; `whole`: it holds all factors.

    Of one group of several that is 1 where the signs decide, and 0, not known, where they do not.
    """
    if not whole:
        return int(count.signs_decide)
    return next(vector.parts.at_least for vector in count.each if tuple(vector.signs[i] for i in group) == signs)
