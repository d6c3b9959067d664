"""Boxes of an arm of as many turning joints as rows, proven free all at once: the determinant in Bernstein form.

Seen from link c, joint j turns the k_j columns beyond it, so that det J is a trigonometric polynomial of degree
d_j = min(k_j, 2) in q_j: turned together, columns have no higher waves than two. It is known by its values at
Π (2 d_j + 1) configurations, which are computed in interval arithmetic, and its coefficients G by the discrete Fourier
transform of these, in intervals as well.

Over a box with centre c and half-widths h, with τ_j = tan(δ_j/2), f(c + δ) Π (1 + τ_j²)^d_j is a polynomial of degree
2 d_j in each τ_j, and lies between the least and the largest of its coefficients in Bernstein form over the τ_j of the
box. These are (B_1 ⊗ … ⊗ B_d) G, where B_j depends on the j-th side of the box alone: its 2^level matrices are made in
intervals and rounded once. Only the products are made in double precision, many boxes at a time, and what they lose is
bounded beforehand: a sum of n products loses at most n u / (1 − n u) of the sum of their sizes, u = 2^-53, in whatever
order it is added up, with fused operations or without (Higham, Accuracy and Stability of Numerical Algorithms, 3.1).
"""

from __future__ import annotations

from itertools import product
from math import comb, prod

import numpy as np
from numpy.typing import NDArray

from rankdrop.proof.arm import Arm, Interval, Matrix, flint
from rankdrop.proof.record import TURN, Array, Unproven

_U = 2.0**-53
_WIDEST = 3.0  # half-widths of boxes, at most: tan(h/2) is finite [rad]
_TRIED = 8  # configurations at which the polynomial is held against the determinant
_DEGREE = 2
_HALVINGS, _PARTS = 4, 1 << 18  # of boxes that are not proven free whole: along every variable, and of all of them
_MOST = 1 << 22  # numbers of a table made at one go
_FINEST = 14  # halvings of a range, at most: a table holds every part of it


def applies(arm: Arm, rows: list[int], rank: int) -> bool:
    """Is its determinant a trigonometric polynomial: turning joints, each for itself, as many as rows?"""
    alone = all(link.kind == TURN and (link.multiplier, link.offset) == (1.0, 0.0) for link in arm.links)
    return alone and len(arm.links) == arm.variables == len(rows) == rank


class Determinant:
    """The determinant of an arm over boxes of a range that is halved again and again.

    Args:
        arm, rows: an arm to which this applies, and its rows.
        places: the variables that the boxes bound; all that decide are among them.
        lower, upper: ends of their ranges [rad].
        wider: each box is taken wider by this, on every side [rad].
    """

    def __init__(
        self, arm: Arm, rows: list[int], places: list[int], lower: tuple[float, ...], upper: tuple[float, ...],
        wider: float,
    ) -> None:  # fmt: skip
        self._f, self._places = flint(), places
        self._lower, self._upper, self._wider = lower, upper, wider
        self._degrees = [_degree(arm, place) for place in places]
        self._cut = len(places) // 2
        coefficients = _coefficients(arm, rows, places, self._degrees)
        _check(arm, rows, places, self._degrees, coefficients)
        shape = (prod(2 * d + 1 for d in self._degrees[: self._cut]), -1)
        self._g = np.array([float(x.mid()) for x in coefficients]).reshape(shape)
        self._error = max(_upper_size(x, float(x.mid())) for x in coefficients)  # of one coefficient
        self._sides: dict[tuple[int, int], tuple[Array, float]] = {}

    def free(self, levels: list[int], cells: NDArray[np.int64]) -> NDArray[np.bool_]:
        """(M,) which boxes (M, d) are proven to hold no zero, whole or in parts; False where it is not proven.

        Args:
            levels: how often the range of each variable was halved.
            cells: which of the 2^level equal parts.
        """
        proven = self._prove_whole_boxes(levels, cells)
        owner = np.flatnonzero(~proven)
        parts, corners = cells[owner], np.array(list(product((0, 1), repeat=cells.shape[1])))
        for halvings in range(1, _HALVINGS + 1):
            if not len(parts) or len(parts) << cells.shape[1] > _PARTS:
                break
            parts = (parts[:, None, :] * 2 + corners).reshape(-1, cells.shape[1])
            left = ~self._prove_whole_boxes([level + halvings for level in levels], parts)
            parts, owner = parts[left], np.repeat(owner, len(corners))[left]
        proven[:] = True
        proven[owner] = False
        return proven

    def _prove_whole_boxes(self, levels: list[int], cells: NDArray[np.int64]) -> NDArray[np.bool_]:
        if not len(cells) or max(levels) > _FINEST:
            return np.zeros(len(cells), dtype=np.bool_)
        if not all(self._half(j, level) < _WIDEST for j, level in enumerate(levels)):
            return np.zeros(len(cells), dtype=np.bool_)
        least, most, lost = self.bounds(levels, cells)
        return np.asarray((least > lost) | (most < -lost))

    def bounds(self, levels: list[int], cells: NDArray[np.int64]) -> tuple[Array, Array, float]:
        """(M,) least and (M,) largest Bernstein coefficient of boxes, and by how much each may be off.

        f(c + δ) Π (1 + tan²(δ_j/2))^d_j lies between them all over a box.
        """
        least, most = np.empty(len(cells)), np.empty(len(cells))
        sides = [self._side(j, level) for j, level in enumerate(levels)]
        cut = self._cut
        lost = self._lost(sides[:cut], sides[cut:])
        near, far = _numbers(cells[:, :cut], levels[:cut]), _numbers(cells[:, cut:], levels[cut:])
        order = np.argsort(near, kind="stable")
        first, begin = np.unique(near[order], return_index=True)
        left = _products(sides[:cut], first, levels[:cut]) @ self._g  # (U, a, b)
        second, at = np.unique(far[order], return_inverse=True)
        right = _products(sides[cut:], second, levels[cut:])  # (V, b, b)
        size = right.shape[1]
        step = max(1, _MOST // (size * left.shape[1]))
        for number, (start, end) in enumerate(zip(begin, [*begin[1:], len(cells)], strict=True)):
            for low in range(start, end, step):
                part = slice(low, min(low + step, end))
                taken = right[at[part]]
                values = (taken.reshape(-1, size) @ left[number].T).reshape(len(taken), -1)
                least[order[part]], most[order[part]] = values.min(axis=1), values.max(axis=1)
        return least, most, lost

    def _half(self, j: int, level: int) -> float:
        return float(self._width(j, level).upper())

    def _width(self, j: int, level: int) -> Interval:
        f = self._f
        return (f.arb(self._upper[j]) - f.arb(self._lower[j])) / 2 ** (level + 1) + self._wider

    def _side(self, j: int, level: int) -> tuple[Array, float]:
        """(2^level, n, n) B_j of every side of a level, and by how much an entry may be off."""
        if (j, level) not in self._sides:
            f, degree = self._f, self._degrees[j]
            low, high = f.arb(self._lower[j]), f.arb(self._upper[j])
            form = _bernstein(degree, (self._width(j, level) / 2).tan())
            size, off = 2 * degree + 1, 0.0
            made = np.empty((1 << level, size, size))
            for cell in range(1 << level):
                centre = low + (high - low) * (2 * cell + 1) / 2 ** (level + 1)
                entries = (form * _shifted_waves(degree, centre)).entries()
                rounded = [float(x.mid()) for x in entries]
                made[cell] = np.reshape(rounded, (size, size))
                off = max(off, *(_upper_size(x, y) for x, y in zip(entries, rounded, strict=True)))
            self._sides[j, level] = made, off
        return self._sides[j, level]

    def _lost(self, near: list[tuple[Array, float]], far: list[tuple[Array, float]]) -> float:
        """By how much a coefficient of the Bernstein form may be off, at most.

        With α, β the largest sums of sizes in a row of both products of B_j, and g the largest size in G, it is at most
        α g β; each of the three is off by a share, and the two products lose theirs.
        """
        size, share = 1.0, 2 * self._error / float(np.abs(self._g).max())
        for made, off in [*near, *far]:
            row = float(np.abs(made).sum(axis=2).max())
            size *= row * (1 + 1e-12)
            share += 2 * made.shape[2] * off / row + 2 * _U
        count = self._g.shape[0] + self._g.shape[1]
        return (share + 2 * (count + 20) * _U) * size * float(np.abs(self._g).max()) + 1e-300


def _upper_size(x: Interval, rounded: float) -> float:
    return float((x - rounded).abs_upper()) * (1 + 1e-15)


def _degree(arm: Arm, place: int) -> int:
    """Waves of q_j in the determinant, at most: how many columns the joint turns, but never more than two."""
    after, before = range(arm.link, len(arm.links)), range(arm.link - 1, -1, -1)
    for side in (after, before):
        for number, i in enumerate(side):
            if arm.links[i].driver == place:
                return min(len(side) - 1 - number, _DEGREE)
    return 0


def _nodes(degree: int) -> list[Interval]:
    """2 d + 1 angles at equal distances; none is a multiple of a right angle, where arms like to be singular."""
    f, count = flint(), 2 * degree + 1
    return [2 * f.arb.pi() * (7 * k + 1) / (7 * count) for k in range(count)]


def _coefficients(arm: Arm, rows: list[int], places: list[int], degrees: list[int]) -> list[Interval]:
    """Coefficients of Π (1, cos, sin, cos 2, sin 2)(q_j), the last variable fastest."""
    f = flint()
    values = []
    for angles in product(*(_nodes(degree) for degree in degrees)):
        q = [f.arb(0)] * arm.variables
        for place, angle in zip(places, angles, strict=True):
            q[place] = angle
        values.append(arm.determinant(q, rows))
    for degree in degrees:  # one variable after the other: it goes from the front to the back
        size = 2 * degree + 1
        table = f.arb_mat(size, len(values) // size, values)
        waves = f.arb_mat([_waves(x, degree, 0.5) for x in _nodes(degree)]) * (f.arb(2) / size)
        values = (table.transpose() * waves).entries()
    return list(values)


def _waves(x: Interval, degree: int, first: float = 1.0) -> list[Interval]:
    """1, cos, sin, cos 2, sin 2 of an angle; `first` in place of 1."""
    waves = [flint().arb(first)]
    for k in range(1, degree + 1):
        sine, cosine = (k * x).sin_cos()
        waves += [cosine, sine]
    return waves


def _check(arm: Arm, rows: list[int], places: list[int], degrees: list[int], coefficients: list[Interval]) -> None:
    """The polynomial has the values of the determinant elsewhere too: else it had more waves than were looked for.

    Raises:
        Unproven: it has not.
    """
    f = flint()
    for angles in np.random.default_rng(2).uniform(-np.pi, np.pi, (_TRIED, arm.variables)):
        q = [f.arb(float(x)) for x in angles]
        values = coefficients
        for place, degree in zip(places, degrees, strict=True):
            size = 2 * degree + 1
            table = f.arb_mat(size, len(values) // size, values)
            values = (f.arb_mat([_waves(q[place], degree)]) * table).entries()
        if not values[0].overlaps(arm.determinant(q, rows)):
            raise Unproven("the determinant of this arm is no trigonometric polynomial of the degree looked for")


def _shifted_waves(degree: int, centre: Interval) -> Matrix:
    """(n, n) coefficients in the waves of x − c, from those in the waves of x."""
    f, size = flint(), 2 * degree + 1
    shifted = f.arb_mat(size, size, [0] * (size * size))
    shifted[0, 0] = f.arb(1)
    for k in range(1, degree + 1):
        sine, cosine = (k * centre).sin_cos()
        c, s = 2 * k - 1, 2 * k
        shifted[c, c], shifted[c, s], shifted[s, c], shifted[s, s] = cosine, sine, -sine, cosine
    return shifted


def _bernstein(degree: int, most: Interval) -> Matrix:
    """(n, n) Bernstein coefficients over |τ| ≤ most of the waves times (1 + τ²)^d, τ = tan(x/2).

    The coefficient number i of τ^p is the mean of the products of p out of 2 d numbers of which i are `most`, the
    others −`most`.
    """
    f, last = flint(), 2 * degree
    shares = f.arb_mat(last + 1, last + 1)
    for i in range(last + 1):
        for p in range(last + 1):
            total = sum(comb(i, k) * comb(last - i, p - k) * (-1) ** (p - k) for k in range(p + 1))
            shares[i, p] = most**p * f.arb(f.fmpq(total, comb(last, p)))
    one, cosine, sine = f.fmpz_poly([1, 0, 1]), f.fmpz_poly([1, 0, -1]), f.fmpz_poly([0, 2])
    waves, c, s = [one**degree], f.fmpz_poly([1]), f.fmpz_poly([0])
    for k in range(1, degree + 1):
        c, s = c * cosine - s * sine, s * cosine + c * sine
        waves += [c * one ** (degree - k), s * one ** (degree - k)]
    powers = f.arb_mat(last + 1, len(waves))
    for p in range(last + 1):
        for column, wave in enumerate(waves):
            powers[p, column] = f.arb(int(wave[p]))
    return shares * powers


def _numbers(cells: NDArray[np.int64], levels: list[int]) -> NDArray[np.int64]:
    """(M,) boxes of some variables by number, the first slowest."""
    numbers = np.zeros(len(cells), dtype=np.int64)
    for cell, level in zip(cells.T, levels, strict=True):
        numbers = (numbers << level) + cell
    return numbers


def _products(sides: list[tuple[Array, float]], numbers: NDArray[np.int64], levels: list[int]) -> Array:
    """(U, a, a) Kronecker products of the matrices of boxes, by their numbers."""
    products = np.ones((len(numbers), 1, 1))
    if levels:
        cells = np.unravel_index(numbers, [1 << level for level in levels])
    else:
        cells = ()
    for (side, _), cell in zip(sides, cells, strict=True):
        matrices = side[cell]
        size = products.shape[1] * matrices.shape[1]
        products = np.einsum("nij,nkl->nikjl", products, matrices).reshape(len(numbers), size, size)
    return products
