"""Balls and paths proven free again, by halving whatever one enclosure does not decide."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import numpy as np

from rankdrop.proof.arm import Arm, Interval, Region, flint
from rankdrop.proof.record import CLEAR, CROSSING, Array, Claim, Record, Unproven, Work

FREE, OUTSIDE, LETTERS = ".", "-", "abcdefghijklmnopqrstuvwxyzABCDEF"
"""A tree of boxes in preorder: a letter halves along that variable (a the first), lower half first."""
_DEEPEST, _PARTS = 40, 1000  # halvings of one leaf of the tree, and parts of it
_NARROW = 1e-13  # pieces of a path whose joints move less are given up [rad]
_ROUGH, _FINE = 32, 4000  # parts of the surroundings of a piece of a path: of one that is halved next, and of the last
_SHORT = 0.02  # share of the distance to be kept below which a piece is not halved
_OUTWARDS = 1e-12  # share by which doubles are taken larger
_UNCLAIMED = 1e-3  # share of a path's joint motion that may lie in spans that are not free: those are slivers
_WIDE = 1.2  # half diagonal of boxes around runs of stretches that are tried [rad]

Place = tuple[int, float]


@dataclass(frozen=True)
class Cell:
    """A box of a range that is halved again and again: for each variable, which of 2^level equal parts."""

    index: tuple[int, ...]
    level: tuple[int, ...]

    def halved(self, place: int) -> tuple[Cell, Cell]:
        """Both halves along one variable."""
        parts = []
        for half in (0, 1):
            index, level = list(self.index), list(self.level)
            index[place], level[place] = 2 * index[place] + half, level[place] + 1
            parts.append(Cell(tuple(index), tuple(level)))
        return parts[0], parts[1]

    def ends(self, place: int) -> tuple[Fraction, Fraction]:
        """Of a range from −1 to 1."""
        low = Fraction(2 * self.index[place], 2 ** self.level[place]) - 1
        return low, low + Fraction(2, 2 ** self.level[place])

    def lies_outside(self, share: Fraction) -> bool:
        """Has it no point nearer to the centre than `share` of the side?"""
        gaps = (max(Fraction(0), low, -high) for low, high in map(self.ends, range(len(self.index))))
        return sum((gap * gap for gap in gaps), Fraction(0)) >= share * share


@dataclass(frozen=True, eq=False)
class ClaimCheck:
    """A claim that is checked: the arm as it is looked at, the claim, and what the check may cost."""

    arm: Arm
    claim: Claim
    work: Work

    def keeps_rank(self, region: Region, *, near: bool = True) -> bool:
        """Does one enclosure prove a region free, for arms near this one as well?

        Raises:
            Unproven: the work is used up.
        """
        if not self.work.spend():
            raise Unproven(f"the work is used up ({self.work.most:,} enclosures) before everything was proven again")
        claim = self.claim
        return self.arm.keeps_rank(region, claim.whole_rows, claim.rank, claim.tolerance if near else None)


def prove_free(
    keeps: Callable[[Cell], bool], start: Cell, along: Callable[[Cell], int], *, parts: int = _PARTS,
    deepest: int = _DEEPEST,
) -> bool:  # fmt: skip
    """Is a box free, whole or in at most so many parts?

    Args:
        keeps: is this part free, or of no interest?
        start: the box.
        along: the variable along which a part is halved.
        parts, deepest: parts that may be halved, and halvings of one of them.
    """
    stack, deepest = [start], deepest + sum(start.level)
    while stack:
        cell = stack.pop()
        if keeps(cell):
            continue
        parts -= 1
        if parts <= 0 or sum(cell.level) >= deepest:
            return False
        stack += cell.halved(along(cell))
    return True


def verify_ball(check: ClaimCheck) -> None:
    """Every box of the tree is free, the others are outside the ball.

    Raises:
        Unproven: a part that is not confirmed.
    """
    claim, moving, proof = check.claim, check.arm.moving, check.claim.proof
    radius, side = claim.entries["radius"], proof["side"]
    scale = check_scale(claim)
    if not radius <= side:
        raise Unproven("the boxes do not reach as far as the radius")
    share = Fraction(radius) / Fraction(side)
    f = flint()

    def keeps(cell: Cell) -> bool:
        if cell.lies_outside(share):
            return True
        centre, half = [f.arb(x) for x in claim.entries["q"]], [f.arb(0)] * claim.variables
        for place, j in enumerate(moving):
            low, high = cell.ends(place)
            unit = f.arb(side) * f.arb(scale[j])
            middle, width = (low + high) / 2, (high - low) / 2
            centre[j] = centre[j] + unit * f.arb(f.fmpq(middle.numerator, middle.denominator))
            half[j] = unit * f.arb(f.fmpq(width.numerator, width.denominator))
        return check.keeps_rank(Region(centre, half))

    for letter, leaf in leaves(proof["tree"], moving, share):
        check.work.report(letter, len(proof["tree"]))
        if not prove_free(keeps, leaf, lambda cell: min(range(len(moving)), key=lambda place: cell.level[place])):
            raise Unproven("a box could not be proven free again")


def leaves(tree: str, moving: list[int], share: Fraction) -> Iterator[tuple[int, Cell]]:
    """(place in the tree, box) of those said to be free.

    Raises:
        Unproven: the tree is cut off, goes on behind its end, halves what does not matter, or calls a box outside that
            is not.
    """
    places = {j: place for place, j in enumerate(moving)}
    stack = [Cell((0,) * len(moving), (0,) * len(moving))]
    for place, letter in enumerate(tree):
        if not stack:
            raise Unproven("the tree of boxes goes on behind its end")
        cell = stack.pop()
        if letter == FREE:
            yield place, cell
        elif letter == OUTSIDE:
            if not cell.lies_outside(share):
                raise Unproven(f"box {place + 1} of the tree is said to be outside the ball, and is not")
        elif (variable := LETTERS.find(letter)) in places:
            low, high = cell.halved(places[variable])
            stack += [high, low]
        else:
            raise Unproven(f"letter {place + 1} of the tree of boxes means nothing")
    if stack:
        raise Unproven("the tree of boxes is cut off: part of the ball is in no box")


def check_scale(claim: Claim) -> list[float]:
    """What a motion of each variable is divided by.

    Raises:
        Unproven: turns are not measured in rad, or slides differ in their unit.
    """
    scale: list[float] = claim.entries["scale"]
    if any(scale[j] != 1.0 for j in range(claim.variables) if j not in claim.slides):
        raise Unproven("turns are measured in another unit than rad")
    if len({scale[j] for j in claim.slides}) > 1:
        raise Unproven("slides are measured in different units")
    return scale


def verify_path(check: ClaimCheck) -> list[Record]:
    """Every span that is said to be free is so, and every crossing has two signs; the spans that are not free.

    Raises:
        Unproven: a span that is not confirmed, a gap between spans, nothing claimed, or nothing of more than a sliver.
    """
    claim = check.claim
    path, spans = CurvePath(check), claim.entries["spans"]
    _check_tiles(spans, path.count)
    others = [span for span in spans if span["kind"] != CLEAR]
    if (claim.entries["verdict"] == CLEAR) == bool(others):
        raise Unproven("the path is said to be free, and spans of it are not" if others else
                       "the path is said to meet singularities, and all of it is free")  # fmt: skip
    if not any(span["kind"] == CROSSING or span["from"] < span["to"] for span in spans if span["kind"] in (
        CLEAR, CROSSING
    )):
        raise Unproven("every span of the path is open: nothing is claimed")
    unclaimed = path.share_of(others)
    if not unclaimed <= _UNCLAIMED:
        raise Unproven(f"only a part of the path is said to be free: a share of {unclaimed:.3g} is not, and at most "
                       f"{_UNCLAIMED:g} may be slivers around singularities")  # fmt: skip
    for span in spans:
        if ("bracket" in span) != (span["kind"] == CROSSING):
            raise Unproven("a span has a bracket where it is a crossing, and only there")
        if span["kind"] == CLEAR:
            path.prove(span["from"], span["to"])
        elif span["kind"] == CROSSING:
            path.crosses(span)
    return others


def verify_distance(check: ClaimCheck) -> None:
    """No configuration nearer to a path than its `min_distance` has a lower rank.

    Around each piece of the path, the boxes that come nearer to it than the distance are free; a piece is halved until
    they are.

    Raises:
        Unproven: somewhere it is not confirmed.
    """
    entries = check.claim.entries
    if "min_distance" not in entries:
        if "scale" in entries:
            raise Unproven("a scale of slides is stated and no distance")
        return
    if "scale" not in entries:
        raise Unproven("a distance is claimed and no scale of slides is stated")
    path, scale = CurvePath(check), np.array(check_scale(check.claim))
    for stretch in range(path.count):
        check.work.report(stretch, path.count)
        path.keeps_away(stretch, entries["min_distance"], scale)


def _check_tiles(spans: list[Record], count: int) -> None:
    at: Place = (0, 0.0)
    for place, span in enumerate(spans, start=1):
        start, end = span["from"], span["to"]
        if max(start[0], end[0]) >= count:
            raise Unproven(f"a segment of the path is missing: span {place} is on stretch {end[0] + 1} of {count}")
        if not _is_same_place(at, start):
            raise Unproven(f"a segment of the path is missing before span {place}")
        if end < start:
            raise Unproven(f"span {place} ends before it begins")
        at = end
    if not _is_same_place(at, (count - 1, 1.0)):
        raise Unproven("a segment of the path is missing behind the last span")


def _is_same_place(a: Place, b: Place) -> bool:
    return a == b or (a[0] + 1 == b[0] and a[1] == 1.0 and b[1] == 0.0)


class CurvePath:
    """A curve whose control points are exact.

    Attributes:
        count: stretches.

    Raises:
        Unproven: control points are missing, or there are too many for the arm.
    """

    def __init__(self, check: ClaimCheck) -> None:
        self._check, self._f = check, flint()
        self._points: Array = check.claim.entries["points"]
        self._degree: int = check.claim.entries["degree"]
        self.count, rest = divmod(len(self._points) - 1, self._degree)
        if rest or self.count < 1:
            raise Unproven(
                f"control points are missing: {len(self._points)} are not 1 more than a multiple of {self._degree}"
            )
        if self._points.shape[1] != check.claim.variables:
            raise Unproven(f"control points have {self._points.shape[1]} joints, the arm has {check.claim.variables}")

    def _stretch(self, k: int) -> list[list[Interval]]:
        rows = self._points[k * self._degree : (k + 1) * self._degree + 1]
        return [[self._f.arb(float(x)) for x in row] for row in rows]

    def _cut(self, control: list[list[Interval]], share: Interval) -> tuple[list[list[Interval]], list[list[Interval]]]:
        """Both parts of a curve (de Casteljau)."""
        first, last, row = [control[0]], [control[-1]], control
        while len(row) > 1:
            row = [[x + (y - x) * share for x, y in zip(a, b, strict=True)] for a, b in pairwise(row)]
            first.append(row[0])
            last.append(row[-1])
        return first, last[::-1]

    def share_of(self, spans: list[Record]) -> float:
        """Share of the path's joint motion that lies in some spans, at most; 1 where the path does not move.

        A stretch moves by at most d max |b_{j+1} − b_j| for a unit of its share, and by its chord at least.
        """
        points, degree = self._points, self._degree
        whole = float(np.linalg.norm(np.diff(points[::degree], axis=0), axis=1).sum())
        inside = 0.0
        for span in spans:
            (first, begin), (last, end) = span["from"], span["to"]
            for k in range(first, last + 1):
                low, high = begin if k == first else 0.0, end if k == last else 1.0
                polygon = np.linalg.norm(np.diff(points[k * degree : (k + 1) * degree + 1], axis=0), axis=1)
                inside += (high - low) * degree * float(polygon.max())
        if not whole > 0.0:
            return 1.0 if spans else 0.0
        return inside / whole

    def prove(self, start: Place, end: Place) -> None:
        """Everything from one place to the other is free."""
        if start[0] == end[0]:
            control = self._stretch(start[0])
            if end[1] < 1.0:
                control = self._cut(control, self._f.arb(end[1]))[0]
            if start[1] > 0.0 and end[1] > 0.0:
                control = self._cut(control, self._f.arb(start[1]) / self._f.arb(end[1]))[1]
            self._piece(control, start[0])
            return
        if start[1] > 0.0:
            self._piece(self._cut(self._stretch(start[0]), self._f.arb(start[1]))[1], start[0])
        if end[1] < 1.0:
            self._piece(self._cut(self._stretch(end[0]), self._f.arb(end[1]))[0], end[0])
        self._run(start[0] + (start[1] > 0.0), end[0] + (end[1] == 1.0))

    def _run(self, first: int, after: int) -> None:
        """Whole stretches, by boxes around as many as can be."""
        stack = [(first, after)]
        while stack:
            low, high = stack.pop()
            if low >= high:
                continue
            self._check.work.report(low, self.count)
            if high - low == 1:
                self._piece(self._stretch(low), low)
                continue
            rows = self._points[low * self._degree : high * self._degree + 1]
            least, most = rows.min(axis=0), rows.max(axis=0)
            if float(np.linalg.norm(most - least)) < 2 * _WIDE and self._check.keeps_rank(
                Region(*self._middle(least, most))
            ):
                continue
            middle = (low + high) // 2
            stack += [(middle, high), (low, middle)]

    def _middle(self, least: Array, most: Array) -> tuple[list[Interval], list[Interval]]:
        ends = [(self._f.arb(float(a)), self._f.arb(float(b))) for a, b in zip(least, most, strict=True)]
        return [(a + b) / 2 for a, b in ends], [(b - a) / 2 for a, b in ends]

    def _piece(self, control: list[list[Interval]], stretch: int) -> None:
        """Part of one stretch, halved until it is free."""
        stack = [control]
        while stack:
            piece = stack.pop()
            degree = len(piece) - 1
            middle = [(a + b) / 2 for a, b in zip(piece[0], piece[-1], strict=True)]
            chord = [(b - a) / 2 for a, b in zip(piece[0], piece[-1], strict=True)]
            extra = [self._f.arb(0)] * len(middle)
            for j in range(1, degree):
                at = self._f.arb(2 * j - degree) / degree
                off = [abs(x - (m + at * c)) for x, m, c in zip(piece[j], middle, chord, strict=True)]
                extra = [a.max(b).upper() for a, b in zip(off, extra, strict=True)]
            centre, slack = [x.mid() for x in middle], [x.rad() for x in middle]
            half = [x + y for x, y in zip(extra, slack, strict=True)]
            if self._check.keeps_rank(Region(centre, half, chord)):
                continue
            if max(float(abs(x).upper()) for x in chord) < _NARROW:
                raise Unproven(f"the path could not be proven free again between rows {stretch + 1} and {stretch + 2}")
            low, high = self._cut(piece, self._f.arb(0.5))
            stack += [high, low]

    def crosses(self, span: Record) -> None:
        """The determinant has two signs at the ends of the bracket: it vanishes between them."""
        claim, (low, high) = self._check.claim, span["bracket"]
        if not span["from"] <= low < high <= span["to"]:
            raise Unproven("the bracket of a crossing is not inside its span")
        if not len(claim.whole_rows) == claim.rank == claim.variables:
            raise Unproven("a crossing is proven by two signs of a determinant, and this arm and task have none")
        signs = [self._check.arm.sign(self._at(place), claim.whole_rows) for place in (low, high)]
        if signs[0] * signs[1] != -1:
            raise Unproven(
                f"the determinant is not proven to have two signs between rows {low[0] + 1} and {high[0] + 2}"
            )

    def keeps_away(self, stretch: int, distance: float, scale: Array) -> None:
        """Everything nearer to a stretch than a distance is free.

        Raises:
            Unproven: it is not confirmed.
        """
        moving = self._check.arm.moving
        stack = [self._stretch(stretch)]
        while stack:
            piece = stack.pop()
            least = np.array([[float(x.lower()) for x in row] for row in piece]).min(axis=0)
            most = np.array([[float(x.upper()) for x in row] for row in piece]).max(axis=0)
            centre = (least + most) / 2
            wide = ((most - least) / 2 + 1e-15 * np.abs(centre)) * (1 + _OUTWARDS)  # of the piece
            last = bool((wide / scale)[moving].max(initial=0.0) <= _SHORT * distance)
            if self._surroundings(centre, wide, distance, scale, _FINE if last else _ROUGH):
                continue
            if last:
                raise Unproven(f"the distance {distance:.6g} rad could not be proven again between rows {stretch + 1} "
                               f"and {stretch + 2}")  # fmt: skip
            low, high = self._cut(piece, self._f.arb(0.5))
            stack += [high, low]

    def _surroundings(self, centre: Array, wide: Array, distance: float, scale: Array, parts: int) -> bool:
        """Is everything nearer than a distance to the box centre ± wide free, in so many parts at most?"""
        f, moving = self._f, self._check.arm.moving
        reach = (wide + distance * scale) * (1 + _OUTWARDS)

        def keeps(cell: Cell) -> bool:
            ends = [cell.ends(place) for place in range(len(moving))]
            table = np.array([[float(x) for x in pair] for pair in ends]).reshape(-1, 2)
            gap = np.maximum(0.0, np.maximum(table[:, 0], -table[:, 1])) * reach[moving] - wide[moving]
            if np.linalg.norm(np.maximum(0.0, gap / scale[moving])) > distance * (1 + 1e-9):
                return True
            middle, half = [f.arb(float(x)) for x in centre], [f.arb(float(x)) for x in wide]
            for (low, high), j in zip(ends, moving, strict=True):
                middle[j] += f.arb(float((low + high) / 2)) * f.arb(float(reach[j]))
                half[j] = f.arb(float((high - low) / 2)) * f.arb(float(reach[j]))
            return self._check.keeps_rank(Region(middle, half), near=False)

        def along(cell: Cell) -> int:
            return int(np.argmax([2.0**-level * reach[j] / scale[j]
                                  for level, j in zip(cell.level, moving, strict=True)]))  # fmt: skip

        zero = (0,) * len(moving)
        return prove_free(keeps, Cell(zero, zero), along, parts=parts)

    def _at(self, place: Place) -> list[Interval]:
        return self._cut(self._stretch(place[0]), self._f.arb(place[1]))[0][-1]
