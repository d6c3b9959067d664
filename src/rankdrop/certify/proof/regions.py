"""Balls and paths proven free again, by halving whatever one enclosure does not decide."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import numpy as np

from rankdrop.certify.proof.intervals import SLIDE, Arm, Interval, Region, flint
from rankdrop.certify.proof.reading import Record, Told, Unproven, Work, number, numbers, vector, whole
from rankdrop.robot.model import Array

FREE, OUTSIDE, LETTERS = ".", "-", "abcdefghijklmnopqrstuvwxyzABCDEF"
"""A tree of boxes in preorder: a letter halves along that variable (a the first), lower half first."""
OPEN, CROSSING, CLEAR = "open", "crossing", "free"
"""What a span of a path is said to be."""
_DEEPEST, _PARTS = 40, 1000  # halvings of one leaf of the tree, and parts of it
_NARROW = 1e-13  # pieces of a path whose joints move less are given up [rad]
_ROUGH, _FINE = 32, 4000  # parts of the surroundings of a piece of a path: of one that is halved next, and of the last
_SHORT = 0.02  # share of the distance to be kept below which a piece is not halved
_OUTWARDS = 1e-12  # share by which doubles are taken larger
_WIDE = 1.2  # half diagonal of boxes around runs of stretches that are tried [rad]


@dataclass(frozen=True)
class Cell:
    """A box of the tree: for each variable that matters, which of 2^level equal parts of −side … side."""

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
        """In units of the side, from −1 to 1."""
        low = Fraction(2 * self.index[place], 2 ** self.level[place]) - 1
        return low, low + Fraction(2, 2 ** self.level[place])

    def outside(self, share: Fraction) -> bool:
        """Has it no point nearer to the centre than `share` of the side?"""
        total = Fraction(0)
        for place in range(len(self.index)):
            low, high = self.ends(place)
            gap = max(Fraction(0), low, -high)
            total += gap * gap
        return total >= share * share


def verify_ball(arm: Arm, told: Told, work: Work) -> str:
    """Every box of the tree free, the others outside the ball; a sentence on what holds.

    Raises:
        ValueError: the claim is malformed.
        Unproven: a part that is not confirmed.
    """
    claim = told.claim
    q = vector(claim["q"], told.variables, "q")
    radius = number(claim["radius"], 0.0, 4.0, "radius")
    scale = _scale(told)
    side, tree = number(told.proof["side"], 0.0, 4.0, "side"), text_of_tree(told.proof["tree"])
    if not 0.0 < radius <= side:
        raise Unproven("the boxes do not reach as far as the radius" if radius else "the radius is zero")
    share = Fraction(radius) / Fraction(side)
    for place, leaf in leaves(tree, arm.moving, share):
        work.tell(place, len(tree))
        _free(arm, told, _Ball(q, scale, side, share), leaf, work)
    fixed = [str(j + 1) for j in range(told.variables) if j not in arm.moving]
    joints = f"joint{'s' if len(fixed) > 1 else ''} {' and '.join(filter(None, (', '.join(fixed[:-1]), fixed[-1])))}" \
        if fixed else ""
    free = f"; {joints} may stand anywhere" if fixed else ""
    return f"no configuration within {radius:.9g} rad of q has a rank below {told.rank}{_slides(told)}{free}"


def text_of_tree(value: object) -> str:
    """The tree; a budget on its length.

    Raises:
        ValueError: no text, or too long.
    """
    if not isinstance(value, str) or len(value) > 50_000_000:
        raise ValueError("tree: a text of at most 50,000,000 letters")
    return value


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
            if not cell.outside(share):
                raise Unproven(f"box {place + 1} of the tree is said to be outside the ball, and is not")
        elif (variable := LETTERS.find(letter)) in places:
            low, high = cell.halved(places[variable])
            stack += [high, low]
        else:
            raise Unproven(f"letter {place + 1} of the tree of boxes means nothing")
    if stack:
        raise Unproven("the tree of boxes is cut off: part of the ball is in no box")


@dataclass(frozen=True, eq=False)
class _Ball:
    q: list[float]
    scale: list[float]
    side: float
    share: Fraction

    def region(self, cell: Cell, moving: list[int]) -> Region:
        f = flint()
        centre, half = [f.arb(x) for x in self.q], [f.arb(0)] * len(self.q)
        for place, j in enumerate(moving):
            low, high = cell.ends(place)
            unit = f.arb(self.side) * f.arb(self.scale[j])
            middle, width = (low + high) / 2, (high - low) / 2
            centre[j] = centre[j] + unit * f.arb(f.fmpq(middle.numerator, middle.denominator))
            half[j] = unit * f.arb(f.fmpq(width.numerator, width.denominator))
        return Region(centre, half)


def _free(arm: Arm, told: Told, ball: _Ball, leaf: Cell, work: Work) -> None:
    """A box free, whole or in parts; parts outside the ball do not matter."""
    stack, spent = [leaf], 0
    while stack:
        cell = stack.pop()
        if cell.outside(ball.share):
            continue
        if not work.spend():
            raise Unproven(f"the work is used up ({work.most:,} enclosures) before every box was proven free again")
        if arm.keeps_rank(ball.region(cell, arm.moving), told.whole_rows, told.rank, told.tolerance):
            continue
        spent += 1
        if sum(cell.level) - sum(leaf.level) >= _DEEPEST or spent >= _PARTS:
            raise Unproven("a box could not be proven free again")
        stack += cell.halved(min(range(len(cell.level)), key=lambda place: (cell.level[place], place)))


def verify_path(arm: Arm, told: Told, work: Work) -> str:
    """Every span that is said to be free proven so, and every crossing by two signs; a sentence on what holds.

    Raises:
        ValueError: the claim is malformed.
        Unproven: a span that is not confirmed, or a gap between spans.
    """
    claim = told.claim
    path, count = _read_path(arm, told, work)
    spans = [_Span.read(one, count) for one in _list(claim["spans"])]
    _check_tiles(spans, count)
    met: dict[str, int] = {CLEAR: 0, CROSSING: 0, OPEN: 0}
    for span in spans:
        met[span.kind] += 1
        if span.kind == CLEAR:
            path.prove(span.start, span.end)
        elif span.kind == CROSSING:
            path.crosses(span)
    if claim["verdict"] == CLEAR and met[CLEAR] != len(spans):
        raise Unproven("the path is said to be free, and spans of it are not")
    if not met[CROSSING] and not met[OPEN]:
        return f"every point of the path has rank {told.rank}: it meets no singularity"
    parts = [f"{met[CLEAR]} spans are free"]
    if met[CROSSING]:
        parts.append(f"{met[CROSSING]} hold a singular configuration (two signs of the determinant)")
    if met[OPEN]:
        parts.append(f"of {met[OPEN]} nothing is claimed")
    return ", ".join(parts)


def _read_path(arm: Arm, told: Told, work: Work) -> tuple[_Path, int]:
    degree = whole(told.claim["degree"], 1, 9, "degree")
    points = numbers(told.claim["points"], (-1, told.variables), "points")
    count, rest = divmod(len(points) - 1, degree)
    if rest or count < 1:
        raise Unproven(f"control points are missing: {len(points)} are not 1 more than a multiple of {degree}")
    return _Path(arm, told, points, degree, count, work), count


def verify_distance(arm: Arm, told: Told, work: Work) -> str:
    """No configuration nearer to a path than its `min_distance` has a lower rank; a sentence, "" where none is claimed.

    Around each piece of the path, the boxes that come nearer to it than the distance are free; a piece is halved until
    they are.

    Raises:
        ValueError: the claim is malformed.
        Unproven: somewhere it is not confirmed.
    """
    if told.claim.get("min_distance") is None:
        return ""
    distance = number(told.claim["min_distance"], 0.0, 4.0, "min_distance")
    scale = _scale(told)
    path, count = _read_path(arm, told, work)
    for stretch in range(count):
        work.tell(stretch, count)
        path.keeps_away(stretch, distance, np.array(scale))
    return f"no configuration of this arm nearer to the path than {distance:.9g} rad has a rank below {told.rank}" \
           f"{_slides(told)}"


def _slides(told: Told) -> str:
    """How slides are counted in a distance; nothing where there are none."""
    return " (slides divided by their scale)" if any(one.kind == SLIDE for one in told.links) else ""


def _scale(told: Told) -> list[float]:
    """What a motion of each variable is divided by.

    Raises:
        Unproven: turns are not measured in rad.
    """
    scale = [number(one, 1e-9, 1e9, "scale") for one in vector(told.claim["scale"], told.variables, "scale")]
    slides = {one.driver for one in told.links if one.kind == SLIDE}
    if any(scale[j] != 1.0 for j in range(told.variables) if j not in slides):
        raise Unproven("turns are measured in another unit than rad")
    return scale


Place = tuple[int, float]


@dataclass(frozen=True)
class _Span:
    start: Place
    end: Place
    kind: str
    bracket: tuple[Place, Place] | None

    @classmethod
    def read(cls, record: Record, count: int) -> _Span:
        kind = record["kind"]
        if kind not in (CLEAR, CROSSING, OPEN):
            raise ValueError("kind of a span: free, crossing or open")
        bracket = None
        if kind == CROSSING:
            low, high = _list(record["bracket"])
            bracket = (_place(low, count), _place(high, count))
        return cls(_place(record["from"], count), _place(record["to"], count), kind, bracket)


def _list(value: object) -> list[Record]:
    if not isinstance(value, list):
        raise ValueError("spans: a list")
    return value


def _place(value: object, count: int) -> Place:
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError("a place is [stretch, share]")
    stretch = whole(value[0], 0, 1 << 40, "stretch")
    if stretch >= count:
        raise Unproven(f"a segment of the path is missing: a span is on stretch {stretch + 1} of {count}")
    return stretch, number(value[1], 0.0, 1.0, "share")


def _check_tiles(spans: list[_Span], count: int) -> None:
    at: Place = (0, 0.0)
    for number_, span in enumerate(spans, start=1):
        if not _same(at, span.start):
            raise Unproven(f"a segment of the path is missing before span {number_}")
        if span.end < span.start:
            raise Unproven(f"span {number_} ends before it begins")
        at = span.end
    if not _same(at, (count - 1, 1.0)):
        raise Unproven("a segment of the path is missing behind the last span")


def _same(a: Place, b: Place) -> bool:
    return a == b or (a[0] + 1 == b[0] and a[1] == 1.0 and b[1] == 0.0)


class _Path:
    """A curve whose control points are exact."""

    def __init__(self, arm: Arm, told: Told, points: Array, degree: int, count: int, work: Work) -> None:
        self._arm, self._told, self._points, self._degree = arm, told, points, degree
        self._count, self._work, self._f = count, work, flint()

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
            self._work.tell(low, self._count)
            if high - low == 1:
                self._piece(self._stretch(low), low)
                continue
            rows = self._points[low * self._degree : high * self._degree + 1]
            least, most = rows.min(axis=0), rows.max(axis=0)
            if float(np.linalg.norm(most - least)) < 2 * _WIDE and self._free(
                Region(*self._middle(least, most)), low
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
            if self._free(Region(centre, half, chord), stretch):
                continue
            if max(float(abs(x).upper()) for x in chord) < _NARROW:
                raise Unproven(f"the path could not be proven free again between rows {stretch + 1} and {stretch + 2}")
            low, high = self._cut(piece, self._f.arb(0.5))
            stack += [high, low]

    def _free(self, region: Region, stretch: int) -> bool:
        if not self._work.spend():
            raise Unproven(
                f"the work is used up ({self._work.most:,} enclosures) at row {stretch + 1} of {self._count + 1}"
            )
        return self._arm.keeps_rank(region, self._told.whole_rows, self._told.rank, self._told.tolerance)

    def crosses(self, span: _Span) -> None:
        """The determinant has two signs at the ends of the bracket: it vanishes between them."""
        told = self._told
        assert span.bracket is not None
        low, high = span.bracket
        if not span.start <= low < high <= span.end:
            raise Unproven("the bracket of a crossing is not inside its span")
        if not len(told.whole_rows) == told.rank == told.variables:
            raise Unproven("a crossing is told by two signs of a determinant, and there is none for this arm and task")
        signs = [self._arm.sign(self._at(place), told.whole_rows) for place in (low, high)]
        if signs[0] * signs[1] != -1:
            raise Unproven(
                f"the determinant is not proven to have two signs between rows {low[0] + 1} and {high[0] + 2}"
            )

    def keeps_away(self, stretch: int, distance: float, scale: Array) -> None:
        """Everything nearer to a stretch than a distance is free.

        Raises:
            Unproven: it is not confirmed.
        """
        moving = self._arm.moving
        stack = [self._stretch(stretch)]
        while stack:
            piece = stack.pop()
            ends = np.array([[[float(x.lower()), float(x.upper())] for x in row] for row in piece])
            least, most = ends[..., 0].min(axis=0), ends[..., 1].max(axis=0)
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
        f, moving = self._f, self._arm.moving
        reach = (wide + distance * scale) * (1 + _OUTWARDS)
        stack = [Cell((0,) * len(moving), (0,) * len(moving))]
        while stack:
            cell = stack.pop()
            ends = np.array([[float(x) for x in cell.ends(place)] for place in range(len(moving))]).reshape(-1, 2)
            gap = np.maximum(0.0, np.maximum(ends[:, 0], -ends[:, 1])) * reach[moving] - wide[moving]
            if np.linalg.norm(np.maximum(0.0, gap / scale[moving])) > distance * (1 + 1e-9):
                continue
            if not self._work.spend():
                raise Unproven(f"the work is used up ({self._work.most:,} enclosures) before the distance was proven")
            middle, half = [f.arb(float(x)) for x in centre], [f.arb(float(x)) for x in wide]
            for place, j in enumerate(moving):
                low, high = cell.ends(place)
                middle[j] += f.arb(float((low + high) / 2)) * f.arb(float(reach[j]))
                half[j] = f.arb(float((high - low) / 2)) * f.arb(float(reach[j]))
            if self._arm.keeps_rank(Region(middle, half), self._told.whole_rows, self._told.rank):
                continue
            parts -= 1
            if parts <= 0 or sum(cell.level) >= _DEEPEST:
                return False
            widths = [Fraction(1, 2 ** level) * Fraction(float(reach[j] / scale[j]))
                      for level, j in zip(cell.level, moving, strict=True)]  # fmt: skip
            stack += cell.halved(widths.index(max(widths)))
        return True

    def _at(self, place: Place) -> list[Interval]:
        return self._cut(self._stretch(place[0]), self._f.arb(place[1]))[0][-1]
