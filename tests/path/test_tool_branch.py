"""Every branch of a tool path is followed for itself; a start near the first pose is enough."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.kinematics import pose
from rankdrop.path.check.first_pose import within_limits
from rankdrop.path.check.tool_line import poses_at
from rankdrop.path.check.tool_path import check_poses
from rankdrop.robot.open import open_robot
from rankdrop.robot.transform import from_xyz_rpy
from rankdrop.task import resolve_task

ACROSS = np.stack([from_xyz_rpy([0.42, y, 0.6], [0.0, np.pi / 2, 0.0]) for y in (-0.15, 0.15)])
"""Of a KUKA KR 3: tool forward, across the front (industrialmonitordirect, "A4 and A6 spin on a LIN")."""


@pytest.fixture(scope="module")
def across():
    return check_poses(open_robot("kr3r540"), ACROSS)


@pytest.mark.slow
def test_the_table_has_every_branch_once(across) -> None:
    arm, branches = across.robot, across.tool.branches
    known = within_limits(arm, ACROSS[0], resolve_task(None, arm))
    assert (len(branches), across.tool.solutions) == (6, len(known))
    assert [one.chosen for one in branches] == [True] + [False] * 5
    for one in branches:
        assert np.abs(pose(arm, one.start) - ACROSS[0]).max() < 1e-9
        assert len(one.posture) == 3
    assert {one.complete for one in branches} == {True, False}  # or nothing is tested here
    text = "\n".join("\n".join(section.lines) for section in across.sections())
    assert "the verdict is about this one" in text


@pytest.mark.spread(1)
@pytest.mark.slow
@pytest.mark.parametrize("number", [1, 2, 5])
def test_each_branch_has_its_own_verdict(across, number: int) -> None:
    """What the table says of a branch is what the path is alone, begun there."""
    one = across.tool.branches[number]
    alone = check_poses(across.robot, ACROSS, start=one.start, branches=False)
    assert alone.tool.reached == pytest.approx(one.reached, abs=1e-9)
    assert (alone.tool.reason, alone.tool.joint, alone.free_share == 1.0) == (one.reason, one.joint, one.free)
    assert (alone.verdict == "free") == (one.free and one.complete)


@pytest.mark.slow
def test_a_singular_first_pose_is_not_called_free() -> None:
    """A wrist that is straight at the first pose, whichever branch."""
    arm = open_robot("irb120")
    q = np.array([[0.2, 0.3, 0.2, 0.0, 0.0, 0.4], [0.2, 0.3, 0.2, 0.0, 0.6, 0.4]])
    found = check_poses(arm, pose(arm, q), start=q[0])
    straight = [one for one in found.tool.branches if abs(one.start[4]) < 1e-4]
    assert straight or not found.tool.branches
    assert not any(one.free for one in straight)


@pytest.mark.slow
def test_long_files_and_redundant_arms_get_no_table() -> None:
    arm = open_robot("kr3r540")
    many = poses_at(ACROSS, np.linspace(0, 1, 301))
    assert check_poses(arm, many).tool.branches == ()
    seven = open_robot("panda")
    q = np.array([[0.1, 0.2, 0.3, -1.5, 0.1, 1.8, 0.2], [0.1, 0.3, 0.3, -1.4, 0.1, 1.8, 0.2]])
    assert check_poses(seven, pose(seven, q), start=q[0]).tool.branches == ()


def test_the_table_says_where_a_branch_is_singular() -> None:
    """An LR Mate along Y through the middle, with A4 at 90°: two branches pass the wrist's singularity there."""
    arm = open_robot("lrmate200id")
    middle = pose(arm, np.radians([[0.0, 2.0, -2.0, 90.0, 0.0, 90.0]]))[0]
    poses = np.stack([middle, middle])
    poses[:, 1, 3] += (-0.02, 0.03)
    start = np.radians([-2.0, 2.0, -2.0, 90.0, 2.0, 90.0])
    check = check_poses(arm, poses, start=start)
    taken = next(branch for branch in check.tool.branches if branch.chosen)
    assert not taken.free
    assert taken.singular
    assert taken.place == pytest.approx(1.4, abs=1e-3)
    assert all(branch.singular <= (not branch.free) for branch in check.tool.branches)
    assert "at pose 1.4;" in check.sentence
    (crossing,) = check.to_dict()["crossings"]
    assert crossing["poses"] == pytest.approx([1.4, 1.4], abs=1e-3)
    rows = next(section for section in check.sections() if section.title == "Branches").rows
    assert "meets a singularity at pose 1.4" in str(rows)
