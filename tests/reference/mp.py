"""Singular values to many digits, by mpmath: what a double precision SVD is measured against."""

from __future__ import annotations

import mpmath
import numpy as np

from rankdrop.robot.model import Array


def singular_values(matrix: Array, digits: int = 50) -> Array:
    """(min(m, n),) singular values of one matrix of doubles, descending, each the double nearest to the true value.

    Square roots of the eigenvalues of the Gram matrix: an eigenvalue is right to 10^−digits·‖J‖², so a singular value
    is right to 10^(−digits/2)·‖J‖, 1e-25 with 50 digits, and in less time than by mpmath's own SVD.
    """
    wide = matrix if matrix.shape[0] <= matrix.shape[1] else matrix.T
    with mpmath.workdps(digits):
        rows = mpmath.matrix(wide.tolist())  # doubles are exact in mpmath
        eigenvalues = mpmath.eigsy(rows * rows.T, eigvals_only=True)
        roots = [mpmath.sqrt(max(value, mpmath.mpf(0))) for value in eigenvalues]
        return np.array(sorted((float(root) for root in roots), reverse=True))
