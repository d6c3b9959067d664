"""Targets of numbers: rotations against SciPy's, frames, and ranges."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rankdrop.path.read.program_record import Posture, Reason
from rankdrop.path.read.program_targets import angle_target, in_base, joint_target, turned_target
from rankdrop.path.read.trajectory import TrajectoryError


def test_angles_turn_about_fixed_axes_x_first() -> None:
    """R = Rz(yaw) Ry(pitch) Rx(roll), in degrees; lengths are in millimetres."""
    target = angle_target([100.0, -200.0, 300.0, 10.0, 20.0, 30.0], "here", Posture(signs=3))
    assert target.pose[:3, 3] == pytest.approx([0.1, -0.2, 0.3])
    assert target.pose[:3, :3] == pytest.approx(Rotation.from_euler("xyz", [10, 20, 30], degrees=True).as_matrix())
    assert (target.joints, target.posture) == (None, Posture(signs=3))


def test_a_target_in_a_frame_is_moved_with_it_and_without_one_not_known() -> None:
    frame = np.eye(4)
    frame[:3, :3] = Rotation.from_euler("z", 90, degrees=True).as_matrix()
    frame[:3, 3] = [1.0, 0.0, 0.0]
    target = turned_target([0.2, 0.0, 0.5], np.eye(3), "here")
    assert in_base(target, frame).pose[:3, 3] == pytest.approx([1.0, 0.2, 0.5])
    assert in_base(target, frame).pose[:3, :3] == pytest.approx(frame[:3, :3])
    assert in_base(target, None) is Reason.BASE
    joints = joint_target([1.0, 2.0], "here")
    assert in_base(joints, None) is joints
    assert in_base(Reason.CIRCLE, frame) is Reason.CIRCLE


@pytest.mark.parametrize("make", [
    lambda: joint_target([1e300], "line 7"), lambda: angle_target([1e300, 0, 0, 0, 0, 0], "line 7"),
    lambda: angle_target([0, 0, 0, 1e300, 0, 0], "line 7"), lambda: turned_target([0, 0, -1e300], np.eye(3), "line 7"),
])  # fmt: skip
def test_numbers_out_of_range_are_refused_with_their_line(make) -> None:
    with pytest.raises(TrajectoryError, match="line 7: the value is too large"):
        make()
