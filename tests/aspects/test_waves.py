"""Enclosures of trigonometric polynomials."""

from __future__ import annotations

import numpy as np

from rankdrop.algebra.ring import Ring
from rankdrop.aspects.waves import wave_of


def test_terms_that_cancel_widen_an_enclosure() -> None:
    """c1² and s1² in letters that are almost equal: what is left is rounding, and no sign."""
    ring = Ring([1], (), ["a", "b"])
    p = ring.letter["a"] * ring.c[1] - ring.letter["b"] * ring.c[1]
    wave = wave_of(ring, p, {"a": 1e6, "b": 1e6 + 1e-9}, unit=1)
    here = wave.over({1: np.array([0.0])}, 0.0)
    assert here.low[0] < 0 < here.high[0]
