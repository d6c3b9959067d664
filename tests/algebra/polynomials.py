"""Polynomials that tests of several algorithms take."""

from __future__ import annotations

import random

from algebra.number_fields import RING


def long_polynomial(seed: int, terms: int = 60):
    """A random polynomial over √2 and √3 in three variables, irreducible but for chance."""
    rng = random.Random(seed)
    x, y, a, h = RING.t[1], RING.t[2], RING.letter_half["a"], RING.letter_half
    roots = (1, h["sqrt2"], h["sqrt3"], h["sqrt2"] * h["sqrt3"])
    parts = (rng.randrange(1, 99) * rng.choice(roots) * x ** rng.randrange(4) * y ** rng.randrange(4)
             * a ** rng.randrange(3) for _ in range(terms))  # fmt: skip
    return 1 + sum(parts, RING.half.constant(0))
