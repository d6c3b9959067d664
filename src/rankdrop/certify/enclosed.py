"""Trees of bits from enclosures: any arm and task whose regions can be certified."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from rankdrop.certify.ball import settings_of
from rankdrop.certify.setting import Setting, enclose
from rankdrop.kinematics import task_jacobian
from rankdrop.local.block import sample
from rankdrop.proof.boxes import Cells, Flags, Masks, Plan, Shape, allowed, bits, packed
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task

_TRIED = 200  # random configurations at which settings are compared
_ROUNDING = 1e-12  # of a determinant, per product of the lengths of its columns: a thousand times what LU loses
_SEAM = 1e-15  # centres and corners are rounded: boxes are tested this much wider
_ROUNDS, _MOST = 8, 1 << 22  # of a closer look: rounds, boxes
_PART = 1 << 16  # boxes tested at one go


Batch = tuple[Masks, NDArray[np.int32], int, int]
"""Of boxes of the level `top`: masks, box by box and in each level by level (the proven last); (boxes, levels + 1) how
many; boxes tested; leaves freed."""
Near = Callable[[Cells, int], NDArray[np.int64]]
"""near(parts of leaves, how often they are halved) -> for each the number of a family that is near, or −1."""
Looked = tuple[NDArray[np.int8], NDArray[np.int64]]
"""Of leaves: 0 free, 1 proven to hold a singularity, 2 neither, 3 all that is left is near families; and which."""


class BudgetSpent(Exception):
    """More enclosures are needed than were allowed."""


def viewed(robot: Robot, task: Task, corank: int = 1) -> Setting:
    """The setting that certifies the largest balls at random configurations.

    Args:
        robot, task: the arm and what it does.
        corank: that must not be reached in a ball: the setting's rank is the one that is kept then.

    Raises:
        OptionError: the arm or the task cannot be certified.
    """
    settings = [replace(one, rank=one.rank - corank + 1) for one in settings_of(robot, task)]
    q = sample(robot, task, _TRIED, seed=7)
    sizes = [float(np.median(enclose(robot, setting, q)[1])) for setting in settings]
    return settings[int(np.argmax(sizes))]


def enclosed_trees(
    robot: Robot, task: Task, setting: Setting, plan: Plan, begin: int, end: int, budget: int, threads: int
) -> Batch:
    """Trees of boxes begin … end − 1 of the level `top`, as `_core.cover` gives them.

    Raises:
        BudgetSpent: they need more than `budget` enclosures.
    """
    shape = plan.shape
    boxes = _Boxes(robot, task, setting, plan, threads)
    numbers = np.arange(begin, end)
    cells = np.stack(np.unravel_index(numbers, shape.cells(shape.top)), axis=1).astype(np.int32)
    tree = np.arange(len(numbers))
    masks: list[Masks] = []
    trees: list[NDArray[np.int64]] = []
    tested = 0
    for level in range(shape.top + 1, shape.levels + 1):
        every = np.full(len(cells), allowed(shape, level), shape.kind)
        below, parent = shape.children(cells, every, level)
        tested += len(below)
        if tested > budget:
            raise BudgetSpent
        free = boxes.free(below, level)
        flags = bits(every, shape.variables).copy()
        flags[flags] = ~free
        masks.append(packed(flags, shape.kind))
        trees.append(tree)
        cells, tree = below[~free], tree[parent[~free]]
    proven = boxes.proven(cells)
    flags = bits(masks[-1], shape.variables).copy()
    flags[flags] = proven
    _prune(shape, masks)
    last = masks[-1] != 0
    masks.append(packed(flags, shape.kind))
    kept = [one != 0 for one in masks[:-1]] + [last]
    where = [*trees, trees[-1]]
    rows = range(len(numbers))
    sizes = np.stack([np.bincount(w[k], minlength=len(numbers)) for w, k in zip(where, kept, strict=True)], axis=1)
    ends = [np.cumsum(np.bincount(w[k], minlength=len(numbers))) for w, k in zip(where, kept, strict=True)]
    parts = [one[k] for one, k in zip(masks, kept, strict=True)]
    ordered = [part[e[row] - sizes[row, p] : e[row]] for row in rows
               for p, (part, e) in enumerate(zip(parts, ends, strict=True))]  # fmt: skip
    return np.concatenate([np.zeros(0, shape.kind), *ordered]), sizes.astype(np.int32), tested, 0


def closer(
    robot: Robot, task: Task, setting: Setting, plan: Plan, cells: Cells, threads: int, near: Near | None = None
) -> Looked:
    """Leaves (M, d) halved on, and what is left of them asked about.

    Each takes at most `_ROUNDS` rounds, and no more than `_MOST` boxes are kept for all of them. Parts near a family
    are halved no further; a leaf of which nothing else is left is explained, by the family of the first of them.
    """
    shape = plan.shape
    boxes = _Boxes(robot, task, setting, plan, threads)
    proven = boxes.proven(cells)
    by = np.full(len(cells), -1, dtype=np.int64)
    parts, owner, halvings = cells, np.arange(len(cells)), 0
    corners = np.array(list(product((0, 1), repeat=shape.variables)), dtype=np.int32)
    while len(parts) and halvings < _ROUNDS and len(parts) << shape.variables <= _MOST:
        parts = (parts[:, None, :] * 2 + corners).reshape(-1, shape.variables)
        owner, halvings = np.repeat(owner, len(corners)), halvings + 1
        left = ~boxes.free(parts, shape.levels + halvings)
        parts, owner = parts[left], owner[left]
        if near is not None:
            told = near(parts, halvings)
            there = np.flatnonzero(told >= 0)[::-1]  # of several the first is the last to be written
            by[owner[there]] = told[there]
            parts, owner = parts[told < 0], owner[told < 0]
    found = np.where(by >= 0, 3, 0).astype(np.int8)
    left = np.unique(owner)
    found[left] = np.where(proven[left], 1, 2)
    return found, by


def _prune(shape: Shape, masks: list[Masks]) -> None:
    """Take back the bits of boxes below which nothing is left."""
    for above in range(len(masks) - 2, -1, -1):
        flags = bits(masks[above], shape.variables).copy()
        flags[flags] = masks[above + 1] != 0
        masks[above] = packed(flags, shape.kind)


class _Boxes:
    """Boxes of one plan as configurations of the arm."""

    def __init__(self, robot: Robot, task: Task, setting: Setting, plan: Plan, threads: int) -> None:
        self.robot, self.task, self.setting, self.plan, self.threads = robot, task, setting, plan, threads
        self.low, self.high = np.array(plan.lower), np.array(plan.upper)
        self.place = np.array(plan.variables) - 1

    def _at(self, cells: Cells, level: int) -> tuple[Array, Array]:
        """(M, n) centres, and (M, n) half-widths in units of motion, rounded outwards."""
        deepest = self.plan.shape.levels
        width = (self.high - self.low) / self.plan.shape.cells(level) / (1 << max(0, level - deepest))
        q, half = np.zeros((len(cells), self.robot.n)), np.zeros((len(cells), self.robot.n))
        unit = np.asarray(self.setting.scale)[self.place]
        q[:, self.place] = self.low + (cells + 0.5) * width
        far = 1.0 + np.maximum(np.abs(self.low), np.abs(self.high)) / unit
        half[:, self.place] = width / 2 / unit * (1 + 1e-12) + _SEAM * far
        return q, half

    def free(self, cells: Cells, level: int) -> Flags:
        """(M,) whether the rank is proven to hold in all of each box."""
        found = np.zeros(len(cells), dtype=np.bool_)
        for begin in range(0, len(cells), _PART):
            part = slice(begin, begin + _PART)
            q, half = self._at(cells[part], level)
            found[part] = enclose(self.robot, self.setting, q, half, threads=self.threads)[0] != 0
        return found

    def proven(self, cells: Cells) -> Flags:
        """(M,) whether a determinant has two signs among centre and corners.

        False where the Jacobian is not square, and for coranks above 1, which no sign tells.
        """
        found = np.zeros(len(cells), dtype=np.bool_)
        if not self.task.m == self.robot.n == self.plan.kept:
            return found
        for begin in range(0, len(cells), _PART):
            part = slice(begin, begin + _PART)
            q, half = self._at(cells[part], self.plan.shape.levels)
            half = half * np.asarray(self.setting.scale)
            plus, minus = np.zeros(len(q), dtype=np.bool_), np.zeros(len(q), dtype=np.bool_)
            for corner in [(0,) * len(self.place), *product((-1, 1), repeat=len(self.place))]:
                at = q.copy()
                at[:, self.place] += half[:, self.place] * corner
                jacobian = task_jacobian(self.robot, at, self.task)
                value = np.linalg.det(jacobian)
                least = _ROUNDING * np.prod(np.linalg.norm(jacobian, axis=1), axis=1)
                plus |= value > least
                minus |= value < -least
            found[part] = plus & minus
        return found
