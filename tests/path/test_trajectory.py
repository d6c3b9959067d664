"""Joint values whatever their file: units that look wrong, numbers that are not finite."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rankdrop.path.read.files import read_trajectory
from rankdrop.path.read.trajectory import TrajectoryError, unit_hint
from rankdrop.robot.open import open_robot

ARM = open_robot("scara")
Q = np.array([[0.1, 0.2, 0.05, 0.4], [0.2, 0.3, 0.06, 0.5], [0.3, 0.1, 0.07, 0.6]])


def test_angles_that_look_like_the_other_unit_are_warned_of() -> None:
    assert unit_hint(Q, ARM) is None
    assert "look like degrees" in unit_hint(Q * 100, ARM)
    assert unit_hint(np.array([[0.0, 0.0, 90.0, 0.0]]), ARM) is None  # a slide
    assert "look like radians" in unit_hint(np.radians(Q), ARM, deg=True)
    assert unit_hint(np.radians(Q * 100), ARM, deg=True) is None
    assert unit_hint(np.zeros((3, 4)), ARM, deg=True) is None


@pytest.mark.filterwarnings("error")
def test_a_signalling_nan_is_refused_before_it_is_multiplied(tmp_path: Path) -> None:
    """Half-precision files can hold one: NumPy warns where it is multiplied."""
    rows = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], dtype=np.float16)
    rows.view(np.uint16)[1, 2] = 0x7D00
    np.save(tmp_path / "a.npy", rows)
    with pytest.raises(TrajectoryError, match="is not finite"):
        read_trajectory(tmp_path / "a.npy", open_robot("planar2r"), deg=True)
