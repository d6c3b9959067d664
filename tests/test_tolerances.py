"""Thresholds that a configuration carries."""

from __future__ import annotations

from rankdrop.configuration import configuration_at
from rankdrop.local.self_motions import self_motion
from rankdrop.robot.open import open_robot
from rankdrop.tolerances import Tolerances


def test_a_configuration_carries_its_tolerances() -> None:
    """At 1e-6 of the stretched elbow the PA-10 counts as singular with a wider tolerance only."""
    arm, q = open_robot("pa10"), [0.1, 0.5, 0.7, 1e-6, 0.9, 0.4, 0.2]
    assert self_motion(arm, q, length=0.1).corank == 0
    assert self_motion(configuration_at(arm, q, None, Tolerances(singular=1e-4)), length=0.1).corank == 1
