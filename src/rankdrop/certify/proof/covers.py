"""A covering proven again: every box that it leaves out is free.

Where the arm has a determinant, all boxes of a level are proven by it at once (`determinant.py`), and some chosen at
random by enclosures of the Jacobian as well; else, and what it does not decide, by enclosures alone.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict
from math import pi
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from rankdrop.certify.bittree import BitTree, bits, counts
from rankdrop.certify.coverfile import Plan, digest, load
from rankdrop.certify.proof.determinant import Determinant, applies
from rankdrop.certify.proof.intervals import Arm, Interval, Region, flint
from rankdrop.certify.proof.reading import COVERING, Told, Unproven, Work, text, whole
from rankdrop.errors import ResultFileError

ACROSS, _FEW = 100, 100
"""Boxes proven by the determinant that are looked at by enclosures as well, and parts of each, at most."""
_SEAM = 1e-14  # boxes are proven so much wider [rad]: a whole turn of doubles is shorter than 2π
_DEEPEST, _PARTS = 48, 10_000  # halvings of one box, and parts of it
_PARENTS = 1 << 12  # boxes whose children are looked at in one batch
_OFTEN = 256  # boxes proven by enclosures from one line of a journal to the next
_MILLISECONDS = 2.0  # of one enclosure, about: what a check is said to take before it begins
_LONGEST = 1 << 22  # bytes of a journal

Cells = NDArray[np.int64]
Flags = NDArray[np.bool_]


def verify_covering(
    arm: Arm, told: Told, work: Work, sample: int | None, *, every: bool = False, journal: Path | None = None
) -> str:
    """Every box that was left out proven free; a sentence on what holds.

    Args:
        arm, told, work: as everywhere.
        sample: only so many boxes, chosen at random.
        every: however many there are.
        journal: how many are proven is kept in this file, and taken from it.

    Raises:
        ValueError: the claim is malformed.
        Unproven: a box that is not confirmed, or boxes that were not looked at.
        ResultFileError: the covering, or the journal, cannot be read, or the journal is that of another certificate.
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
    boxes = _Boxes(arm, told, plan, tree, work)
    if sample is not None and sample < boxes.count:
        boxes.some(sample)
        raise Unproven(f"{sample:,} of {boxes.count:,} free boxes, chosen at random, are free; the others are not "
                       "looked at")  # fmt: skip
    how = boxes.all(every=every, journal=journal)
    where = "joint limits" if plan.limits else "joint space"
    return (
        f"every configuration of the {where} with a rank below {told.rank} is in one of the {tree.leaves:,} boxes of "
        f"{name} ({boxes.count:,} free boxes proven again{how})"
    )


class _Boxes:
    """The boxes that a covering leaves out."""

    def __init__(self, arm: Arm, told: Told, plan: Plan, tree: BitTree, work: Work) -> None:
        self._arm, self._told, self._plan, self._tree, self._work = arm, told, plan, tree, work
        shape = tree.shape
        self.count = int((~tree.roots).sum())
        for level, masks in enumerate(tree.masks, start=shape.top + 1):
            self.count += len(masks) * 2 ** sum(shape.halved(level)) - int(counts(masks).sum())

    def some(self, sample: int) -> None:
        """So many, chosen at random, by enclosures.

        Raises:
            Unproven: one is not free.
        """
        for place, (level, cell) in enumerate(self._chosen(sample)):
            self._work.tell(place, sample)
            self._one(level, cell)

    def _chosen(self, sample: int) -> Iterator[tuple[int, list[int]]]:
        numbers = np.sort(np.random.default_rng(0).choice(self.count, min(sample, self.count), replace=False))
        begin = 0
        for level, cells in _free_boxes(self._tree):
            inside = numbers[(numbers >= begin) & (numbers < begin + len(cells))] - begin
            yield from ((level, cell) for cell in cells[inside].tolist())
            begin += len(cells)

    def _one(self, level: int, cell: list[int]) -> None:
        if not _free(self._arm, self._told, self._plan, level, cell, self._work):
            raise Unproven("a box that the covering leaves out could not be proven free again")

    def _across(self) -> str:
        """How many of some boxes, chosen at random, few enclosures prove as well."""
        given = Work(ACROSS * _FEW * 3, None)
        free = [_free(self._arm, self._told, self._plan, *box, given, _FEW) for box in self._chosen(ACROSS)]
        self._work.done += given.done
        return f"{sum(free)} of {len(free)} chosen at random by {given.done:,} enclosures too"

    def all(self, *, every: bool, journal: Path | None) -> str:
        """All of them; how, in words.

        Raises:
            Unproven: one is not free, or they are more than enclosures may be made.
        """
        told, plan, work = self._told, self._plan, self._work
        split = None
        if told.tolerance is None and applies(self._arm, told.whole_rows, told.rank):
            places = [j - 1 for j in plan.variables]
            split = Determinant(self._arm, told.whole_rows, places, plan.lower, plan.upper, _SEAM)
        elif self.count > work.most and not every:
            hours = self.count * _MILLISECONDS / 3.6e6
            raise Unproven(
                f"not begun: {self.count:,} free boxes take more than the {work.most:,} enclosures allowed, "
                f"about {hours:,.1f} hours; ask for all of them (--all), or for some (--sample)"
            )
        if every:
            work.most = max(work.most, 1 << 62)
        notes = None if journal is None else _Journal(journal, told.sha256)
        if notes is not None and notes.known > self.count:
            notes.close()
            raise ResultFileError(
                "the journal tells of more boxes than the covering has free", where=str(journal), got=notes.known,
                allowed=f"at most {self.count:,}", mend="name another file, or delete this one",
            )  # fmt: skip
        try:
            earlier, left = self._prove(split, notes)
        finally:
            if notes is not None:
                notes.close()
        before = f"{earlier:,} of them in an earlier run, as the journal says" if earlier else ""
        if split is None:
            return f": {before}" if before else ""
        rest = f" and {left:,} by enclosures" if left else ""
        ways = f"{self.count - earlier - left:,} by the determinant in Bernstein form{rest}"
        return f": {', '.join(filter(None, (before, ways)))}; {self._across()}"

    def _prove(self, split: Determinant | None, notes: _Journal | None) -> tuple[int, int]:
        """Every box that a journal does not have: how many it had, and how many were left to enclosures."""
        work, depth = self._work, self._plan.depth
        known = 0 if notes is None else notes.known
        begin, earlier, left = 0, 0, 0
        for level, cells in _free_boxes(self._tree):
            end = begin + len(cells)
            if end <= known:
                begin, earlier = end, end
                continue
            work.tell(begin, self.count)
            if split is None:
                free = np.arange(begin, end) < known
                earlier += int(free.sum())
            else:
                free = split.free([min(level, most) for most in depth], cells)
                left += int((~free).sum())
            for number, place in enumerate(np.flatnonzero(~free).tolist(), start=1):
                self._one(level, cells[place].tolist())
                if split is None:
                    work.tell(begin + place + 1, self.count)
                    if notes is not None and number % _OFTEN == 0:
                        notes.add(begin + place + 1)
            begin = end
            if notes is not None:
                notes.add(begin)
        return earlier, left


class _Journal:
    """How many boxes, in the order of the covering, are proven; of one certificate alone."""

    def __init__(self, path: Path, certificate: str) -> None:
        self.known = 0
        head = json.dumps({"journal": "rankdrop/checked/1", "certificate": certificate}).encode() + b"\n"
        try:
            self._file: IO[bytes] = path.open("r+b" if path.is_file() and path.stat().st_size else "w+b")
            there = self._file.read(_LONGEST)
            if not there.startswith(head) and not head.startswith(there):
                self._file.close()
                raise ResultFileError(
                    "this is the journal of another certificate, or no journal", where=str(path),
                    mend="name another file, or delete this one",
                )
            lines = there[len(head) :].split(b"\n")[:-1]  # what stands behind the last line feed was cut off
            whole = [int(line) for line in lines if line.isdigit() and len(line) < 16]
            self.known = whole[-1] if whole else 0
            self._file.seek(0)
            self._file.write(head + (b"%d\n" % self.known if self.known else b""))
            self._file.truncate()
            self._file.flush()
        except OSError as error:
            raise ResultFileError(f"cannot open the journal: {error.strerror}", where=str(path)) from error

    def add(self, proven: int) -> None:
        """So many are proven now.

        Raises:
            ResultFileError: it cannot be written.
        """
        try:
            self._file.write(b"%d\n" % proven)
            self._file.flush()
        except OSError as error:
            raise ResultFileError(f"cannot write the journal: {error.strerror}", where=self._file.name) from error

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def corank_of(told: Told) -> int:
    """Of a covering: by how much the rank that is kept outside it is below the one almost everywhere, and one more.

    Of all else 1.

    Raises:
        ValueError: the claim is malformed.
    """
    if told.kind != COVERING:
        return 1
    return whole(told.claim.get("corank", 1), 1, 6, "corank")  # certificates of 0.2.0 do not tell it


def _compare(arm: Arm, told: Told, plan: Plan) -> None:
    """The covering is about the arm, task and rank of the certificate, and leaves out no variable that matters."""
    if plan.fingerprint != told.model or tuple(plan.rows) != told.rows or plan.kept != told.rank:
        raise Unproven("the covering is about another arm or task than its certificate")
    places = [j - 1 for j in plan.variables]
    if len({len(plan.lower), len(plan.upper), len(plan.turns), len(plan.depth), len(places)}) != 1:
        raise Unproven("the covering has another number of ranges than of variables")
    if not set(arm.moving) <= set(places) <= set(range(told.variables)):
        raise Unproven("the covering leaves out a joint that decides")
    if corank_of(told) != plan.corank:
        raise Unproven("the covering is of another corank than its certificate says")
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
    """(level, (M, d) boxes) that are left out, as large as they can be, some thousands at a time."""
    shape = tree.shape
    roots = np.stack(np.unravel_index(np.arange(shape.trees), shape.cells(shape.top)), axis=1).astype(np.int64)
    yield shape.top, roots[~tree.roots]
    cells = roots[tree.roots]
    d = shape.variables
    digits = (np.arange(1 << d)[:, None] >> (d - 1 - np.arange(d))) & 1
    for level, masks in enumerate(tree.masks, start=shape.top + 1):
        halved = np.array(shape.halved(level), dtype=np.int64)
        real = ~(digits.astype(bool) & (halved == 0)).any(axis=1)
        kept = []
        for begin in range(0, len(masks), _PARENTS):
            part = slice(begin, begin + _PARENTS)
            below = (cells[part, None, :] << halved) + digits[None]
            marked = bits(masks[part], d)
            yield level, below[~marked & real[None]].reshape(-1, d)
            if level < shape.levels:
                kept.append(below[marked & real[None]].reshape(-1, d))
        cells = np.concatenate([np.zeros((0, d), np.int64), *kept])


def _free(arm: Arm, told: Told, plan: Plan, level: int, cell: list[int], work: Work, parts: int = _PARTS) -> bool:
    """Is a box free, whole or in so many parts?

    Raises:
        Unproven: the work is used up.
    """
    depth = [min(level, most) for most in plan.depth]
    stack, spent = [(cell, depth)], 0
    while stack:
        index, levels = stack.pop()
        if not work.spend():
            raise Unproven(f"the work is used up ({work.most:,} enclosures) before every box was proven free again")
        if arm.keeps_rank(_region(told, plan, index, levels), told.whole_rows, told.rank, told.tolerance):
            continue
        spent += 1
        if sum(levels) - sum(depth) >= _DEEPEST or spent >= parts:
            return False
        place = min(range(len(levels)), key=lambda j: (levels[j] - plan.depth[j], j))
        for half in (1, 0):
            finer, deeper = list(index), list(levels)
            finer[place], deeper[place] = 2 * index[place] + half, levels[place] + 1
            stack.append((finer, deeper))
    return True


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
