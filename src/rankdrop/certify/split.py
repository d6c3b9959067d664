"""The determinant of an arm of six turning joints as a dot product of two vectors of six minors.

Seen from the link between joints 3 and 4, columns 3 and 4 of the Jacobian are constant, columns 1 and 2 depend on q2
and q3 alone, columns 5 and 6 on q4 and q5. Modulo columns 3 and 4 there is left, by Laplace's expansion,

    det J = constant · det₄[S1 S2 S5 S6] = constant · Σ_t a_t(q2, q3) b_t(q4, q5),   t over the six pairs of four rows,

a_t the 2 × 2 minors of S1, S2, b_t the complementary ones of S5, S6 with their signs. Each is a trigonometric
polynomial of degree 1 in the outer variable and 2 in the inner one; its coefficients are computed in rational numbers
from the screws and rounded once.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from math import cos, frexp, pi

import numpy as np

from rankdrop.certify.setting import middle_of
from rankdrop.robot.model import Array, Robot

VARIABLES = 4
"""q2 … q5 decide; q1 and q6 drop out."""
GRID = 32
"""Points of a turn at which second derivatives are looked at; cos(π/32)² cos(2π/32)² = 0.953."""
ROUNDING = 1e-13
"""Share of Σ_t (Σ|a_t|)(Σ|b_t|) that f may lose to rounding.

A product of two waves (1, cos, sin, cos 2, sin 2), each right to 4 roundings of 1.1e-16, has 9, a sum of three rows of
five of them 8 more, and the sum of six products of two such sums 7 more: 41 roundings, 4.6e-15. Bernstein coefficients
have thrice as many, and axes are unit vectors to a few. This is some seven times that.
"""

_PAIRS = tuple(combinations(range(4), 2))
_OTHERS = tuple(tuple(sorted({0, 1, 2, 3} - set(pair))) for pair in _PAIRS)
_SIGNS = (1, -1, 1, 1, -1, 1)  # of the permutation (pair, other)
_DEGREES = (1, 2)  # of a in (q2, q3), of b in (q5, q4)

_Vector = Array
"""Of `Fraction`s, dtype object."""
_Wave = dict[tuple[int, int], Fraction]
"""Coefficients of (1, cos, sin)(outer) · (1, cos, sin)(inner), by their two numbers."""


@dataclass(frozen=True, eq=False)
class Split:
    """f = Σ_t a_t(q2, q3) b_t(q4, q5), proportional to the determinant of the Jacobian.

    Attributes:
        a, b: (6, 15) coefficients of (1, cos, sin)(outer) ⊗ (1, cos, sin, cos 2, sin 2)(inner); outer: q2, q5, inner:
            q3, q4.
        curvature: (4, 4) bounds of |∂²f/∂q_j∂q_k| over all configurations, j and k from q2 to q5.
        rounding: |f computed − f| at most.
        slope: |∂f/∂q_j computed − ∂f/∂q_j| at most.
    """

    a: Array
    b: Array
    curvature: Array
    rounding: float
    slope: float

    def value(self, q: Array) -> Array:
        """(N,) f at q (N, 4), q2 … q5."""
        return np.asarray(np.einsum("nt,nt->n", *self.minors(q, (0, 0, 0, 0))))

    def minors(self, q: Array, order: tuple[int, int, int, int]) -> tuple[Array, Array]:
        """(N, 6) derivatives of a and of b of the given order by each variable, at q (N, 4)."""
        a = _sums(self.a, q[:, 0], q[:, 1], order[0], order[1])
        return a, _sums(self.b, q[:, 3], q[:, 2], order[3], order[2])


def split_of(robot: Robot) -> Split:
    """The split determinant of an arm of six turning joints without mimics.

    The curvature is bounded by values on a grid: a trigonometric polynomial of degree d is, within π/N of its largest
    absolute value M, at least M cos(dπ/N) (M. Riesz), one variable after the other.
    """
    a, b = _coefficients(robot)
    size = float((np.abs(a).sum(axis=1) * np.abs(b).sum(axis=1)).sum())
    return Split(a, b, _curvature(a, b), ROUNDING * size, 4 * ROUNDING * size)  # waves of degree 2 have slope 2


def _coefficients(robot: Robot) -> tuple[Array, Array]:
    screws = [_screw(joint.screw) for joint in robot.joints]
    origin = _near_axes(robot)
    screws = [_at(screw, origin) for screw in screws]
    chosen, rest = _pivots(screws[2], screws[3])
    first = _turned(screws[0], outer=(screws[1], -1), inner=(screws[2], -1))
    second = _turned(screws[1], outer=None, inner=(screws[2], -1))
    fifth = _turned(screws[4], outer=None, inner=(screws[3], 1))
    sixth = _turned(screws[5], outer=(screws[4], 1), inner=(screws[3], 1))
    modulo = _modulo(screws[2], screws[3], chosen, rest)
    a = [_minor(_quotient(first, modulo), _quotient(second, modulo), pair) for pair in _PAIRS]
    pairs = zip(_OTHERS, _SIGNS, strict=True)
    b = [[sign * value for value in _minor(_quotient(fifth, modulo), _quotient(sixth, modulo), pair)]
         for pair, sign in pairs]  # fmt: skip
    return _rounded(a), _rounded(b)


def _screw(numbers: Array) -> _Vector:
    """The screw in rational numbers, without what rounding left of a pitch."""
    screw = _exact(numbers)
    v, w = screw[:3], screw[3:]
    return np.concatenate([v - v @ w / (w @ w) * w, w])


def _exact(numbers: Array) -> _Vector:
    return np.array([Fraction(float(x)) for x in numbers], dtype=object)


def _near_axes(robot: Robot) -> _Vector:
    """The point of axis 4 nearest to the middle of the arm: coordinates of the arm's own size, wherever its base is."""
    v, w = robot.joints[3].screw[:3], robot.joints[3].screw[3:]
    foot = np.cross(w, v)
    return _exact(foot + w * (w @ (middle_of(robot) - foot)))


def _at(screw: _Vector, point: _Vector) -> _Vector:
    return np.concatenate([screw[:3] + np.cross(screw[3:], point), screw[3:]])


def _bracket(x: _Vector, y: _Vector) -> _Vector:
    return np.concatenate([np.cross(x[3:], y[:3]) + np.cross(x[:3], y[3:]), np.cross(x[3:], y[3:])])


def _turned(
    screw: _Vector, *, outer: tuple[_Vector, int] | None, inner: tuple[_Vector, int]
) -> list[_Wave]:
    """Six waves: Ad(exp(± inner)) Ad(exp(± outer)) screw, Ad(exp(S q)) = 1 + sin q ad + (1 − cos q) ad²."""
    parts: dict[tuple[int, int], _Vector] = {(0, 0): screw}
    for place, by in ((0, outer), (1, inner)):
        if by is None:
            continue
        axis, sign = by
        found: dict[tuple[int, int], _Vector] = {}
        for number, vector in parts.items():
            once = _bracket(axis, vector)
            twice = _bracket(axis, once)
            for wave, change in enumerate((vector + twice, -twice, sign * once)):
                found[(wave, number[1]) if place == 0 else (number[0], wave)] = change
        parts = found
    return [{key: vector[row] for key, vector in parts.items() if vector[row]} for row in range(6)]


def _pivots(x: _Vector, y: _Vector) -> tuple[tuple[int, int], tuple[int, ...]]:
    """The two rows whose minor of x, y is largest, and the four others."""
    chosen = max(combinations(range(6), 2), key=lambda p: (abs(x[p[0]] * y[p[1]] - x[p[1]] * y[p[0]]), -p[0], -p[1]))
    return chosen, tuple(row for row in range(6) if row not in chosen)


def _modulo(
    x: _Vector, y: _Vector, chosen: tuple[int, int], rest: tuple[int, ...]
) -> list[tuple[int, list[tuple[int, Fraction]]]]:
    """(row, [(chosen row, factor)]) for each of the four rows: row − Σ factor · chosen vanishes on x and y."""
    p, q = chosen
    minor = x[p] * y[q] - x[q] * y[p]
    found = []
    for row in rest:
        first = (x[row] * y[q] - x[q] * y[row]) / minor
        second = (x[p] * y[row] - x[row] * y[p]) / minor
        found.append((row, [(p, first), (q, second)]))
    return found


def _quotient(column: list[_Wave], modulo: list[tuple[int, list[tuple[int, Fraction]]]]) -> list[_Wave]:
    found = []
    for row, less in modulo:
        wave = dict(column[row])
        for other, factor in less:
            for key, value in column[other].items():
                wave[key] = wave.get(key, Fraction(0)) - factor * value
        found.append(wave)
    return found


def _minor(x: list[_Wave], y: list[_Wave], pair: tuple[int, ...]) -> list[Fraction]:
    """(15,) x_i y_j − x_j y_i; only one of the two depends on the outer variable."""
    total = [Fraction(0)] * 15
    for sign, i, j in ((1, *pair), (-1, pair[1], pair[0])):
        for (outer, inner), value in x[i].items():
            for (other, second), factor in y[j].items():
                for wave, share in _product(inner, second):
                    total[(outer or other) * 5 + wave] += sign * value * factor * share
    return total


def _product(x: int, y: int) -> tuple[tuple[int, Fraction], ...]:
    """Products of 1, cos, sin as sums of 1, cos, sin, cos 2, sin 2."""
    half = Fraction(1, 2)
    if x == 0 or y == 0:
        return ((x + y, Fraction(1)),)
    if x != y:
        return ((4, half),)
    return ((0, half), (3, half if x == 1 else -half))


def _rounded(rows: list[list[Fraction]]) -> Array:
    """As doubles of size one, divided by a power of two: no digit depends on the unit of length."""
    largest = max(abs(value) for row in rows for value in row)
    power = Fraction(2) ** frexp(float(largest))[1]
    return np.array([[float(value / power) for value in row] for row in rows])


def _waves(x: Array, count: int, order: int) -> Array:
    """(N, count) derivatives of order `order` of 1, cos, sin, cos 2, sin 2."""
    turn = order * pi / 2
    rows = [np.ones_like(x) if order == 0 else np.zeros_like(x)]
    for multiple in (1, 2):
        rows += [multiple**order * np.cos(multiple * x + turn), multiple**order * np.sin(multiple * x + turn)]
    return np.stack(rows[:count], axis=-1)


def _sums(coefficients: Array, outer: Array, inner: Array, first: int, second: int) -> Array:
    both = _waves(outer, 3, first)[:, :, None] * _waves(inner, 5, second)[:, None, :]
    return np.asarray(both.reshape(len(outer), 15) @ coefficients.T)


def _curvature(a: Array, b: Array) -> Array:
    """(4, 4) bounds of the second derivatives of f over the whole torus."""
    step = np.arange(GRID) * (2 * pi / GRID)
    outer, inner = (x.reshape(-1) for x in np.meshgrid(step, step, indexing="ij"))
    short = (cos(_DEGREES[0] * pi / GRID) * cos(_DEGREES[1] * pi / GRID)) ** 2
    found = np.zeros((VARIABLES, VARIABLES))
    for j in range(VARIABLES):
        for k in range(j, VARIABLES):
            order = np.bincount([j, k], minlength=VARIABLES)
            left = _sums(a, outer, inner, int(order[0]), int(order[1]))
            right = _sums(b, outer, inner, int(order[3]), int(order[2]))
            found[j, k] = found[k, j] = _upwards(float(np.abs(left @ right.T).max()) / short)
    return found


def _upwards(value: float) -> float:
    """A little more, in few digits: what the linear algebra of another machine rounds otherwise is lost in it."""
    if value == 0.0:
        return 0.0
    fraction, exponent = frexp(value * (1 + 1e-9))
    return float(np.ldexp(np.ceil(fraction * 2**20) / 2**20, exponent))
