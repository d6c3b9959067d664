"""A process that derives all day does not grow: what is remembered modulo primes is bounded, and ends with its ring."""

from __future__ import annotations

import subprocess
import sys

import pytest

from rankdrop.algebra import field
from rankdrop.algebra import ring as ring_module
from rankdrop.algebra.field import ModularPoint, value_at
from rankdrop.algebra.ring import Ring

GROWN = """
import gc, tracemalloc
from rankdrop import conditions, open_robot

robot = open_robot("planar2r")

def grown(count):
    begun = tracemalloc.get_traced_memory()[0]
    for seed in range(count):
        conditions(robot, points=0, seed=seed, fresh=True)
    gc.collect()
    return tracemalloc.get_traced_memory()[0] - begun

tracemalloc.start()
grown(5)
print(grown(10))
"""


@pytest.mark.by_hand
def test_derivations_leave_nothing_behind() -> None:
    """In a process of its own: what other tests have left to be filled or freed is not counted."""
    done = subprocess.run([sys.executable, "-c", GROWN], capture_output=True, text=True, check=True)
    assert int(done.stdout) < 10_000


def test_so_many_terms_are_remembered_and_values_stay_right(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ring_module, "KEPT", 40)
    ring = Ring([1, 2])
    t, kept = ring.t, ring.images
    asked = [t[1] ** k * t[2] + k * t[2] + 3 for k in range(2, 40)]
    for _ in range(2):
        for k, f in enumerate(asked, start=2):
            assert value_at(ring, f, ModularPoint({"t1": 2, "t2": 5})) == 5 * 2**k % field.P + 5 * k + 3
            assert sum(1 + len(one) for one, *_ in kept.values()) == kept.terms <= 40
    again = len(kept)
    value_at(ring, asked[-1], ModularPoint({"t1": 7, "t2": 1}))
    assert len(kept) == again
