"""Files of paths, read and checked."""

from __future__ import annotations

from pathlib import Path

import pytest

from rankdrop.path.check.path_file import PathQuestion, check_file
from rankdrop.questions import PathOptions
from rankdrop.robot.open import open_robot

SAMPLE = """name = "sample-manipulator"
[home]
xyz = [0, 0, 2]
"""  # the arm of pinocchio's buildSampleModelManipulator, pinocchio issue 1006
SAMPLE += "".join(
    f"[[joints]]\naxis = {axis}\npoint = [0, 0, {z}]\n"
    for axis, z in (("[1, 0, 0]", 0), ("[0, 1, 0]", 0), ("[0, 0, 1]", 0), ("[0, 1, 0]", 1), ("[1, 0, 0]", 2),
                    ("[0, 1, 0]", 2))
)  # fmt: skip


@pytest.mark.slow
def test_a_path_from_the_edge_of_reach_inwards_is_followed(tmp_path: Path) -> None:
    (tmp_path / "arm.toml").write_text(SAMPLE)
    (tmp_path / "in.csv").write_text("x,y,z,roll,pitch,yaw\n0,0,2,0,0,0\n0.5,0,1.5,0,0,0\n")
    robot = open_robot(tmp_path / "arm.toml")
    check = check_file(robot, tmp_path / "in.csv", PathQuestion(None, None, PathOptions()))
    assert check.tool.complete
    assert [one.rest for one in check.tool.passed] == [True]
    assert check.sentence == "The path leaves the singularity at its start, from rest."
    assert not check.holds
    assert not check.clear
    (tmp_path / "out.csv").write_text("x,y,z,roll,pitch,yaw\n0.5,0,1.5,0,0,0\n-0.1,0,2.1,0,0,0\n")
    out = check_file(robot, tmp_path / "out.csv", PathQuestion(None, None, PathOptions()))
    assert not out.tool.complete
    assert out.tool.folds
    assert "folds back" in out.sentence
