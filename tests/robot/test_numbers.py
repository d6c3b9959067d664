"""Lines, common normals and Denavit and Hartenberg's numbers between the axes of a chain."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from reference.arms import remade
from reference.kinematics import exponential

from rankdrop.robot.dh import from_dh
from rankdrop.robot.numbers import (
    axis_lines,
    common_normals,
    feet,
    numbers_of,
    offsets_along,
    parallel_runs,
    wrap_angle,
)
from rankdrop.robot.open import open_robot

ROWS = ((0.3, 1.1, 0.2, 0.4), (0.25, -0.7, -0.15, 1.3), (0.1, 0.9, 0.35, -2.0), (0.2, 0.4, 0.1, 0.5))
"""Rows of a standard table, no two axes parallel: a [m], α [rad], d [m], θ [rad]."""
ARMS = ("puma560", "ur5e", "iiwa14", "canadarm2")
EXACT = {"angle": 1e-6, "length": 1e-9}


def test_a_table_is_read_back_from_its_axes() -> None:
    """Between the first normal and the last: before the first axis and after the last no other axis is."""
    found = numbers_of(from_dh(ROWS, convention="standard"), **EXACT)
    for number, (a, alpha, _, _) in zip(found[:-1], ROWS, strict=False):
        assert (number.a, number.twist) == pytest.approx((a, alpha), abs=1e-12)
    for number, (_, _, d, theta) in list(zip(found, ROWS, strict=True))[1:-1]:
        assert (number.d, number.phase) == pytest.approx((d, theta), abs=1e-12)


@pytest.mark.parametrize("name", ARMS)
def test_numbers_do_not_depend_on_where_the_base_stands(name: str, rng: np.random.Generator) -> None:
    robot = open_robot(name)
    motion = exponential(np.array([0.3, -0.2, 0.5, 0.6, 0.0, 0.8]), float(rng.uniform(0.5, 2.5)))
    for one, other in zip(numbers_of(robot, **EXACT), numbers_of(remade(robot, motion=motion), **EXACT), strict=True):
        assert (other.a, other.d) == pytest.approx((one.a, one.d), abs=1e-9)
        for turn, same in ((one.phase, other.phase), (one.twist, other.twist)):
            assert wrap_angle(turn - same) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("name", ARMS)
def test_a_common_normal_is_perpendicular_to_both_axes_and_ends_on_them(name: str) -> None:
    robot = open_robot(name)
    lines = axis_lines(robot, length=1e-9)
    normals = common_normals(robot, lines, **EXACT)
    assert len(normals) == len(lines) + 1
    for (x, near, far), (axis, point), (other, beyond) in zip(normals[1:-1], lines[:-1], lines[1:], strict=True):
        assert (x @ x, x @ axis, x @ other) == pytest.approx((1.0, 0.0, 0.0), abs=1e-12)
        assert np.cross(near - point, axis) == pytest.approx(np.zeros(3), abs=1e-12)
        assert np.cross(far - beyond, other) == pytest.approx(np.zeros(3), abs=1e-12)
        assert np.cross(far - near, x) == pytest.approx(np.zeros(3), abs=1e-9)


def test_feet_are_nearer_than_any_other_two_points(rng: np.random.Generator) -> None:
    for _ in range(20):
        (a, b), (start, end) = rng.normal(size=(2, 3)), rng.normal(size=(2, 3))
        a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
        foot, other = feet((a, start), (b, end))
        steps = rng.normal(size=(2, 50, 1))
        far = np.linalg.norm(foot + steps[0] * a - other - steps[1] * b, axis=1)
        assert np.linalg.norm(foot - other) <= far.min()


def test_parallel_axes_make_runs_and_their_offsets_add_up() -> None:
    """The last axis but one points the other way: its offset counts backwards."""
    rows = [(0, pi / 2, 0.3, 0), (0.4, 0, 0.1, 0), (0.3, pi, 0.2, 0), (0.2, 0, 0.05, 0), (0.1, 0, 0.4, 0)]
    found = numbers_of(from_dh(rows, convention="standard"), **EXACT)
    assert parallel_runs(found) == [[0], [1, 2, 3, 4]]
    assert offsets_along(found, [2, 3]) == pytest.approx([found[2].d, -found[3].d])
    assert found[3].d == pytest.approx(0.05)


@pytest.mark.parametrize(("angle", "wrapped"), [(3 * pi, -pi), (0.5 + 4 * pi, 0.5), (-0.5 - 2 * pi, -0.5)])
def test_a_wrapped_angle_is_the_same_within_half_a_turn(angle: float, wrapped: float) -> None:
    assert wrap_angle(angle) == pytest.approx(wrapped, abs=1e-12)
