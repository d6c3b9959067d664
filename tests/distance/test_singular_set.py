"""Nearest points of the singular set, whatever family they are of: walks on the set, and minima of the distance."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest

from rankdrop.distance.singular_set import SetDistance
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task


def test_walks_that_end_nowhere_have_no_foot(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = open_robot("planar3r")
    unbounded = np.array([[-inf], [inf]]) * np.ones(3)
    near = SetDistance(robot, resolve_task(None, robot), unbounded, 0)
    q = np.array([[0.3, 0.8, 0.4], [0.1, -0.6, 0.2]])
    feet = near.feet(q, np.full(2, inf))
    assert np.abs(feet[:, 1]).max() < 1e-6  # stretched
    monkeypatch.setattr(near, "_walks", lambda centre, starts: (starts, np.full(len(starts), inf)))
    assert np.isnan(near.feet(q, np.full(2, inf))).all()


def test_a_ball_is_searched_once_its_size_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of places with a singular configuration known the ball is searched at once, of others after the first round."""
    robot = open_robot("planar3r")
    near = SetDistance(robot, resolve_task(None, robot), np.array([[-inf], [inf]]) * np.ones(3), 0)
    counts: list[list[int]] = []
    onto = near._onto_set

    def counted(starts: list[Array]) -> list[Array]:
        counts.append([len(some) for some in starts])
        assert np.isfinite(np.concatenate(starts)).all()
        return onto(starts)

    monkeypatch.setattr(near, "_onto_set", counted)
    q = np.array([[0.3, 0.8, 0.4], [0.1, -0.6, 0.2], [0.1, 0.0, 0.2]])
    feet = near.feet(q, np.array([inf, 0.7, 0.0]))
    ball = len(near._ball)
    assert counts == [[1, 1 + ball, 1], [ball]]
    assert np.abs(feet[:, 1]).max() < 1e-6
