"""Masked configurations are refused: NumPy would compute with the numbers under the mask."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.errors import ConfigurationError
from rankdrop.kinematics import pose
from rankdrop.robot.open import open_robot


def test_masked_values_are_refused_and_an_empty_mask_is_not() -> None:
    arm = open_robot("planar2r")
    q = np.ma.masked_array([[0.1, 0.2], [0.3, 99.0]], mask=[[False, False], [False, True]])
    with pytest.raises(ConfigurationError, match="q has masked values"):
        pose(arm, q)
    assert pose(arm, np.ma.masked_array([0.1, 0.2], mask=False)).tolist() == pose(arm, [0.1, 0.2]).tolist()
