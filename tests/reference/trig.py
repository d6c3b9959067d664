"""Trigonometric polynomials of the exact ring in floating point, straight from their terms."""

from __future__ import annotations

from math import prod

import numpy as np


def value(chain, p, q):
    """A trigonometric polynomial p of the chain's ring at q (n,), term by term, with the lengths' values."""
    theta = np.asarray(q) + chain.shifts
    point = dict(chain.numbers)
    for j in chain.ring.revolute:
        point |= {f"s{j}": np.sin(theta[j - 1]), f"c{j}": np.cos(theta[j - 1])}
    point |= {f"q{j}": theta[j - 1] for j in chain.ring.prismatic}
    names = chain.ring.trig.names()
    return sum(
        int(c.p) / int(c.q) * prod(point[name] ** int(e) for name, e in zip(names, powers, strict=True))
        for powers, c in p.terms()
    )
