"""A joint of a URDF without <axis> turns about X, as URDF says, and a note names it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from rankdrop.robot.open import open_robot

JOINT = """<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/>{3}
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>"""


def test_a_joint_without_an_axis_is_noted(tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    links = "".join(f'<link name="{name}"/>' for name in "abc")
    joints = JOINT.format("first", "a", "b", "") + JOINT.format("second", "b", "c", '<axis xyz="0 0 1"/>')
    file.write_text(f'<robot name="arm">{links}{joints}</robot>')
    arm = open_robot(file)
    np.testing.assert_array_equal(arm.joints[0].axis, [1.0, 0.0, 0.0])
    noted = [str(note) for note in arm.notes if "axis" in str(note)]
    assert noted == ["joint 'first' has no <axis>: it is X of the joint, as URDF says"]
