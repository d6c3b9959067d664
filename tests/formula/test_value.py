"""Numbers with roots."""

from __future__ import annotations

from math import cos, sin

import numpy as np
import pytest

from rankdrop.algebra.ring import Ring
from rankdrop.formula.value import Quotient, Value


def test_a_quotient_keeps_the_roots_of_its_number() -> None:
    ring = Ring([1, 2], letters=["sqrt2", "sqrt3"])
    two, three = ring.letter["sqrt2"], ring.letter["sqrt3"]
    top = ring.reduce((1 + two) * ring.s[1] * (ring.c[2] + two * ring.s[2]))
    bottom = ring.reduce(three * ring.s[1] * (three + ring.c[2]))
    whole = Quotient(*(Value(ring, p, ring.factor(p)) for p in (top, bottom)))
    theta = np.array([0.4, 1.1])
    wanted = (1 + 2**0.5) * (cos(1.1) + 2**0.5 * sin(1.1)) / (3**0.5 * (3**0.5 + cos(1.1)))
    assert whole.at(theta, {"sqrt2": 2**0.5, "sqrt3": 3**0.5}) == pytest.approx(wanted, rel=1e-12)
