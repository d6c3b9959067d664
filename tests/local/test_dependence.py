"""Circuits of joint screws, and the questions that lines answer."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from rankdrop.local.axes import Scene
from rankdrop.local.circuits import to_blame
from rankdrop.local.dependence import describe, line_meets_all
from rankdrop.robot.model import Robot
from rankdrop.robot.screws import from_screws, revolute
from rankdrop.task import resolve_task


def arm(lines: list[tuple[tuple[float, float, float], tuple[float, float, float]]]) -> Robot:
    """Revolute joints along (direction, point) at q = 0."""
    return from_screws([revolute(direction, point) for direction, point in lines], order="linear-first")


def scene(robot: Robot) -> Scene:
    return Scene(robot, np.zeros((1, robot.n)))


def test_circuits_are_minimal_and_not_structural(rng: np.random.Generator) -> None:
    generic = rng.normal(size=(3, 6, 6))
    generic[:, :, 5] = generic[:, :, 4]  # always dependent: not worth telling
    here = generic.copy()
    here[:, :, 2] = here[:, :, 0] + 2.0 * here[:, :, 1]
    assert to_blame(here, generic, 1) == [(0, 1, 2)]


def test_no_circuit_in_independent_columns(rng: np.random.Generator) -> None:
    assert to_blame(rng.normal(size=(2, 6, 6)), rng.normal(size=(2, 6, 6)), 1) == []


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ([((0, 0, 1), (1, 0, 0)), ((0, 0, 1), (1, 0, 5))], "axes 1, 2 aligned"),
        ([((1, x, 0), (0, 0, 0)) for x in (0, 1, 2)], "axes 1, 2, 3 concurrent and coplanar"),
        ([((0, 0, 1), (x, 0, 0)) for x in (0, 1, 3)], "axes 1, 2, 3 parallel and coplanar"),
        ([((0, 0, 1), (x, x**2, 0)) for x in (0, 1, 2, 3)], "axes 1, 2, 3, 4 parallel"),
        ([((1, x, x**2), (0, 0, 0)) for x in (0, 1, 2, 3)], "axes 1, 2, 3, 4 concurrent"),
        ([((1, x, 0), (x**2, 0, 0)) for x in (0, 1, 2, 3)], "axes 1, 2, 3, 4 coplanar"),
    ],
)
def test_dependent_axes_in_words(lines: list[tuple[tuple[float, float, float], ...]], expected: str) -> None:
    robot = arm(lines)  # type: ignore[arg-type]
    told = describe(scene(robot), tuple(range(robot.n)), resolve_task("pose", robot))
    assert told.replace("1–4", "1, 2, 3, 4") == expected


def test_a_line_that_meets_every_axis_is_found_and_a_screw_is_not_taken_for_one(rng: np.random.Generator) -> None:
    meeting = [(tuple(rng.normal(size=3)), (0.0, 0.0, z)) for z in rng.uniform(-1, 1, 6)]  # all meet the z axis
    robot = arm(meeting)  # type: ignore[arg-type]
    assert line_meets_all(scene(robot), resolve_task("pose", robot))
    directions = rng.normal(size=(6, 3))
    points = rng.normal(size=(6, 3))
    # reciprocal to the wrench (z; 0.3 z): v·z + 0.3 ω·z = 0
    lines = []
    for direction, point in zip(directions, points, strict=True):
        x, y = direction[0], direction[1]
        moment = point[0] * y - point[1] * x  # (p × ω)·z
        lines.append(((x, y, -moment / 0.3), tuple(point)))
    skew = arm(lines)  # type: ignore[arg-type]
    assert np.linalg.matrix_rank(scene(skew).screws[0], tol=1e-9) == 5
    assert not line_meets_all(scene(skew), resolve_task("pose", skew))


def test_what_lines_have_in_common_is_seen() -> None:
    robot = arm([((0, 0, 1), (1, 0, 0)), ((0, 0, 2), (1, 0, 3)), ((0, 1, 0), (1, 0, 7)), ((1, 0, 0), (0, 5, 0))])
    s = scene(robot)
    assert s.aligned[0, 1].all()
    assert s.meeting(0, 2).all()
    assert s.perpendicular[0, 3].all()
    assert not s.meeting(0, 3).any()
    assert not s.aligned[0, 2].any()
    point, on = s.common_point((0, 1, 2))
    assert on.all()
    assert np.allclose(point, [[1, 0, 7]])
    assert not s.common_point((0, 1))[1].any(), "one line has no single point"
    assert s.coplanar((0, 1, 2)).all()
    assert not s.coplanar((0, 2, 3)).any()
    assert not s.after_motion(0, pi / 3).meeting(2, 3).all()
