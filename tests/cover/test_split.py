"""The split determinant: it is the determinant, and every bound that boxes are judged by holds and is reached."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from reference import arms
from reference import kinematics as oracle

from rankdrop import _core
from rankdrop.cover.split import VARIABLES, _sums, split_of
from rankdrop.robot.open import open_robot

ARMS = ("ur5", "puma560", "random", "random far")
MIDDLE = [1, 2, 3, 4]


@cache
def robot_of(name: str):
    if not name.startswith("random"):
        return open_robot(name)
    made = arms.random_chain(np.random.default_rng(3), "rrrrrr")
    if name == "random":
        return made
    shift = np.eye(4)
    shift[:3, 3] = [40.0, -70.0, 20.0]
    return arms.remade(made, motion=shift)


@cache
def split_for(name: str):
    return split_of(robot_of(name))


def tables(name: str, lower, upper, depth, top=0, further=0):
    return _core.Split(
        **split_for(name), lower=np.array(lower, float), upper=np.array(upper, float),
        depth=np.array(depth, dtype=np.int32), further=further, top=top,
    )  # fmt: skip


def minors(name: str, q, order=(0, 0, 0, 0)):
    """(N, 6) derivatives of a and of b of the given order by each variable, at q (N, 4)."""
    made = split_for(name)
    a = _sums(made["a"], q[:, 0], q[:, 1], order[0], order[1])
    return a, _sums(made["b"], q[:, 3], q[:, 2], order[3], order[2])


def value_of(name: str, q):
    return derivative(name, q, (0, 0, 0, 0))


def derivative(name: str, q, order):
    a, b = minors(name, q, order)
    return (a * b).sum(axis=1)


def determinant(name: str, q):
    """Of the Jacobian in base coordinates, by the oracle."""
    robot = robot_of(name)
    return np.linalg.det(oracle.screws(robot, oracle.carried(robot, q)).swapaxes(-1, -2))


@pytest.mark.parametrize("name", ARMS)
def test_it_is_the_determinant_up_to_a_constant(name):
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (400, 6))
    det, f = determinant(name, q), value_of(name, q[:, MIDDLE])
    constant = (f @ det) / (det @ det)
    scale = np.abs(f).max()
    assert scale > 0.05  # of size one, whatever the unit of length
    np.testing.assert_allclose(f, constant * det, atol=1e-9 * scale)


@pytest.mark.parametrize("name", ["ur5", "random"])
def test_the_derivatives_of_the_minors_are_theirs(name):
    q, h = np.random.default_rng(1).uniform(-np.pi, np.pi, (50, VARIABLES)), 1e-5
    for j in range(VARIABLES):
        order = tuple(int(k == j) for k in range(VARIABLES))
        step = h * np.eye(VARIABLES)[j]
        slope = (value_of(name, q + step) - value_of(name, q - step)) / (2 * h)
        np.testing.assert_allclose(derivative(name, q, order), slope, atol=1e-9)


@pytest.mark.parametrize("name", ARMS)
def test_every_bound_of_a_second_derivative_holds_and_is_reached(name):
    made, rng = split_for(name), np.random.default_rng(2)
    for j in range(VARIABLES):
        for k in range(j, VARIABLES):
            order = tuple(np.bincount([j, k], minlength=VARIABLES).tolist())
            x = rng.uniform(-np.pi, np.pi, (1500, VARIABLES))
            a, b = minors(name, x, order)
            every = np.abs(a @ b.T)  # any two angles of one minor with any two of the other
            assert every.max() <= made["curvature"][j, k]
            assert every.max() >= 0.9 * made["curvature"][j, k], (j, k)


@pytest.mark.parametrize("name", ["ur5", "puma560", "random"])
@pytest.mark.parametrize("width", [0.4, 0.05])
def test_the_slack_is_the_remainder_and_no_more(name, width):
    # a box wide along one variable, where the curvature along it is greatest: the remainder fills the bound
    made, rng = split_for(name), np.random.default_rng(4)
    reached = []
    for j in range(VARIABLES):
        if made["curvature"][j, j] < 1e-12:  # PUMA's determinant does not depend on q4
            continue
        x = rng.uniform(-np.pi, np.pi, (1000, VARIABLES))
        order = tuple(2 * int(k == j) for k in range(VARIABLES))
        a, b = minors(name, x, order)
        first, second = np.unravel_index(np.abs(a @ b.T).argmax(), (1000, 1000))
        centre = np.concatenate([x[first, :2], x[second, 2:]])
        centre = _sharpest(name, centre, order)
        lower, upper = centre.copy(), centre.copy()
        lower[j] -= width  # halved once: the first leaf has `centre` less half a width in its middle
        upper[j] += width
        lower[j], upper[j] = centre[j] - width / 2, centre[j] + width * 1.5
        split = tables(name, lower, upper, [int(k == j) for k in range(VARIABLES)])
        half, slack, _, _ = _core.split_level(split, 1)
        assert half[j] == pytest.approx(width / 2, rel=1e-9)
        value = value_of(name, centre[None])[0]
        slope = derivative(name, centre[None], tuple(int(k == j) for k in range(VARIABLES)))[0]
        delta = np.linspace(-half[j], half[j], 41)
        at = np.tile(centre, (41, 1))
        at[:, j] += delta
        gap = np.abs(value_of(name, at) - value - slope * delta).max()
        assert gap <= slack
        reached.append(gap / slack)
    assert len(reached) >= 3
    assert min(reached) >= (0.9 if width < 0.1 else 0.85)


def _sharpest(name: str, centre, order):
    """A few steps uphill on |∂²f|, by trying."""
    rng = np.random.default_rng(5)
    best = abs(derivative(name, centre[None], order)[0])
    for size in (0.1, 0.03, 0.01):
        tried = centre + size * rng.standard_normal((400, VARIABLES))
        values = np.abs(derivative(name, tried, order))
        if values.max() > best:
            centre, best = tried[values.argmax()], values.max()
    return centre


@pytest.mark.parametrize("name", ["ur5", "puma560", "random"])
def test_the_slack_of_boxes_wide_in_every_variable_holds(name):
    made, rng = split_for(name), np.random.default_rng(6)
    for width in (1.0, 0.4, 0.05):
        lower = rng.uniform(-np.pi, np.pi, VARIABLES)
        split = tables(name, lower, lower + 2 * width, [1] * VARIABLES)
        half, slack, a, b = _core.split_level(split, 1)
        centre = lower + width / 2
        delta = half * rng.choice([-1.0, 1.0], (200, VARIABLES))
        slopes = [derivative(name, centre[None], tuple(np.eye(VARIABLES, dtype=int)[j]))[0] for j in range(VARIABLES)]
        value = value_of(name, centre[None])[0]
        assert np.abs(value_of(name, centre + delta) - value - delta @ slopes).max() <= slack
        bound = 0.5 * half @ made["curvature"] @ half + made["rounding"] + made["slope"] * half.sum()
        assert slack == pytest.approx(bound, rel=1e-9)
        # the tables hold what the bound speaks of
        a, b = a.reshape(2, 2, 3, 6)[0, 0], b.reshape(1, 1, 3, 6, 4)[0, 0, :, :, 0]
        assert a[0] @ b[0] == pytest.approx(value, abs=made["rounding"])
        for j, pair in enumerate(((1, 0), (2, 0), (0, 1), (0, 2))):
            assert a[pair[0]] @ b[pair[1]] == pytest.approx(slopes[j], abs=made["slope"])


@pytest.mark.parametrize("name", ["ur5", "random far"])
@pytest.mark.parametrize("level", [1, 2, 4])
def test_the_coefficients_of_a_box_hold_f_between_them_and_reach_it(name, level):
    made, rng = split_for(name), np.random.default_rng(7)
    lower = np.full(VARIABLES, -np.pi - 0.1)
    split = tables(name, lower, lower + 2 * np.pi, [4] * VARIABLES)
    half = _core.split_level(split, level)[0]
    powers = np.array([1, 2, 2, 1])  # of 1 + t²
    tight = 0
    for place in rng.integers(0, 1 << level, (20, VARIABLES)).astype(np.int32):
        shape = _core.split_shape(split, level, place)[:, :15]
        centre = lower + (place + 0.5) * 2 * np.pi / (1 << level)
        delta = np.concatenate([rng.uniform(-1, 1, (300, VARIABLES)), rng.choice([-1.0, 1.0], (100, VARIABLES))]) * half
        weight = np.prod(((1 + np.tan(delta / 2) ** 2) / (1 + np.tan(half / 2) ** 2)) ** powers, axis=1)
        seen = value_of(name, centre + delta) * weight
        np.testing.assert_allclose(_polynomial(shape, delta, half), seen, atol=4 * made["rounding"])
        assert shape.min() <= seen.min() + made["rounding"]
        assert seen.max() - made["rounding"] <= shape.max()
        corners = shape[np.ix_([0, 4, 10, 14], [0, 4, 10, 14])]
        signs = np.array([[a, b] for a in (-1, 1) for b in (-1, 1)])
        for row, first in enumerate(signs):  # rows: q2 outer, q3 inner; columns: q5 outer, q4 inner
            for column, second in enumerate(signs):
                corner = centre + half * np.array([first[0], first[1], second[1], second[0]])
                assert corners[row, column] == pytest.approx(value_of(name, corner[None])[0], abs=2 * made["rounding"])
        tight += seen.max() >= 0.9 * shape.max() > 0 or seen.min() <= 0.9 * shape.min() < 0
    assert tight >= 15 or level < 4  # the coefficients close in with the square of the width


def _polynomial(shape, delta, half):
    """(N,) what the coefficients mean: Σ shape[q2 q3, q5 q4] B(q2) B(q3) B(q5) B(q4), B in t = tan(δ/2)."""
    s = (np.tan(delta / 2) / np.tan(half / 2) + 1) / 2

    def basis(j, degree):
        k = np.arange(degree + 1)
        choose = np.array([1, 2, 1] if degree == 2 else [1, 4, 6, 4, 1])
        return choose * s[:, j, None] ** k * (1 - s[:, j, None]) ** (degree - k)

    rows = (basis(0, 2)[:, :, None] * basis(1, 4)[:, None, :]).reshape(-1, 15)
    columns = (basis(3, 2)[:, :, None] * basis(2, 4)[:, None, :]).reshape(-1, 15)
    return np.einsum("nr,rc,nc->n", rows, shape, columns)
