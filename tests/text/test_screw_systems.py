"""Screw systems in words."""

from __future__ import annotations

import numpy as np

from rankdrop.local.screw_systems import systems_at
from rankdrop.robot.open import open_robot


def test_the_zero_pose_of_the_pa10() -> None:
    found = systems_at(open_robot("pa10"), np.zeros(7))
    assert [(s.numbers, s.kind, s.permanent) for s in found] == [
        ((1, 3, 5, 7), "coaxial", False), ((1, 2, 3), "spherical", False), ((3, 4, 5), "spherical", False),
        ((5, 6, 7), "spherical", False),
    ]  # fmt: skip
    assert found[0].words.endswith("dependent here: no motion of these joints alone breaks it")
    assert found[1].words == "axes 1, 2, 3 meet in one point (spherical system of dimension 3), at every configuration"
