"""Conditions divided by one another on the way to their common zeros."""

from __future__ import annotations

import pytest

pytest.importorskip("flint")

from rankdrop.algebra.decompose import decompose
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.work import Work


def test_divisions_that_raise_one_anothers_degrees_end() -> None:
    """A third condition, divided in t2 by the first one, grows in t1, and divided in t1 by the second one in t2."""
    ring = Ring((1, 2, 3), (), ())
    t1, t2, t3 = (ring.t[joint] for joint in (1, 2, 3))
    first = (1 + t1**2) * t2**3 + 3 * t1**2 * t2 + 2 * t1 - 6
    second = (1 + t2**2) * t1**3 + 5 * t2**2 * t1 - 4 * t2 - 3
    third = t1**2 * t2**4 * t3**2 + t1 * t3 + t2 + 5
    work = Work(1.3)
    (found,) = decompose(ring, {}, [ring.form(f) for f in (first, second, third)], 3, work)
    assert not work.unresolved
    assert all(found.half_vanishes(f) for f in (first, second, third))
