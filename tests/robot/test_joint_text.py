"""Joint values as they stand in code, in messages and in programs: the list is found, its unit and order are kept.

Forms of reports: arrays of NumPy and MATLAB (petercorke/robotics-toolbox-python#350), a trajectory point as ROS prints
it (ros-industrial-attic/ur_modern_driver#54), an array of C++ in degrees (DoosanRobotics/API-DRFL#32).
"""

from __future__ import annotations

from math import pi, radians

import pytest

from rankdrop.cli.values import parse_configuration
from rankdrop.errors import ConfigurationError
from rankdrop.robot.joint_text import LONGEST_PASTE, joints_of_text
from rankdrop.robot.open import open_robot

VALUES = [0.1, -1.2, 1.0, 0.2, 0.0, 0.3]
DEGREES = [0, -90, 90, 0, 5, 0]
NAMES = ["elbow_joint", "shoulder_lift_joint", "shoulder_pan_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
"""Of a UR arm as its driver sorts them: not in the order of the chain."""
SORTED = [1.0, -1.2, 0.1, 0.2, 0.0, 0.3]


@pytest.mark.parametrize(
    "text",
    [
        "q = [0.1 -1.2 1.0 0.2 0.0 0.3]';",
        "q0 = np.array([0.1, -1.2, 1.0, 0.2, 0.0, 0.3], dtype=np.float64)",
        "tensor([[ 0.1, -1.2, 1.0, 0.2, 0.0, 0.3]])",
        "double q[6] = {0.1, -1.2, 1.0, 0.2, 0.0, 0.3};",
        "std::vector<double> q = {0.1, -1.2, 1.0, 0.2, 0.0, 0.3};",
        "{{0.1, -1.2, 1.0, 0.2, 0.0, 0.3}}",
        "q: 0.1, -1.2, 1.0, 0.2, 0.0, 0.3",
        "positions: [0.1, -1.2, 1.0, 0.2, 0.0, 0.3]\nvelocities: [0, 0, 0, 0, 0, 0]",
        "position:\n- 0.1\n- -1.2\n- 1.0\n- 0.2\n- 0.0\n- 0.3\nvelocity:\n- 0.0\n",
        "- 0.1\n- -1.2\n- 1.0\n- 0.2\n- 0.0\n- 0.3",
        "0.1|-1.2|1.0|0.2|0.0|0.3",
        "J1=0.1 J2=-1.2 J3=1.0 J4=0.2 J5=0.0 J6=0.3",
        "J1 = 0.1 rad  J2 = -1.2 rad\nJ3 = 1.0 rad J4=0.2 J5=0.0  J6=0.3",
        "ur_joint1 = 0.1\nur_joint2 = -1.2\nur_joint3 = 1.0\nur_joint4 = 0.2\nur_joint5 = 0.0\nur_joint6 = 0.3\n",
        "arm1_q1: 0.1, arm1_q2: -1.2, arm1_q3: 1.0, arm1_q4: 0.2, arm1_q5: 0.0, arm1_q6: 0.3",
    ],
)
def test_a_list_is_read_without_what_stands_around_it(text: str) -> None:
    assert parse_configuration(text, open_robot("ur5"), deg=False) == VALUES


@pytest.mark.parametrize(
    "text",
    [
        "deg2rad([0,-90,90,0,5,0])",
        "q = np.radians(np.array([0, -90, 90, 0, 5, 0]))",
        "q=[0 -90 90 0 5 0] * pi / 180;",
        "np.array([0,-90,90,0,5,0])/180*np.pi",
        "[0,-90,90,0,5,0]*DEG2RAD",
        "[d2r(0), d2r(-90), d2r(90), d2r(0), d2r(5), d2r(0)]",
        "[0, -M_PI_2, M_PI/2, 0, 5 * M_PI / 180, 0]",
        "0, -np.pi / 2, pi/2, 0, math.radians(5), 0",
        "[0, -math.pi/2, math.pi / 2, 0, 5*math.pi/180, -0*math.pi]",
        "J1=0deg J2=-90 deg J3=90 ° J4=0 J5=5deg J6=0",
        "posj(0,-90,90,0,5,0)",
        "[[0,-90,90,0,5,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]]",
        "CONST jointtarget p1 := [[0,-90,90,0,5,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];",
        "{A1 0, A2 -90, A3 90, A4 0, A5 5, A6 0}",
        "{E6AXIS: A1 0, A2 -90, A3 90, A4 0, A5 5, A6 0, E1 0.0, E2 0.0}",
        "DECL E6AXIS XHOME={A1 0,A2 -90,A3 90,A4 0,A5 5,A6 0,E1 100.0}",
    ],
)
@pytest.mark.parametrize("deg", [False, True])
def test_a_form_that_states_its_unit_is_read_in_it(text: str, deg: bool) -> None:
    if deg and ("pi" in text or "PI" in text) and not text.startswith(("q=", "np.array")):
        pytest.skip("the numbers of this form are in radians")
    got = parse_configuration(text, open_robot("kr6r900"), deg=deg)
    assert got == pytest.approx([radians(x) for x in DEGREES], abs=1e-15)


@pytest.mark.parametrize("prefix", ["", "left_"])
@pytest.mark.parametrize("dashes", [False, True])
def test_the_values_of_a_message_are_ordered_by_its_names(prefix: str, dashes: bool) -> None:
    names, values = [prefix + name for name in NAMES], [str(x) for x in SORTED]
    if dashes:
        listed = ["\n" + "\n".join(f"- {item}" for item in items) for items in (names, values)]
    else:
        listed = [f"[{', '.join(items)}]" for items in (names, values)]
    text = f"header:\n  frame_id: base\nname: {listed[0]}\nposition: {listed[1]}\nvelocity: []\neffort: []\n---"
    assert parse_configuration(text, open_robot("ur5"), deg=False) == VALUES


def test_a_message_of_another_arm_is_refused() -> None:
    arm = open_robot("ur5")
    with pytest.raises(ConfigurationError, match="no value for this joint; got a, b"):
        parse_configuration("name: [a, b]\nposition: [1, 2]", arm, deg=False)
    with pytest.raises(ConfigurationError, match="2 names, 3 values"):
        parse_configuration("name: [a, b]\nposition: [1, 2, 3]", arm, deg=False)


def test_two_configurations_are_no_joint_target() -> None:
    with pytest.raises(ConfigurationError, match="6 joint values are needed; got 12"):
        parse_configuration("[[0,0,0,0,1,0],[0,0,0,0,2,0]]", open_robot("ur5"), deg=False)


def test_arithmetic_is_no_form_around_a_list() -> None:
    scara = open_robot("scara")
    assert parse_configuration("sqrt(4), 0, 0, sqrt(1)", scara, deg=False) == [2.0, 0.0, 0.0, 1.0]
    assert parse_configuration("3 * pi / 4, 0, 0, 0", scara, deg=False)[0] == 3 * pi / 4
    assert joints_of_text("q = [" + " " * LONGEST_PASTE, ("a",), where="--q").text.startswith("q = [")


def test_values_with_names_keep_their_names() -> None:
    text = "j1 = (pi/2), j2 = 0, j3 = 0, j4 = 0, j5 = 0, j6 = 0"
    assert parse_configuration(text, open_robot("kr16"), deg=False) == [pi / 2, 0, 0, 0, 0, 0]
