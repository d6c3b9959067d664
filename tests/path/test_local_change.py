"""Changes of a few rows of a path."""

from __future__ import annotations

import numpy as np
import pytest

from path.dipping import mended
from rankdrop.path.mend.local_change import step


@pytest.mark.slow
def test_a_bump_has_two_continuous_derivatives() -> None:
    share = np.linspace(-0.2, 1.2, 1401)
    value, slope, bend = step(share)
    np.testing.assert_allclose(np.gradient(value, share), slope, atol=1e-4)
    np.testing.assert_allclose(np.gradient(slope, share)[5:-5], bend[5:-5], atol=0.1)
    assert np.abs(np.diff(bend)).max() < 0.02 * np.abs(bend).max()
    q, found = mended("irb120")
    assert found.best is not None
    moved = (found.best.trajectory.q - q)[:, 4]
    second = np.gradient(np.gradient(moved, 0.01), 0.01)
    assert np.abs(np.diff(second)).max() < 0.4 * np.abs(second).max()  # at a jump: as large as the values themselves
