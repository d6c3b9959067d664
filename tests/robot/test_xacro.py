"""xacro files are expanded by xacrodoc; what it cannot do is said in our words."""

from __future__ import annotations

import sys
from math import pi
from pathlib import Path

import pytest

from rankdrop.errors import MissingExtraError, RobotError
from rankdrop.robot.open import open_robot
from rankdrop.robot.xacro import from_xacro

ARM = """<?xml version="1.0"?>
<robot name="x_arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:include filename="{include}"/>
  <xacro:arg name="length" default="0.5"/>
  <link name="l0"/>
  <xacro:one i="0" j="1" xyz="0 0 0"/>
  <xacro:one i="1" j="2" xyz="$(arg length) 0 0"/>
</robot>
"""
MACRO = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="one" params="i j xyz">
    <link name="l${j}"/>
    <joint name="j${j}" type="revolute">
      <parent link="l${i}"/> <child link="l${j}"/> <origin xyz="${xyz}"/> <axis xyz="0 0 1"/>
      <limit lower="${-pi/2}" upper="${pi/2}"/>
    </joint>
  </xacro:macro>
</robot>
"""


def write(folder: Path, include: str, name: str = "arm.urdf.xacro") -> Path:
    path = folder / name
    path.write_text(ARM.replace("{include}", include), encoding="utf-8")
    return path


@pytest.fixture
def macros(tmp_path: Path) -> Path:
    folder = tmp_path / "pack"
    (folder / "urdf").mkdir(parents=True)
    (folder / "urdf" / "macro.xacro").write_text(MACRO, encoding="utf-8")
    return folder


def test_includes_are_relative_to_the_file(tmp_path: Path, macros: Path) -> None:
    pytest.importorskip("xacrodoc")
    arm = open_robot(write(tmp_path, "pack/urdf/macro.xacro"))
    assert (arm.name, arm.n, arm.tip, arm.upper[0]) == ("x_arm", 2, "l2", pi / 2)
    assert arm.joints[1].screw.tolist() == [0, -0.5, 0, 0, 0, 1]


def test_packages_are_found_by_the_map(tmp_path: Path, macros: Path) -> None:
    pytest.importorskip("xacrodoc")
    path = write(tmp_path, "$(find pack)/urdf/macro.xacro")
    assert open_robot(path, packages={"pack": macros}).n == 2
    with pytest.raises(RobotError, match="a package is not found; got 'pack'; mend: give its folder: packages="):
        open_robot(path)  # the map of the first call is not kept
    with pytest.raises(RobotError, match="package 'pack': the folder of a package is not there"):
        open_robot(path, packages={"pack": tmp_path / "nowhere"})


def test_arguments_are_passed(tmp_path: Path, macros: Path) -> None:
    pytest.importorskip("xacrodoc")
    path = write(tmp_path, "pack/urdf/macro.xacro")
    assert from_xacro(path, arguments={"length": "0.25"}).joints[1].screw[1] == -0.25


def test_a_urdf_with_xacro_elements_is_expanded(tmp_path: Path, macros: Path) -> None:
    pytest.importorskip("xacrodoc")
    assert open_robot(write(tmp_path, "pack/urdf/macro.xacro", "arm.urdf")).n == 2


def test_xacro_in_comments_does_not_make_a_xacro_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xacrodoc", None)
    path = tmp_path / "arm.urdf"
    joint = '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>'
    text = f'<robot name="r"><!-- <xacro:x/> --><link name="a"/><link name="b"/>{joint}</robot>'
    path.write_text(text, encoding="utf-8")
    assert open_robot(path).n == 1


def test_without_xacrodoc_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xacrodoc", None)
    with pytest.raises(MissingExtraError, match=r"rankdrop\[xacro\]"):
        open_robot(write(tmp_path, "x.xacro"))


def test_what_xacro_cannot_expand_is_said_in_one_line(tmp_path: Path) -> None:
    pytest.importorskip("xacrodoc")
    with pytest.raises(RobotError, match="xacro cannot expand the file") as caught:
        open_robot(write(tmp_path, "missing.xacro"))
    assert "\n" not in str(caught.value)


def test_document_types_are_refused_before_expansion(tmp_path: Path) -> None:
    path = tmp_path / "arm.xacro"
    path.write_text('<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/hostname">]><robot/>', encoding="utf-8")
    with pytest.raises(RobotError, match="document types and entities are refused"):
        open_robot(path)
