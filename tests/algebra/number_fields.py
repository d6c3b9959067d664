"""A ring, and algebraic numbers as sets of floating-point values."""

from __future__ import annotations

from hypothesis import strategies as st

from rankdrop.algebra.ring import Ring
from rankdrop.algebra.roots import ROOTS

RING = Ring([1, 2], letters=["a", *ROOTS])


def numbers():
    return st.lists(st.integers(-3, 3), min_size=4, max_size=4).filter(any)


def number_of(values):
    h = RING.letter_half
    return sum(v * w for v, w in zip(values, [1, h["sqrt2"], h["sqrt3"], h["sqrt2"] * h["sqrt3"]], strict=True))
