"""The box of a slice."""

from __future__ import annotations

import numpy as np

from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.viewer.slice_box import SliceBox


def test_places_in_a_slice_box_are_in_the_box() -> None:
    arm = open_robot("ur5")
    task = resolve_task(None, arm)
    for joints in ((2, 3), (2, 3, 5)):
        box = SliceBox.of(arm, task, joints, 1.0, limits=False)
        q = np.full((3, 6), -np.pi)
        q[1], q[2] = np.pi, 0.0
        low, high, middle = box.place(q)
        assert np.allclose(low, box.corner)
        assert np.allclose(middle, (low + high) / 2)
        assert box.lines().shape == ({2: 4, 3: 12}[len(joints)], 2, 3)
        assert np.allclose(np.linalg.norm(np.diff(box.lines(), axis=1), axis=2), box.edge)
        assert len(box.labels(arm)) == 3 * len(joints)
