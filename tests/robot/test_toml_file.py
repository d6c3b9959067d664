"""The DH file and the screw file: what they mean, and errors that name file, line, key and what is allowed."""

from __future__ import annotations

from contextlib import suppress
from math import inf, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rankdrop.errors import RobotError
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import JointKind, Robot
from rankdrop.robot.screws import from_screws, helical, revolute, spherical
from rankdrop.robot.toml_file import robot_from_toml
from rankdrop.robot.transform import from_xyz_rpy

DH = """\
name = "arm"
convention = "standard"
task = "position"

[base]
xyz = ["1 cm", 0, 0]

[[joints]]
name = "turn"
alpha = "pi/2"
d = "316 mm"
lower = "-90 deg"
upper = 2.5
velocity = "180 deg/s"

[[joints]]
kind = "prismatic"
theta = "-pi/2"
d = 0.1
lower = 0
upper = "50 in"

[tool]
rpy = [0, "90 deg", 0]
"""


def read(text: str) -> Robot:
    return robot_from_toml(text, file="arm.toml")


def test_dh_file_is_the_table_it_holds() -> None:
    robot = read(DH)
    base, tool = from_xyz_rpy([0.01, 0, 0], [0, 0, 0]), from_xyz_rpy([0, 0, 0], [0, pi / 2, 0])
    same = from_dh(
        [(0, pi / 2, 0.316, 0), (0, 0, 0.1, -pi / 2)], kinds="RP", convention="standard", base=base, tool=tool
    )
    assert np.array_equal(robot.home, same.home)
    assert all(np.array_equal(a.screw, b.screw) for a, b in zip(robot.joints, same.joints, strict=True))
    assert (robot.name, robot.task, robot.source.kind, robot.source.origin) == ("arm", "position", "dh", "arm.toml")
    assert [joint.name for joint in robot.joints] == ["turn", "joint2"]
    assert robot.joints[0].velocity == pytest.approx(pi)
    assert (robot.lower.tolist(), robot.upper.tolist()) == ([-pi / 2, 0.0], [2.5, pytest.approx(1.27)])


def test_a_joint_table_may_be_empty() -> None:
    joint = read('convention = "modified"\n[[joints]]\na = 0\n[[joints]]\n').joints[1]
    assert (joint.kind, joint.lower, joint.upper, joint.velocity) == (JointKind.REVOLUTE, -inf, inf, inf)


def test_screw_file_takes_screws_axes_and_compound_joints() -> None:
    robot = read(
        """\
        order = "angular-first"
        [home]
        xyz = [0, 0, 1]
        [[joints]]
        screw = [0, 0, 2, 0, "-1 * 2", 0]
        [[joints]]
        kind = "helical"
        axis = [0, 1, 0]
        point = ["100 mm", 0, 0]
        pitch = "5 mm"
        [[joints]]
        name = "ball"
        kind = "spherical"
        point = [0, 0, 1]
        lower = [-1, "-90 deg", -3]
        upper = [1, 2, 3]
        [[joints]]
        name = "c"
        kind = "cylindrical"
        axis = [1, 0, 0]
        point = [0, 0, 0]
        [[joints]]
        kind = "prismatic"
        axis = [0, 0, 1]
        upper = "20 cm"
        """
    )
    expected = [revolute([0, 0, 1], [1, 0, 0]), helical([0, 1, 0], [0.1, 0, 0], 0.005), *spherical([0, 0, 1])]
    same = from_screws(expected, order="linear-first")
    for joint, wanted in zip(robot.joints, same.joints, strict=False):
        assert joint.screw == pytest.approx(wanted.screw, abs=1e-15)
        assert joint.kind is wanted.kind
    assert [joint.name for joint in robot.joints] == [
        "joint1", "joint2", "ball_1", "ball_2", "ball_3", "c_slide", "c_turn", "joint5",
    ]  # fmt: skip
    assert robot.joints[3].lower == -pi / 2
    assert robot.joints[7].upper == pytest.approx(0.2)
    assert robot.home[2, 3] == 1.0


@pytest.mark.parametrize("head", ['convention = "standard"', 'order = "linear-first"'])
def test_lengths_are_letters_with_values_in_either_file(head: str) -> None:
    joint = "a = 0.635" if "convention" in head else "screw = [0, 0, 0, 0, 0, 1]"
    robot = read(f'{head}\n[lengths]\nd = 6.85\na = "635 mm"\nupper_arm = "1/4"\n[[joints]]\n{joint}\n')
    assert robot.lengths == (("d", 6.85), ("a", pytest.approx(0.635, abs=1e-15)), ("upper_arm", 0.25))
    assert read(f"{head}\n[[joints]]\n{joint}\n").lengths == ()


BAD = [
    ("convention = 'standard'\n[[joints]]\nalfa = 0\n", 3, "joint 1, alfa: unknown key; got 'alfa'; allowed: a, alpha"),
    ("convention = 'standard'\nnam = 'x'\n[[joints]]\n", 2, "nam: unknown key; got 'nam'; allowed: name, maker, "),
    ("convention = 'craig'\n[[joints]]\n", 1, "no such convention; got 'craig'; allowed: \"standard\" or"),
    ("order = 'v'\n[[joints]]\n", 1, "no such order"),
    ("name = 'x'\n[[joints]]\na = 1\n", 1, "kind of table is not said"),
    ("name = 'x'\nconvention = 'standard'\n", 1, "there are no joints"),
    ("convention = 'standard'\njoints = [1]\n", 2, "there are no joints"),
    ("convention = 'standard'\n[[joints]]\n[[joints]]\n\nd = 'two'\n", 5, "joint 2, d: the unit"),
    ("convention = 'standard'\n[[joints]]\nd = nan\n", 3, "not finite; got nan"),
    ("convention = 'standard'\n[[joints]]\na = true\n", 3, "not a number; got True"),
    ("convention = 'standard'\n[[joints]]\nkind = 'ball'\n", 3, "no such kind of joint"),
    ("convention = 'standard'\n[[joints]]\nupper = 1\nlower = 2\n", 4, "lower limit above upper limit"),
    ("convention = 'standard'\n[[joints]]\nname = 3\n", 3, "name of a joint is a text"),
    ("convention = 'standard'\n[tool]\nxyz = [0, 0]\n[[joints]]\n", 3, "xyz is a list of 3 numbers"),
    ("convention = 'standard'\n[tool]\nquat = [0, 0]\n[[joints]]\n", 3, "unknown key; got 'quat'; allowed: xyz, rpy"),
    ("convention = 'standard'\ntool = 3\n[[joints]]\n", 2, "a pose is a table"),
    ("convention = 'standard'\ntask = 3\n[[joints]]\n", 2, "task is a text"),
    ("convention = 'standard'\nlengths = 3\n[[joints]]\n", 2, "lengths is a table of letters; got 3"),
    ("convention = 'standard'\n[lengths]\na = 1\nc23 = 1\n[[joints]]\n", 4, "c23: a length cannot have this name"),
    ("convention = 'standard'\n[lengths]\n'ℓ' = 1\n[[joints]]\n", 3, "cannot have this name; got 'ℓ'"),
    ("convention = 'standard'\n[lengths]\npi = 1\n[[joints]]\n", 3, "this name; got 'pi'; allowed: a letter"),
    ("convention = 'standard'\n[lengths]\na = 0\n[[joints]]\n", 3, "a: a length with a letter is positive; got 0"),
    ("convention = 'standard'\n[lengths]\na = '-3 mm'\n[[joints]]\n", 3, "is positive; got -3 mm; .*without its sign"),
    ("convention = 'standard'\n[lengths]\na = nan\n[[joints]]\n", 3, "not finite"),
    ("convention = 'standard'\n[lengths]\na = '3 deg'\n[[joints]]\n", 3, "the unit is not one that fits"),
    ("order = 'linear-first'\n[lengths]\na = [1]\n[[joints]]\naxis = [0, 0, 1]\n", 3, "this is not a number"),
    ("convention = 'standard'\nnotes = 'x'\n[[joints]]\n", 2, "notes is a list"),
    ("[[joints]]\nscrew = [0, 0, 1, 0, 0, 0]\n", 2, "order of the screws must be named"),
    ("order = 'linear-first'\n[[joints]]\nscrew = [0, 0, 1]\n", 3, "screw is a list of 6 numbers"),
    ("order = 'linear-first'\n[[joints]]\nscrew = [0, 0, 0, 0, 0, 0]\n", 3, "no length"),
    ("[[joints]]\naxis = [0, 0, 0]\npoint = [0, 0, 0]\n", 1, "the axis has no length"),
    ("[[joints]]\naxis = [0, 0, 1]\n", 1, "point is a list of 3 numbers"),
    ("[[joints]]\naxis = [0, 0, 1]\nkind = 'helical'\npoint = [0, 0, 0]\n", 1, "needs a pitch"),
    ("[[joints]]\nkind = 'prismatic'\naxis = [0, 0, 1]\npoint = [0, 0, 0]\n", 4, "unknown key; got 'point'"),
    ("[[joints]]\nkind = 'spherical'\npoint = [0, 0, 0]\nlower = 3\n", 4, "lower of a compound joint is a list"),
    ("[[joints]]\nkind = 'spherical'\npoint = [0, 0, 0]\naxes = [[1,0,0],[2,0,0],[0,0,1]]\n", 1, "three independent"),
    ("[[joints]]\nkind = 'ball'\npoint = [0, 0, 0]\n", 2, "no such kind of joint; got 'ball'; .*spherical"),
]


@pytest.mark.parametrize(("text", "line", "words"), BAD)
def test_what_cannot_be_used_names_file_line_and_key(text: str, line: int, words: str) -> None:
    with pytest.raises(RobotError, match=words) as caught:
        read(text)
    assert str(caught.value).startswith(f"arm.toml, line {line}")
    assert "\n" not in str(caught.value)


def test_what_concerns_the_whole_file_names_the_file() -> None:
    for text, words in (("a = [", "not TOML"), ("a = " + "[" * 5000, "not TOML")):
        with pytest.raises(RobotError, match=words) as caught:
            read(text)
        assert str(caught.value).startswith("arm.toml: ")
    with pytest.raises(RobotError, match=r"arm\.toml, .*same name"):
        read("convention = 'standard'\n[[joints]]\nname = 'a'\n[[joints]]\nname = 'a'\n")


def test_lines_are_right_after_a_text_of_several_lines() -> None:
    text = 'source = """\nx = 1\n[[joints]]\n"""\nconvention = "standard"\n[[joints]]\n"b" = 1\n'
    with pytest.raises(RobotError, match=r"^arm\.toml, line 7, joint 1, b: unknown key"):
        read(text)


@pytest.mark.slow
@given(st.text(max_size=60))
def test_any_text_gives_a_robot_or_a_robot_error(text: str) -> None:
    with suppress(RobotError):
        assert read(text).joints


def test_a_number_of_thousands_of_digits_is_refused_in_one_line() -> None:
    with pytest.raises(RobotError, match=r"this is not TOML: .*digits"):
        robot_from_toml(f'convention = "standard"\n[[joints]]\na = {"9" * 5000}\n', file="long.toml")
