"""An arm in exact rings (Arb's intervals or rational numbers, python-flint), and the proof that it keeps its rank.

Nothing here comes from what makes certificates: the core, `setting`, `kinematics`. The mathematics differs as well. The
second derivatives are enclosed over the whole region, so that no bound on lengths is needed for what is beyond them:

    A(δ) = U^T J(c + δ) V  ∈  A(c) + Σ_k g_k δ_k + ½ Σ_kl H_kl([region]) δ_k δ_l

U and V are any matrices of doubles (the singular vectors at c). Where the comparison matrix of A, |A_ii| from below on
the diagonal and −|A_ij| from above elsewhere, takes a positive vector to a positive one, A is regular, and the rank of
J is at least its size. Every number is an interval that holds the exact one: rounding is part of the proof.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from rankdrop.proof.record import SCREW, SLIDE, TURN, Array, Link, Tolerance

Interval = Any
"""A `flint.arb`; in rational numbers a `flint.fmpq`."""
Matrix = Any
"""A `flint.arb_mat`; in rational numbers a `flint.fmpq_mat`."""

BITS = 90
"""Of the midpoints: a path next to a singularity has σ of 1e-9, and half of these digits are left."""
_LEAST = 1e-13  # share of the terms of a product that must be left of it: a thousand times what doubles round

Seen = tuple[list[Matrix], list[Matrix | None]]
"""Screws (6, 1) over a box, and the motions (6, 6) that brought each of them there; None where nothing did."""
_UNIT = np.eye(6, dtype=np.int64).ravel().tolist()


def flint() -> ModuleType:
    """The module `flint`.

    Raises:
        ImportError: python-flint is not installed.
    """
    import flint as module

    return module


@dataclass(frozen=True, eq=False)
class Region:
    """Configurations c + Σ_k h_k s_k + Δ τ, |s_k| ≤ 1, |τ| ≤ 1.

    Attributes:
        centre, half: (n,) intervals c and h.
        along: (n,) intervals Δ; None for a box.
    """

    centre: list[Interval]
    half: list[Interval]
    along: list[Interval] | None = None


class Arm:
    """A chain seen from a point of link `link` (0 … N), lengths divided by `length`.

    Its axes are those of the base as the link carries them from q = 0, or `axes` (3, 3, columns): those of the tool.

    Attributes:
        moving: places of the variables on which some column depends, seen from there.
        variables: n.
    """

    def __init__(
        self, links: list[Link], variables: int, link: int, point: list[Interval], length: Interval,
        axes: Array | None = None,
    ) -> None:  # fmt: skip
        self._f = flint()
        self._matrix = self.matrices()
        self.links, self.link, self.variables = links, link, variables
        self._point, self._length = point, length
        self._screws = [self._screw(body) for body in links]
        if axes is not None:
            self._screws = [self._in_axes(screw, self._exact_axes(axes)) for screw in self._screws]
        self._ads = [self._ad(screw) for screw in self._screws]
        self._squares = [adjoint * adjoint for adjoint in self._ads]
        after, before = list(range(link, len(links))), list(range(link - 1, -1, -1))
        self._sides = ((after, 1), (before, -1))
        self.moving = sorted({links[i].driver for side, _ in self._sides for i in side[:-1]})

    def matrices(self) -> Any:
        """The type of its matrices."""
        return self._f.arb_mat

    def _number(self, value: float) -> Interval:
        return self._f.arb(value)

    def _numbers(self, values: Iterable[float]) -> list[Interval]:
        return [self._number(float(value)) for value in values]

    def _screw(self, link: Link) -> list[Interval]:
        """The unit screw about the point, lengths scaled: axis, foot and pitch made exactly what they are called."""
        v, w = self._numbers(link.screw[:3]), self._numbers(link.screw[3:])
        zero = self._number(0)
        if link.kind == SLIDE:
            size = _norm(v)
            return [x / size / self._length for x in v] + [zero] * 3
        square = dot(w, w)
        size = square.sqrt()
        foot = [x / square for x in cross(w, v)]
        axis = [x / size for x in w]
        arm = [x - y for x, y in zip(foot, self._point, strict=True)]
        moment = cross(arm, axis)
        if link.kind == SCREW:
            pitch = dot(w, v) / square
            moment = [x + pitch * y for x, y in zip(moment, axis, strict=True)]
        return [x / self._length for x in moment] + axis

    def _exact_axes(self, axes: Array) -> list[list[Interval]]:
        """Three unit vectors exactly at right angles next to the columns of a rotation, by Gram and Schmidt."""
        x, y = self._numbers(axes[:, 0]), self._numbers(axes[:, 1])
        size = _norm(x)
        x = [entry / size for entry in x]
        along = dot(x, y)
        y = [entry - along * other for entry, other in zip(y, x, strict=True)]
        size = _norm(y)
        y = [entry / size for entry in y]
        return [x, y, cross(x, y)]

    @staticmethod
    def _in_axes(screw: list[Interval], axes: list[list[Interval]]) -> list[Interval]:
        """The components of a screw (v; ω) along three axes."""
        linear, angular = screw[:3], screw[3:]
        return [dot(axis, linear) for axis in axes] + [dot(axis, angular) for axis in axes]

    def _ad(self, screw: Any) -> Matrix:
        """(6, 6) ad_S, with [S, T] = ad_S T, linear part first."""
        v1, v2, v3, w1, w2, w3 = screw
        return self._matrix([
            [0, -w3, w2, 0, -v3, v2], [w3, 0, -w1, v3, 0, -v1], [-w2, w1, 0, -v2, v1, 0],
            [0, 0, 0, 0, -w3, w2], [0, 0, 0, w3, 0, -w1], [0, 0, 0, -w2, w1, 0],
        ])  # fmt: skip

    def _motion(self, i: int, middle: Interval, half: Interval, sign: int) -> Matrix:
        """(6, 6) Ad(exp(± S_i q)) for q in an interval."""
        arb, link = self._f.arb, self.links[i]
        middle, half = link.multiplier * middle + link.offset, abs(self._number(link.multiplier)) * half
        value = _ball(arb, middle, half)
        if link.kind == SLIDE:
            return self.exponential(i, sign * value, 0)
        sine, cosine = _sine_cosine(arb, middle, half)
        if link.kind == TURN:
            return self.exponential(i, sign * sine, 1 - cosine)
        unit = self.unit()
        axis = self._screws[i][3:]
        pitch = dot(axis, self._screws[i][:3])
        turn = self._ad([x - pitch * y for x, y in zip(self._screws[i][:3], axis, strict=True)] + axis)
        slide = self._ad([pitch * x for x in axis] + [arb(0)] * 3)
        return (unit + turn * (sign * sine) + turn * turn * (1 - cosine)) * (unit + slide * (sign * value))

    def unit(self) -> Matrix:
        """(6, 6) the motion that moves nothing."""
        return self._matrix(6, 6, _UNIT)

    def exponential(self, i: int, once: Any, twice: Any) -> Matrix:
        """(6, 6) 1 + once · ad + twice · ad² of a joint's screw: every turn and every shift has this form."""
        return self.unit() + self._ads[i] * once + self._squares[i] * twice

    def screws_over(self, centre: list[Interval], half: list[Interval]) -> Seen:
        """All screws as the link sees them, over a box; multipliers are left out."""

        def motion_over(i: int, sign: int) -> Matrix:
            driver = self.links[i].driver
            return self._motion(i, centre[driver], half[driver], sign)

        return self.carry_screws(motion_over)

    def carry_screws(self, motion_of: Callable[[int, int], Matrix]) -> Seen:
        """All screws as the link sees them, with the motion (6, 6) of each joint i, forwards (1) or backwards (−1)."""
        screws: list[Matrix] = [None] * len(self.links)
        motions: list[Matrix | None] = [None] * len(self.links)
        for side, sign in self._sides:
            motion = None
            for place, i in enumerate(side):
                column = self._matrix(6, 1, self._screws[i])
                if motion is None:
                    screws[i] = column
                else:
                    screws[i] = motion * column
                motions[i] = motion
                if place + 1 < len(side):
                    step = motion_of(i, sign)
                    if motion is None:
                        motion = step
                    else:
                        motion = motion * step
        return screws, motions

    def jacobian(self, columns: list[Matrix]) -> Array:
        """(6, n) middles of the Jacobian, as doubles."""
        out = np.zeros((6, self.variables))
        for link, column in zip(self.links, columns, strict=True):
            out[:, link.driver] += link.multiplier * np.array([float(x.mid()) for x in column.entries()])
        return out

    def keeps_rank(self, region: Region, rows: list[int], rank: int, tolerance: Tolerance | None = None) -> bool:
        """Is the rank of the rows proven to be at least `rank` everywhere in a region?

        Args:
            region: where.
            rows: of the twist about the point.
            rank: how many.
            tolerance: for every arm so near as well.
        """
        enclosed = self.enclose(region, rows, rank, tolerance)
        return enclosed is not None and regular(enclosed[0].tolist(), rank)

    def enclose(
        self, region: Region, rows: list[int], rank: int, tolerance: Tolerance | None = None
    ) -> tuple[Matrix, Array, Array] | None:
        """U^T J V over a region, as intervals (r, r), with U (rows, r) and V (n, r); None where J has no such rank."""
        f = self._f
        zeros = [f.arb(0)] * self.variables
        at = self.screws_over(region.centre, zeros)[0]
        u, sigma, vt = np.linalg.svd(self.jacobian(at)[rows])
        if len(sigma) < rank or not sigma[rank - 1] > 0.0:
            return None
        left = f.arb_mat(rank, 6, [0.0] * (6 * rank))
        for place, row in enumerate(rows):
            for k in range(rank):
                left[k, row] = float(u[place, k])
        weights = [self._weights(link, vt[:rank]) for link in self.links]
        wide = _half_widths(region)
        seen = self.screws_over(region.centre, wide)
        over = seen[0]
        total = left * _sum(c * w for c, w in zip(at, weights, strict=True))
        for side, sign in self._sides:
            first = self._first(side, at if region.along is None else over, weights, region.half)
            for moved, size in first:
                total += left * moved * _ball(f.arb, f.arb(0), size)
            if region.along is not None:
                total += self._moved_together(side, sign, at, over, weights, region.along, left)
            else:
                total += self._second(side, over, weights, region.half, left)
        if tolerance is not None:
            moves = max(rows) <= 2
            total += self._tolerance_part(seen, weights, tolerance, left, Region(region.centre, wide), moves=moves)
        return total, u[:, :rank], vt[:rank].T

    def _weights(self, link: Link, vt: Array) -> Matrix:
        """(1, r) entries of V for the column of a link, with the share of the variable that it turns by."""
        row = [self._f.arb(link.multiplier) * float(x) for x in vt[:, link.driver]]
        return self._f.arb_mat(1, len(row), row)

    def sign(self, q: list[Interval], rows: list[int]) -> int:
        """Sign of the determinant of the rows at a configuration, 0 where it is not decided; as many rows as variables.

        Times a constant sign that does not depend on the configuration.
        """
        value = self.determinant(q, rows)
        if value > 0:
            return 1
        if value < 0:
            return -1
        return 0

    def determinant(self, q: list[Interval], rows: list[int]) -> Interval:
        """The determinant of the rows at a configuration; as many rows as variables.

        By minors of the first rows, without a division: at a singular configuration it is as narrow as elsewhere.
        """
        f, n = self._f, self.variables
        columns = self.screws_over(q, [f.arb(0)] * n)[0]
        entries = [[f.arb(0)] * n for _ in rows]
        for link, column in zip(self.links, columns, strict=True):
            values = column.entries()
            for place, row in enumerate(rows):
                entries[place][link.driver] += link.multiplier * values[row]
        minors = {0: f.arb(1)}  # by the columns they take, as bits
        for line in entries:
            wider: dict[int, Interval] = {}
            for taken, minor in minors.items():
                for j in range(n):
                    if taken >> j & 1:
                        continue
                    term = minor * line[j]
                    both = taken | 1 << j
                    if (taken >> j).bit_count() & 1:  # columns behind it: as many exchanges
                        term = -term
                    if both in wider:
                        wider[both] = wider[both] + term
                    else:
                        wider[both] = term
            minors = wider
        return minors[(1 << n) - 1]

    def brackets(self, columns: list[Matrix]) -> Iterator[tuple[int, int, Matrix]]:
        """(joint i, variable k, (6, 1) derivative of the screw of i by k) wherever it is not zero."""
        for side, sign in self._sides:
            for place, by in enumerate(side):
                ad = self._ad(columns[by].entries()) * (sign * self._number(self.links[by].multiplier))
                for i in side[place + 1 :]:
                    yield i, self.links[by].driver, ad * columns[i]

    def _weighted_columns(self, side: list[int], columns: list[Matrix], weights: list[Matrix]) -> list[Matrix]:
        """For each place on a side, Σ of the columns farther from the link, times their weights."""
        weighted: list[Matrix] = [None] * len(side)
        rank = weights[0].ncols()
        total = self._f.arb_mat(6, rank, [0] * (6 * rank))
        for place in range(len(side) - 1, -1, -1):
            weighted[place] = total
            total = total + columns[side[place]] * weights[side[place]]
        return weighted

    def _first(
        self, side: list[int], columns: list[Matrix], weights: list[Matrix], half: list[Interval]
    ) -> list[tuple[Matrix, Interval]]:
        """(derivative of J V by a joint, ± and how far the joint goes), joints of one variable together."""
        beyond = self._weighted_columns(side, columns, weights)
        moved: dict[int, Matrix] = {}
        for place, i in enumerate(side[:-1]):
            link = self.links[i]
            part = self._ad(columns[i].entries()) * beyond[place] * self._number(link.multiplier)
            if link.driver in moved:
                moved[link.driver] = moved[link.driver] + part
            else:
                moved[link.driver] = part
        return [(part, half[driver]) for driver, part in moved.items() if half[driver] > 0]

    def _second(
        self, side: list[int], over: list[Matrix], weights: list[Matrix], half: list[Interval], left: Matrix
    ) -> Matrix:
        """½ Σ H δ δ of a box, each pair of joints for itself."""
        beyond = self._weighted_columns(side, over, weights)
        rank = weights[0].ncols()
        total = self._f.arb_mat(rank, rank, [0] * (rank * rank))
        ads = [self._ad(over[i].entries()) for i in side[:-1]]
        steps = [abs(self._number(self.links[i].multiplier)) * half[self.links[i].driver] for i in side[:-1]]
        for b, outer in enumerate(ads):
            if not steps[b] > 0:
                continue
            moved = outer * beyond[b]
            for a in range(b + 1):
                if steps[a] > 0:
                    size = steps[a] * steps[b] / (2 if a == b else 1)
                    total += left * (ads[a] * moved) * _ball(self._f.arb, self._f.arb(0), size)
        return total

    def _moved_together(
        self, side: list[int], sign: int, at: list[Matrix], over: list[Matrix], weights: list[Matrix],
        along: list[Interval], left: Matrix,
    ) -> Matrix:  # fmt: skip
        """g(Δ) τ + ½ H(Δ, Δ) τ²: joints that move together."""
        f, rank = self._f, weights[0].ncols()
        slope, bend = f.arb_mat(6, rank, [0] * (6 * rank)), f.arb_mat(6, rank, [0] * (6 * rank))
        near, far = self._weighted_columns(side, at, weights), self._weighted_columns(side, over, weights)
        nearer = f.arb_mat(6, 1, [0] * 6)
        for place, i in enumerate(side[:-1]):
            link = self.links[i]
            step = self._number(link.multiplier) * along[link.driver]
            slope += self._ad((at[i] * step).entries()) * near[place]
            moved = self._ad((over[i] * step).entries()) * far[place]
            bend += self._ad((over[i] * step + nearer * 2).entries()) * moved
            nearer = nearer + over[i] * step
        whole, share = _ball(f.arb, f.arb(0), f.arb(1)), _ball(f.arb, f.arb(0.25), f.arb(0.25))
        return left * slope * (whole * sign) + left * bend * share

    def _tolerance_part(
        self, over: Seen, weights: list[Matrix], tolerance: Tolerance, left: Matrix, region: Region, *, moves: bool
    ) -> Matrix:
        """What arms within the tolerance add: by the mean value theorem along the way from this arm to that one.

        Each joint is turned about its point by a vector θ and moved by t; all that is beyond it goes along. The
        derivative is the bracket with that motion, linear in θ and t, so that its entries are at most
        |θ| times the length of the three for unit turns, plus |t| times that of the three for unit moves. It is taken
        over all arms on the way: screws and points are widened by how far they can be carried.

        With `moves` the point from which the arm is seen is moved as well, as a tool's point is.
        """
        f, rank = self._f, left.nrows()
        shift, angle = f.arb(tolerance.length) / self._length, f.arb(tolerance.angle)
        points = [self._from_link_point(row) for row in tolerance.points]
        total = [f.arb(0)] * rank**2  # entries, row by row
        for side, sign in self._sides:
            for motions, carried in self._displaced_joints(
                side, sign, points, shift, angle, over, weights, region, int(moves)
            ):
                for three, size in ((motions[:3], angle), (motions[3:], shift)):
                    changes = [(left * (self._ad(motion) * carried)).entries() for motion in three]
                    for place, change in enumerate(zip(*changes, strict=True)):
                        total[place] += size * _norm(list(change))
        return f.arb_mat(rank, rank, [_ball(f.arb, f.arb(0), x) for x in total])

    def _from_link_point(self, point: Array) -> list[Interval]:
        """A point [m], seen from the link's point, lengths scaled."""
        return [(self._f.arb(float(x)) - p) / self._length for x, p in zip(point, self._point, strict=True)]

    def _displaced_joints(
        self, side: list[int], sign: int, points: list[list[Interval]], shift: Interval, angle: Interval, over: Seen,
        weights: list[Matrix], region: Region, moves: int,
    ) -> Iterator[tuple[list[list[Interval]], Matrix]]:  # fmt: skip
        """For each joint that may be displaced: six unit motions at its point, and Σ of the columns it carries.

        The joint before the link is fixed in it; on that side a joint carries those before it, not itself.
        """
        f = self._f
        zero = f.arb(0)
        reach = self._reach(side, sign, points, region)
        grown = []
        for place, i in enumerate(side):
            times = place + 1 if sign > 0 else place
            if self.links[i].kind == SLIDE:
                wide = [times * angle / self._length] * 3 + [zero] * 3
            else:
                around = reach[place] + (times + moves) * shift + self._foot(i, points[i]) + self._pitch(i)
                wide = [times * (shift + angle * around) + moves * shift] * 3 + [times * angle] * 3
            grown.append(over[0][i] + f.arb_mat(6, 1, [_ball(f.arb, zero, x) for x in wide]))
        for place, i in enumerate(side):
            beyond = range(place if sign > 0 else place + 1, len(side))
            if not len(beyond):
                continue
            carried = _sum([grown[k] * weights[side[k]] for k in beyond])
            slack = place * (shift + angle * (reach[place] + (place + moves) * shift)) + moves * shift
            motion = over[1][i]
            if sign < 0 and self.links[i].kind != TURN:  # its point stands before it
                driver = self.links[i].driver
                own = self._motion(i, region.centre[driver], region.half[driver], sign)
                motion = own if motion is None else motion * own
            yield self._motions_at(points[i], motion, slack + 2 * self._foot(i, points[i])), carried
        if moves and side:
            every = _sum([grown[k] * weights[side[k]] for k in range(len(side))])
            yield [[zero] * 6] * 3 + self.unit().tolist()[:3], every

    def _reach(self, side: list[int], sign: int, points: list[list[Interval]], region: Region) -> list[Interval]:
        """How far the point of each joint of a side can be from the link's point, along the polygon of the points."""
        reach, at, total = [], [self._f.arb(0)] * 3, self._f.arb(0)
        for i in side:
            out = self._travel(i, region)
            total += _norm([x - y for x, y in zip(points[i], at, strict=True)])
            reach.append(total if sign > 0 else total + out)
            at, total = points[i], total + out
        return reach

    def _travel(self, i: int, region: Region) -> Interval:
        """How far a joint carries along its axis, in lengths."""
        link = self.links[i]
        value = link.multiplier * _ball(self._f.arb, region.centre[link.driver], region.half[link.driver]) + link.offset
        if link.kind == SLIDE:
            return value.abs_upper() / self._length
        return value.abs_upper() * self._pitch(i)

    def _pitch(self, i: int) -> Interval:
        """Of a joint that screws, in lengths for a radian; else 0."""
        if self.links[i].kind != SCREW:
            return self._f.arb(0)
        return dot(self._screws[i][3:], self._screws[i][:3]).abs_upper()

    def _motions_at(self, point: list[Interval], motion: Matrix | None, slack: Interval) -> list[list[Interval]]:
        """Unit turns about a point that was moved, and unit moves, each six intervals."""
        f = self._f
        zero, unit = f.arb(0), f.arb(1)
        motions = []
        for k in range(6):
            axis = [unit if r == k % 3 else zero for r in range(3)]
            twist = f.arb_mat(6, 1, cross(point, axis) + axis if k < 3 else axis + [zero] * 3)
            seen = (twist if motion is None else motion * twist).entries()
            wide = _ball(f.arb, zero, slack)
            motions.append([x + wide for x in seen[:3]] + seen[3:] if k < 3 else seen)
        return motions

    def _foot(self, i: int, point: list[Interval]) -> Interval:
        """How far the axis of a joint is from its point: 0 but for rounding."""
        if self.links[i].kind == SLIDE:
            return self._f.arb(0)
        screw = self._screws[i]
        moment = cross(point, screw[3:])
        if self.links[i].kind == SCREW:
            along = dot(screw[3:], screw[:3])
        else:
            along = self._f.arb(0)
        return _norm([x - y - along * z for x, y, z in zip(screw[:3], moment, screw[3:], strict=True)])


def regular(rows: list[list[Interval]], rank: int) -> bool:
    """Is every matrix in a matrix of intervals regular: does its comparison matrix keep some vector positive?

    The doubles that bound the entries are rounded to the safe side; the vector is multiplied out.
    """
    matrix = np.empty((rank, rank))
    for r in range(rank):
        for c in range(rank):
            value = rows[r][c]
            if r == c:
                matrix[r, c] = float(value.abs_lower()) * (1 - 1e-15)
            else:
                matrix[r, c] = -float(value.abs_upper()) * (1 + 1e-15) - 1e-300
    if not np.isfinite(matrix).all():
        return False
    try:
        vector = np.linalg.solve(matrix, np.ones(rank))
    except np.linalg.LinAlgError:
        return False
    if not ((vector > 0.0) & np.isfinite(vector)).all():
        return False
    return bool((matrix @ vector > _LEAST * (np.abs(matrix) @ vector)).all())


def _half_widths(region: Region) -> list[Interval]:
    """Half of the width of a region in each variable, with the way along which it is swept."""
    if region.along is None:
        return list(region.half)
    return [half + abs(way) for half, way in zip(region.half, region.along, strict=True)]


def _ball(arb: Any, middle: Interval, half: Interval) -> Interval:
    """The interval middle ± half, of intervals."""
    return middle + arb(0, half.abs_upper())


def _sine_cosine(arb: Any, middle: Interval, half: Interval) -> tuple[Interval, Interval]:
    """Sine and cosine of middle ± half, tight for half up to a quarter turn: by the sums of angles."""
    if half.is_zero():
        sine, cosine = middle.sin_cos()
        return sine, cosine
    if not half < 1.5:
        return arb(0, 1), arb(0, 1)
    s, c = middle.sin_cos()
    low, most = half.cos(), half.sin()
    cosine = _ball(arb, (1 + low) / 2, (1 - low) / 2)
    sine = _ball(arb, arb(0), most)
    return s * cosine + c * sine, c * cosine - s * sine


def _sum(parts: Iterable[Matrix]) -> Matrix:
    total = None
    for part in parts:
        total = part if total is None else total + part
    return total


def dot(a: list[Interval], b: list[Interval]) -> Interval:
    """Inner product of three numbers."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _norm(a: list[Interval]) -> Interval:
    total = a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
    return total.nonnegative_part().sqrt()


def cross(a: list[Interval], b: list[Interval]) -> list[Interval]:
    """Cross product of three numbers."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
