"""The determinant of an arm of six turning joints as a dot product of two vectors of six minors.

Seen from the link between joints 3 and 4, columns 3 and 4 of the Jacobian are constant, columns 1 and 2 depend on q2
and q3 alone, columns 5 and 6 on q4 and q5. Modulo columns 3 and 4 there is left, by Laplace's expansion,

    det J = constant · det₄[S1 S2 S5 S6] = constant · Σ_t a_t(q2, q3) b_t(q4, q5),   t over the six pairs of four rows,

a_t the 2 × 2 minors of S1, S2, b_t the complementary ones of S5, S6 with their signs. Each is a trigonometric
polynomial of degree 1 in the outer variable and 2 in the inner one; its coefficients are computed in rational numbers
from the screws and rounded once.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations
from math import cos, frexp, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rankdrop.cover.setting import middle_of
from rankdrop.robot.arm_reach import nearest
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

_PAIRS = np.array(list(combinations(range(4), 2)))
_OTHERS = _PAIRS[::-1]  # pair t and other t are the four rows
_SIGNS = np.array([1, -1, 1, 1, -1, 1])  # of the permutation (pair, other)
_DEGREES = (1, 2)  # of a in (q2, q3), of b in (q5, q4)

_Exact = NDArray[Any]
"""Of `Fraction`s, dtype object."""


def split_of(robot: Robot) -> dict[str, Any]:
    """The split determinant of an arm of six turning joints without mimics: f = Σ_t a_t(q2, q3) b_t(q4, q5).

    The curvature is bounded by values on a grid: a trigonometric polynomial of degree d is, within π/N of its largest
    absolute value M, at least M cos(dπ/N) (M. Riesz), one variable after the other.

    Returns:
        a, b: (6, 15) coefficients of (1, cos, sin)(outer) ⊗ (1, cos, sin, cos 2, sin 2)(inner); outer: q2, q5, inner:
            q3, q4. curvature: (4, 4) bounds of |∂²f/∂q_j∂q_k| over all configurations, j and k from q2 to q5.
            rounding: |f computed − f| at most. slope: |∂f/∂q_j computed − ∂f/∂q_j| at most.
    """
    a, b = _coefficients(robot)
    rounding = ROUNDING * float((np.abs(a).sum(axis=1) * np.abs(b).sum(axis=1)).sum())
    slope = 4 * rounding  # waves of degree 2 have slope 2
    return {"a": a, "b": b, "curvature": _curvature(a, b), "rounding": rounding, "slope": slope}


def _coefficients(robot: Robot) -> tuple[Array, Array]:
    fourth = robot.joints[3]
    origin = _exact(nearest((fourth.axis, fourth.foot), middle_of(robot)))  # coordinates of the arm's own size
    s1, s2, s3, s4, s5, s6 = (_screw(joint.screw, origin) for joint in robot.joints)
    quotient = _quotient(s3, s4)

    def minors(turned: _Exact, other: _Exact, about: _Exact, sign: int, pairs: _Exact) -> _Exact:
        """(6, 15) minors of a column (3, 6) turned by its outer variable and another (6,), both about an inner axis."""
        first, second = (_adjoint_coefficients(column, about, sign) @ quotient.T for column in (turned, other))
        return _minors(first, second, pairs)

    a = minors(_adjoint_coefficients(s1, s2, -1), s2, s3, -1, _PAIRS)
    b = -minors(_adjoint_coefficients(s6, s5, 1), s5, s4, 1, _OTHERS)  # columns 5 and 6 change places
    return _to_doubles(a), _to_doubles(b * _SIGNS[:, None])


def _exact(numbers: Array) -> _Exact:
    return np.array([Fraction(float(x)) for x in numbers], dtype=object)


def _screw(numbers: Array, point: _Exact) -> _Exact:
    """(6,) the screw about a point in rational numbers, without what rounding left of a pitch."""
    screw = _exact(numbers)
    v, w = screw[:3], screw[3:]
    return np.concatenate([v - v @ w / (w @ w) * w + np.cross(w, point), w])


def _adjoint_coefficients(screws: _Exact, axis: _Exact, sign: int) -> _Exact:
    """(…, 3, 6) coefficients of 1, cos q, sin q of Ad(exp(± axis q)) screws (…, 6), 1 + sin q ad + (1 − cos q) ad²."""
    v, w = axis[:3], axis[3:]

    def bracket(x: _Exact) -> _Exact:
        return np.concatenate([np.cross(w, x[..., :3]) + np.cross(v, x[..., 3:]), np.cross(w, x[..., 3:])], axis=-1)

    once = bracket(screws)
    twice = bracket(once)
    return np.stack([screws + twice, -twice, sign * once], axis=-2)


def _quotient(x: _Exact, y: _Exact) -> _Exact:
    """(4, 6) four combinations of rows that vanish on both columns: each row less multiples of two pivots."""

    def minor(p: int, q: int) -> Any:
        return x[p] * y[q] - x[q] * y[p]

    p, q = max(combinations(range(6), 2), key=lambda pair: (abs(minor(*pair)), -pair[0], -pair[1]))
    rest = [row for row in range(6) if row not in (p, q)]
    quotient = np.array([[Fraction(int(row == column)) for column in range(6)] for row in rest])
    quotient[:, p] = [-minor(row, q) / minor(p, q) for row in rest]
    quotient[:, q] = [-minor(p, row) / minor(p, q) for row in rest]
    return quotient


def _products() -> _Exact:
    """(3, 3, 5) products of two of 1, cos, sin as sums of 1, cos, sin, cos 2, sin 2."""
    products, half = np.full((3, 3, 5), Fraction(0)), Fraction(1, 2)
    for wave in range(3):
        products[0, wave, wave] = products[wave, 0, wave] = Fraction(1)
    products[1, 1, [0, 3]] = half
    products[2, 2, [0, 3]] = half, -half
    products[1, 2, 4] = products[2, 1, 4] = half
    return products


def _minors(x: _Exact, y: _Exact, pairs: _Exact) -> _Exact:
    """(6, 15) minors x_i y_j − x_j y_i of x (3, 3, 4), by outer and inner wave, and y (3, 4), by inner wave."""
    both = np.tensordot(np.tensordot(x, _products(), (1, 0)), y, (2, 0))  # (outer, i, wave, j)
    i, j = pairs.T
    minors = both[:, i, :, j] - both[:, j, :, i]  # (pair, outer, wave)
    return np.asarray(minors.reshape(len(pairs), 15))


def _to_doubles(values: _Exact) -> Array:
    """As doubles of size one, divided by a power of two: no digit depends on the unit of length."""
    power = Fraction(2) ** frexp(float(abs(values).max()))[1]
    return np.asarray(values / power, dtype=np.float64)


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
    curvature = np.zeros((VARIABLES, VARIABLES))
    for j in range(VARIABLES):
        for k in range(j, VARIABLES):
            order = np.bincount([j, k], minlength=VARIABLES)
            left = _sums(a, outer, inner, int(order[0]), int(order[1]))
            right = _sums(b, outer, inner, int(order[3]), int(order[2]))
            curvature[j, k] = curvature[k, j] = _upwards(float(np.abs(left @ right.T).max()) / short)
    return curvature


def _upwards(value: float) -> float:
    """A little more, in few digits: what the linear algebra of another machine rounds otherwise is lost in it."""
    if value == 0.0:
        return 0.0
    fraction, exponent = frexp(value * (1 + 1e-9))
    return float(np.ldexp(np.ceil(fraction * 2**20) / 2**20, exponent))
