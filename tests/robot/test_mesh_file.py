"""Mesh files: each is read once, in a child process with limits; copies are counted before they are made."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rankdrop.errors import RobotError
from rankdrop.jobs import limited
from rankdrop.robot import mesh_file, shapes
from rankdrop.robot.mesh_file import mesh_parts, read_meshes
from rankdrop.robot.open import open_robot

pytest.importorskip("trimesh", reason="viser and trimesh are not installed")

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
COLLADA = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="millimeter" meter="0.001"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry>
</library_geometries>
<library_nodes>{nodes}</library_nodes>
<library_visual_scenes><visual_scene id="s"><node id="root">{shown}</node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""
GEOMETRY = '<instance_geometry url="#g"/>'


def bomb(levels: int, wide: int = 10) -> str:
    """wide**levels triangles of a few kB."""
    nodes = [f'<node id="n0">{GEOMETRY}</node>']
    nodes += [f'<node id="n{k}">{f"<instance_node url={chr(34)}#n{k - 1}{chr(34)}/>" * wide}</node>'
              for k in range(1, levels + 1)]  # fmt: skip
    return COLLADA.format(nodes="".join(nodes), shown=f'<instance_node url="#n{levels}"/>')


def arm(folder: Path, *meshes: str) -> Path:
    drawn = "".join(f'<visual><geometry><mesh filename="{mesh}"/></geometry></visual>' for mesh in meshes)
    file = folder / "one.urdf"
    file.write_text(f"""<robot name="one"><link name="base">{drawn}</link><link name="tip"/>
        <joint name="j1" type="continuous"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/></joint>
        </robot>""")
    return file


def drawn(file: Path) -> tuple[tuple[shapes.Mesh, ...], tuple[str, ...]]:
    visuals, notes = shapes.visuals_of(open_robot(file), {})
    meshes, unread = shapes.meshes_of(visuals)
    return meshes, notes + unread


@pytest.mark.slow
def test_a_file_with_units_is_read_in_metres(tmp_path: Path) -> None:
    (tmp_path / "a.dae").write_text(COLLADA.format(nodes="", shown=GEOMETRY))
    (mesh,), notes = drawn(arm(tmp_path, "a.dae"))
    assert notes == ()
    assert np.allclose(mesh.vertices.max(axis=0), [1e-3, 1e-3, 0.0])


@pytest.mark.slow
def test_a_file_that_is_named_many_times_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One PLY that was named 6,000 times took over 70 s."""
    (tmp_path / "a.obj").write_text(TRIANGLE)
    read: list[int] = []

    def counted(function: Any, names: list[str], **more: Any) -> Any:
        read.append(len(names))
        return function(names)

    monkeypatch.setattr(mesh_file, "run_limited", counted)
    meshes, notes = drawn(arm(tmp_path, *["a.obj"] * 3000))
    assert read == [1]
    assert len(meshes) == shapes.MOST_VISUALS
    (note,) = notes
    assert "one.urdf: the file has too many shapes; the first ones are used; got 3000; allowed: at most 2,000" in note


@pytest.mark.parametrize("count", ["MOST_FACES", "MOST_VERTICES"])
def test_copies_of_a_mesh_are_counted(count: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.obj").write_text(TRIANGLE)
    monkeypatch.setattr(mesh_file, "run_limited", lambda function, names, **_: function(names))
    monkeypatch.setattr(shapes, count, 10)
    meshes, (note,) = drawn(arm(tmp_path, *["a.obj"] * 20))
    assert len(meshes) == (10 if count == "MOST_FACES" else 3)
    assert f"{tmp_path / 'a.obj'}: the meshes have too many" in note


def errors_of(*names: Path) -> list[dict[str, Any]]:
    with np.load(io.BytesIO(mesh_parts([str(name) for name in names]))) as read:
        return [told.get("error", {}) for told in json.loads(str(read["about"]))]


def test_what_a_file_places_is_counted_before_it_is_copied(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.dae").write_text(bomb(2))
    for name, said in (("MOST_INSTANCES", "too many copies"), ("MOST_FACES", "triangles"), ("MOST_VERTICES", "vert")):
        with monkeypatch.context() as patch:
            patch.setattr(mesh_file, name, 99)
            (error,) = errors_of(tmp_path / "a.dae")
        assert said in error["what"]
        assert error["where"] == str(tmp_path / "a.dae")
    assert errors_of(tmp_path / "a.dae") == [{}]


@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")  # of trimesh
def test_a_vertex_far_away_is_refused_with_the_file(tmp_path: Path) -> None:
    for word in ("1e300", "1e13"):
        (tmp_path / "a.obj").write_text(TRIANGLE.replace("1 0 0", f"{word} 0 0"))
        (error,) = errors_of(tmp_path / "a.obj")
        assert "mesh" in error["what"]
        assert error["where"] == str(tmp_path / "a.obj")


def test_a_file_that_takes_too_long_is_named_and_the_rest_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("a.obj", "slow.obj", "z.obj"):
        (tmp_path / name).write_text(TRIANGLE)
    real = mesh_file._read_parts

    def slow(file: Path, *most: int) -> Any:
        while file.stem == "slow":
            pass
        return real(file, *most)

    monkeypatch.setattr(mesh_file, "_read_parts", slow)
    monkeypatch.setattr(mesh_file, "_PATIENCE", 0.1)
    told = errors_of(tmp_path / "slow.obj", tmp_path / "a.obj")
    assert "needs more than 0 s of processor time" in told[0]["what"]
    assert told[1] == {}
    monkeypatch.setattr(mesh_file, "CPU", 0)
    monkeypatch.setattr(mesh_file, "_SECONDS", 0.0)
    assert "the meshes before it took too long" in errors_of(tmp_path / "z.obj")[0]["what"]


def test_a_crash_over_one_file_leaves_the_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    paths = [tmp_path / f"{name}.obj" for name in ("a", "bad1", "b", "bad2", "bad3", "c")]
    for path in paths:
        path.write_text(TRIANGLE)

    def crashes(function: Any, names: list[str], **more: Any) -> Any:
        if any("bad" in name for name in names):
            raise RobotError("the reader of meshes crashes on the file", where=more["file"])
        return function(names)

    monkeypatch.setattr(mesh_file, "run_limited", crashes)
    found = read_meshes(paths)
    assert [isinstance(found[path], list) for path in paths] == [True, False, True, False, False, False]
    assert "other meshes of the arm crash the reader" in str(found[paths[-1]])


@pytest.mark.slow
def test_a_bomb_of_collada_is_one_note(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """2.8 kB took 4.5 GB."""
    monkeypatch.setattr(limited, "MEMORY", 300 * 2**20)
    (tmp_path / "bomb.dae").write_text(bomb(9))
    (tmp_path / "a.obj").write_text(TRIANGLE)
    meshes, notes = drawn(arm(tmp_path, "a.obj", "bomb.dae"))
    assert len(meshes) == 1
    (note,) = notes
    assert str(tmp_path / "bomb.dae") in note
