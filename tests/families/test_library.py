"""Libraries of functions: circuits of candidates, and the sparsest basis of a space."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.families.library import MOST_CIRCUITS, circuits, sparse_basis


def test_sparse_basis_spans_the_same_space(rng):
    null = np.linalg.qr(rng.standard_normal((12, 3)))[0]
    basis = sparse_basis(null)
    np.testing.assert_allclose(null @ (null.T @ basis), basis, atol=1e-12)
    assert (np.abs(basis) < 1e-9).sum() >= 6


@pytest.mark.slow
def test_circuits_have_one_joint_more_than_the_dimension_and_are_counted(rng):
    basis = np.linalg.qr(rng.standard_normal((7, 3)))[0]
    found = circuits((basis @ basis.T)[None], tuple(range(7)))
    assert len(found) == 35
    assert {len(one) for one in found} == {4}
    basis = np.linalg.qr(rng.standard_normal((14, 5)))[0]
    assert len(circuits((basis @ basis.T)[None], tuple(range(14)))) == MOST_CIRCUITS  # of 3,003
