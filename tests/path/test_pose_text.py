"""A pose as it is copied from a program or a teach pendant: read by the maker's conventions, or refused in doubt."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.errors import OptionError
from rankdrop.path.read.makers import shoulder_height
from rankdrop.path.read.pose_text import pose_of_text
from rankdrop.poses.branches import matrix_of
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot

C, S = np.cos(np.radians(30)), np.sin(np.radians(30))
DOWN = np.array([[C, S, 0, 0.4], [S, -C, 0, 0.1], [0, 0, -1, 0.3], [0, 0, 0, 1]])
"""Rz(30°) Rx(180°) at (400, 100, 300) mm, entry by entry."""
AXIS = np.pi * np.array([np.cos(np.radians(15)), np.sin(np.radians(15)), 0])  # half a turn about this one
HALF = AXIS / np.pi


def read(text: str, **given: bool) -> Array:
    made = pose_of_text(text, "--pose", **given)
    assert made is not None
    return matrix_of(made.numbers)


@pytest.mark.parametrize("text", [
    f"p[0.4, 0.1, 0.3, {AXIS[0]}, {AXIS[1]}, 0]",
    "{X 400, Y 100, Z 300, A 30, B 0, C 180}",
    "{E6POS: X 400.0, Y 100.0, Z 300.0, A 30, B 0, C 180, S 2, T 35, E1 0.0}",
    "X = 400.000 mm, Y = 100 mm, Z = 300 mm, W = -180.0 deg, P = 0 deg, R = 30 deg",
    "X 400 Y 100 Z 300 W 180 P 0 R 30",
    "X 0.4m, Y 0.1m, Z 300mm, A 30°, B 0°, C 180°",
    f"[[400, 100, 300], [0, {HALF[0]}, {HALF[1]}, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]]",
    f"[[400, 100, 300], [0, {HALF[0]}, {HALF[1]}, 0]]",
    f"0.4, 0.1, 0.3, 0, {HALF[0]}, {HALF[1]}, 0 wxyz",
    f"400mm 100mm 300mm {HALF[0]} {HALF[1]} 0 0 xyzw",
    f"x=0.4 y=0.1 z=0.3 qw=0 qx={HALF[0]} qy={HALF[1]} qz=0",
    f"x: 400, y: 100, z: 300, q1: 0, q2: {HALF[0]}, q3: {HALF[1]}, q4: 0",
    "x=0.4; y=0.1; z=0.3; roll=π; pitch=0; yaw=pi/6",
    "posx(400, 100, 300, 0, 180, 150)",
    f"CONST robtarget p10:=[[400,100,300],[0,{HALF[0]},{HALF[1]},0],[0,-1,0,0],[9E+09,9E9,9E9,9E9,9E9,9E9]];",
    f"  LOCAL PERS robtarget p10 := [[400,100,300],[0,{HALF[0]},{HALF[1]},0],[0,-1,0,0],[0,0,9E9,9E9,9E9,9E9]];",
    f"P1=[[400, 100, 300], [0, {HALF[0]}, {HALF[1]}, 0]]",
    f"global Waypoint_1_p = p[0.4, 0.1, 0.3, {AXIS[0]}, {AXIS[1]}, 0]",
    "DECL E6POS XP1={X 400.0,Y 100.0,Z 300.0,A 30.0,B 0.0,C 180.0,S 2,T 35,E1 0.0}",
    "target[2] = posx(400, 100, 300, 0, 180, 150)",
    "x=0.4; y=0.1; z=0.3; roll=math.pi; pitch=0; yaw=np.pi / 6",
    f"{C} {S} 0 0.4 {S} {-C} 0 0.1 0 0 -1 0.3",
    f"{C}, {S}, 0, 400, {S}, {-C}, 0, 100, 0, 0, -1, 300 mm",
    f"T = np.array([[{C}, {S}, 0, 0.4], [{S}, {-C}, 0, 0.1], [0, 0, -1, 0.3], [0, 0, 0, 1]])",
    "posx([400.0, 100.0, 300.0, 30.0, 180.0, 180.0])",
])  # fmt: skip
def test_every_form_gives_the_same_pose(text: str) -> None:
    np.testing.assert_allclose(read(text), DOWN, atol=1e-12)


def test_the_order_of_turns_is_the_makers() -> None:
    """Three turns that do not commute, multiplied here."""
    a, b, c = np.radians([20, 40, 60])
    z = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    x = np.array([[1, 0, 0], [0, np.cos(c), -np.sin(c)], [0, np.sin(c), np.cos(c)]])
    np.testing.assert_allclose(read("{X 400, Y 0, Z 300, A 20, B 40, C 60}")[:3, :3], z @ y @ x, atol=1e-15)
    last = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    np.testing.assert_allclose(read("posx(400, 0, 300, 20, 40, 60)")[:3, :3], z @ y @ last, atol=1e-15)
    np.testing.assert_allclose(read("X 400 Y 0 Z 300 W 60 P 40 R 20")[:3, :3], z @ y @ x, atol=1e-15)


def test_a_whole_robtarget_is_in_millimetres_however_near() -> None:
    """Its configuration and external axes say that it is one: no length has to be above 10."""
    whole = "[[5, -4, 0], [0, 1, 0, 0], [0, -1, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]]"
    np.testing.assert_allclose(read(whole)[:3, 3], [0.005, -0.004, 0])
    for part in ("[[5, -4, 0], [0, 1, 0, 0]]", "[[5, -4, 0], [0, 1, 0, 0], [0, -1, 0, 0]]"):
        with pytest.raises(OptionError, match=r"order of the quaternion is in doubt.*or the whole robtarget"):
            read(part)


def test_pi_and_conversions_are_read_in_a_pose_of_urscript() -> None:
    for text in ("p[0.4, 0, 0.3, -math.pi, 0, 0]", "p[0.4, 0, 0.3, d2r(180), 0, 0]", "p[0.4,0,0.3,2*pi/2,0,0]"):
        np.testing.assert_allclose(read(text), read(f"p[0.4, 0, 0.3, {np.pi}, 0, 0]"), atol=1e-12)


@pytest.mark.parametrize(
    "numbers", ["1 0 0 0 1 0 0 0 1 0.4 0.1 0.3", "1 0 0 0 0 1 0 -1 0 0 1 0.3", "1 2 3 4 5 6 7 8 9 10 11 12"]
)
def test_twelve_numbers_in_doubt_are_refused_and_read_as_the_refusal_says(numbers: str) -> None:
    """Nine of a rotation, then the place; numbers that are a rotation in both orders; none in either."""
    with pytest.raises(OptionError, match=r"order of twelve numbers is in doubt; .*fix: write the rows in brackets"):
        read(numbers)


def test_a_mirrored_other_order_leaves_no_doubt() -> None:
    np.testing.assert_allclose(read("1 0 0 0 0 1 0 1 0 0 1 0.3")[:3, 3], [0, 1, 0.3])


def test_twelve_numbers_in_brackets_are_rows() -> None:
    np.testing.assert_allclose(read("[[1,0,0,0],[0,1,0,-1],[0,0,1,0.3]]")[:3, 3], [0, -1, 0.3])


@pytest.mark.parametrize(("text", "said"), [
    ("p[400, 0, 300, 3.1, 0, 0]", r"m or mm is in doubt.*got 400 in x, y, z; allowed: Universal Robots: m and rad"),
    ("p[0.4, 0, 0.3, 180, 0, 0]", r"radians or degrees is in doubt.*got 180 in rx, ry, rz"),
    ("p[0.4, 0, 0.3, 3.1, 0]", "a pose of URScript has six numbers"),
    ("X 0.4, Y 0.1, Z 0.3, A 0, B 90, C 0", r"m or mm is in doubt.*fix: write a unit behind each length, such as"),
    ("X 400, Y 100, Z 300, A 0, B 1.57, C 0", r"radians or degrees is in doubt.*write a unit behind each angle"),
    ("X 400mm, Y 100, Z 300, A 0, B 90, C 0", "m or mm is in doubt"),
    ("posx(0.4, 0, 0.3, 0, 180, 0)", r"m or mm is in doubt.*allowed: Doosan: mm and degrees"),
    ("posx(400, 0, 300, 0, 180)", "a pose of DRL has six numbers"),
    ("x=300mm y=0 z=200mm roll=180 pitch=0 yaw=0", r"angles look like degrees; got 180; .*write a unit behind each"),
    ("x=300mm y=0 z=200mm roll=0deg pitch=0 yaw=-90", "angles look like degrees; got -90"),
    ("[[0.4, 0.1, 0.3], [0, 1, 0, 0]]", "the order of the quaternion is in doubt"),
    ("x 0.4 y 0 z 0.3 rx 180deg ry 0deg rz 0deg", "can be a rotation vector or angles about three axes"),
    ("X 400, Y 100, A 90", "the names are not those of one pose; got X, Y, A"),
    ("0.4, 0, 0.3, 1, 0, 0 wxyz", "three lengths and a quaternion are seven numbers; got|got 6 numbers"),
])  # fmt: skip
def test_doubtful_forms_are_refused(text: str, said: str) -> None:
    with pytest.raises(OptionError, match=said):
        pose_of_text(text, "--pose")


def test_plain_numbers_are_none_of_these_forms() -> None:
    for text in ("0.4,0.1,0.3", "0.4 0.1 0.3 180deg 0 30deg", "[0.35, 0, 0.4, 1, 0, 0, 0]", "350mm,0,0.4,pi,0,0"):
        assert pose_of_text(text, "--pose") is None


def test_angles_by_name_are_in_degrees_where_that_is_said() -> None:
    stated = "x=0.4 y=0.1 z=0.3 roll=180deg pitch=0 yaw=30deg"
    np.testing.assert_allclose(read(stated), DOWN, atol=1e-12)
    np.testing.assert_allclose(read("x=0.4 y=0.1 z=0.3 roll=900 pitch=0 yaw=30", deg=True), DOWN, atol=1e-12)


def test_degrees_by_option_and_the_height_of_a_fanuc_count() -> None:
    arm = open_robot("lrmate200id")
    flat = pose_of_text("X 400 Y 0 Z 300 W 2 P 0 R 3", "--pose", deg=True, robot=arm)
    assert flat is not None
    np.testing.assert_allclose(flat.numbers, [0.4, 0, 0.3 + shoulder_height(arm), *np.radians([2, 0, 3])], atol=1e-15)
    assert "FANUC writes them" in flat.notes[0]
    with pytest.raises(OptionError, match="are a rotation vector in radians"):
        pose_of_text("p[0.4,0,0.3,3.1,0,0]", "--pose", deg=True)
