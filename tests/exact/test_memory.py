"""A process that derives all day does not grow: what is remembered modulo primes is bounded, and ends with its ring."""

from __future__ import annotations

import gc
import tracemalloc

import pytest

from rankdrop import conditions, open_robot
from rankdrop.exact.algebra import field
from rankdrop.exact.algebra import ring as ring_module
from rankdrop.exact.algebra.field import Point, value_at
from rankdrop.exact.algebra.ring import Ring


@pytest.mark.slow
def test_derivations_leave_nothing_behind() -> None:
    robot = open_robot("planar2r")

    def grown(count: int) -> int:
        begun = tracemalloc.get_traced_memory()[0]
        for seed in range(count):
            conditions(robot, points=0, seed=seed, fresh=True)
        gc.collect()
        return tracemalloc.get_traced_memory()[0] - begun

    tracemalloc.start()
    try:
        grown(5)
        assert grown(10) < 50_000  # what one derivation keeps while it runs is ten times that
    finally:
        tracemalloc.stop()


def test_so_many_terms_are_remembered_and_values_stay_right(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ring_module, "KEPT", 40)
    ring = Ring([1, 2])
    t, kept = ring.t, ring.images
    asked = [t[1] ** k * t[2] + k * t[2] + 3 for k in range(2, 40)]
    for _ in range(2):
        for k, f in enumerate(asked, start=2):
            assert value_at(ring, f, Point({"t1": 2, "t2": 5})) == 5 * 2**k % field.P + 5 * k + 3
            assert sum(1 + len(one) for one, *_ in kept.values()) == kept.terms <= 40
    again = len(kept)
    value_at(ring, asked[-1], Point({"t1": 7, "t2": 1}))
    assert len(kept) == again
