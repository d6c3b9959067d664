"""What the controls of the arm do."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("viser", reason="viser and trimesh are not installed")

from rankdrop.kinematics import pose
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.viewer.controls import pull_towards


def test_out_of_reach_the_arm_goes_as_far_as_it_can_and_no_limit_is_crossed() -> None:
    arm = open_robot("panda")
    task = resolve_task(None, arm)
    q = np.clip(np.radians([0.0, 30.0, 0.0, -100.0, 0.0, 100.0, 0.0]), arm.lower, arm.upper)
    target = pose(arm, q)
    target[:3, 3] = [-0.6, 0.0, -1.5]
    missing = np.inf
    for _ in range(40):
        q, left = pull_towards(arm, task, q, target)
        assert left <= missing
        missing = left
    assert missing > 0.3
    assert np.isfinite(q).all()
    assert ((q >= arm.lower) & (q <= arm.upper)).all()
    assert np.isclose(q, arm.lower, atol=1e-9).any() or np.isclose(q, arm.upper, atol=1e-9).any()
