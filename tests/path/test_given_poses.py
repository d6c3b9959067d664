"""Tool paths that were given as poses: places between them, lengths, and moved ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from path.planar_detours import checked
from rankdrop.path.mend.given_poses import given_tool_path, way_lengths
from rankdrop.robot.transform import translation


def test_the_poses_given_are_kept_to_the_last_bit_and_those_between_lie_on_the_line() -> None:
    poses, _, check = checked("kr6r900")
    assert check.tool is not None
    path = given_tool_path(check, check.tool.q[0])
    assert np.array_equal(path.at_places(np.arange(len(poses), dtype=np.float64)).poses, poses)
    fine = path.at_places(np.array([3.0, 3.25, 4.0]))
    line = 0.75 * poses[3, :3, 3] + 0.25 * poses[4, :3, 3]
    assert fine.poses[1, :3, 3] == pytest.approx(line, abs=1e-12)
    assert np.array_equal(fine.poses[[0, 2]], poses[[3, 4]])
    assert fine.poses[1, :3, :3] @ fine.poses[1, :3, :3].T == pytest.approx(np.eye(3), abs=1e-12)


def test_a_moved_base_moves_the_poses_between_as_well() -> None:
    _, _, check = checked("kr6r900")
    assert check.tool is not None
    path = given_tool_path(check, check.tool.q[0])
    moved = path.shift(translation(0.1, 0.0, 0.0), np.eye(4)).at_places(np.array([2.0, 2.5]))
    plain = path.at_places(np.array([2.0, 2.5]))
    assert moved.poses[:, :3, 3] - plain.poses[:, :3, 3] == pytest.approx(np.tile([0.1, 0.0, 0.0], (2, 1)))


def test_lengths_are_ways_by_the_length_scale_and_turns_and_do_not_depend_on_places_between() -> None:
    poses, _, check = checked("kr6r900")
    assert check.tool is not None
    path = given_tool_path(check, check.tool.q[0])
    straight = poses[:3].copy()
    straight[1:, :3, :3] = straight[0, :3, :3]
    straight[1, :3, 3] = straight[0, :3, 3] + [0.3, 0.0, 0.4]
    straight[2, :3, 3] = straight[1, :3, 3]
    assert way_lengths(straight, 2.0) == pytest.approx([0.0, 0.25, 0.25], abs=1e-8)
    quarter = replace(path, poses=straight)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    straight[2, :3, :3] = turn @ straight[1, :3, :3]
    assert np.diff(quarter.lengths)[1] == pytest.approx(np.pi / 2, abs=1e-8)
    fine = path.at_places(np.linspace(0.0, len(poses) - 1.0, 4 * len(poses) - 3))
    assert fine.lengths[-1] == pytest.approx(path.lengths[-1], rel=1e-6)
