"""Systems are dropped for a proof that they have no zeros, not for want of zeros modulo a prime."""

from __future__ import annotations

import pytest

pytest.importorskip("flint")

from collections.abc import Iterator
from fractions import Fraction
from itertools import combinations
from math import prod
from typing import Any

from rankdrop.algebra import solving
from rankdrop.algebra.field import PRIMES
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.solving import binds_more

NOWHERE = 4 * (prod(PRIMES) - 1)  # ≡ −4, a square modulo none of the primes


def test_a_system_with_zeros_in_extensions_alone_is_kept() -> None:
    """t1 = t2 = √n is real, and no number modulo any of the primes."""
    assert all(pow(NOWHERE, (p - 1) // 2, p) == p - 1 for p in PRIMES)
    ring = Ring([1, 2, 3])
    x, y = ring.t[1], ring.t[2]
    system = [x**2 - NOWHERE, y**2 - NOWHERE, x * y - NOWHERE]
    assert not binds_more(system, 2, ring.moving)
    assert binds_more(system, 1, ring.moving)
    assert binds_more([*system, x + y - 1], 2, ring.moving)


def test_zeros_at_which_no_configuration_is_are_none() -> None:
    ring = Ring([1, 2])
    x, y = ring.t[1], ring.t[2]
    assert binds_more([x**2 + 1 + (y - 3) ** 2 * (x**2 + 1), (x**2 + 1) * y, (x**2 + 1) * (x - y)], 1, ring.moving)
    assert binds_more([x**2 * y + y + y**2 + 1, y**2 + 1, (x**2 + 1) * (x - 5)], 2, ring.moving)


def test_pairs_of_zeros_are_no_zeros_of_all() -> None:
    ring = Ring([1, 2])
    x, y = ring.t[1], ring.t[2]
    assert not binds_more([x - 1, y - 2, x * y - 2], 2, ring.moving)
    assert binds_more([x - 1, y - 2, x * y - 3], 2, ring.moving)


def test_long_conditions_are_combined_where_short_ones_hold_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """A line and a conic meet in two points: the others are of degree 1 there, and their combination costs little."""
    ring = Ring([1, 2])
    x, y = ring.t[1], ring.t[2]
    lengths: list[int] = []

    def pairs(conditions: list[Any], size: int) -> Iterator[tuple[Any, ...]]:
        lengths.extend(int(f.degrees()[0]) for f in conditions)
        return combinations(conditions, size)

    monkeypatch.setattr(solving, "combinations", pairs)
    long = [(x * y - NOWHERE) * (x + k * y + 1) ** 6 + (x - y) * (x + k) ** 7 for k in (1, 2, 3)]
    assert not binds_more([x - y, x**2 - NOWHERE, *long], 2, ring.moving)
    assert lengths
    assert max(lengths) < 2


def test_it_is_asked_for_the_lengths_at_hand() -> None:
    """a cos θ1 = d and θ1 = 0 hold together for a = d alone."""
    ring = Ring([1, 2], letters=["a", "d"])
    a, d = ring.letter_half["a"], ring.letter_half["d"]
    t, u = ring.t[1], ring.t[2]
    system = [a * (1 - t**2) - d * (1 + t**2), t * (u - 2), u * t]
    assert binds_more(system, 1, ring.moving)
    assert not binds_more(system, 1, ring.moving, {"a": Fraction(3, 10), "d": Fraction(3, 10)})
    assert binds_more(system, 1, ring.moving, {"a": Fraction(3, 10), "d": Fraction(2, 10)})
