"""Configurations as they are typed."""

from __future__ import annotations

from math import pi, radians

import pytest

from rankdrop.cli.values import parse_configuration, parse_pose
from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.path import axes_2_and_3_opposed
from rankdrop.robot.open import open_robot


def test_configurations_as_people_write_them() -> None:
    arm = open_robot("scara")
    assert parse_configuration("[30deg, -pi/2; 120mm 0.5]", arm, deg=False) == [
        pytest.approx(pi / 6), -pi / 2, pytest.approx(0.12), 0.5,
    ]  # fmt: skip
    assert parse_configuration("30, -90, 0.12, 0.5rad", arm, deg=True) == [
        pytest.approx(pi / 6), pytest.approx(-pi / 2), 0.12, 0.5,
    ]  # fmt: skip
    for text in ("(1+1)/2, 0, 0, (1)", "{1, 0, 0, 1}", "(1 0 0 1)", "1, 0, 0, 1,", "[1;0;0;1]"):
        assert parse_configuration(text, arm, deg=False) == [1.0, 0.0, 0.0, 1.0]
    assert parse_configuration("−π/2, 0, 0, 1", arm, deg=False)[0] == -pi / 2  # as printed
    for text in ("", "1,,0,0,1", "1,2,3", "0,5 0,1 0 0"):
        with pytest.raises(ConfigurationError, match="4 joint values"):
            parse_configuration(text, arm, deg=False)


def test_configurations_of_programs_are_read_by_name() -> None:
    """As KRL writes an axis target: names, or letters and number, in the order of the joints."""
    arm = open_robot("kr16")
    wanted = [radians(x) for x in (0, -90, 90, 0, 0.5, 0)]
    for text in ("{A1 0, A2 -90, A3 90, A4 0, A5 0.5, A6 0}", "j1: 0; j2: −90; j3: 90; j4: 0; j5: 0.5; j6: 0;",
                 "joint_a1=0, joint_a2=-pi/2 rad, joint_a3=90, joint_a4=0, joint_a5=0.5deg, joint_a6=0"):  # fmt: skip
        assert parse_configuration(text, arm, deg=True) == pytest.approx(wanted)
    for text in ("A2 0, A1 -90, A3 90, A4 0, A5 0, A6 0", "A1 0, A2 -90", "A1 0, 5, A3 90, A4 0, A5 0, A6 0"):
        with pytest.raises(ConfigurationError, match="6 joint values"):
            parse_configuration(text, arm, deg=True)


@pytest.mark.parametrize(("arm", "noted"), [("lrmate200id", True), ("ur5", False)])
def test_joint_3_of_a_fanuc_is_counted_from_the_horizontal(
    arm: str, noted: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    listed = ", ".join(f"J{i}= {10 * i}.000 deg" for i in range(1, 7))
    values = parse_configuration(listed, open_robot(arm), deg=False)
    assert values == pytest.approx([radians(10 * i) for i in range(1, 7)])
    assert ("then write J3 + J2" in capsys.readouterr().err) == noted


def test_values_without_names_get_no_note_on_joint_3(capsys: pytest.CaptureFixture[str]) -> None:
    parse_configuration("0,0,0,0,0,0", open_robot("lrmate200id"), deg=False)
    assert capsys.readouterr().err == ""


def test_poses_in_degrees_without_a_unit_are_refused() -> None:
    arm = open_robot("ur5")
    with pytest.raises(OptionError, match="angles look like degrees; got 180; "):
        parse_pose("0.4,0.1,0.3,180,0,0", deg=False, robot=arm)
    for text, deg in (("0.4,0.1,0.3,1800deg,0,0", False), ("0.4,0.1,0.3,1800,0,0", True)):
        assert parse_pose(text, deg=deg, robot=arm)[3] == pytest.approx(radians(1800))


@pytest.mark.parametrize(("arm", "opposed"), [("lrmate200id", True), ("ur5", False), ("planar2r", False)])
def test_axes_2_and_3_of_a_fanuc_are_opposed(arm: str, opposed: bool) -> None:
    assert axes_2_and_3_opposed(open_robot(arm)) == opposed


@pytest.mark.parametrize("text", ["J2=0 J1=-90 J3=90 J4=0 J5=0 J6=0", "a: 0, b: 1, c: 2, d: 3, e: 4, f: 5"])
def test_names_in_another_order_are_refused_with_the_joints(text: str) -> None:
    with pytest.raises(ConfigurationError, match=r"names are not those of the joints in their order; .*fix: write the"):
        parse_configuration(text, open_robot("ur5e"), deg=True)


def test_a_pose_is_read_with_its_name_and_with_pi_as_code_writes_it() -> None:
    wanted = [0.3, 0.0, 0.4, -pi, 0.0, pi / 2]
    for text in ("0.3,0,0.4,-math.pi,0,np.pi/2", "home = [0.3, 0, 0.4, -math.pi, 0, M_PI_2];", "0.3 0 0.4 −π 0 π/2"):
        assert parse_pose(text, deg=False) == pytest.approx(wanted)
