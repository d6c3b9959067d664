"""Every branch of a tool path is followed for itself; a start near the first pose is enough."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.kinematics import pose
from rankdrop.local.posture import fault, spine
from rankdrop.path.check import check
from rankdrop.path.check.check import check_poses, within_limits
from rankdrop.path.check.tool_line import poses_at
from rankdrop.poses.inverse import joint_difference
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
@pytest.mark.parametrize(("name", "q", "counts"), [
    ("puma560", [0.2, -0.6, 0.3, 0.4, 0.0, 0.3], (2, 1)),
    ("ur5e", [0.3, -1.2, 1.4, -1.0, 0.0, 0.4], (4, 2)),
    ("puma560", [0.2, -0.6, 0.3, 0.4, 0.5, 0.3], (2, 0)),
])  # fmt: skip
def test_points_of_a_self_motion_are_not_counted_as_solutions(
    monkeypatch: pytest.MonkeyPatch, name: str, q: list[float], counts: tuple[int, int]
) -> None:
    """Newton's method ends on more points of a self-motion from more starts; the counts stay what they are."""
    arm = open_robot(name)
    goal = pose(arm, np.array(q))
    found = []
    for starts in (256, 512):
        monkeypatch.setattr(check, "STARTS", starts)
        many = within_limits(arm, goal, resolve_task(None, arm))
        found.append(len(many))
        assert check._count_solutions(arm, goal, resolve_task(None, arm), many) == counts
    assert (found[1] > found[0]) == (counts[1] > 0)
    tool = check_poses(arm, goal[None]).tool
    assert (tool.solutions, tool.self_motions) == counts
    assert (f"of {counts[1]} self-motion" in tool.chosen) == (counts[1] > 0)


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
def test_a_start_near_the_first_pose_is_enough() -> None:
    arm = open_robot("ur5e")
    task = resolve_task(None, arm)
    goal = from_xyz_rpy([0.4, 0.2, 0.3], [np.pi, 0.0, 0.0])
    known = within_limits(arm, goal, task)
    rng = np.random.default_rng(4)
    for row, size in ((0, 0.1), (3, 0.4), (5, 0.7), (7, 0.8)):
        for _ in range(2):
            way = rng.normal(size=6)
            start = known[row] + size * way / np.linalg.norm(way)
            found = check_poses(arm, goal[None], start=start, branches=False)
            nearest = np.linalg.norm(joint_difference(arm, start, known), axis=1).min()
            taken = np.linalg.norm(joint_difference(arm, start, np.asarray(found.tool.start)[None]), axis=1)[0]
            assert taken == pytest.approx(nearest, abs=1e-6)
            assert found.tool.moved == pytest.approx(taken, abs=1e-6)


def test_the_posture_that_people_use_has_its_elbow_up() -> None:
    arm = open_robot("ur5e")
    for place in ([-0.4, 0.2, 0.3], [0.4, 0.2, 0.3], [0.5, -0.3, 0.4]):
        known = within_limits(arm, from_xyz_rpy(place, [np.pi, 0.0, 0.0]), resolve_task(None, arm))
        assert len(known) == 8
        height = spine(arm, known)[:, :, 2].mean(axis=1)
        assert height[0] > np.median(height)
        assert fault(arm, known)[0] == 0.0


@pytest.mark.slow
def test_long_files_and_redundant_arms_get_no_table() -> None:
    arm = open_robot("kr3r540")
    many = poses_at(ACROSS, np.linspace(0, 1, 301))
    assert check_poses(arm, many).tool.branches == ()
    seven = open_robot("panda")
    q = np.array([[0.1, 0.2, 0.3, -1.5, 0.1, 1.8, 0.2], [0.1, 0.3, 0.3, -1.4, 0.1, 1.8, 0.2]])
    assert check_poses(seven, pose(seven, q), start=q[0]).tool.branches == ()
