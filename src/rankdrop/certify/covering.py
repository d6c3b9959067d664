"""Boxes that hold every singular configuration of an arm, and those that are proven to hold one.

The joint space is halved into boxes, and a box is left out where the rank is proven to be the generic one in all of it.
What is left, down to leaves of a given width, holds every singular configuration. Two ways to prove a box free:

- split: six turning joints and the full pose. The determinant is f = a · b (`rankdrop.certify.split`), and a box with
  centre c and half-widths h is free where |f(c)| > Σ |∂_j f(c)| h_j + ½ Σ |f_jk| h_j h_k + rounding, or where the
  Bernstein coefficients of f in the tangents of half angles have one sign. A leaf is proven to hold a singularity where
  f has two signs at its corners, beyond rounding.
- enclosures: any other arm, by the bound of certified balls (`rankdrop.certify.setting`). So are coranks K above 1 of
  every arm: a box is free where K − 1 less than the generic rank is proven to be kept in all of it.

Variables that move no column against another are free: a box is a cylinder over them.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from math import ceil, log2, pi
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.certify.certificates import refused_as_result
from rankdrop.certify.enclosed import Batch, BudgetSpent, Looked, Near, closer, enclosed_trees, viewed
from rankdrop.certify.setting import Setting
from rankdrop.certify.split import split_of
from rankdrop.disk import replace_file
from rankdrop.errors import OptionError, ResultFileError
from rankdrop.local.block import generic_rank
from rankdrop.proof.boxes import BitTree, Masks, Plan, Shape, counts, covering_bytes, load, load_plan
from rankdrop.robot.model import Array, JointKind, Robot, fingerprint
from rankdrop.task import Task, resolve_task
from rankdrop.version import VERSION

Progress = Callable[[int, int], None]

SPLIT, ENCLOSURES = "split determinant", "enclosures"
SPENT = "the budget is spent"
BUDGET = 100_000_000
"""Enclosures spent at most, about 1.5 µs each; the split determinant needs none."""
FURTHER = 0
"""Halvings by which leaves that are not proven are looked into: four prove 2 % more for PUMA in four times the time."""
NARROWEST = 2 * pi / 512
"""No leaf is made narrower [rad]: the tables of six joints have 500 MB then."""
WIDEST = pi
_MOST_LEAVES = 2**40  # boxes of the last level, free ones included
_MOST_VARIABLES = 5
_TOP = 3  # level of the boxes that are done one by one
_CLOSER = 24  # halvings by which leaves that no family explains are looked into
_PARTS = 10_000_000  # of them in all, about 2 µs each
_CHUNKS = 64  # into which a covering is divided, at most


@dataclass(frozen=True, eq=False)
class Covering:
    """What is left of the joint space when all that is proven free is taken out.

    Attributes:
        plan: arm, task, variables, ranges, width and method.
        tree: the boxes.
        tested: boxes tested.
        freed: leaves that were proven free by looking into them.
        stopped: why it is not complete; "" where it is.
    """

    plan: Plan
    tree: BitTree
    tested: int
    freed: int
    stopped: str = ""

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
        made = open_ & tree.finished[number]
        row = (np.cumsum(tree.roots & tree.finished) - 1)[number]
        for level, masks in enumerate(tree.masks, start=shape.top + 1):
            child = np.zeros(len(x), dtype=np.int64)
            for j, halved in enumerate(shape.halved(level)):
                child = child << 1 | (at(level)[:, j] & halved)
            first = np.concatenate([[0], np.cumsum(counts(masks))])
            row = np.where(made, row, 0)
            mask = masks[row] if len(masks) else np.zeros(len(x), shape.kind)
            bit = np.left_shift(1, child.astype(shape.kind), dtype=shape.kind)
            there = (mask & bit) != 0
            row = first[row] + counts((mask & (bit - 1)).astype(shape.kind))
            open_ &= ~made | there
            made &= there
        return np.asarray(open_ | ~inside)

    def _places(self, q: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Shares of the ranges, and whether they are inside."""
        low, high = np.array(self.plan.lower), np.array(self.plan.upper)
        x = q[:, np.array(self.plan.variables) - 1]
        turns = np.array(self.plan.turns)
        x = np.where(turns, low + np.mod(x - low, 2 * pi), x)
        inside = np.asarray(((x >= low) & (x <= high)).all(axis=1))
        return np.clip((x - low) / np.where(high > low, high - low, 1.0), 0.0, 1.0), inside


def covering(
    robot: Robot,
    width: float = 0.05,
    task: str | Task | None = None,
    *,
    corank: int = 1,
    limits: bool = False,
    budget: int = BUDGET,
    further: int = FURTHER,
    threads: int = 0,
    progress: Progress | None = None,
) -> Covering:
    """Boxes no wider than `width` that hold every configuration of a corank or more.

    Args:
        robot: the arm.
        width: of a leaf, at most [rad; slides divided by the length scale].
        task: as everywhere.
        corank: by how much the rank falls below the generic one, at least.
        limits: within the joint limits only; else turning joints go all the way round. Slides need limits.
        budget: enclosures, at most; arms of six turning joints need none.
        further: halvings by which leaves not proven are looked into (six turning joints).
        threads: 0 for all cores; the result does not depend on it.
        progress: progress(done, total) parts.

    Raises:
        OptionError: a width, a corank or a budget outside what is allowed, a slide without limits, an arm or task that
            cannot be certified, or more than five variables that matter.
    """
    plan = plan_of(robot, width, task, corank=corank, limits=limits, further=further)
    check_budget(budget)
    batches: dict[int, Batch] = {}
    left, stopped, resolved = int(budget), "", resolve_task(task, robot)
    try:
        for chunk in range(chunks_of(plan)):
            made = batches[chunk] = chunk_of(robot, resolved, plan, chunk, budget=left, threads=threads)
            left -= 0 if plan.method == SPLIT else made[2]
            if progress is not None:
                progress(chunk + 1, chunks_of(plan))
    except KeyboardInterrupt:
        stopped = "interrupted"
    except BudgetSpent:
        stopped = SPENT
    return put_together(plan, batches, stopped)


def check_budget(budget: int) -> None:
    """A budget is a whole number from 1.

    Raises:
        OptionError: else.
    """
    if isinstance(budget, bool) or not isinstance(budget, int | np.integer) or budget < 1:
        raise OptionError("no such budget", where="budget", got=budget, allowed="a whole number from 1")


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


def put_together(plan: Plan, batches: Mapping[int, Batch], stopped: str = "") -> Covering:
    """The covering of chunks, by their numbers; those that are missing are not covered.

    Args:
        plan: what is covered.
        batches: what `chunk_of` made.
        stopped: why some are missing.
    """
    shape, size = plan.shape, _size(plan)
    finished = np.zeros(shape.trees, dtype=np.bool_)
    for chunk in batches:
        finished[chunk * size : (chunk + 1) * size] = True
    ordered = [batches[chunk] for chunk in sorted(batches)]
    tested, freed = (sum(int(one[part]) for one in ordered) for part in (2, 3))
    return Covering(plan, _join_trees(shape, finished, ordered), tested, freed, stopped)


def _join_trees(shape: Shape, finished: NDArray[np.bool_], batches: list[Batch]) -> BitTree:
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
    levels = [np.concatenate(one).astype(shape.kind) for one in pieces]
    return BitTree(shape, finished, roots, tuple(levels[:-1]), levels[-1])


_HEAD = struct.Struct("<qqqq")  # of a chunk: boxes, masks, tested, freed


def batch_to_bytes(batch: Batch) -> bytes:
    """A chunk as it is kept: counts, then sizes, then masks, all little-endian."""
    masks, sizes, tested, freed = batch
    body = sizes.astype("<i4").tobytes() + np.ascontiguousarray(masks).tobytes()
    return _HEAD.pack(len(sizes), len(masks), tested, freed) + body


def batch_from_bytes(content: bytes, shape: Shape) -> Batch:
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


def write_covering(path: Path, found: Covering) -> None:
    """Write a finished covering, all or nothing.

    Raises:
        ResultFileError: it cannot be written.
    """
    try:
        replace_file(path, covering_bytes(found.plan, found.tree, found.tested, found.freed))
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
    robot: Robot, width: float, task: str | Task | None = None, *, corank: int = 1, limits: bool = False,
    further: int = FURTHER,
) -> Plan:
    """What is to be covered, and how: all that decides the covering.

    Raises:
        OptionError: as `covering`.
    """
    resolved = resolve_task(task, robot)
    if not NARROWEST <= width <= WIDEST:
        raise OptionError("no such width of boxes", where="width", got=width, allowed=f"{NARROWEST:.4f} … π [rad]")
    setting = viewed(robot, resolved)
    if isinstance(corank, bool) or not isinstance(corank, int | np.integer) or not 1 <= corank <= setting.rank:
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
    shape = Shape(depth, 0)
    if float(np.prod([float(count) for count in shape.cells(shape.levels)])) > _MOST_LEAVES:
        raise OptionError(
            "too many boxes", where="width", got=width, allowed="fewer than 2^40 leaves", mend="take a larger width"
        )
    top = min(_TOP if split else max(0, ceil(10 / len(numbers)) - 1), shape.levels - 1)
    return Plan(
        robot=robot.name, fingerprint=fingerprint(robot), task=resolved.name, rows=resolved.rows,
        rank=generic_rank(robot, resolved), method=SPLIT if split else ENCLOSURES, width=float(width), limits=limits,
        variables=numbers, lower=lower, upper=upper, turns=turns, depth=depth, top=top,
        further=further if split else 0, version=VERSION, corank=int(corank),
    )  # fmt: skip


def _splits(robot: Robot, task: Task, setting: Setting) -> bool:
    turning = all(joint.kind is JointKind.REVOLUTE and joint.mimic is None for joint in robot.joints)
    return turning and robot.n == 6 and task.m == 6 and setting.rank == 6


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
    return max(0, ceil(log2(length / width) - 1e-12)) if length > width else 0


def tables_of(robot: Robot, plan: Plan) -> _core.Split:
    """The split determinant of an arm in tables."""
    made = split_of(robot)
    return _core.Split(
        a=made.a, b=made.b, lower=np.array(plan.lower), upper=np.array(plan.upper),
        depth=np.array(plan.depth, dtype=np.int32), curvature=made.curvature, rounding=made.rounding,
        slope=made.slope, further=plan.further, top=plan.top,
    )  # fmt: skip


def looked_into(
    robot: Robot, task: Task, found: Covering, cells: NDArray[np.int32], *, near: Near | None = None, threads: int = 0
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
    if found.plan.method == SPLIT:
        leaves, parts = np.ascontiguousarray(cells), int(np.clip(_PARTS // len(cells), 64, 4096))
        return _core.judge_leaves(
            tables_of(robot, found.plan), leaves, _CLOSER, parts=parts, threads=threads
        ), nothing  # fmt: skip
    return closer(robot, task, viewed(robot, task, found.plan.corank), found.plan, cells, threads, near)


@lru_cache(1)
def _kept_tables(robot: Robot, plan: Plan) -> _core.Split:
    return tables_of(robot, plan)


@lru_cache(1)
def _kept_view(robot: Robot, task: Task, plan: Plan) -> Setting:
    return viewed(robot, task, plan.corank)
