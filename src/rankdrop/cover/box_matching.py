"""A covering against families: which boxes known families explain.

A leaf is explained where a point of some family was found within half a diagonal of its centre, or, when it is halved
on, so near to the centre of each part that is left that no place of the part is farther from it than a diagonal of the
leaf. The point is one of the family, so no leaf is explained that is not near one; one that is not explained may be
near a point that was not found. When every leaf is explained, every singular configuration lies within one diagonal of
a known family. The boxes that are left are places to look at (`spots.py`).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import combinations, islice, product

import numpy as np
from numpy.typing import NDArray

from rankdrop.cover.covering import Covering
from rankdrop.families.points import Rows, near_family
from rankdrop.families.record import Family
from rankdrop.families.searching import Progress
from rankdrop.formula.equation import SOLVED, Equation, System
from rankdrop.proof.boxes import Cells, Flags
from rankdrop.robot.model import Array, Robot

_MOST_CELLS = 20_000  # boxes that are joined one by one; more are joined in coarser boxes

PROVEN, FOUND, MISS, LEFT = "singular, proven", "singular, found", "near miss", "undecided"

_WIDER = 1e-9  # half a diagonal is taken this much longer: neighbours of a pinned value lie exactly so far [rad]
_SIDES = 1e-12  # a value of an equation counts as of one sign beyond this, per sum of its coefficients
_STEPS = 12  # of Newton's method
_SUBSETS = 20  # of a family's equations that are walked by


def touching_groups(cells: Cells, counts: Sequence[int], turns: Sequence[bool]) -> list[NDArray[np.int64]]:
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


class FamilyBoxes:
    """Families of one arm in the variables of a covering.

    Args:
        covering: what is explained.
        robot: its arm.
        families: of this arm and task; those without equations, or on joints that are not covered, explain nothing.
        scale: (n,) unit of motion of each joint, as for distances.
        halvings: of leaves, whose parts are asked about: near is what leaves no place of a part farther from the family
            than a place of a whole leaf may be, a diagonal of the leaf.
    """

    def __init__(
        self, covering: Covering, robot: Robot, families: Sequence[Family], scale: Array, halvings: int = 0
    ) -> None:
        self.found, self.families = covering, tuple(families)
        shape = covering.tree.shape
        self.place = np.array(covering.plan.variables) - 1
        self.n, self.unit = robot.n, scale[self.place]
        leaves = shape.cells(shape.levels)
        self.cells = tuple(count << halvings for count in leaves)
        self.low = np.array(covering.plan.lower)
        self.width = (np.array(covering.plan.upper) - self.low) / self.cells
        part = float(np.linalg.norm(self.width / self.unit)) / 2
        self.radius = part * ((2 << halvings) - 1) + _WIDER
        self.turns = np.zeros(robot.n, dtype=np.bool_)
        self.turns[self.place] = covering.plan.turns
        usable = [i for i, family in enumerate(self.families) if self._usable(family)]
        self._order = sorted(usable, key=lambda i: (bool(self.families[i].coupled), -self.families[i].dimension, i))

    @property
    def diagonal(self) -> float:
        """Of a box asked about [rad; slides divided by the length scale]."""
        return float(np.linalg.norm(self.width / self.unit)) + 2 * _WIDER

    def _usable(self, family: Family) -> bool:
        joints = {number for equation in family.equations for number in equation.joints}
        return family.named and bool(family.equations) and joints <= {int(j) + 1 for j in self.place}

    def families_of_all(self, progress: Progress | None = None) -> tuple[NDArray[np.int64], Cells, Flags]:
        """(F,) leaves of the covering that each family explains, the first that does; (M, d) leaves that none explains,
        and (M,) which of these are proven to hold a singularity.
        """
        families = np.zeros(len(self.families), dtype=np.int64)
        left: list[Cells] = []
        proven: list[Flags] = []
        leaves = 0
        for cells, sure in self.found.tree.parts():
            by = self.families_of(cells)
            families += np.bincount(by[by >= 0], minlength=len(families))
            left.append(cells[by < 0])
            proven.append(sure[by < 0])
            leaves += len(cells)
            if progress is not None:
                progress(leaves, self.found.tree.leaves)
        none = np.zeros((0, len(self.place)), np.int32)
        return families, np.concatenate([none, *left]), np.concatenate([none[:, 0] > 0, *proven])

    def families_of(self, cells: Cells) -> NDArray[np.int64]:
        """(M,) index of the family that explains each leaf (M, d), the first that does; −1 where none does."""
        numbers = np.full(len(cells), -1)
        for i in self._order:
            left = np.flatnonzero(numbers < 0)
            if not len(left):
                break
            numbers[left[self._is_near(self.families[i], cells[left])]] = i
        return numbers

    def _is_near(self, family: Family, cells: Cells) -> Flags:
        """(M,) whether a point of a family was found near enough to the centre of each leaf, or part."""
        q, scale = np.zeros((len(cells), self.n)), np.ones(self.n)
        q[:, self.place], scale[self.place] = self.low + (cells + 0.5) * self.width, self.unit
        return near_family(family, q, self.radius, scale, self.turns, partial(self._is_near_coupled, family, cells))

    def _is_near_coupled(self, family: Family, cells: Cells, rows: Rows, q: Array, radius: Array) -> Flags:
        """The same, pinned joints at one value each; once for all leaves that differ in other joints only."""
        pinned = {pin.number for pin in family.pinned}
        joints = pinned.union(*(equation.joints for equation in family.equations))
        columns = [column for column, j in enumerate(self.place.tolist()) if j + 1 in joints]
        told = keys(cells[rows][:, columns], [self.cells[at] for at in columns])
        _, first, back = np.unique(told, axis=0, return_index=True, return_inverse=True)
        q, radius = q[first], radius[first]
        scale = np.zeros(self.n)
        bound = [column for column in columns if self.place[column] + 1 not in pinned]
        scale[self.place[bound]] = self.unit[bound]
        others = tuple(equation for equation in family.equations if not pinned.issuperset(equation.joints))
        if len(others) == 1:
            near = _zero_between(others[0], q, radius, scale)
        else:
            near = np.zeros(len(q), dtype=np.bool_)
        left = np.flatnonzero(~near)
        near[left] = _walk_to_zero(others, self.n - family.dimension - len(pinned), q[left], radius[left], scale)
        return np.asarray(near[back.reshape(-1)])


def _zero_between(equation: Equation, q: Array, radius: Array, scale: Array) -> Flags:
    """(M,) whether there is a zero between two points along the gradient, by a change of sign."""
    f, slope = equation.with_gradient(q)
    way = slope * scale
    length = np.linalg.norm(way, axis=1, keepdims=True)
    step = scale * way / np.maximum(length, 1e-300) * radius[:, None]
    other = equation(q - np.sign(f)[:, None] * step)
    sure = _SIDES * sum(abs(term.coefficient) for term in equation.terms)
    return np.asarray((length[:, 0] > 0.0) & ((np.abs(f) <= sure) | ((f * other < 0.0) & (np.abs(other) > sure))))


def _walk_to_zero(equations: tuple[Equation, ...], conditions: int, q: Array, radius: Array, scale: Array) -> Flags:
    """(M,) whether a zero at the end of Newton's walk is near enough.

    Where equations are more than conditions, they pull apart off the family, or one that has double zeros leads
    astray: what as many of them as there are conditions lead to is a zero as well if it is one of all.
    """
    whole, moves = System(equations), np.flatnonzero(scale)
    fewer = combinations(equations, conditions) if 0 < conditions < len(equations) else ()
    near = np.zeros(len(q), dtype=np.bool_)
    for system in (whole, *map(System, islice(fewer, _SUBSETS))):
        left = np.flatnonzero(~near)
        if not len(left):
            break
        end, there = system.solve(q[left], along=np.eye(len(scale))[:, moves], iterations=_STEPS)
        away = np.linalg.norm((end - q[left])[:, moves] / scale[moves], axis=1)
        near[left] = there & (away <= radius[left]) & (np.abs(whole.values(end)).max(axis=1) <= SOLVED)
    return near


def keys(cells: Cells, counts: Sequence[int]) -> NDArray[np.int64]:
    """(M, 1 or 2) numbers that tell cells (M, d) apart, of so many along each variable; two where one has too few bits.

    Example:
        >>> keys(np.array([[1, 2], [3, 0]]), [4, 4]).tolist()
        [[6], [12]]
    """
    if sum(count.bit_length() for count in counts) < 63:
        count = len(counts)
    else:
        count = len(counts) // 2
    parts = [(cells[:, some], counts[some]) for some in (slice(count), slice(count, None)) if len(counts[some])]
    return np.stack([np.ravel_multi_index(tuple(part.T), tuple(sizes)) for part, sizes in parts], axis=1)
