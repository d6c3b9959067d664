"""Shapes of a URDF: on the right link, from files of this machine only, and nothing but meshes is opened."""

from __future__ import annotations

import builtins
import io
from pathlib import Path

import numpy as np
import pytest

from rankdrop.kinematics import link_poses
from rankdrop.robot.open import open_robot
from rankdrop.robot.shapes import Visual, visuals_of

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
URDF = """<robot name="two">
 <material name="blue"><color rgba="0 0 1 1"/></material>
 <link name="base"><visual><geometry><box size="1 2 3"/></geometry><material name="blue"/></visual></link>
 <link name="arm"><visual><origin xyz="0 0 0.5" rpy="0 0 0"/><geometry><cylinder radius="0.1" length="1"/></geometry>
  </visual></link>
 <link name="flange"><visual><geometry>{mesh}</geometry></visual></link>
 <link name="finger"><visual><geometry><sphere radius="0.02"/></geometry></visual></link>
 <joint name="j1" type="continuous"><parent link="base"/><child link="arm"/>
  <origin xyz="0 0 1"/><axis xyz="0 1 0"/></joint>
 <joint name="j2" type="continuous"><parent link="arm"/><child link="flange"/>
  <origin xyz="0 0 1"/><axis xyz="1 0 0"/></joint>
 <joint name="grip" type="prismatic"><parent link="flange"/><child link="finger"/>
  <origin xyz="0 0 0.3"/><axis xyz="1 0 0"/>
  <limit lower="0" upper="0.1" effort="1" velocity="1"/></joint>
</robot>"""


Found = tuple[tuple[Visual, ...], tuple[str, ...]]


def shapes(folder: Path, mesh: str, packages: dict[str, Path] | None = None) -> Found:
    file = folder / "two.urdf"
    file.write_text(URDF.format(mesh=mesh), encoding="utf-8")
    return visuals_of(open_robot(file, tip="flange"), packages or {})


def test_every_shape_is_on_its_link(tmp_path: Path) -> None:
    (tmp_path / "part.obj").write_text(TRIANGLE, encoding="utf-8")
    found, notes = shapes(tmp_path, '<mesh filename="part.obj" scale="2 2 2"/>')
    assert notes == ()
    assert [(one.link, one.solid) for one in found] == [(0, "box"), (1, "cylinder"), (2, "mesh"), (2, "sphere")]
    assert found[0].colour == (0.0, 0.0, 1.0)
    arm = open_robot(tmp_path / "two.urdf", tip="flange")
    links = link_poses(arm, [np.pi / 2, 0.0])  # the arm lies along x
    centre = links[1] @ found[1].pose
    assert np.allclose(centre[:3, 3], [0.5, 0, 1.0])
    finger = links[2] @ found[3].pose
    assert np.allclose(finger[:3, 3], [1.3, 0, 1.0])


@pytest.mark.slow
def test_meshes_are_read_with_scale_and_place(tmp_path: Path) -> None:
    pytest.importorskip("trimesh", reason="viser and trimesh are not installed")
    from rankdrop.robot.shapes import meshes_of

    (tmp_path / "part.obj").write_text("mtllib ../../../etc/passwd\n" + TRIANGLE, encoding="utf-8")
    found, _ = shapes(tmp_path, '<mesh filename="part.obj" scale="2 2 -2"/>')
    meshes, notes = meshes_of(found)
    assert notes == ()
    assert [mesh.link for mesh in meshes] == [0, 1, 2, 2]
    assert np.allclose(np.abs(meshes[0].vertices).max(axis=0), [0.5, 1.0, 1.5])
    assert np.allclose(meshes[1].vertices[:, 2].min(), 0.0)
    assert np.allclose(meshes[2].vertices.max(axis=0), [2.0, 2.0, 0.0])


@pytest.mark.parametrize(
    ("mesh", "said"),
    [
        ('<mesh filename="package://nowhere/part.stl"/>', "packages={'nowhere': FOLDER}"),
        ('<mesh filename="https://example.org/part.stl"/>', "this machine only"),
        ('<mesh filename="/etc/passwd"/>', "no mesh that can be read"),
        ('<mesh filename="missing.dae"/>', "no such mesh"),
        ('<mesh filename="missing.dae" scale="1 x 1"/>', "scale is not a finite number"),
        ("<capsule/>", "the shape is not known"),
        ('<box size="1"/>', "size is three numbers"),
    ],
)
def test_what_cannot_be_used_is_told_and_the_rest_is_drawn(tmp_path: Path, mesh: str, said: str) -> None:
    found, notes = shapes(tmp_path, mesh)
    assert len(found) == 3
    assert len(notes) == 1
    assert said in notes[0]
    assert "two.urdf, line" in notes[0]


def test_packages_are_given_or_found_above_the_file(tmp_path: Path) -> None:
    folder = tmp_path / "two_description" / "urdf"
    folder.mkdir(parents=True)
    mesh = '<mesh filename="package://two_description/part.stl"/>'
    (tmp_path / "two_description" / "part.stl").write_bytes(b"")
    found, notes = shapes(folder, mesh)
    assert notes == ()
    assert found[2].file == tmp_path / "two_description" / "part.stl"
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "part.stl").write_bytes(b"")
    found, _ = shapes(folder, mesh, {"two_description": tmp_path / "elsewhere"})
    assert found[2].file == tmp_path / "elsewhere" / "part.stl"


@pytest.mark.slow
def test_a_damaged_mesh_is_told(tmp_path: Path) -> None:
    pytest.importorskip("trimesh", reason="viser and trimesh are not installed")
    from rankdrop.robot.shapes import meshes_of

    bomb = '<?xml version="1.0"?><!DOCTYPE d [<!ENTITY a "aa">]><COLLADA>&a;</COLLADA>'
    (tmp_path / "part.dae").write_text(bomb, encoding="utf-8")
    found, _ = shapes(tmp_path, '<mesh filename="part.dae"/>')
    meshes, notes = meshes_of(found)
    assert len(meshes) == 3
    assert "document types and entities are refused" in notes[0]


def test_an_arm_of_the_catalogue_has_no_shapes() -> None:
    assert visuals_of(open_robot("pa10"), {}) == ((), ())


@pytest.mark.slow
def test_a_xacro_file_is_drawn_as_it_was_expanded(tmp_path: Path) -> None:
    pytest.importorskip("xacro", reason="xacrodoc is not installed")
    (tmp_path / "part.obj").write_text(TRIANGLE, encoding="utf-8")
    plain, _ = shapes(tmp_path, '<mesh filename="part.obj"/>')
    text = URDF.format(mesh='<mesh filename="part.obj" scale="$(arg size) 1 1"/>')
    head, rest = text.split(">", 1)
    file = tmp_path / "two.urdf.xacro"
    whole = f'{head} xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="size" default="1"/>{rest}'
    file.write_text(whole, encoding="utf-8")
    found, notes = visuals_of(open_robot(file, tip="flange", args={"size": 3}), {}, {"size": "3"})
    assert notes == ()
    assert [(one.link, one.solid) for one in found] == [(one.link, one.solid) for one in plain]
    assert found[2].size == (3.0, 1.0, 1.0)
    assert all(np.allclose(one.pose, other.pose) for one, other in zip(found, plain, strict=True))


def test_a_mesh_opens_no_file_that_it_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("trimesh", reason="viser and trimesh are not installed")
    from rankdrop.robot.mesh_file import mesh_parts

    (tmp_path / "secret.mtl").write_text("newmtl red\nKd 1 0 0\n", encoding="utf-8")
    (tmp_path / "part.obj").write_text(f"mtllib secret.mtl\nusemtl red\n{TRIANGLE}", encoding="utf-8")
    found, _ = shapes(tmp_path, '<mesh filename="part.obj"/>')
    monkeypatch.chdir(tmp_path)
    opened: list[str] = []

    def recorded(file: object, *args: object, **more: object) -> object:
        opened.append(str(file))
        return io.open(file, *args, **more)  # noqa: UP020  # `open` itself is replaced

    monkeypatch.setattr(builtins, "open", recorded)
    with np.load(io.BytesIO(mesh_parts([str(found[2].file)]))) as read:  # as the child process does
        assert len(read["f0_0"]) == 1
    assert not [name for name in opened if "secret" in name]
