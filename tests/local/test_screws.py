"""Twists as screws."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest

from rankdrop.local.screws import Screw, screw_of


def test_the_sentence_about_the_point_is_true_of_every_motion_that_is_left(rng: np.random.Generator) -> None:
    for _ in range(50):
        wrench = rng.normal(size=6)
        line = screw_of(np.concatenate([wrench[3:], wrench[:3]]))
        motion = rng.normal(size=6)
        motion -= wrench * (motion @ wrench) / (wrench @ wrench)
        velocity = motion[:3] + np.cross(motion[3:], line.point)
        along = np.array(line.direction)
        assert velocity @ along == pytest.approx(-line.pitch * (motion[3:] @ along), abs=1e-12)


def test_a_twist_is_the_twist_of_its_screw(rng: np.random.Generator) -> None:
    for twist in [*rng.normal(size=(50, 6)), np.array([0, 0, 2.0, 0, 0, 0]), np.array([0, 0, 0, 0, 3.0, 0])]:
        assert np.abs(screw_of(twist).twist - twist).max() < 1e-12


def test_a_screw_is_the_screw_of_its_twist() -> None:
    screw = Screw((0.0, 0.3, 0.0), (0.0, 0.0, 1.0), 0.2, 4.0)
    again = screw_of(screw.twist)
    assert np.allclose(again.point, screw.point)
    assert np.allclose(again.direction, screw.direction)
    assert (again.pitch, again.magnitude) == pytest.approx((0.2, 4.0))
    assert screw_of([3, 0, 4, 0, 0, 0]) == Screw((0.0, 0.0, 0.0), (0.6, 0.0, 0.8), inf, 5.0)
