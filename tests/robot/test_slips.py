"""Slips of the hand in robot files: refused or noted, with their place."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest

from rankdrop.errors import RobotError
from rankdrop.robot.dh import DHRow, from_dh
from rankdrop.robot.model import JointKind, Robot
from rankdrop.robot.open import open_robot, robot_names
from rankdrop.robot.quantities import quantity
from rankdrop.robot.screws import from_screws
from rankdrop.robot.toml_file import robot_from_toml
from rankdrop.robot.urdf import from_urdf
from robot import urdf_text

DH = 'convention = "standard"\n[[joints]]\na = 1\n[[joints]]\n'
SCREWS = 'order = "linear-first"\n[[joints]]\naxis = [0, 0, 1]\npoint = [0, 0, 0]\n[[joints]]\n'
TREE = """<robot name="r"><link name="base"/><link name="arm"/><link name="tool"/>
<joint name="j1" type="continuous"><parent link="base"/><child link="arm"/></joint>
<joint name="j2" type="fixed"><parent link="arm"/><child link="tool"/></joint></robot>"""


def read(text: str) -> Robot:
    return robot_from_toml(text, file="arm.toml")


def test_a_helical_joint_needs_a_pitch() -> None:
    for text in (DH + 'kind = "helical"', DH + 'kind = "H"'):
        with pytest.raises(RobotError, match="joint 2, pitch: a helical joint needs a pitch"):
            read(text)
    with pytest.raises(RobotError, match="joint 2, pitch: a helical joint needs a pitch"):
        read(SCREWS + 'kind = "helical"\naxis = [0, 0, 1]\npoint = [1, 0, 0]')
    with pytest.raises(RobotError, match="DH row 1, pitch: a helical joint needs a pitch"):
        from_dh([DHRow(kind=JointKind.HELICAL)], convention="standard")


@pytest.mark.parametrize("text", [DH + "a = 1\n", SCREWS + "axis = [0, 0, 1]\npoint = [1, 0, 0]\n"])
def test_limits_of_many_turns_are_kept_and_noted(text: str) -> None:
    arm = read(text + 'name = "X"\nlower = -170\nupper = 170')
    assert arm.upper[1] == 170.0
    words = "joint 'X': limits of -170 … 170 rad are many turns; write \"170 deg\" for degrees"
    assert [str(note) for note in arm.notes if "turns" in str(note)] == [words]
    assert not [str(note) for note in read(text + "lower = -6.3\nupper = 6.3").notes if "turns" in str(note)]


@pytest.mark.parametrize(
    ("limit", "told"),
    [('lower="-170" upper="165"', "2.967"), ('lower="-6.3" upper="6.3"', ""), ('lower="-1000" upper="1000"', "")],
)
def test_limits_of_a_urdf_that_look_like_degrees_are_noted(limit: str, told: str) -> None:
    inside = f'<axis xyz="0 0 1"/><limit {limit} velocity="3"/>'
    arm = from_urdf(urdf_text.robot([urdf_text.joint("X", "base", "a", inside=inside)]))
    words = f"joint 'X': limits of -170 … 165 rad are many turns; 170° is {told}"
    assert [str(note) for note in arm.notes if "turns" in str(note)] == ([words] if told else [])


@pytest.mark.parametrize(
    ("angle", "told"),
    [("alpha = 90", True), ("theta = -90.0", True), ('alpha = "90 deg"', False), ("theta = 7", False)],
)
def test_fixed_angles_that_look_like_degrees_are_noted(angle: str, told: bool) -> None:
    notes = [str(note) for note in read(DH + angle).notes if "turns" in str(note)]
    assert notes == (["a fixed angle of 90 rad is many turns; 90° is 1.571"] if told else [])


def test_no_arm_of_the_catalogue_makes_many_turns() -> None:
    assert not [note for name in robot_names() for note in open_robot(name).notes if "many turns" in str(note)]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (DH + "a = 1e308", "line 5, joint 2, a: the value is too large; got 1e[+]308; allowed: -1e[+]12 … 1e[+]12 m"),
        (DH + 'd = "1e16 mm"', "joint 2, d: the value is too large"),
        (SCREWS + "axis = [0, 0, 1]\npoint = [1e308, 0, 0]", "joint 2, point: the value is too large"),
        (SCREWS + "axis = [0, 0, 1e308]\npoint = [1, 0, 0]", "joint 2, axis: the value is too large"),
        (SCREWS + "screw = [1e308, 0, 0, 0, 0, 1]", "joint 2, screw: the value is too large"),
    ],
)
def test_lengths_that_no_arm_has_are_refused(text: str, words: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(RobotError, match=words):
            read(text)
        with pytest.raises(RobotError, match="the screw is too large"):
            from_screws([[1e308, 0, 0, 0, 0, 1]], order="linear-first")


def test_units_are_named_in_words() -> None:
    with pytest.raises(RobotError, match=r"and a unit \(m, cm, mm, in\)"):
        quantity("1 deg", "length", where="a")


def test_an_empty_file_is_called_empty(tmp_path: Path) -> None:
    for name in ("arm.urdf", "arm.toml", "arm.xacro"):
        (tmp_path / name).write_text(" \n", encoding="utf-8")
        with pytest.raises(RobotError, match="the file is empty"):
            open_robot(tmp_path / name)


def test_a_tip_above_the_base_is_told_so() -> None:
    words = "allowed: another tip: 'base' is a root, no joint carries it; fix: exchange base and tip"
    with pytest.raises(RobotError, match=words):
        from_urdf(TREE, base="tool", tip="base")


def test_one_joint_is_one_joint() -> None:
    assert "end of the longest chain, 1 moving joint;" in str(from_urdf(TREE).notes[1])


def test_a_link_that_differs_in_capitals_only_is_the_only_suggestion() -> None:
    with pytest.raises(RobotError, match=r"did you mean base\?$"):
        from_urdf(TREE.replace("tool", "base2"), base="Base")
