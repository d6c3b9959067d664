"""Boxes that hold every singular configuration of an arm, and those that are proven to hold one.

The joint space is halved into boxes, and a box is left out where the rank is proven to be the generic one in all of it.
What is left, down to leaves of a given width, holds every singular configuration. Two ways to prove a box free:

- split: six turning joints and the full pose, or five and all but the turn about the tool's axis: that turn is a sixth
  joint then. The determinant is f = a · b (`rankdrop.cover.split`), and a box with
  centre c and half-widths h is free where |f(c)| > Σ |∂_j f(c)| h_j + ½ Σ |f_jk| h_j h_k + rounding, or where the
  Bernstein coefficients of f in the tangents of half angles have one sign. A leaf is proven to hold a singularity where
  f has two signs at its corners, beyond rounding.
- enclosures: any other arm, by the bound of certified balls (`rankdrop.cover.setting`). So are coranks K above 1 of
  every arm: a box is free where K − 1 less than the generic rank is proven to be kept in all of it.

Variables that move no column against another are free: a box is a cylinder over them.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import lru_cache
from itertools import product
from math import ceil, log2, pi
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.cover.certificates import refused_as_result
from rankdrop.cover.setting import Setting, best_setting, enclose
from rankdrop.cover.split import split_of
from rankdrop.disk import replace_file
from rankdrop.errors import OptionError, ResultFileError
from rankdrop.kinematics import task_jacobian
from rankdrop.local.block import generic_rank
from rankdrop.proof.boxes import (
    BitTree,
    BoxShape,
    Cells,
    Flags,
    Masks,
    Plan,
    allowed_children,
    bits,
    counts,
    covering_bytes,
    load,
    load_plan,
    pack_bits,
)
from rankdrop.robot.model import Array, Joint, JointKind, Robot, fingerprint, screw_of
from rankdrop.task import Task, resolve_task
from rankdrop.version import VERSION

SPLIT, ENCLOSURES = "split determinant", "enclosures"
BUDGET = 10_000_000_000
"""Enclosures that one chunk may take, about 1.5 µs each; the split determinant needs none."""
NARROWEST = 2 * pi / 512
"""No leaf is made narrower [rad]: the tables of six joints have 500 MB then."""
WIDEST = pi
_MOST_LEAVES = 2**40  # boxes of the last level, free ones included
_MOST_VARIABLES = 5
_POINTING = (0, 1, 2, 3, 4)  # rows in tool axes of a tool that may turn about its own z axis
_TOP = 3  # level of the boxes that are done one by one
_CLOSER = 24  # halvings by which leaves that no family explains are looked into
_PARTS = 10_000_000  # of them in all, about 2 µs each
_CHUNKS = 64  # into which a covering is divided, at most
_ROUNDING = 1e-12  # of a determinant, per product of the lengths of its columns: a thousand times what LU loses
_SEAM = 1e-15  # centres and corners are rounded: boxes are tested this much wider
_ROUNDS, _MOST = 8, 1 << 22  # of a closer look: rounds, boxes
_PART = 1 << 16  # boxes tested at one go
_AT_ONCE = 1 << 14  # boxes halved at one go

Batch = tuple[Masks, NDArray[np.int32], int, int]
"""Of boxes of the level `top`: masks, box by box and in each level by level (the proven last); (boxes, levels + 1) how
many; boxes tested; leaves freed."""
Near = Callable[[Cells, int], NDArray[np.int64]]
"""near(parts of leaves, how often they are halved) -> for each the number of a family that is near, or −1."""
Looked = tuple[NDArray[np.int8], NDArray[np.int64]]
"""Of leaves: 0 free, 1 proven to hold a singularity, 2 neither, 3 all that is left is near families; and which."""

_HEAD = struct.Struct("<qqqq")  # of a chunk: boxes, masks, tested, freed


class CoveringEnd(StrEnum):
    """Why a covering ended before the whole joint space was covered."""

    INTERRUPTED = "interrupted"
    BUDGET_SPENT = "budget-spent"
    BUDGET_TOO_SMALL = "budget-too-small"


class BudgetSpent(Exception):
    """More enclosures are needed than were allowed."""


@dataclass(frozen=True, eq=False)
class Covering:
    """What is left of the joint space when all that is proven free is taken out.

    Attributes:
        plan: arm, task, variables, ranges, width and method.
        tree: the boxes.
        tested: boxes tested.
        freed: leaves that were proven free by looking into them.
        stopped: why it is not complete; None where it is.
        needed: enclosures that all of it takes, by `estimate`; 0 where that was not asked.
    """

    plan: Plan
    tree: BitTree
    tested: int
    freed: int
    stopped: CoveringEnd | None = None
    needed: int = 0

    @property
    def interrupted(self) -> bool:
        """Ctrl-C ended it before it was complete."""
        return self.stopped is CoveringEnd.INTERRUPTED

    @property
    def complete(self) -> bool:
        """Every singular configuration is in a leaf; else those in parts not done are in none."""
        return self.tree.complete

    @property
    def free_share(self) -> float:
        """Share of the volume of the joint space (of the ranges covered) that is proven free."""
        return self.tree.free_share

    def boxes(self, cells: NDArray[np.int32]) -> tuple[Array, Array]:
        """(M, d) centres of leaves and (d,) their half-widths [rad, m], in the variables covered."""
        low, high = np.array(self.plan.lower), np.array(self.plan.upper)
        width = (high - low) / self.tree.shape.cells(self.tree.shape.levels)
        return low + (cells + 0.5) * width, width / 2

    def holds(self, q: Array) -> NDArray[np.bool_]:
        """(N,) whether configurations (N, n) lie in a box that is not free; turning joints modulo a turn.

        Outside the ranges covered nothing is known, and the answer is True.
        """
        x, inside = self._places(np.atleast_2d(np.asarray(q, dtype=np.float64)))
        shape, tree = self.tree.shape, self.tree
        deepest = np.array(shape.cells(shape.levels))
        cells = np.clip((x * deepest).astype(np.int64), 0, deepest - 1)
        depth = np.array(shape.depth)

        def at(level: int) -> NDArray[np.int64]:
            return np.asarray(cells >> (depth - np.minimum(level, depth)), dtype=np.int64)

        number = np.ravel_multi_index(tuple(at(shape.top).T), shape.cells(shape.top))
        open_ = tree.roots[number]
        finished = open_ & tree.finished[number]
        row = (np.cumsum(tree.roots & tree.finished) - 1)[number]
        for level, masks in enumerate(tree.masks, start=shape.top + 1):
            child = np.zeros(len(x), dtype=np.int64)
            for j, halved in enumerate(shape.halved(level)):
                child = child << 1 | (at(level)[:, j] & halved)
            first = np.concatenate([[0], np.cumsum(counts(masks))])
            row = np.where(finished, row, 0)
            if len(masks):
                mask = masks[row]
            else:
                mask = np.zeros(len(x), shape.kind)
            bit = np.left_shift(1, child.astype(shape.kind), dtype=shape.kind)
            there = (mask & bit) != 0
            row = first[row] + counts((mask & (bit - 1)).astype(shape.kind))
            open_ &= ~finished | there
            finished &= there
        return np.asarray(open_ | ~inside)

    def _places(self, q: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Shares of the ranges, and whether they are inside."""
        low, high = np.array(self.plan.lower), np.array(self.plan.upper)
        x = q[:, np.array(self.plan.variables) - 1]
        turns = np.array(self.plan.turns)
        x = np.where(turns, low + np.mod(x - low, 2 * pi), x)
        inside = np.asarray(((x >= low) & (x <= high)).all(axis=1))
        return np.clip((x - low) / np.where(high > low, high - low, 1.0), 0.0, 1.0), inside


def chunks_of(plan: Plan) -> int:
    """Into how many chunks a covering is divided: so many boxes of the level `top`, one after another, in each."""
    return -(-plan.shape.trees // _size(plan))


def _size(plan: Plan) -> int:
    return -(-plan.shape.trees // _CHUNKS)


def chunk_of(
    robot: Robot, task: Task, plan: Plan, chunk: int, *, budget: int = BUDGET, threads: int = 0
) -> Batch:
    """One chunk of a covering; it depends on the plan and its number alone.

    Raises:
        BudgetSpent: it takes more enclosures than that; never for the split determinant.
    """
    begin = chunk * _size(plan)
    end = min(begin + _size(plan), plan.shape.trees)
    if plan.method == SPLIT:
        return _core.cover(_kept_tables(robot, plan), begin, end, threads=threads)
    return enclosed_trees(robot, task, _kept_view(robot, task, plan), plan, begin, end, budget, threads)


def estimate(robot: Robot, task: Task, plan: Plan, *, ways: int = 512, seed: int = 0) -> int:
    """About how many enclosures a covering takes, from random ways down its tree (Knuth 1975): two digits.

    At each level all children of the boxes of the ways are tested, and each way goes on to one of its children that are
    not free: a way stands for the product of the numbers of such children so far. Without bias; the split
    determinant needs no enclosures.
    """
    if plan.method == SPLIT:
        return 0
    shape, rng = plan.shape, np.random.default_rng(seed)
    boxes = _Boxes(robot, task, _kept_view(robot, task, plan), plan, 1)
    roots = rng.integers(shape.trees, size=ways)
    cells = np.stack(np.unravel_index(roots, shape.cells(shape.top)), axis=1).astype(np.int32)
    stands_for = np.full(ways, shape.trees / ways)
    total = 0.0
    for level in range(shape.top + 1, shape.levels + 1):
        every = np.full(len(cells), allowed_children(shape, level), shape.kind)
        children, parent = shape.children(cells, every, level)
        total += float(stands_for @ np.bincount(parent, minlength=len(cells)))
        left = np.flatnonzero(~boxes.free(children, level))
        if not len(left):
            break
        many = np.bincount(parent[left], minlength=len(cells))
        going = np.flatnonzero(many)
        first = np.searchsorted(parent[left], going)
        chosen = left[first + (rng.random(len(going)) * many[going]).astype(np.int64)]
        cells, stands_for = children[chosen], stands_for[going] * many[going]
    return int(float(f"{total:.1e}"))


def put_together(
    plan: Plan, batches: Mapping[int, Batch], stopped: CoveringEnd | None = None, needed: int = 0
) -> Covering:
    """The covering of chunks, by their numbers; those that are missing are not covered.

    Args:
        plan: what is covered.
        batches: what `chunk_of` made.
        stopped: why some are missing.
        needed: enclosures that all of it takes, as estimated.
    """
    shape, size = plan.shape, _size(plan)
    finished = np.zeros(shape.trees, dtype=np.bool_)
    for chunk in batches:
        finished[chunk * size : (chunk + 1) * size] = True
    ordered = [batches[chunk] for chunk in sorted(batches)]
    tested, freed = sum(int(batch[2]) for batch in ordered), sum(int(batch[3]) for batch in ordered)
    return Covering(plan, _join_trees(shape, finished, ordered), tested, freed, stopped, needed)


def _join_trees(shape: BoxShape, finished: NDArray[np.bool_], batches: list[Batch]) -> BitTree:
    """One tree of bits from those of the boxes of level `top` that are finished, in their order."""
    parts = shape.levels - shape.top + 1
    pieces: list[list[Masks]] = [[np.zeros(0, shape.kind)] for _ in range(parts)]
    roots = ~finished
    filled = [np.zeros(0, dtype=np.bool_)]
    for masks, sizes, _, _ in batches:
        which = np.repeat(np.tile(np.arange(parts), len(sizes)), sizes.reshape(-1))
        for part in range(parts):
            pieces[part].append(masks[which == part])
        filled.append(sizes[:, 0] > 0)
    roots[finished] = np.concatenate(filled)
    levels = [np.concatenate(masks).astype(shape.kind) for masks in pieces]
    return BitTree(shape, finished, roots, tuple(levels[:-1]), levels[-1])


def batch_to_bytes(batch: Batch) -> bytes:
    """A chunk as it is kept: counts, then sizes, then masks, all little-endian."""
    masks, sizes, tested, freed = batch
    body = sizes.astype("<i4").tobytes() + np.ascontiguousarray(masks).tobytes()
    return _HEAD.pack(len(sizes), len(masks), tested, freed) + body


def batch_from_bytes(content: bytes, shape: BoxShape) -> Batch:
    """What `batch_to_bytes` made of a chunk of such boxes.

    Raises:
        ValueError: it did not make this.
    """
    parts = shape.levels - shape.top + 1
    if len(content) < _HEAD.size:
        raise ValueError("a chunk of a covering that ends too soon")
    boxes, count, tested, freed = _HEAD.unpack_from(content)
    begin = _HEAD.size + boxes * parts * 4
    if len(content) != begin + count * shape.kind.itemsize:
        raise ValueError("a chunk of another covering")
    sizes = np.frombuffer(content[_HEAD.size : begin], "<i4").reshape(boxes, parts).astype(np.int32)
    return np.frombuffer(content[begin:], shape.kind), sizes, tested, freed


def write_covering(path: Path, covering: Covering) -> None:
    """Write a finished covering, all or nothing.

    Raises:
        ResultFileError: it cannot be written.
    """
    try:
        replace_file(path, covering_bytes(covering.plan, covering.tree, covering.tested, covering.freed))
    except OSError as error:
        raise ResultFileError(f"cannot write: {error.strerror}", where=str(path)) from error


def load_covering(path: Path, plan: Plan | None = None) -> Covering | None:
    """Read a covering and check its hash.

    Args:
        path: of the file.
        plan: None is returned, and no box read, where the file holds another covering than this.

    Raises:
        ResultFileError: it cannot be read, is no covering, or was damaged or changed.
    """
    with refused_as_result():
        if plan is not None and load_plan(path)[0].line() != plan.line():
            return None
        return Covering(*load(path))


def finished_leaves(path: Path) -> int:
    """How many boxes the covering of a file has, as it says.

    Raises:
        ResultFileError: it is no covering.
    """
    with refused_as_result():
        return int(load_plan(path)[1]["leaves"])


def plan_of(
    robot: Robot, width: float, task: str | Task | None = None, *, corank: int = 1, limits: bool = False
) -> Plan:
    """What is to be covered, and how: all that decides the covering.

    Args:
        robot: the arm.
        width: of a leaf, at most [rad; slides divided by the length scale].
        task: as everywhere.
        corank: by how much the rank falls below the generic one, at least.
        limits: within the joint limits only; else turning joints go all the way round. Slides need limits.

    Raises:
        OptionError: a width or a corank outside what is allowed, a slide without limits, an arm or task that cannot be
            certified, or more than five variables that matter.
    """
    resolved = resolve_task(task, robot)
    if not NARROWEST <= width <= WIDEST:
        raise OptionError("no such width of boxes", where="width", got=width, allowed=f"{NARROWEST:.4f} … π [rad]")
    setting = best_setting(robot, resolved)
    if not 1 <= corank <= setting.rank:
        raise OptionError("there is no such corank for this arm and task", where="corank", got=corank,
                          allowed=f"1 … {setting.rank}")  # fmt: skip
    split = corank == 1 and _splits(robot, resolved, setting)
    numbers = tuple(int(j) + 1 for j in np.flatnonzero(setting.matters))
    if not numbers:
        raise OptionError("no joint decides whether this arm is singular: there is nothing to cover", got=robot.name)
    if len(numbers) > _MOST_VARIABLES:
        raise OptionError(
            "too many joints decide for a covering", got=len(numbers), allowed=f"at most {_MOST_VARIABLES}",
            mend="cover an arm with fewer joints, or a task that fewer joints decide",
        )  # fmt: skip
    lower, upper, depth, turns = zip(*(_range(robot, setting, j - 1, width, limits) for j in numbers), strict=True)
    shape = BoxShape(depth, 0)
    if float(np.prod([float(count) for count in shape.cells(shape.levels)])) > _MOST_LEAVES:
        raise OptionError(
            "too many boxes", where="width", got=width, allowed="fewer than 2^40 leaves", mend="take a larger width"
        )
    top = min(_TOP if split else max(0, ceil(10 / len(numbers)) - 1), shape.levels - 1)
    return Plan(
        robot=robot.name, fingerprint=fingerprint(robot), task=resolved.name, rows=resolved.rows,
        rank=generic_rank(robot, resolved), method=SPLIT if split else ENCLOSURES, width=float(width), limits=limits,
        variables=numbers, lower=lower, upper=upper, turns=turns, depth=depth, top=top,
        further=0, version=VERSION, corank=int(corank),
    )  # fmt: skip


def _splits(robot: Robot, task: Task, setting: Setting) -> bool:
    if not all(joint.kind is JointKind.REVOLUTE and joint.mimic is None for joint in robot.joints):
        return False
    if setting.tool:
        return robot.n == 5 and task.rows == _POINTING and not any(task.frame.point)
    return robot.n == 6 and task.m == 6 and setting.rank == 6


def _with_tool_axis(robot: Robot) -> Robot:
    """An arm of five joints with a sixth that turns the tip about its own z axis.

    Its column is zero in all rows of the twist in tool axes but the last, where it is 1: the determinant of the six
    columns is that of the five rows above, up to the sign.
    """
    axis = screw_of(JointKind.REVOLUTE, robot.home[:3, 2], robot.home[:3, 3])
    return replace(robot, joints=(*robot.joints, Joint("tool-axis", JointKind.REVOLUTE, axis)))


def _range(robot: Robot, setting: Setting, j: int, width: float, limits: bool) -> tuple[float, float, int, bool]:
    """Ends, halvings, and whether the ends of the range are one configuration.

    A whole turn begins half a leaf before −π: multiples of π/2 lie in the middle of leaves, not on their borders.
    """
    joint = robot.variables[j]
    unit = float(setting.scale[j])
    low, high = joint.lower, joint.upper
    if robot.periodic[j] and (not limits or not high - low < 2 * pi):
        depth = _halvings(2 * pi, width)
        begin = -pi - pi / 2**depth
        return begin, begin + 2 * pi, depth, True
    if not (np.isfinite(low) and np.isfinite(high)):
        raise OptionError(
            "a joint without limits cannot be covered", where=f"joint {joint.name!r}", got=f"{low} … {high}",
            allowed="limits, or a joint that turns, with all that follows it, in whole turns", mend="give it limits",
        )
    return low, high, _halvings((high - low) / unit, width), False


def _halvings(length: float, width: float) -> int:
    if length > width:
        return max(0, ceil(log2(length / width) - 1e-12))
    return 0


def tables_of(robot: Robot, plan: Plan) -> _core.Split:
    """The split determinant of an arm in tables."""
    if plan.rows == _POINTING:
        six = _with_tool_axis(robot)
    else:
        six = robot
    return _core.Split(
        **split_of(six), lower=np.array(plan.lower), upper=np.array(plan.upper),
        depth=np.array(plan.depth, dtype=np.int32), further=plan.further, top=plan.top,
    )  # fmt: skip


def classify_boxes(
    robot: Robot, task: Task, covering: Covering, cells: NDArray[np.int32], *,
    near: Near | None = None, threads: int = 0,
) -> Looked:
    """Leaves (M, d) looked at more closely: free after all (0), proven to hold a singularity (1), or neither (2).

    By enclosures, and with `near`, also: all that is left of it is near families (3); and the number of one of them.

    Args:
        robot, task: what the covering is about.
        found: it.
        cells: leaves of it.
        near: which family is near parts of leaves.
        threads: 0 for all cores.
    """
    nothing = np.full(len(cells), -1, dtype=np.int64)
    if not len(cells):
        return np.zeros(0, dtype=np.int8), nothing
    if covering.plan.method == SPLIT:
        leaves, parts = np.ascontiguousarray(cells), int(np.clip(_PARTS // len(cells), 64, 4096))
        return _core.judge_leaves(
            tables_of(robot, covering.plan), leaves, _CLOSER, parts=parts, threads=threads
        ), nothing  # fmt: skip
    return closer(robot, task, best_setting(robot, task, covering.plan.corank), covering.plan, cells, threads, near)


@lru_cache(1)
def _kept_tables(robot: Robot, plan: Plan) -> _core.Split:
    return tables_of(robot, plan)


@lru_cache(1)
def _kept_view(robot: Robot, task: Task, plan: Plan) -> Setting:
    return best_setting(robot, task, plan.corank)


def enclosed_trees(
    robot: Robot, task: Task, setting: Setting, plan: Plan, begin: int, end: int, budget: int, threads: int
) -> Batch:
    """Trees of boxes begin … end − 1 of the level `top`, as `_core.cover` gives them.

    Raises:
        BudgetSpent: they need more than `budget` enclosures.
    """
    shape = plan.shape
    numbers = np.arange(begin, end)
    cells = np.stack(np.unravel_index(numbers, shape.cells(shape.top)), axis=1).astype(np.int32)
    halving = _Halving(_Boxes(robot, task, setting, plan, threads), budget)
    levels = halving.below(cells, np.arange(len(numbers), dtype=np.int32), shape.top + 1)
    roots = levels[0]
    left = roots.masks != 0
    levels[0] = _Level(roots.masks[left], roots.tree[left])

    sizes = np.stack([np.bincount(level.tree, minlength=len(numbers)) for level in levels], axis=1)
    ends = np.cumsum(sizes, axis=0)
    ordered = []
    for tree in range(len(numbers)):
        for part, level in enumerate(levels):
            until = ends[tree, part]
            ordered.append(level.masks[until - sizes[tree, part] : until])
    return np.concatenate([np.zeros(0, shape.kind), *ordered]), sizes.astype(np.int32), halving.tested, 0


@dataclass(frozen=True, slots=True)
class _Level:
    """Boxes of one level: their masks (M,), and the trees (M,) that they are in."""

    masks: Masks
    tree: NDArray[np.int32]


class _Halving:
    """Boxes halved down to leaves, few at a time: memory does not grow with the number of boxes."""

    def __init__(self, boxes: _Boxes, budget: int) -> None:
        self.boxes, self.budget, self.tested = boxes, budget, 0
        self.shape = boxes.plan.shape

    def below(self, cells: Cells, tree: NDArray[np.int32], level: int) -> list[_Level]:
        """The boxes that are left below those of the level above `level`.

        Returns:
            one mask for each box (0 where nothing is left of it), then the masks of each level below it and those of
            the proven leaves, of boxes of which something is left only.
        """
        shape = self.shape
        every = np.full(len(cells), allowed_children(shape, level), shape.kind)
        children, parent = shape.children(cells, every, level)
        self.tested += len(children)
        if self.tested > self.budget:
            raise BudgetSpent
        left = ~self.boxes.free(children, level)
        flags = bits(every, shape.variables).copy()
        kept, owner = children[left], tree[parent[left]]

        if level == shape.levels:
            flags[flags] = left
            masks = pack_bits(flags, shape.kind)
            proven = np.zeros_like(flags)
            proven[flags] = self.boxes.proven(kept)
            there = masks != 0
            return [_Level(masks, tree), _Level(pack_bits(proven, shape.kind)[there], tree[there])]

        parts = [
            self.below(kept[at : at + _AT_ONCE], owner[at : at + _AT_ONCE], level + 1)
            for at in range(0, len(kept), _AT_ONCE)
        ] or [self._nothing(level + 1)]
        deeper = [_join_levels(pieces) for pieces in zip(*parts, strict=True)]
        first = deeper[0]
        there = first.masks != 0
        left[left] = there
        flags[flags] = left
        return [_Level(pack_bits(flags, shape.kind), tree), _Level(first.masks[there], first.tree[there]), *deeper[1:]]

    def _nothing(self, level: int) -> list[_Level]:
        empty = _Level(np.zeros(0, self.shape.kind), np.zeros(0, np.int32))
        return [empty] * (self.shape.levels - level + 2)


def _join_levels(pieces: tuple[_Level, ...]) -> _Level:
    return _Level(np.concatenate([level.masks for level in pieces]), np.concatenate([level.tree for level in pieces]))


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
            families = near(parts, halvings)
            there = np.flatnonzero(families >= 0)[::-1]  # of several the first is the last to be written
            by[owner[there]] = families[there]
            parts, owner = parts[families < 0], owner[families < 0]
    verdicts = np.where(by >= 0, 3, 0).astype(np.int8)
    left = np.unique(owner)
    verdicts[left] = np.where(proven[left], 1, 2)
    return verdicts, by


class _Boxes:
    """Boxes of one plan as configurations of the arm."""

    def __init__(self, robot: Robot, task: Task, setting: Setting, plan: Plan, threads: int) -> None:
        self.robot, self.task, self.setting, self.plan, self.threads = robot, task, setting, plan, threads
        self.low, self.high = np.array(plan.lower), np.array(plan.upper)
        self.place = np.array(plan.variables) - 1

    def _centres_and_halves(self, cells: Cells, level: int) -> tuple[Array, Array]:
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
        flags = np.zeros(len(cells), dtype=np.bool_)
        for begin in range(0, len(cells), _PART):
            part = slice(begin, begin + _PART)
            q, half = self._centres_and_halves(cells[part], level)
            flags[part] = enclose(self.robot, self.setting, q, half, threads=self.threads)[0] != 0
        return flags

    def proven(self, cells: Cells) -> Flags:
        """(M,) whether a determinant has two signs among centre and corners.

        False where the Jacobian is not square, and for coranks above 1, which no sign tells.
        """
        flags = np.zeros(len(cells), dtype=np.bool_)
        if not self.task.m == self.robot.n == self.plan.kept_rank:
            return flags
        for begin in range(0, len(cells), _PART):
            part = slice(begin, begin + _PART)
            q, half = self._centres_and_halves(cells[part], self.plan.shape.levels)
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
            flags[part] = plus & minus
        return flags
