"""A covering proven again: every box that it leaves out is free."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from math import pi

import numpy as np
from numpy.typing import NDArray

from rankdrop.certify.bittree import BitTree, bits
from rankdrop.certify.coverfile import Plan, digest, load
from rankdrop.certify.proof.intervals import Arm, Interval, Region, flint
from rankdrop.certify.proof.reading import Told, Unproven, Work, text
from rankdrop.errors import ResultFileError

_SEAM = 1e-14  # boxes are proven so much wider [rad]: a whole turn of doubles is shorter than 2π
_DEEPEST, _PARTS = 48, 10_000  # halvings of one box, and parts of it

Cells = NDArray[np.int64]


def verify_covering(arm: Arm, told: Told, work: Work, sample: int | None) -> str:
    """Every box that was left out proven free; a sentence on what holds.

    Args:
        arm, told, work: as everywhere.
        sample: only so many boxes, chosen at random.

    Raises:
        ValueError: the claim is malformed.
        Unproven: a box that is not confirmed, or boxes that were not looked at.
    """
    name = text(told.claim["file"], "file")
    if "/" in name or "\\" in name or name in ("", ".", ".."):
        raise ValueError("file: a name without a folder")
    path = told.folder / name
    if not path.is_file():
        raise ResultFileError("the covering is not beside its certificate", where=str(path), mend="put it there")
    try:
        plan, tree, _, _ = load(path)
    except ResultFileError as error:
        raise Unproven(f"{name}: {error.what}") from error
    if digest(plan, tree.payload()) != told.claim["sha256"]:
        raise Unproven(f"{name} is another covering than the one of the certificate: its hash differs")
    _compare(arm, told, plan)
    left_out = [(level, cells) for level, cells in _free_boxes(tree)]
    count = sum(len(cells) for _, cells in left_out)
    numbers = np.arange(count)
    if sample is not None and sample < count:
        numbers = np.sort(np.random.default_rng(0).choice(count, sample, replace=False))
    begin, done = 0, 0
    for level, cells in left_out:
        inside = numbers[(numbers >= begin) & (numbers < begin + len(cells))] - begin
        for cell in cells[inside]:
            work.tell(done, len(numbers))
            _free(arm, told, plan, level, [int(x) for x in cell], work)
            done += 1
        begin += len(cells)
    if len(numbers) < count:
        raise Unproven(f"{len(numbers):,} of {count:,} free boxes, chosen at random, are free; the others are not "
                       "looked at")  # fmt: skip
    where = "joint limits" if plan.limits else "joint space"
    return (
        f"every configuration of the {where} with a rank below {told.rank} is in one of the {tree.leaves:,} boxes of "
        f"{name} ({count:,} free boxes proven again)"
    )


def _compare(arm: Arm, told: Told, plan: Plan) -> None:
    """The covering is about the arm, task and rank of the certificate, and leaves out no variable that matters."""
    if plan.fingerprint != told.model or tuple(plan.rows) != told.rows or plan.rank != told.rank:
        raise Unproven("the covering is about another arm or task than its certificate")
    places = [j - 1 for j in plan.variables]
    if len({len(plan.lower), len(plan.upper), len(plan.turns), len(plan.depth), len(places)}) != 1:
        raise Unproven("the covering has another number of ranges than of variables")
    if not set(arm.moving) <= set(places) <= set(range(told.variables)):
        raise Unproven("the covering leaves out a joint that decides")
    record = asdict(plan)
    for key in ("variables", "lower", "upper", "turns", "limits"):
        said = told.claim[key]
        if (tuple(said) if isinstance(said, list) else said) != record[key]:
            raise Unproven(f"the covering has other {key} than its certificate says")
    for low, high, turns in zip(plan.lower, plan.upper, plan.turns, strict=True):
        if turns and not high - low > 2 * pi - _SEAM / 4:
            raise Unproven("a turn of the covering is shorter than a turn")
        if not low <= high:
            raise Unproven("a range of the covering ends before it begins")


def _free_boxes(tree: BitTree) -> Iterator[tuple[int, Cells]]:
    """(level, (M, d) boxes) that are left out, as large as they can be."""
    shape = tree.shape
    roots = np.stack(np.unravel_index(np.arange(shape.trees), shape.cells(shape.top)), axis=1).astype(np.int64)
    yield shape.top, roots[~tree.roots]
    cells = roots[tree.roots]
    for level, masks in enumerate(tree.masks, start=shape.top + 1):
        halved = np.array(shape.halved(level), dtype=np.int64)
        d = shape.variables
        child = np.arange(1 << d)
        digits = (child[:, None] >> (d - 1 - np.arange(d))) & 1
        real = ~(digits.astype(bool) & (halved == 0)).any(axis=1)
        below = (cells[:, None, :] << halved) + digits[None]
        marked = bits(masks, d)
        yield level, below[~marked & real[None]].reshape(-1, d)
        cells = below[marked & real[None]].reshape(-1, d)


def _free(arm: Arm, told: Told, plan: Plan, level: int, cell: list[int], work: Work) -> None:
    """A box free, whole or in parts."""
    depth = [min(level, most) for most in plan.depth]
    stack, spent = [(cell, depth)], 0
    while stack:
        index, levels = stack.pop()
        if not work.spend():
            raise Unproven(f"the work is used up ({work.most:,} enclosures) before every box was proven free again")
        if arm.keeps_rank(_region(told, plan, index, levels), told.whole_rows, told.rank, told.tolerance):
            continue
        spent += 1
        if sum(levels) - sum(depth) >= _DEEPEST or spent >= _PARTS:
            raise Unproven("a box that the covering leaves out could not be proven free again")
        place = min(range(len(levels)), key=lambda j: (levels[j] - plan.depth[j], j))
        for half in (1, 0):
            finer, deeper = list(index), list(levels)
            finer[place], deeper[place] = 2 * index[place] + half, levels[place] + 1
            stack.append((finer, deeper))


def _region(told: Told, plan: Plan, index: list[int], levels: list[int]) -> Region:
    f = flint()
    centre: list[Interval] = [f.arb(0)] * told.variables
    half: list[Interval] = [f.arb(0)] * told.variables
    for place, j in enumerate(plan.variables):
        low, high = f.arb(plan.lower[place]), f.arb(plan.upper[place])
        width = (high - low) / 2 ** (levels[place] + 1)
        centre[j - 1] = low + (2 * index[place] + 1) * width
        half[j - 1] = width + _SEAM
    return Region(centre, half)
