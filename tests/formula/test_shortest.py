"""The shortest way to write a number."""

from __future__ import annotations

import pytest

from rankdrop.algebra.polynomial import number_value
from rankdrop.algebra.ring import Ring
from rankdrop.formula.shortest import ratio


def test_a_number_with_a_root_has_its_own_sign() -> None:
    ring = Ring([1], letters=["sqrt2"])
    two = ring.letter["sqrt2"]
    p = (1 - two) * (2 + ring.c[1])
    f = ring.to_half(2 + ring.c[1]).f
    assert number_value(ratio(ring, p, f)) == pytest.approx(1 - 2**0.5, rel=1e-12)
