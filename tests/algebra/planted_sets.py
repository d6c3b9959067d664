"""Planes with random coefficients, systems of them taken apart, and the sets that are found."""

from __future__ import annotations

import random

from rankdrop.algebra.decompose import decompose
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.work import Work
from rankdrop.algebra.zeroset import ZeroSet


def factor_on_stratum(ring: Ring, polynomials, most: int) -> list[ZeroSet]:
    return decompose(ring, {}, [ring.form(f) for f in polynomials], most, Work())


def is_there(ring: Ring, found: list[ZeroSet], pins: dict[int, str], *conditions) -> bool:
    """Whether exactly this set is among those found: each holds the conditions of the other."""
    codimension = len(pins) + len(conditions)
    for one in found:
        there = one.codimension == codimension and all(one.stands(j, value) for j, value in pins.items())
        if there and all(one.half_vanishes(f) for f in conditions):
            return True
    return False


def random_plane(ring: Ring, rng: random.Random, joints):
    return sum((rng.randint(1, 9) * ring.t[j] for j in joints), ring.half.constant(rng.randint(1, 9)))
