"""Boxes that no known family explains, grouped: places to look at, and what a descent finds there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from rankdrop.certify.bittree import Cells, Flags
from rankdrop.certify.covering import Covering
from rankdrop.families.searching import refine
from rankdrop.local.block import singular_values
from rankdrop.problem import wrap
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT

_MOST_CELLS = 20_000  # boxes that are joined one by one; more are joined in coarser boxes
_STARTS = 4  # descents in one place
_NEAR = 3.0  # a descent that ends farther than so many leaves from its box has left the place

PROVEN, FOUND, MISS, LEFT = "singular, proven", "singular, found", "near miss", "undecided"


@dataclass(frozen=True, eq=False)
class Spot:
    """Neighbouring boxes that no known family explains.

    Attributes:
        boxes: how many.
        proven: how many of them are proven to hold a singularity.
        lower, upper: (d,) the range of their centres in the variables covered, where they begin [rad, m]; on a turn
            `upper` may be beyond its end.
        q: (n,) a configuration there: the end of the descent with the smallest σ, else the centre of a box.
        sigma: σ_r there [1].
        kind: "singular, proven" (a change of sign), "singular, found" (σ vanishes), "near miss" (descents end at a
            larger σ), "undecided" (they leave the place).
    """

    boxes: int
    proven: int
    lower: Array
    upper: Array
    q: Array
    sigma: float
    kind: str


def spots(found: Covering, robot: Robot, task: Task, cells: Cells, proven: Flags) -> tuple[Spot, ...]:
    """Group leaves (M, d) and descend in each group; those with most boxes first.

    Args:
        found: the covering.
        robot, task: what it is about.
        cells: leaves of it.
        proven: (M,) which are proven to hold a singularity.
    """
    if not len(cells):
        return ()
    groups = grouped(cells, found.tree.shape.cells(found.tree.shape.levels), found.plan.turns)
    order = sorted(groups, key=lambda rows: (-len(rows), int(rows[0])))
    return _descended(found, robot, task, cells, proven, order)


def grouped(cells: Cells, counts: Sequence[int], turns: Sequence[bool]) -> list[NDArray[np.int64]]:
    """Rows of boxes (M, d) that touch each other, at corners too; across the ends of whole turns."""
    shift = 0
    while len(coarse := np.unique(cells >> shift, axis=0)) > _MOST_CELLS:
        shift += 1
    size = [max(1, count >> shift) for count in counts]
    number = {tuple(cell): i for i, cell in enumerate(coarse.tolist())}
    label = np.full(len(coarse), -1)
    steps = [step for step in product((-1, 0, 1), repeat=cells.shape[1]) if any(step)]
    for first in range(len(coarse)):
        if label[first] >= 0:
            continue
        label[first], waiting = first, [first]
        while waiting:
            at = coarse[waiting.pop()].tolist()
            for step in steps:
                place = tuple((a + s) % n if t else a + s for a, s, n, t in zip(at, step, size, turns, strict=True))
                other = number.get(place)
                if other is not None and label[other] < 0:
                    label[other] = first
                    waiting.append(other)
    _, whose = np.unique(cells >> shift, axis=0, return_inverse=True)
    mine = label[whose.reshape(-1)]
    rows = np.argsort(mine, kind="stable")
    return np.split(rows, np.flatnonzero(np.diff(mine[rows])) + 1)


def _descended(
    found: Covering, robot: Robot, task: Task, cells: Cells, proven: Flags, order: list[NDArray[np.int64]]
) -> tuple[Spot, ...]:
    place = np.array(found.plan.variables) - 1
    starts, owner = [], []
    for number, rows in enumerate(order):
        chosen = rows[np.argsort(~proven[rows], kind="stable")[:: max(1, len(rows) // _STARTS)][:_STARTS]]
        q = np.zeros((len(chosen), robot.n))
        q[:, place] = found.boxes(cells[chosen])[0]
        starts.append(q)
        owner += [number] * len(chosen)
    begun, whose = np.concatenate(starts), np.array(owner)
    ends = refine(robot, begun, 1, task=task, limits=found.plan.limits)
    rank = found.plan.rank
    width = 2 * found.boxes(cells[:1])[1]
    away = np.abs(ends.q - begun)[:, place]
    away = np.where(np.array(found.plan.turns), np.abs(wrap(away)), away)
    stays = (away <= _NEAR * width).all(axis=1) & np.isfinite(ends.sigma[:, rank - 1])
    here = singular_values(robot, begun, task)[:, rank - 1]
    sigma = np.where(stays, ends.sigma[:, rank - 1], here)
    at = np.where(stays[:, None], ends.q, begun)
    spots_found = []
    for number, rows in enumerate(order):
        mine = np.flatnonzero(whose == number)
        best = mine[int(sigma[mine].argmin())]
        centres, half = found.boxes(cells[rows])
        sure = int(proven[rows].sum())
        if sure:
            kind = PROVEN
        elif sigma[best] <= DEFAULT.singular:
            kind = FOUND
        else:
            kind = MISS if stays[mine].all() else LEFT
        spots_found.append(
            Spot(len(rows), sure, centres.min(axis=0) - half, centres.max(axis=0) + half, at[best],
                 float(sigma[best]), kind)
        )  # fmt: skip
    return tuple(spots_found)
