"""Solution curves of made-up moves in one joint value x and the way w, whose folds and crossings are known."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from rankdrop.path.check.passing import _departure_along
from rankdrop.path.check.solution_curve import CurvePart, _CurvePoint, _CurveWalk, follow_curve
from rankdrop.robot.model import Array


class Plane:
    """A move of two joint values: x₁ = w, and the zero set of f(x₀, w)."""

    def __init__(self, f: Any, room: float) -> None:
        self.aim, self.room, self.f = SimpleNamespace(joints=np.ones(2)), room, f

    def error(self, y: Array) -> Array:
        return np.array([self.f(y[0], y[2]), y[1] - y[2]])

    def slopes(self, y: Array) -> Array:
        step = 1e-6
        columns = [(self.error(y + step * e) - self.error(y - step * e)) / (2 * step) for e in np.eye(3)]
        return np.stack(columns, axis=1)

    def on_plane(self, guess: Array, across: Array) -> Array | None:
        y = guess
        for _ in range(20):
            off = np.append(self.error(y), across @ (y - guess))
            if np.abs(off).max() < 1e-13:
                return y
            y = y - np.linalg.lstsq(np.vstack([self.slopes(y), across]), off, rcond=1e-13)[0]
        return None

    def place_at(self, w: float) -> float:
        return w

    def solution_near(self, w: float, guess: Array) -> Array | None:
        end = self.on_plane(np.append(guess, w), np.array([0.0, 0.0, 1.0]))
        return None if end is None else end[:2]


def followed(move: Plane, q: Array) -> CurvePart:
    """The last part of a curve, with the crossings of all: to a fold, or to the end of the move."""
    part, crossings = follow_curve(move, q, None), []
    for _ in range(20):
        assert part is not None
        crossings += part.crossings
        if part.folds or part.w[-1] == move.room:
            break
        walk = _CurveWalk(move)  # the way is counted from the start of the move
        walk.points.append(walk.first_point(np.append(part.q[-1], part.w[-1]), part.heading))
        part = walk.run()
    else:
        pytest.fail("the curve has no end")
    return replace(part, crossings=tuple(crossings))


def test_a_curve_folds_back_where_its_way_is_largest() -> None:
    """w = 0.05 − (x − 0.1)²"""
    move = Plane(lambda x, w: w - 0.05 + (x - 0.1) ** 2, 1.0)
    part = followed(move, np.array([0.1 - np.sqrt(0.05), 0.0]))
    assert part.folds
    assert part.q[-1, 0] == pytest.approx(0.1, abs=1e-4)
    assert part.q[-1, 1] == pytest.approx(0.05, abs=1e-8)


def test_a_curve_that_folds_back_at_the_end_of_the_move_has_reached_it() -> None:
    """w = 0.05 − x², and a move of 0.05."""
    move = Plane(lambda x, w: w - 0.05 + x**2, 0.05)
    part = followed(move, np.array([-np.sqrt(0.05), 0.0]))
    assert (part.folds, part.w[-1]) == (False, 0.05)
    assert part.q[-1, 0] == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize(("f", "way", "room", "step"), [
    (lambda x, w: x - 20 * w * w, [0.0, 1.0], 0.1, 0.0025),  # bent by 80 % of 0.04, by 20 % of 0.01
    (lambda x, w: w - 0.05 * x + 1.5 * x * x, [1.0, 0.05], 0.1, 0.01),  # behind the start after 0.04
    (lambda x, w: x, [0.0, 1.0], 0.02, 0.01),  # beyond the end of the move after 0.04
])  # fmt: skip
def test_a_departure_is_ahead_on_the_move_and_next_to_its_tangent(
    f: Any, way: list[float], room: float, step: float
) -> None:
    """The longest of the steps 0.04, 0.01 and 0.0025 for which that holds."""
    move = Plane(f, room)
    direction = np.array([way[0], way[1], way[1]]) / np.linalg.norm([way[0], way[1], way[1]])
    departure = _departure_along(move, np.zeros(3), direction, room)
    assert departure is not None
    x, w = departure.q
    assert f(x, w) == pytest.approx(0.0, abs=1e-12)
    assert departure.place == pytest.approx(w)
    assert direction @ [x, w, w] == pytest.approx(step)
    assert 0.0 < w <= room


def test_a_singular_start_has_no_direction_of_its_own() -> None:
    """Where two curves cross, and next to corank 2."""
    move = Plane(lambda x, w: (x - w) * (x + 2 * w), 0.06)
    assert _CurveWalk(move).first_point(np.zeros(3), None) is None
    flat = SimpleNamespace(aim=move.aim, room=1.0, slopes=lambda y: np.array([[1e-5, 0.0, 1.0], [0.0, 1e-5, 1.0]]))
    assert _CurveWalk(flat).first_point(np.zeros(3), np.array([0.0, 0.0, 1.0])) is None


def test_a_solution_far_from_the_curve_is_not_its_end(monkeypatch: pytest.MonkeyPatch) -> None:
    move = Plane(lambda x, w: x - w, 0.02)
    assert follow_curve(move, np.zeros(2), None) is not None
    monkeypatch.setattr(move, "solution_near", lambda w, guess: guess + 0.01)
    assert follow_curve(move, np.zeros(2), None) is None


@pytest.mark.parametrize("room", [0.03001, 0.031, 0.04])
def test_a_crossing_in_the_last_step_is_noted(room: float) -> None:
    move = Plane(lambda x, w: (x - (w - 0.03)) * (x + 2 * (w - 0.03)), room)
    part = follow_curve(move, np.array([-0.03, 0.0]), None)
    assert part is not None
    assert [crossing.w for crossing in part.crossings] == [pytest.approx(0.03, abs=1e-6)]


def test_where_two_curves_cross_the_one_that_arrives_goes_on() -> None:
    """(x − w)(x + 2 w) = 0, shifted: from x = w through the crossing at w = 0.03."""
    move = Plane(lambda x, w: (x - (w - 0.03)) * (x + 2 * (w - 0.03)), 0.06)
    part = follow_curve(move, np.array([-0.03, 0.0]), None)
    assert part is not None
    (crossing,) = part.crossings
    assert (crossing.w, crossing.rest) == (pytest.approx(0.03, abs=1e-7), False)
    np.testing.assert_allclose(part.q[-1], [0.03, 0.06], atol=1e-9)


@pytest.mark.parametrize(("off", "folds", "end"), [(1e-5, False, -0.06011095), (-1e-5, True, 0.00105409)])
def test_two_curves_that_pass_each_other_are_not_crossed(off: float, folds: bool, end: float) -> None:
    """(x − w)(x + 2 w) = ±1e-5, shifted: the branch turns onto the other line, or folds back before it."""
    move = Plane(lambda x, w: (x - (w - 0.03)) * (x + 2 * (w - 0.03)) - off, 0.06)
    start = move.solution_near(0.0, np.array([-0.03, 0.0]))
    assert start is not None
    part = followed(move, start)
    assert (part.folds, part.crossings) == (folds, ())
    assert part.q[-1, 0] == pytest.approx(end, abs=1e-5)


def walk_with(points: list[float], sigma: Any, monkeypatch: pytest.MonkeyPatch) -> _CurveWalk:
    """A walk along x at these places, where σ_r is a function of x."""
    walk = _CurveWalk(Plane(lambda x, w: x - w, 1.0))

    def point(x: float) -> _CurvePoint:
        return _CurvePoint(np.array([x, x, x]), np.ones(3) / np.sqrt(3), 1.0, float(sigma(x)))

    monkeypatch.setattr(walk, "step_along", lambda here, step: point(here.y[0] + step))
    walk.points = [point(x) for x in points]
    return walk


@pytest.mark.parametrize(("least", "crosses"), [(0.0, True), (5e-7, True), (5e-6, False)])
def test_a_change_of_sign_without_a_zero_is_a_jump(
    least: float, crosses: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    walk = walk_with([0.0], lambda x: (x - 0.01) + np.copysign(least, x - 0.01), monkeypatch)
    found = walk.find_crossing(walk.points[0], 0.02)
    assert (found is not None) == crosses
    assert found is None or found.w == pytest.approx(0.01, abs=1e-6)


@pytest.mark.parametrize(("least", "touches"), [(0.0, True), (5e-7, True), (5e-6, False)])
def test_a_singularity_is_touched_where_sigma_is_zero_at_its_least(
    least: float, touches: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    walk = walk_with([0.0, 0.011, 0.02], lambda x: (x - 0.01) ** 2 + least, monkeypatch)
    found = walk.find_touch()
    assert (found is not None) == touches
    assert found is None or found.y[0] == pytest.approx(0.01, abs=1e-4)


@pytest.mark.parametrize(("sigma", "w", "slope", "doubtful"), [
    (0.0, 0.01, 1.0, True), (1e-3, 0.01, 1.0, False), (1e-3, -0.01, 1.0, True), (1e-3, -0.01, -1.0, False),
    (0.0, 1.5, 1.0, False),
])  # fmt: skip
def test_a_point_of_a_self_motion_is_not_taken(sigma: float, w: float, slope: float, doubtful: bool) -> None:
    """Nor one that lies behind the last one though the way grows there."""
    walk = _CurveWalk(Plane(lambda x, w: x - w, 1.0))
    way = np.ones(3) / np.sqrt(3)
    walk.points = [_CurvePoint(np.zeros(3), way, 1.0, 1e-3)]
    assert walk.is_doubtful(_CurvePoint(np.array([w, w, w]), way, slope, sigma)) == doubtful


def test_a_step_around_a_corner_is_too_long() -> None:
    """An ellipse of half axes 0.01 and 0.014."""
    move = Plane(lambda x, w: x**2 + (w - 0.01) ** 2 - 1e-4, 1.0)
    walk = _CurveWalk(move)
    here = walk.first_point(np.array([-0.01, 0.01, 0.01]), np.array([0.0, 1.0, 1.0]) / np.sqrt(2))
    assert here is not None
    assert walk.step_along(here, 4e-3) is None
    assert walk.step_along(here, 1e-4) is not None
