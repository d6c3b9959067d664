"""A covering proven again: every box that it leaves out is free, and its ranges are those of the claim.

Where the arm has a determinant, all boxes of a level are proven by it at once (`determinant.py`), and some chosen at
random by enclosures of the Jacobian as well; else, and what it does not decide, by enclosures alone.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict
from math import inf, pi
from pathlib import Path
from typing import IO

import numpy as np

from rankdrop.proof.arm import Interval, Region, flint
from rankdrop.proof.boxes import BitTree, Plan, digest, load
from rankdrop.proof.determinant import Determinant, applies
from rankdrop.proof.record import TURN, Claim, Refused, Unproven, Work
from rankdrop.proof.regions import Cell, ClaimCheck, prove_free

ACROSS, _FEW = 100, 100
"""Boxes proven by the determinant that are looked at by enclosures as well, and parts of each, at most."""
_SEAM = 1e-14  # boxes are proven so much wider [rad]: a whole turn of doubles is shorter than 2π
_DEEPEST, _PARTS = 48, 10_000  # halvings of one box, and parts of it
_OFTEN = 256  # boxes proven by enclosures from one line of a journal to the next
_MILLISECONDS = 2.0  # of one enclosure, about: a check states its time before it begins
_LONGEST = 1 << 22  # bytes of a journal


def open_covering(claim: Claim) -> tuple[Plan, BitTree]:
    """The covering that a certificate names, of the arm, task, rank and ranges that it states.

    Raises:
        Refused: the file is not there, or cannot be read.
        Unproven: it is another covering, or damaged.
    """
    name, path = claim.entries["file"], _path_of_covering(claim)
    try:
        plan, tree, _, _ = load(path)
    except Refused as error:
        raise Unproven(f"{name}: {error.what}") from error
    if digest(plan, tree) != claim.entries["sha256"]:
        raise Unproven(f"{name} is another covering than the one of the certificate: its hash differs")
    about = plan.fingerprint, tuple(plan.rows), plan.kept_rank
    if about != (claim.record["arm"]["fingerprint"], claim.rows, claim.rank):
        raise Unproven("the covering is about another arm or task than its certificate")
    if corank_of(claim) != plan.corank:
        raise Unproven("the covering is of another corank than its certificate says")
    record = asdict(plan)
    for key in ("variables", "lower", "upper", "turns", "limits"):
        stated = claim.entries[key]
        if (tuple(stated) if isinstance(stated, list) else stated) != record[key]:
            raise Unproven(f"the covering has other {key} than its certificate says")
    return plan, tree


def _path_of_covering(claim: Claim) -> Path:
    """The file of a covering, which stands in the folder of its certificate.

    Raises:
        Refused: it is not there, or the name has a folder.
    """
    name = claim.entries["file"]
    if "/" in name or "\\" in name or name in ("", ".", ".."):
        raise Refused("the certificate is malformed", where="claim.file", got=repr(name),
                      allowed="a name without a folder")  # fmt: skip
    path: Path = claim.folder / name
    if not path.is_file():
        raise Refused("the covering is not in the folder of its certificate", where=str(path), mend="put it there")
    return path


def check_ranges(claim: Claim, moving: list[int]) -> None:
    """The ranges are all of the joint space that is claimed, in every variable that decides.

    A joint that turns, with all that follows it, has the same columns again after a turn: its range is at least one,
    or, of a covering within limits, the limits. Every other variable has its limits.

    Raises:
        Unproven: a variable that decides is left out, or a range is shorter.
    """
    entries = claim.entries
    places = [j - 1 for j in entries["variables"]]
    if len({len(entries[key]) for key in ("lower", "upper", "turns", "variables")}) != 1:
        raise Unproven("the covering has another number of ranges than of variables")
    if not set(moving) <= set(places) <= set(range(claim.variables)) or len(set(places)) < len(places):
        raise Unproven("the covering leaves out a joint that decides")
    for j, low, high, turns in zip(places, entries["lower"], entries["upper"], entries["turns"], strict=True):
        whole = high - low > 2 * pi - _SEAM / 4
        if turns and not (whole and periodic(claim, j)):
            raise Unproven(f"the range of joint {j + 1} is said to be a turn, and is none")
        if not low <= high:
            raise Unproven(f"the range of joint {j + 1} ends before it begins")
        if whole and periodic(claim, j):
            continue
        if not entries["limits"] and periodic(claim, j):
            raise Unproven(f"the covering is not within limits, and the range of joint {j + 1} is less than a turn")
        _check_within_limits(claim, j, low, high)


def _check_within_limits(claim: Claim, j: int, low: float, high: float) -> None:
    """The range of a variable holds all that is within its limits."""
    if claim.limits is None:
        least, most = (-inf, inf)
        stated = "states no limits"
    else:
        least, most = claim.limits[j]
        stated = f"has limits from {least!r} to {most!r}"
    if not low <= least <= most <= high:
        raise Unproven(f"the range of joint {j + 1} is less than its limits: the arm of the certificate {stated}")


def periodic(claim: Claim, j: int) -> bool:
    """Does a whole turn of a variable lead to the same columns? It turns every joint that it drives, in whole turns."""
    driven = [link for link in claim.links if link.driver == j]
    return all(link.kind == TURN and link.multiplier.is_integer() for link in driven)


def corank_of(claim: Claim) -> int:
    """Of a covering: by how much the rank that is kept outside it is below the one almost everywhere, and one more.

    Of all else 1.
    """
    return int(claim.entries.get("corank", 1))  # certificates of 0.2.0 do not have it


def verify_covering(check: ClaimCheck) -> tuple[BitTree, str]:
    """All boxes that a covering leaves out are free; the covering, and how many were proven in which way, in words.

    Raises:
        Unproven: a box that is not confirmed, or boxes that were not looked at.
        Refused: the journal cannot be read, or is that of another certificate.
    """
    plan, tree = open_covering(check.claim)
    check_ranges(check.claim, check.arm.moving)
    work, count = check.work, tree.free_boxes
    sample = work.sample
    if sample is None or sample >= count:
        return tree, _verify_all(check, plan, tree)
    for place, box in enumerate(_choose(tree, sample)):
        work.report(place, sample)
        _check_box(check, plan, *box)
    raise Unproven(f"{sample:,} of {count:,} free boxes, chosen at random, are free; the others are not checked")


def _choose(tree: BitTree, sample: int) -> Iterator[tuple[int, list[int]]]:
    count = tree.free_boxes
    numbers = np.sort(np.random.default_rng(0).choice(count, min(sample, count), replace=False))
    begin = 0
    for level, cells in tree.free():
        inside = numbers[(numbers >= begin) & (numbers < begin + len(cells))] - begin
        yield from ((level, cell) for cell in cells[inside].tolist())
        begin += len(cells)


def _is_free(check: ClaimCheck, plan: Plan, level: int, cell: list[int], parts: int = _PARTS) -> bool:
    """Is a box free, whole or in so many parts?"""
    depth = plan.depth
    start = Cell(tuple(cell), tuple(min(level, most) for most in depth))
    return prove_free(
        lambda part: check.keeps_rank(region_of(plan, check.claim.variables, part)), start,
        lambda part: min(range(len(depth)), key=lambda j: part.level[j] - depth[j]), parts=parts, deepest=_DEEPEST,
    )  # fmt: skip


def region_of(plan: Plan, variables: int, cell: Cell) -> Region:
    """The configurations of a box, a little wider: a whole turn of doubles is shorter than 2π."""
    f = flint()
    centre: list[Interval] = [f.arb(0)] * variables
    half: list[Interval] = [f.arb(0)] * variables
    for place, j in enumerate(plan.variables):
        low, high = f.arb(plan.lower[place]), f.arb(plan.upper[place])
        width = (high - low) / 2 ** (cell.level[place] + 1)
        centre[j - 1] = low + (2 * cell.index[place] + 1) * width
        half[j - 1] = width + _SEAM
    return Region(centre, half)


def _check_box(check: ClaimCheck, plan: Plan, level: int, cell: list[int]) -> None:
    if not _is_free(check, plan, level, cell):
        raise Unproven("a box that the covering leaves out could not be proven free again")


def _check_across(check: ClaimCheck, plan: Plan, tree: BitTree) -> str:
    """How many of some boxes, chosen at random, few enclosures prove as well."""
    few = ClaimCheck(check.arm, check.claim, Work(ACROSS * _FEW * 3))
    free = [_is_free(few, plan, *box, _FEW) for box in _choose(tree, ACROSS)]
    check.work.done += few.work.done
    return f"{sum(free)} of {len(free)} chosen at random by {few.work.done:,} enclosures too"


def _verify_all(check: ClaimCheck, plan: Plan, tree: BitTree) -> str:
    work, count, claim = check.work, tree.free_boxes, check.claim
    split = None
    if claim.tolerance is None and applies(check.arm, claim.whole_rows, claim.rank):
        places = [j - 1 for j in plan.variables]
        split = Determinant(check.arm, claim.whole_rows, places, plan.lower, plan.upper, _SEAM)
    elif count > work.most and not work.every:
        hours = count * _MILLISECONDS / 3.6e6
        raise Unproven(
            f"not begun: {count:,} free boxes take more than the {work.most:,} enclosures allowed, "
            f"about {hours:,.1f} hours; ask for all of them (--all), or for some (--sample)"
        )
    if work.every:
        work.most = max(work.most, 1 << 62)
    if work.journal is None:
        journal = None
    else:
        journal = _Journal(work.journal, claim.record["sha256"], count)
    try:
        earlier, remaining = _prove_boxes(check, plan, tree, split, journal)
    finally:
        if journal is not None:
            journal.file.close()
    if earlier:
        ways = [f"{earlier:,} of them in an earlier run, as the journal says"]
    else:
        ways = []
    across = ""
    if split is not None:
        if remaining:
            rest = f" and {remaining:,} by enclosures"
        else:
            rest = ""
        ways += [f"{count - earlier - remaining:,} by the determinant in Bernstein form{rest}"]
        across = f"; {_check_across(check, plan, tree)}"
    return f"{count:,} free boxes proven again{': ' * bool(ways)}{', '.join(ways)}{across}"


def _prove_boxes(
    check: ClaimCheck, plan: Plan, tree: BitTree, split: Determinant | None, journal: _Journal | None
) -> tuple[int, int]:
    """Prove every box that a journal does not have: how many it had, and how many were left to enclosures."""
    work = check.work
    known = 0 if journal is None else journal.known
    begin, earlier, remaining = 0, 0, 0
    for level, cells in tree.free():
        end = begin + len(cells)
        if end <= known:
            begin, earlier = end, end
            continue
        work.report(begin, tree.free_boxes)
        if split is None:
            free = np.arange(begin, end) < known
            earlier += int(free.sum())
        else:
            free = split.free([min(level, most) for most in plan.depth], cells.astype(np.int64))
            remaining += int((~free).sum())
        for number, place in enumerate(np.flatnonzero(~free).tolist(), start=1):
            _check_box(check, plan, level, cells[place].tolist())
            if split is None:
                work.report(begin + place + 1, tree.free_boxes)
                if journal is not None and number % _OFTEN == 0:
                    journal.add(begin + place + 1)
        begin = end
        if journal is not None:
            journal.add(begin)
    return earlier, remaining


class _Journal:
    """How many boxes, in the order of the covering, are proven; of one certificate alone."""

    def __init__(self, path: Path, certificate: str, count: int) -> None:
        head = json.dumps({"journal": "rankdrop/checked/2", "certificate": certificate}).encode() + b"\n"
        try:
            self.file: IO[bytes] = path.open("r+b" if path.is_file() and path.stat().st_size else "w+b")
            content = self.file.read(_LONGEST)
            lines = content[len(head) :].split(b"\n")[:-1]  # what stands behind the last line feed was cut off
            known = [int(line) for line in lines if line.isdigit() and len(line) < 16]
            self.known = known[-1] if known else 0
            if not content.startswith(head) and not head.startswith(content):
                self.file.close()
                raise Refused("this is the journal of another certificate, or no journal", where=str(path),
                              mend="name another file, or delete this one")  # fmt: skip
            if self.known > count:
                self.file.close()
                raise Refused("the journal has more boxes than the covering has free", where=str(path),
                              got=self.known, allowed=f"at most {count:,}",
                              mend="name another file, or delete this one")  # fmt: skip
            self.file.seek(0)
            self.file.write(head + (b"%d\n" % self.known if self.known else b""))
            self.file.truncate()
            self.file.flush()
        except OSError as error:
            raise Refused(f"cannot open the journal: {error.strerror}", where=str(path)) from error

    def add(self, proven: int) -> None:
        """So many are proven now.

        Raises:
            Refused: it cannot be written.
        """
        try:
            self.file.write(b"%d\n" % proven)
            self.file.flush()
        except OSError as error:
            raise Refused(f"cannot write the journal: {error.strerror}", where=self.file.name) from error
