"""Descriptions in which some numbers are open."""

from __future__ import annotations

from math import pi, radians
from pathlib import Path

import numpy as np
import pytest

from rankdrop.kinematics import pose
from rankdrop.robot.drawing import Drawing


def test_places_of_parameters() -> None:
    drawing = Drawing.of("ur5")
    q = np.array([0.1, -0.8, 0.9, 0.4, 0.7, 0.2])
    arm = drawing.nominal
    longer = drawing.robot({drawing.place("-2.a", "here"): 0.5})
    apart = longer.joints[2].screw[:3] - arm.joints[2].screw[:3]
    assert np.abs(apart).max() == pytest.approx(0.5 - 0.425)
    tool = drawing.robot({drawing.place("tool.z", "here"): 0.1})
    moved = pose(tool, q)[:3, 3] - pose(arm, q)[:3, 3]
    assert np.linalg.norm(moved) == pytest.approx(0.1)
    base = drawing.robot({drawing.place("base.yaw", "here"): pi / 2, drawing.place("base.z", "here"): 1.0})
    x, y, z = pose(arm, q)[:3, 3]
    assert pose(base, q)[:3, 3] == pytest.approx([-y, x, z + 1.0])
    limited = drawing.robot({drawing.place("elbow_joint.upper", "here"): 1.0})
    assert limited.upper[2] == 1.0
    assert drawing.measure(drawing.place("tool.pitch", "here")) == "angle"


def test_a_number_of_a_urdf_is_replaced() -> None:
    file = Path(__file__).resolve().parents[1] / "data" / "arms" / "abbirb1600.urdf"
    drawing = Drawing.of(str(file))
    place = drawing.place("2.z", "here")
    before, after = drawing.nominal, drawing.robot({place: 1.0})
    gap = after.joints[2].frame[:3, 3] - before.joints[2].frame[:3, 3]
    assert gap == pytest.approx([0.0, 0.0, 1.0 - 0.4865])
    tilted = drawing.robot({drawing.place("2.roll", "here"): radians(1.57)})
    assert not np.allclose(tilted.joints[1].frame[:3, :3], before.joints[1].frame[:3, :3])
