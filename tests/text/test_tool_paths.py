"""How the path of a tool is worded."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from rankdrop.kinematics import pose
from rankdrop.path.check.tool_path import check_poses
from rankdrop.poses.inverse import rotation
from rankdrop.robot.open import open_robot
from rankdrop.text import tool_paths
from rankdrop.text.tool_paths import branch_chosen, branches_words


@pytest.mark.shipped
def test_a_line_that_five_joints_cannot_keep_to_is_told_by_their_number() -> None:
    """Both ends are poses of the arm; straight between them its position and orientation are not."""
    arm = open_robot("px150")
    ends = pose(arm, np.array([[0.3, -0.2, 0.4, 0.5, 0.2], [0.5, 0.0, 0.3, 0.4, 0.6]]))
    check = check_poses(arm, ends, task="pose", start=[0.3, -0.2, 0.4, 0.5, 0.2])
    assert check.tool is not None
    assert (check.tool.reason, check.verdict) == ("few joints", "cannot be followed")
    assert "5 joints cannot take all poses between pose 1 and 2" in check.summary[0]
    assert check_poses(arm, ends, task="tool-axis-free", start=[0.3, -0.2, 0.4, 0.5, 0.2]).verdict == "free"


@pytest.mark.slow
def test_half_a_turn_between_two_poses_is_a_choice_and_is_said() -> None:
    """180° about the tool's axis: joint 6 turns by half a turn one way or the other, and both are as short."""
    robot = open_robot("irb120")
    start = np.array([0.2, 0.1, 0.2, 0.3, 0.9, 0.0])
    ends = pose(robot, np.stack([start, start, start]))
    ends[1, :3, :3] = ends[0, :3, :3] @ np.diag([-1.0, -1.0, 1.0])
    ends[2, :3, :3] = ends[1, :3, :3] @ rotation(np.array([[0.0, 0.0, 3.0]]))[0]
    checked = check_poses(robot, ends, start=start)
    assert checked.tool is not None
    assert checked.tool.half_turns == (1,)
    assert any(note.startswith("half a turn: from pose 1 the next one is 180° away") for note in checked.notes)
    plain = check_poses(robot, ends[1:], start=checked.tool.q[-1] - [0, 0, 0, 0, 0, 3.0])
    assert plain.tool is not None
    assert plain.tool.half_turns == ()
    assert not any(note.startswith("half a turn") for note in plain.notes)
    assert check_poses(robot, ends[:2], start=start, task="position").tool.half_turns == ()


@pytest.mark.parametrize(("free", "words"), [
    ([], "1 of 1; the verdict is about this one"),
    ([False], "The other one is not free to the end"), ([True], "The other one is free to the end"),
    ([False] * 3, "None of the 3 others is free to the end"), ([True] * 3, "All 3 others are free to the end"),
    ([True, False], "Of the 2 others 1 is free to the end"),
])  # fmt: skip
def test_how_many_other_branches_are_free(free: list[bool], words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tool_paths, "posture_words", lambda posture, parts: "–")
    branches = [SimpleNamespace(chosen=not k, free=one, complete=True, posture=(), parts=())
                for k, one in enumerate([True, *free])]  # fmt: skip
    said = branches_words(SimpleNamespace(tool=SimpleNamespace(branches=branches)))
    assert said.endswith(words)
    assert " 0 " not in said


def test_a_single_solution_is_no_choice_of_one() -> None:
    tool = SimpleNamespace(given_start=False, more=False, solutions=1, self_motions=0)
    assert branch_chosen(tool) == "the posture that people use (the only one found)"
