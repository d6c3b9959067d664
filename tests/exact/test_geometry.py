"""Angles of an arm as exact numbers."""

from __future__ import annotations

from math import cos, pi, radians, sin

import numpy as np
import pytest
from algebra.number_fields import RING

from rankdrop.algebra.roots import roots_of
from rankdrop.exact.arm.geometry import exact_cosine, turn

HALF = pi / 2


@pytest.mark.parametrize("angle", [*range(-180, 181, 15), *range(-180, 181, 18)])
def test_multiples_of_15_and_18_degrees_are_exact(angle: int) -> None:
    found = turn(radians(angle))
    assert float(found.cos) == pytest.approx(cos(radians(angle)), abs=1e-15)
    assert float(found.sin) == pytest.approx(sin(radians(angle)), abs=1e-15)
    assert abs(found.error) < 1e-14
    circle = RING.reduce(RING.constant(found.cos) ** 2 + RING.constant(found.sin) ** 2)
    assert circle == 1
    assert float(exact_cosine(cos(radians(angle)))) == pytest.approx(cos(radians(angle)), abs=1e-15)


def test_other_angles_are_rational() -> None:
    assert roots_of([turn(0.3).cos, turn(0.3).sin]) == []
    assert 0 < abs(turn(0.3).error) < 1e-11


@pytest.mark.parametrize("angle", [0.0, HALF, -HALF, pi, -pi, 0.3, -2.9, 1e-8])
def test_a_turn_is_exact_and_says_its_error(angle: float) -> None:
    found = turn(angle)
    assert found.cos**2 + found.sin**2 == 1
    exact = np.arctan2(float(found.sin), float(found.cos)) + found.error
    assert np.angle(np.exp(1j * (exact - angle))) == pytest.approx(0, abs=1e-13)
