"""xacro files are expanded by the package xacro in a child process; errors are in our words."""

from __future__ import annotations

import sys
from math import pi
from pathlib import Path

import pytest

from rankdrop.errors import MissingExtraError, RobotError
from rankdrop.robot import xacro
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


@pytest.mark.slow
def test_includes_are_relative_to_the_file(tmp_path: Path, macros: Path) -> None:
    pytest.importorskip("xacro")
    arm = open_robot(write(tmp_path, "pack/urdf/macro.xacro"))
    assert (arm.name, arm.n, arm.tip, arm.upper[0]) == ("x_arm", 2, "l2", pi / 2)
    assert arm.joints[1].screw.tolist() == [0, -0.5, 0, 0, 0, 1]


@pytest.mark.slow
def test_packages_are_found_by_the_map(tmp_path: Path, macros: Path) -> None:
    pytest.importorskip("xacro")
    path = write(tmp_path, "$(find given_pack)/urdf/macro.xacro")
    assert open_robot(path, packages={"given_pack": macros}).n == 2
    with pytest.raises(RobotError, match=r"not found; got 'given_pack'; .*fix: give its folder: packages=") as caught:
        open_robot(path)  # the map of the first call is not kept
    assert caught.value.on_command_line().endswith("fix: give its folder: --package given_pack=FOLDER")
    with pytest.raises(RobotError, match="package 'pack': the folder of a package is not there"):
        open_robot(path, packages={"pack": tmp_path / "nowhere"})


@pytest.mark.slow
def test_a_package_beside_the_file_is_found_and_told(tmp_path: Path, macros: Path) -> None:
    pytest.importorskip("xacro")
    (macros / "package.xml").write_text("<package><name>told_pack</name></package>", encoding="utf-8")
    (tmp_path / "own" / "urdf").mkdir(parents=True)
    arm = open_robot(write(tmp_path / "own" / "urdf", "$(find told_pack)/urdf/macro.xacro"))
    assert (arm.n, str(arm.notes[-1])) == (2, f"package 'told_pack' found: {macros}")


@pytest.mark.slow
def test_a_missing_package_that_only_names_meshes_does_not_matter(tmp_path: Path, macros: Path) -> None:
    pytest.importorskip("xacro")
    mesh = '<visual><geometry><mesh filename="file://$(find mesh_pack)/a.stl"/></geometry></visual>'
    path = write(tmp_path, "pack/urdf/macro.xacro")
    path.write_text(path.read_text().replace('<link name="l0"/>', f'<link name="l0">{mesh}</link>'), encoding="utf-8")
    arm = open_robot(path)
    note = arm.notes[-1]
    assert str(note) == "package 'mesh_pack' is not found: only files that are not read are in it"
    assert arm.n == 2


@pytest.mark.slow
def test_arguments_are_passed(tmp_path: Path, macros: Path) -> None:
    pytest.importorskip("xacro")
    path = write(tmp_path, "pack/urdf/macro.xacro")
    for value in ("0.25", 0.25):
        assert open_robot(path, args={"length": value}).joints[1].screw[1] == -0.25
    assert from_xacro(path, args={"length": "0.125"}).joints[1].screw[1] == -0.125
    assert open_robot(path).joints[1].screw[1] == -0.5  # the arguments of other calls are not kept


@pytest.mark.slow
def test_true_and_false_are_written_as_xacro_reads_them(tmp_path: Path) -> None:
    pytest.importorskip("xacro")
    joint = '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>'
    more = '<xacro:if value="$(arg long)"><link name="c"/>' + joint.replace('"b"', '"c"').replace('"a"', '"b"').replace(
        '"j"', '"k"') + "</xacro:if>"  # fmt: skip
    path = tmp_path / "arm.xacro"
    path.write_text(
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="long" default="false"/>'
        f'<link name="a"/><link name="b"/>{joint}{more}</robot>', encoding="utf-8",
    )  # fmt: skip
    assert [open_robot(path, args={"long": value}).n for value in (True, False, "true")] == [2, 1, 2]


def needs(tmp_path: Path, inside: str, name: str = "r") -> Path:
    """A file of one joint that takes the argument `kind` from the line `inside`."""
    path = tmp_path / "arm.urdf.xacro"
    path.write_text(
        f'<robot name="{name}" xmlns:xacro="http://www.ros.org/wiki/xacro">{inside}<link name="a"/><link name="b"/>'
        '<joint name="j" type="$(arg kind)"><parent link="a"/><child link="b"/></joint></robot>', encoding="utf-8",
    )  # fmt: skip
    return path


@pytest.mark.slow
def test_an_argument_without_a_default_is_named_with_the_mend(tmp_path: Path) -> None:
    pytest.importorskip("xacro")
    path = needs(tmp_path, '<xacro:arg name="with" default="7"/>')
    with pytest.raises(RobotError, match="are not given; got no value of kind") as caught:
        open_robot(path, args={"with": 1})
    assert caught.value.mend == "args={'kind': …}"
    assert caught.value.on_command_line().endswith("fix: --arg kind:=VALUE")
    assert open_robot(path, args={"kind": "continuous"}).n == 1


def test_what_cannot_be_expanded_names_the_arguments_that_may_be_the_reason_first(tmp_path: Path) -> None:
    pytest.importorskip("xacro")
    given = "".join(f'<xacro:arg name="other{i}" default="1"/>' for i in range(20))
    kind = '<xacro:arg name="kind" default=""/><xacro:arg name="type" default="ur5x"/>'
    path = needs(tmp_path, f'{given}{kind}<xacro:include filename="$(arg type)/$(arg kind).xacro"/>')
    with pytest.raises(RobotError, match="xacro cannot expand") as caught:
        open_robot(path)
    assert str(caught.value.allowed).startswith("arguments with defaults: kind='', type='ur5x', other0='1',")
    assert str(caught.value.allowed).endswith(" and 10 more")
    assert caught.value.on_command_line().endswith("--arg NAME:=VALUE")


def test_an_argument_that_the_file_does_not_take_is_refused(tmp_path: Path, macros: Path) -> None:
    pytest.importorskip("xacro")
    path = write(tmp_path, "pack/urdf/macro.xacro")
    with pytest.raises(RobotError, match="the file has no such argument; got 'width'; allowed: length"):
        open_robot(path, args={"width": 1})


@pytest.mark.slow
def test_a_robot_named_by_an_argument_has_its_default_or_the_name_given(tmp_path: Path) -> None:
    pytest.importorskip("xacro")
    inside = '<xacro:arg name="kind" default="continuous"/><xacro:arg name="called" default="rizon"/>'
    path = needs(tmp_path, inside, "$(arg called)_arm")
    assert open_robot(path).name == "rizon_arm"
    assert open_robot(path, args={"called": "ur"}).name == "ur_arm"
    assert open_robot(path, args={"called": True}).name == "true_arm"  # as xacro writes it


def test_arguments_belong_to_xacro_files(tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    path.write_text('convention = "standard"\n[[joints]]\na = 1\n', encoding="utf-8")
    with pytest.raises(RobotError, match="only a xacro file has arguments; got name; fix: leave args out"):
        open_robot(path, args={"name": "x"})
    with pytest.raises(RobotError, match="only a xacro file has arguments"):
        open_robot("pa10", args={"name": "x"})


def test_a_file_of_macros_alone_is_told(macros: Path) -> None:
    pytest.importorskip("xacro")
    with pytest.raises(RobotError, match="nothing comes out of the xacro file"):
        open_robot(macros / "urdf" / "macro.xacro")


@pytest.mark.spread(2)
@pytest.mark.slow
@pytest.mark.parametrize("name", ["arm.urdf", "arm.xml", "arm", "arm.URDF.txt"])
def test_what_does_not_end_in_xacro_is_expanded_on_request_only(
    tmp_path: Path, macros: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write(tmp_path, "pack/urdf/macro.xacro", name)
    with monkeypatch.context() as without:
        without.setattr(xacro, "run_limited", lambda *_, **__: pytest.fail("expanded"))
        with pytest.raises(RobotError, match=r"expanding it can run any command; fix: .*xacro=True") as caught:
            open_robot(path)
    assert caught.value.on_command_line().endswith("--xacro")
    pytest.importorskip("xacro")
    assert open_robot(path, xacro=True).n == 2


def test_the_ending_may_be_in_capitals(tmp_path: Path, macros: Path) -> None:
    pytest.importorskip("xacro")
    assert open_robot(write(tmp_path, "pack/urdf/macro.xacro", "ARM.XACRO")).n == 2


def test_xacro_in_comments_does_not_make_a_xacro_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xacro", None)
    path = tmp_path / "arm.urdf"
    joint = '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>'
    text = f'<robot name="r"><!-- <xacro:x/> --><link name="a"/><link name="b"/>{joint}</robot>'
    path.write_text(text, encoding="utf-8")
    assert open_robot(path).n == 1


def test_without_xacro_the_command_that_installs_it_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xacro", None)
    with pytest.raises(MissingExtraError, match=r"s source: pip install \.$"):
        open_robot(write(tmp_path, "x.xacro"))


@pytest.mark.slow
def test_what_xacro_cannot_expand_is_said_in_one_line(tmp_path: Path) -> None:
    pytest.importorskip("xacro")
    with pytest.raises(RobotError, match="xacro cannot expand the file") as caught:
        open_robot(write(tmp_path, "missing.xacro"))
    assert "\n" not in str(caught.value)


def test_document_types_are_refused_before_expansion(tmp_path: Path) -> None:
    path = tmp_path / "arm.xacro"
    path.write_text('<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/hostname">]><robot/>', encoding="utf-8")
    with pytest.raises(RobotError, match="document types and entities are refused"):
        open_robot(path)
