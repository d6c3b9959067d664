"""Singular places inside the undecided boxes of a covering."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rankdrop.cover.box_matching import FOUND, LEFT, MISS, PROVEN, touching_groups
from rankdrop.cover.covering import Covering
from rankdrop.families.searching import refine
from rankdrop.local.block import singular_values
from rankdrop.problem import wrap
from rankdrop.proof.boxes import Cells, Flags
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT

_STARTS = 4  # descents in one place
_NEAR = 3.0  # a descent that ends farther than so many leaves from its box has left the place


@dataclass(frozen=True, eq=False)
class UnexplainedBoxes:
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


def spots(covering: Covering, robot: Robot, task: Task, cells: Cells, proven: Flags) -> tuple[UnexplainedBoxes, ...]:
    """Group leaves (M, d) and descend in each group; those with most boxes first.

    Args:
        covering: with its boxes.
        robot, task: what it is about.
        cells: leaves of it.
        proven: (M,) which are proven to hold a singularity.
    """
    if not len(cells):
        return ()
    groups = touching_groups(cells, covering.tree.shape.cells(covering.tree.shape.levels), covering.plan.turns)
    order = sorted(groups, key=lambda rows: (-len(rows), int(rows[0])))
    return _descend_in_groups(covering, robot, task, cells, proven, order)


def _descend_in_groups(
    covering: Covering, robot: Robot, task: Task, cells: Cells, proven: Flags, order: list[NDArray[np.int64]]
) -> tuple[UnexplainedBoxes, ...]:
    place = np.array(covering.plan.variables) - 1
    starts, owner = [], []
    for number, rows in enumerate(order):
        chosen = rows[np.argsort(~proven[rows], kind="stable")[:: max(1, len(rows) // _STARTS)][:_STARTS]]
        q = np.zeros((len(chosen), robot.n))
        q[:, place] = covering.boxes(cells[chosen])[0]
        starts.append(q)
        owner += [number] * len(chosen)
    begun, whose = np.concatenate(starts), np.array(owner)
    ends = refine(robot, begun, covering.plan.corank, task=task, limits=covering.plan.limits)
    rank = covering.plan.kept_rank
    width = 2 * covering.boxes(cells[:1])[1]
    away = np.abs(ends.q - begun)[:, place]
    away = np.where(np.array(covering.plan.turns), np.abs(wrap(away)), away)
    stays = (away <= _NEAR * width).all(axis=1) & np.isfinite(ends.sigma[:, rank - 1])
    here = singular_values(robot, begun, task)[:, rank - 1]
    sigma = np.where(stays, ends.sigma[:, rank - 1], here)
    at = np.where(stays[:, None], ends.q, begun)
    spots_found = []
    for number, rows in enumerate(order):
        mine = np.flatnonzero(whose == number)
        best = mine[int(sigma[mine].argmin())]
        centres, half = covering.boxes(cells[rows])
        sure = int(proven[rows].sum())
        if sure:
            kind = PROVEN
        elif sigma[best] <= DEFAULT.singular:
            kind = FOUND
        else:
            kind = MISS if stays[mine].all() else LEFT
        spots_found.append(
            UnexplainedBoxes(len(rows), sure, centres.min(axis=0) - half, centres.max(axis=0) + half, at[best],
                 float(sigma[best]), kind)
        )  # fmt: skip
    return tuple(spots_found)
