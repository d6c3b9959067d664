"""What the points of a family have in common."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from rankdrop.families import inspection
from rankdrop.families.inspection import candidates, independent


def test_candidates_are_primitive_and_simplest_first():
    found = candidates((1, 2, 4), 5)
    assert [int(x) for x in found[0]] == [0, 1, 1, 0, 0]
    assert all(np.gcd.reduce(row) == 1 for row in found)
    assert independent(found) == ((0, 1, 1, 0, 0), (0, 1, 0, 0, 1), (0, 1, 0, 0, -1))


@pytest.mark.slow
def test_relations_of_many_points_take_as_much_memory_as_those_of_some(rng):
    """Ten coupled joints have 2,430 candidates: 6,000 points at once would be 117 MB for a table of numbers alone."""
    normals = rng.normal(size=(6_000, 10))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals[::2] = np.array([1, 1, *(0,) * 8]) / np.sqrt(2)  # half of them have a relation: θ1 + θ2
    conormal = normals[:, :, None] * normals[:, None, :]
    tracemalloc.start()
    try:
        told = inspection._relations(conormal, tuple(range(10)), 10)
        most = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert most < 60e6
    assert told[0] == ((1, 1, *(0,) * 8),)
    assert told[1] == ()


def test_an_arm_of_thirty_joints_is_taken_apart():
    """Its D has 25 rows, more than the core takes apart: singular values and spaces are as of fewer."""
    d = np.random.default_rng(0).normal(size=(3, 25, 30))
    s, v = inspection._right(d)
    np.testing.assert_allclose(np.linalg.norm(d @ v[..., :25], axis=1), s, atol=1e-12)
    np.testing.assert_allclose(d @ v[..., 25:], 0, atol=1e-12)
    narrow, bases = inspection._right(d[:, :5])
    np.testing.assert_allclose(np.linalg.norm(d[:, :5] @ bases[..., :5], axis=1), narrow, atol=1e-12)
