"""Which task is asked of an arm with few joints."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.local.pointing import asked_task, pointing_task
from rankdrop.robot.dh import from_dh
from rankdrop.task import resolve_task


@pytest.mark.parametrize(("beside", "rolls"), [(0.008, True), (0.25, False)])
def test_a_tool_that_the_last_joint_rolls_is_asked_about_its_pose(beside: float, *, rolls: bool) -> None:
    """Yaw, three parallel joints, and the roll of the tool, whose axis passes by the tip."""
    half = np.pi / 2
    joints = [(0, -half, 0.1, 0), (0.12, 0, 0, -half), (0.14, 0, 0, 0), (0, -half, 0, 0), (beside, 0, 0.1, 0)]
    arm = from_dh(joints, convention="standard")
    assert (pointing_task(arm, resolve_task("pose", arm)) is None) == rolls


def test_two_joints_that_turn_a_tool_alone_keep_the_pose() -> None:
    arm = from_dh([(0.0, np.pi / 2, 0.2, 0.0), (0.0, 0.0, 0.0, 0.0)], convention="standard")
    assert asked_task(arm, resolve_task("pose", arm)).name == "pose"
