"""The solver, on circles: what it finds is known."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.robot.model import Array
from rankdrop.solve import iterate, newton, shortest, steps_towards, trace

RADIUS = 0.5


def circle(x: Array) -> tuple[Array, Array]:
    """|x|² = ¼ in the plane."""
    return (x**2).sum(axis=1, keepdims=True) - RADIUS**2, 2 * x[:, None]


def unsolved(x: Array) -> tuple[np.ndarray, Array, Array]:
    f, slope = circle(x)
    return np.abs(f).max(axis=1) > 1e-15, f, slope


def test_every_start_ends_on_the_circle_where_its_radius_meets_it(rng: np.random.Generator) -> None:
    starts = rng.normal(size=(50, 2))
    ends = newton(unsolved, starts)
    np.testing.assert_allclose(ends, RADIUS * starts / np.linalg.norm(starts, axis=1, keepdims=True), atol=1e-12)


def test_directions_that_are_not_to_be_used_are_not_used() -> None:
    ends = newton(unsolved, np.array([[0.3, 0.2]]), scale=np.eye(2)[:, [0]])
    np.testing.assert_allclose(ends, [[np.sqrt(0.25 - 0.04), 0.2]], atol=1e-12)


def test_a_scale_says_which_way_is_short() -> None:
    """With x a thousand times as dear as y, y moves."""
    ends = newton(unsolved, np.array([[0.3, 0.2]]), scale=np.array([1e-3, 1.0]))
    np.testing.assert_allclose(ends, [[0.3, 0.4]], atol=1e-5)


def test_no_step_is_longer_than_is_allowed() -> None:
    assert np.linalg.norm(newton(unsolved, np.array([[9.0, 0.0]]), iterations=3, step=0.1)) == pytest.approx(8.7)


def test_no_starts_give_no_ends() -> None:
    assert newton(unsolved, np.empty((0, 2))).shape == (0, 2)


def test_a_curve_is_followed_until_it_closes_and_both_ways_are_the_same_curve() -> None:
    start = np.array([RADIUS, 0.0])
    for sign in (1.0, -1.0):
        line, closed = trace(circle, start, 0.05, zero=1e-13, most=100, sign=sign)
        assert closed
        np.testing.assert_allclose(np.linalg.norm(line, axis=1), RADIUS, atol=1e-13)
        np.testing.assert_allclose(line[-1], start, atol=1e-12)
        assert np.sign(line[1, 1]) == sign
        length = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
        assert length == pytest.approx(2 * np.pi * RADIUS, rel=2e-3)


def test_a_curve_that_is_too_long_is_said_to_be_open() -> None:
    line, closed = trace(circle, np.array([RADIUS, 0.0]), 0.05, zero=1e-13, most=10)
    assert not closed
    assert len(line) == 11


def test_where_curves_cross_the_walk_ends() -> None:
    def cross(x: Array) -> tuple[Array, Array]:
        return x[:, :1] * x[:, 1:], x[:, None, ::-1].copy()

    line, closed = trace(cross, np.zeros(2), 0.1, zero=1e-13, most=10)
    assert len(line) == 1
    assert not closed


def test_a_step_leaves_out_what_the_equations_do_not_bind(rng: np.random.Generator) -> None:
    a = rng.normal(size=(5, 2, 4))
    f = rng.normal(size=(5, 2))
    a[:, 1] = a[:, 0]  # the second equation says the same as the first
    f[:, 1] = f[:, 0]
    step = shortest(a, f)
    np.testing.assert_allclose(np.einsum("nej,nj->ne", a, step), f, atol=1e-12)
    np.testing.assert_allclose(step, a[:, 0] * (f[:, :1] / (a[:, 0] ** 2).sum(axis=1, keepdims=True)), atol=1e-12)


def test_the_nearest_point_of_a_plane_is_one_step_away(rng: np.random.Generator) -> None:
    normals, offsets = rng.normal(size=(2, 4)), rng.normal(size=2)
    q, target = rng.normal(size=(6, 4)), rng.normal(size=(6, 4))
    there = q + steps_towards(target - q, q @ normals.T - offsets, np.broadcast_to(normals, (6, 2, 4)))
    np.testing.assert_allclose(there @ normals.T, np.broadcast_to(offsets, (6, 2)), atol=1e-12)
    kept = np.linalg.svd(normals)[2][2:]  # along the plane nothing but the target counts
    np.testing.assert_allclose(there @ kept.T, target @ kept.T, atol=1e-12)


def test_one_equation_is_solved_as_several_are(rng: np.random.Generator) -> None:
    a, f = rng.normal(size=(5, 1, 3)), rng.normal(size=(5, 1))
    a[0] = 0.0
    twice = shortest(np.concatenate([a, a], axis=1), np.concatenate([f, f], axis=1))
    np.testing.assert_allclose(shortest(a, f), twice, atol=1e-12)
    assert (shortest(a, f)[0] == 0.0).all()


def test_no_step_leads_out_of_the_box_and_who_stands_still_is_not_asked_again() -> None:
    asked: list[list[int]] = []

    def step(q: Array, active: np.ndarray) -> Array:
        asked.append(active.tolist())
        return np.where(q < 2.0, 1.0, 0.0)

    ends = iterate(step, np.array([[0.0], [2.0]]), iterations=9, longest=0.5, box=np.array([[0.0], [1.25]]))
    np.testing.assert_allclose(ends, [[1.25], [1.25]])
    assert asked == [[0, 1], *[[0]] * 8]
